//! How a client shows that the control lease is its own, and what it is told of itself.

use super::Role;
use serde::{Deserialize, Serialize};
use std::fmt;
use uuid::Uuid;
use vocab::ClientId;

/// A secret that a client makes and keeps over reconnections. The server derives the client's id from it and from the account that has signed in, by a function that cannot
/// be reversed. Others are told the id only, so whoever knows an id can neither drive the robot nor answer in the name of its client.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct LeaseToken(pub Uuid);

impl fmt::Debug for LeaseToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("LeaseToken(…)")
    }
}

/// Who a client is, as the server sees it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClientIdentity {
    /// The client's id, by which it recognises what it did itself.
    pub client: ClientId,
    /// The account that has signed in; none: nobody needs to.
    pub account: Option<String>,
    /// What it may do.
    pub role: Role,
    /// Whether nobody needs to sign in, because the platform is demonstrated.
    pub is_demo: bool,
}

impl ClientIdentity {
    /// An admin of a demonstration.
    pub fn in_demo(client: ClientId) -> Self {
        Self { client, account: None, role: Role::Admin, is_demo: true }
    }
}
