//! Messages on the two WebSockets.

use crate::{ClientIdentity, Command, Event, LeaseToken};
use serde::{Deserialize, Serialize};
use site_model::Edit;
use vocab::{CommandId, Pose, Stamp};

/// Scan frames that may be under way to a client without its acknowledgement.
pub const MAX_UNACKNOWLEDGED: u64 = 4;

/// Client to server, control socket.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ClientMessage {
    /// First message.
    Hello {
        /// [`crate::VERSION`] of the client.
        version: u16,
        /// The client's secret, which it keeps over reconnections.
        lease: LeaseToken,
    },
    /// A command. Repeating an id does nothing.
    Command {
        /// Made by the client.
        id: CommandId,
        /// What is asked.
        command: Command,
    },
    /// Answered by [`ServerMessage::Pong`] at once; at least every 2 s, or the server closes after 10 s.
    Ping {
        /// Any number; comes back.
        token: u64,
    },
    /// The client's graph is not the one that the last [`crate::GraphChanged`] applies to. Answered by the whole graph as an event: at once,
    /// or 5 s after the last answer to such a request. Requests that wait are answered together.
    RequestGraph,
    /// An edit of the site, at most [`crate::MAX_EDIT_BYTES`] long. Answered by [`Event::EditDone`]. Repeating an id that was applied does nothing and is answered
    /// again.
    Edit(Edit),
    /// The client's site is not the one that the last [`crate::SiteChanged`] applies to. Answered by the whole site, as for the graph.
    RequestSite,
}

/// Server to client, control socket.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ServerMessage {
    /// First message; the snapshot follows.
    Welcome {
        /// [`crate::VERSION`] of the server.
        version: u16,
        /// Version of the program, for people.
        program: String,
        /// Who the client is.
        you: ClientIdentity,
    },
    /// The server will not talk to this client; the sentence says why and what to do. Closes after it.
    Refused {
        /// One clear sentence.
        reason: String,
    },
    /// A piece of state. `sequence` counts from 1 after the welcome without gaps.
    Event {
        /// Place in the order.
        sequence: u64,
        /// The state.
        event: Event,
    },
    /// Answer to a ping.
    Pong {
        /// The ping's.
        token: u64,
        /// Robot's clock.
        now: Stamp,
    },
}

/// Client to server, stream socket.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum StreamRequest {
    /// First message, and again to change the rate or resolution.
    Open {
        /// [`crate::VERSION`] of the client.
        version: u16,
        /// Greatest number of scans per second; 0 pauses.
        max_hz: f32,
    },
    /// The frame of this number has been drawn or dropped; all before it too.
    Acknowledge {
        /// [`ScanFrame::sequence`].
        sequence: u64,
    },
}

/// Server to client, stream socket: one motion-corrected scan.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScanFrame {
    /// Counts from 1.
    pub sequence: u64,
    /// The instant of the pose.
    pub stamp: Stamp,
    /// Base in the map at `stamp`.
    pub map_from_base: Pose,
    /// Points in the base frame: `map_codec`'s live scan.
    pub points: Vec<u8>,
}
