//! The contract between server and clients, and between core and gateway: plain data, versioned.
//!
//! Two WebSockets per client, so that clouds never delay a command:
//!
//! - [`CONTROL_PATH`]: state and commands. The client opens with [`ClientMessage::Hello`]; the server answers
//!   [`ServerMessage::Welcome`], then one [`Event`] of each kind it knows (the snapshot), then every change.
//! - [`STREAM_PATH`]: live scans. The client opens with [`StreamRequest::Open`] and acknowledges every frame; the
//!   server keeps at most [`MAX_UNACKNOWLEDGED`] frames under way and always sends the latest.
//!
//! Messages are postcard, one per binary WebSocket frame. Core and gateway speak [`CoreMessage`] and
//! [`GatewayMessage`] over a Unix socket, each behind a little-endian `u32` length. Documents and tiles go over HTTP as
//! JSON and bytes; paths are in [`paths`].

pub mod access;
mod codec;
mod command;
mod core_link;
mod event;
mod goal;
mod graph;
mod loops;
mod map;
pub mod paths;
mod query;
mod site;
mod socket;
mod topomap;

pub use access::{Caller, ClientIdentity, CredentialId, LeaseToken, Privilege, Role};
pub use codec::{DecodeError, MAX_MESSAGE_BYTES, decode, encode, encode_after};
pub use command::{Command, CommandOutcome, MAX_ACCEPTED_CHANGES, MAX_PAIR_RMS_M, MAX_PAIRS, SimulatedFault};
pub use core_link::{AuditNote, CoreMessage, GatewayMessage, MAX_AUDIT_NOTES};
pub use event::*;
pub use goal::*;
pub use graph::{GraphAssembly, GraphChanged, GraphPart, MAX_GRAPH_ENTRIES};
pub use loops::{LoopDecision, LoopSource, LoopVerdict, LoopsChanged, MAX_LOOP_DECISIONS};
pub use map::{
    BinnedMap, DamagedMap, MapSummary, Problem, TileAnchor, TileEntry, TileHash, TileHashError, TileList,
};
pub use paths::{CONTROL_PATH, STREAM_PATH};
pub use query::{
    MAX_PAGE, MAX_PAGE_BYTES, Query, QueryReply, RunFilter, StoredAudit, StoredResult, StoredRevision,
    StoredRun, StoredSlot, StoredStep,
};
pub use site::{
    EditDone, EditOutcome, EditRefusal, MAX_EDIT_BYTES, MAX_EDIT_CHANGES, MAX_OBJECT_BYTES, MAX_SITE_OBJECTS,
    SiteAssembly, SiteChanged, SitePart, SiteParts, SiteState, encoded_bytes,
};
pub use socket::{ClientMessage, MAX_UNACKNOWLEDGED, ScanFrame, ServerMessage, StreamRequest};
pub use topomap::{MAX_BLOCKED_SEGMENTS, TopomapGeneration, TopomapStage, TopomapSummary};

/// Version of everything in this crate. Server and client refuse each other when it differs, and say so.
pub const VERSION: u16 = 31;

/// Time for which a deleted map is kept in the bin.
pub const BIN_RETENTION: vocab::Span = vocab::Span::from_millis(7 * 24 * 3_600_000);

/// Time for which an uploaded file is kept after it came, or after the last attempt to import it.
pub const UPLOAD_RETENTION: vocab::Span = vocab::Span::from_millis(24 * 3_600_000);

/// Space on the disk that neither a new map of the core nor an upload to the gateway takes, bytes. It is kept free for recordings.
pub const DISK_RESERVE_BYTES: u64 = 2 << 30;
