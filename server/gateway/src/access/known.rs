//! The sessions and tokens that are valid, as the core has published them, and which of them were used.

use super::cookies::presented;
use super::identity::{Identity, TcpConnection, http_client};
use super::{AccessConfig, AccessJournal, HostList};
use accounts::credential_id;
use api::access::{AccessState, Grant};
use api::{Caller, CredentialId, Role};
use axum::http::HeaderMap;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::sync::watch;
use vocab::Stamp;

/// What the core has published.
#[derive(Debug, Default)]
struct PublishedAccess {
    /// Whether the core has published anything yet.
    is_complete: bool,
    needs_first_admin: bool,
    grants: BTreeMap<CredentialId, Grant>,
}

/// Decides who somebody is.
pub(crate) struct AccessGate {
    pub(crate) is_demo: bool,
    pub(crate) hosts: HostList,
    /// What the audit log has to say of requests of which the core knows nothing.
    pub(crate) journal: AccessJournal,
    known: watch::Sender<Arc<PublishedAccess>>,
    used: Mutex<BTreeSet<CredentialId>>,
}

impl AccessGate {
    /// Knows nobody yet.
    pub(crate) fn new(config: &AccessConfig) -> Self {
        Self {
            is_demo: config.is_demo,
            hosts: HostList::new(&config.allowed_hosts),
            journal: AccessJournal::default(),
            known: watch::Sender::default(),
            used: Mutex::default(),
        }
    }

    /// The core says who may use the platform.
    pub(crate) fn set(&self, state: AccessState) {
        let grants = state.grants.into_iter().map(|grant| (grant.credential, grant)).collect();
        let needs_first_admin = state.needs_first_admin;
        self.known.send_replace(Arc::new(PublishedAccess { is_complete: true, needs_first_admin, grants }));
    }

    /// Whether the core has said who may use the platform.
    pub(crate) fn is_complete(&self) -> bool {
        self.is_demo || self.known.borrow().is_complete
    }

    /// Whether there is no admin yet.
    pub(crate) fn needs_first_admin(&self) -> bool {
        !self.is_demo && self.known.borrow().needs_first_admin
    }

    /// Who makes a request with these headers.
    pub(crate) fn identify(&self, headers: &HeaderMap, connection: &TcpConnection) -> Identity {
        let credential = presented(headers, connection.is_tls).map(|secret| credential_id(&secret));
        let nobody = Identity::nobody(credential, connection.peer);
        if self.is_demo {
            return Identity {
                role: Some(Role::Admin),
                caller: Caller { credential: None, ..nobody.caller },
                ..nobody
            };
        }
        let known = self.known.borrow().clone();
        let grant = credential.and_then(|id| known.grants.get(&id)).filter(|grant| now() < grant.expires);
        let Some(grant) = grant else { return nobody };
        self.used.lock().unwrap_or_else(PoisonError::into_inner).insert(grant.credential);
        Identity {
            caller: nobody.at(http_client(grant.credential)),
            account: Some(grant.account.clone()),
            role: Some(grant.role),
        }
    }

    /// Takes the sessions and tokens that were used since the last call.
    pub(crate) fn take_used(&self) -> Vec<CredentialId> {
        let used = std::mem::take(&mut *self.used.lock().unwrap_or_else(PoisonError::into_inner));
        used.into_iter().collect()
    }

    /// Notes that a socket is in use.
    pub(crate) fn note_used(&self, identity: &Identity) {
        let credential = identity.caller.credential.filter(|_| identity.role.is_some());
        self.used.lock().unwrap_or_else(PoisonError::into_inner).extend(credential);
    }

    /// Returns once this identity is not valid any more, or may do something else than before.
    pub(crate) async fn revoked(&self, identity: &Identity) {
        let Some(credential) = identity.caller.credential.filter(|_| !self.is_demo) else {
            return std::future::pending().await;
        };
        let is_changed = |known: &Arc<PublishedAccess>| {
            known.grants.get(&credential).map(|grant| grant.role) != identity.role
        };
        if self.known.subscribe().wait_for(is_changed).await.is_err() {
            // The gateway ends.
            std::future::pending().await
        }
    }
}

/// Calendar time.
fn now() -> Stamp {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Stamp::from_nanos(i64::try_from(since_1970.as_nanos()).unwrap_or(i64::MAX))
}
