//! What is known of accounts, sessions and tokens now, shared by the threads that need it.

use super::AccessMode;
use super::texts;
use api::access::{AccessState, Grant};
use api::{Caller, CredentialId, Privilege, Role};
use messages::Principal;
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Mutex, MutexGuard, PoisonError};
use store::{Accounts, StoredCredential};
use vocab::{Span, Stamp};

/// Who may do what now.
#[derive(Debug, Default)]
pub struct AccessDirectory {
    mode: AccessMode,
    known: Mutex<AccessRecords>,
}

#[derive(Debug, Default)]
struct AccessRecords {
    accounts: Accounts,
    grants: BTreeMap<CredentialId, Grant>,
    /// When sessions and tokens were used since that was written to the ledger.
    used: BTreeMap<CredentialId, Stamp>,
}

impl AccessDirectory {
    /// Without accounts.
    pub fn new(mode: AccessMode) -> Self {
        Self { mode, known: Mutex::default() }
    }

    /// Whether people have to sign in.
    pub fn mode(&self) -> AccessMode {
        self.mode
    }

    fn lock(&self) -> MutexGuard<'_, AccessRecords> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Who this is.
    ///
    /// # Errors
    /// When its session or token is not valid, one sentence.
    pub fn principal(&self, caller: &Caller) -> Result<Principal, String> {
        if self.mode == AccessMode::Demo {
            return Ok(Principal { client: caller.client, account: None, role: Role::Admin });
        }
        let known = self.lock();
        let grant = caller.credential.and_then(|credential| known.grants.get(&credential));
        let grant = grant.ok_or_else(|| texts::NOT_SIGNED_IN.to_owned())?;
        Ok(Principal { client: caller.client, account: Some(grant.account.clone()), role: grant.role })
    }

    /// Who this is, if it may do what needs this privilege.
    ///
    /// # Errors
    /// When it may not, one sentence.
    pub fn admit(&self, caller: &Caller, privilege: Privilege) -> Result<Principal, String> {
        let principal = self.principal(caller)?;
        if privilege.admits(Some(principal.role)) {
            Ok(principal)
        } else {
            Err(texts::role_refused(principal.role, privilege))
        }
    }

    /// Whose session or token it was that somebody presents, if it was one.
    pub fn former_owner(&self, caller: &Caller) -> Option<String> {
        let known = self.lock();
        Some(known.accounts.credentials.get(&caller.credential?)?.owner.clone())
    }

    /// Sessions and tokens were used.
    pub fn note_used(&self, credentials: &[CredentialId], now: Stamp) {
        let mut known = self.lock();
        for credential in credentials {
            if known.grants.contains_key(credential) {
                known.used.insert(*credential, now);
            }
        }
    }

    /// Takes the accounts as the ledger has them.
    pub fn set_accounts(&self, accounts: Accounts) {
        self.lock().accounts = accounts;
    }

    /// Decides which sessions and tokens are valid at `now`, and returns them.
    pub fn refresh(&self, idle: Span, now: Stamp) -> AccessState {
        let mut known = self.lock();
        let AccessRecords { accounts, used, .. } = &*known;
        let grants: BTreeMap<_, _> = accounts
            .credentials
            .iter()
            .filter_map(|(id, credential)| {
                let last_used = used.get(id).copied().unwrap_or(credential.used);
                Some((*id, grant(accounts, *id, credential, last_used, idle, now)?))
            })
            .collect();
        known.grants = grants;
        let AccessRecords { accounts, grants, used } = &mut *known;
        used.retain(|id, _| grants.contains_key(id));
        let is_admin = |role: Role, is_enabled: bool| role == Role::Admin && is_enabled;
        let has_admin = accounts.accounts.values().any(|account| is_admin(account.role, account.is_enabled));
        AccessState {
            needs_first_admin: self.mode == AccessMode::SignIn && !has_admin,
            grants: grants.values().cloned().collect(),
        }
    }

    /// Whether somebody has signed in to this account before from this address, or with this browser, which has presented an old session.
    pub fn is_known(&self, account: &str, caller: &Caller) -> bool {
        let known = self.lock();
        let is_of_account =
            |credential: &StoredCredential| credential.token_role.is_none() && credential.owner == account;
        let address = caller.address.map(|address| address.to_string());
        let credentials = &known.accounts.credentials;
        caller.credential.and_then(|id| credentials.get(&id)).is_some_and(is_of_account)
            || credentials.values().any(|it| is_of_account(it) && address.is_some() && it.address == address)
    }

    /// What `read` finds in the accounts as they were read last.
    pub fn with_accounts<T>(&self, read: impl FnOnce(&Accounts) -> T) -> T {
        read(&self.lock().accounts)
    }

    /// When a session or token was used last.
    pub fn last_used(&self, id: CredentialId) -> Option<Stamp> {
        let known = self.lock();
        let stored = known.accounts.credentials.get(&id).map(|credential| credential.used);
        known.used.get(&id).copied().or(stored)
    }

    /// Sessions and tokens of which the ledger knows an older use than `period` ago.
    pub fn uses_to_note(&self, period: Span) -> Vec<(CredentialId, StoredCredential)> {
        let known = self.lock();
        let uses = known.used.iter().filter_map(|(id, used)| {
            let credential = known.accounts.credentials.get(id)?;
            let is_old = *used - credential.used >= period;
            is_old.then(|| (*id, StoredCredential { used: *used, ..credential.clone() }))
        });
        uses.collect()
    }
}

/// What a session or token allows now; `None`: nothing.
fn grant(
    accounts: &Accounts,
    id: CredentialId,
    credential: &StoredCredential,
    last_used: Stamp,
    idle: Span,
    now: Stamp,
) -> Option<Grant> {
    if credential.ended.is_some() || now >= credential.expires {
        return None;
    }
    let role = match credential.token_role {
        Some(role) => role,
        None => {
            let account = accounts.accounts.get(&credential.owner).filter(|account| account.is_enabled)?;
            if now - last_used >= idle {
                return None;
            }
            account.role
        }
    };
    let account = match credential.token_role {
        // Accounts have no colon in their names.
        Some(_) => format!("token:{}", credential.owner),
        None => credential.owner.clone(),
    };
    Some(Grant { credential: id, account, role, expires: credential.expires })
}

/// The address of a caller, for the ledger.
pub(super) fn text_of(address: Option<IpAddr>) -> Option<String> {
    address.map(|address| address.to_string())
}
