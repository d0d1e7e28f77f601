//! Messages between core and gateway. The gateway may crash or be flooded; it has no call that stops the core.

use crate::access::{AccessState, AccountRefusal, AccountReply, AccountRequest};
use crate::{Caller, Command, CredentialId, Event, Query, QueryReply};
use serde::{Deserialize, Serialize};
use site_model::Edit;
use vocab::{ClientId, CommandId, Pose, Stamp};

/// Core to gateway.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum CoreMessage {
    /// First message after the gateway connects; a full snapshot of events follows.
    Hello {
        /// [`crate::VERSION`] of the core.
        version: u16,
    },
    /// State for one client (answers) or for all.
    Event {
        /// Only for this client, or for all.
        to: Option<ClientId>,
        /// The state.
        event: Event,
    },
    /// A live scan.
    Scan {
        /// The instant of the pose.
        stamp: Stamp,
        /// Base in the map at `stamp`.
        map_from_base: Pose,
        /// `map_codec`'s live scan, base frame.
        points: Vec<u8>,
    },
    /// Answer to a question.
    Reply {
        /// Number of the question.
        number: u64,
        /// The answer, or a sentence that says why there is none.
        result: Result<QueryReply, String>,
    },
    /// Who may use the platform. It goes to no client.
    Access(AccessState),
    /// Answer to a request about accounts.
    AccountReply {
        /// Number of the request.
        number: u64,
        /// The answer, or why it was not carried out.
        result: Result<AccountReply, AccountRefusal>,
    },
}

/// Gateway to core.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum GatewayMessage {
    /// First message.
    Hello {
        /// [`crate::VERSION`] of the gateway.
        version: u16,
    },
    /// A client's command.
    Command {
        /// Made by the client.
        id: CommandId,
        /// Who asks.
        by: Caller,
        /// What is asked.
        command: Command,
    },
    /// How many clients listen, so that nothing is encoded for nobody.
    Listeners {
        /// Control sockets.
        clients: u32,
        /// Stream sockets that want scans now.
        streams: u32,
    },
    /// The gateway's graph is not the one that the last [`crate::GraphChanged`] applies to. Answered by the whole graph.
    RequestGraph,
    /// A client's edit of the site. Answered by [`Event::EditDone`] to that client, after [`Event::SiteChanged`] to all.
    Edit {
        /// Who edits.
        by: Caller,
        /// The edit.
        edit: Edit,
    },
    /// The gateway's site is not the one that the last [`crate::SiteChanged`] applies to. Answered by the whole site.
    RequestSite,
    /// A question about what was stored, answered by [`CoreMessage::Reply`].
    Query {
        /// Number of the question, made by the gateway.
        number: u64,
        /// Who asks.
        by: Caller,
        /// The question.
        query: Query,
    },
    /// A request about accounts, answered by [`CoreMessage::AccountReply`].
    Account {
        /// Number of the request, made by the gateway.
        number: u64,
        /// Who asks.
        by: Caller,
        /// What is asked.
        request: AccountRequest,
    },
    /// The clients that are connected. Replaces those before.
    Clients(Vec<ClientId>),
    /// Sessions and tokens that were used since the last such message.
    CredentialsUsed(Vec<CredentialId>),
    /// What the gateway has refused or done itself, for the audit log; [`MAX_AUDIT_NOTES`] at most.
    Audit(Vec<AuditNote>),
}

/// Most [`AuditNote`]s in one message.
pub const MAX_AUDIT_NOTES: usize = 256;

/// Requests of which the core would know nothing, because the gateway has refused or done them itself. Those that are equal are counted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AuditNote {
    /// Who asked last. A credential that is not valid is named here too.
    pub by: Caller,
    /// What was asked.
    pub request: String,
    /// Why it was refused, one sentence; none: it was done.
    pub refused: Option<String>,
    /// How often.
    pub count: u32,
}
