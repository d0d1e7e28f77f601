//! Who makes a request.

use crate::reserved_places::ReservedPlaceId;
use api::access::Endpoint;
use api::{Caller, LeaseToken, Role};
use std::net::IpAddr;
use uuid::Uuid;
use vocab::ClientId;

/// What is known of a TCP connection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TcpConnection {
    /// The address of the other end.
    pub(crate) peer: IpAddr,
    /// The address of this computer that was reached.
    pub(crate) local: IpAddr,
    /// Whether it is encrypted.
    pub(crate) is_tls: bool,
    /// Whether it is not encrypted although it could be: only the pages that explain how to trust the server are shown.
    pub(crate) lacks_tls: bool,
    /// Its reserved place, if all others were taken when it came: it has one request, for [`is_for_reserved_places`].
    pub(crate) reserved: Option<ReservedPlaceId>,
}

/// What can be asked for when all connections are taken. A control socket is for those who have signed in, and there are few ([`crate::limits::Limits::clients`]).
pub(super) fn is_for_reserved_places(endpoint: Endpoint) -> bool {
    matches!(
        endpoint,
        Endpoint::StopMotion | Endpoint::SignIn | Endpoint::Session | Endpoint::Health | Endpoint::Control
    )
}

/// Whose commands those are that came over HTTP without a sign-in.
const ANONYMOUS_HTTP_CLIENT: ClientId = ClientId(Uuid::from_u128(u128::from_be_bytes(*b"AutoInspect HTTP")));

/// Who makes a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    /// As the core is told.
    pub(crate) caller: Caller,
    /// The account; none: nobody has signed in, or nobody needs to.
    pub(crate) account: Option<String>,
    /// What it may do; none: nobody has signed in.
    pub(crate) role: Option<Role>,
}

impl Identity {
    /// Somebody who has not signed in. `credential` may be a session that has ended.
    pub(crate) fn nobody(credential: Option<api::CredentialId>, address: IpAddr) -> Self {
        let address = Some(address.to_canonical());
        let caller = Caller { client: ANONYMOUS_HTTP_CLIENT, credential, address };
        Self { caller, account: None, role: None }
    }

    /// The same as another client.
    pub(super) fn at(&self, client: ClientId) -> Caller {
        Caller { client, ..self.caller }
    }

    /// The same at the socket that has presented this secret.
    pub(crate) fn at_socket(&self, lease: LeaseToken) -> Caller {
        self.at(socket_client(lease, self.account.as_deref()))
    }
}

/// Names the client of a socket by its secret and its account. Whoever knows the name knows neither, and the secret is worth nothing without the account.
pub fn socket_client(lease: LeaseToken, account: Option<&str>) -> ClientId {
    let mut hasher = blake3::Hasher::new_derive_key("AutoInspect 2026 client of a socket");
    hasher.update(lease.0.as_bytes());
    hasher.update(account.unwrap_or_default().as_bytes());
    first_half(hasher.finalize().as_bytes())
}

fn first_half(hash: &[u8; 32]) -> ClientId {
    let mut bytes = [0; 16];
    bytes.copy_from_slice(&hash[..16]);
    ClientId(Uuid::from_bytes(bytes))
}

/// Whose commands those are that came over HTTP with this session or token: each has a lease of its own.
pub(crate) fn http_client(credential: api::CredentialId) -> ClientId {
    first_half(&blake3::derive_key("AutoInspect 2026 client of HTTP requests", &credential.0))
}

tokio::task_local! {
    /// Who makes the request that this task handles. It is a property of the request, like its deadline; so handlers need not pass it on. Outside of a request nothing
    /// can be forwarded to the core.
    static CALLER: Caller;
}

/// Runs the handler of a request.
pub(super) async fn scope<F: Future>(identity: &Identity, handler: F) -> F::Output {
    CALLER.scope(identity.caller, handler).await
}

/// Runs what goes on for a request in another task.
pub(crate) async fn on_behalf_of<F: Future>(caller: Caller, work: F) -> F::Output {
    CALLER.scope(caller, work).await
}

/// Who makes the request that this task handles.
///
/// # Errors
/// Outside of a request, one sentence.
pub(crate) fn current_caller() -> Result<Caller, &'static str> {
    CALLER.try_with(|caller| *caller).map_err(|_| super::texts::NOBODY_ASKS)
}
