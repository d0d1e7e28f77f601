//! Messages from borrowed parts, so that a graph or a cloud is encoded for each client without being copied first.
//!
//! The same bytes as [`api::ServerMessage`] and [`api::ScanFrame`]; the tests hold them to it.

use api::{ClientIdentity, Event, ScanFrame};
use serde::Serialize;
use vocab::{Pose, Stamp};

/// [`api::ServerMessage`], borrowing. The order of the variants is the contract's.
#[derive(Serialize)]
pub(crate) enum ServerMessageRef<'a> {
    Welcome { version: u16, program: &'a str, you: &'a ClientIdentity },
    Refused { reason: &'a str },
    Event { sequence: u64, event: &'a Event },
    Pong { token: u64, now: Stamp },
}

/// [`ScanFrame`], borrowing.
#[derive(Serialize)]
pub(crate) struct ScanFrameRef<'a> {
    pub(crate) sequence: u64,
    pub(crate) stamp: Stamp,
    pub(crate) map_from_base: Pose,
    pub(crate) points: &'a [u8],
}

impl<'a> ScanFrameRef<'a> {
    /// `scan` under another number.
    pub(crate) fn numbered(scan: &'a ScanFrame, sequence: u64) -> Self {
        Self { sequence, stamp: scan.stamp, map_from_base: scan.map_from_base, points: &scan.points }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use api::{Battery, ServerMessage, encode};

    #[test]
    fn borrowed_messages_are_the_contracts_bytes() {
        let event = Event::Battery(Battery { charge: 0.5, ..Battery::default() });
        let now = Stamp::from_nanos(7);
        let you = ClientIdentity::in_demo(vocab::ClientId(uuid::Uuid::from_u128(5)));
        let pairs = [
            (
                ServerMessage::Welcome { version: 3, program: "p".into(), you: you.clone() },
                ServerMessageRef::Welcome { version: 3, program: "p", you: &you },
            ),
            (ServerMessage::Refused { reason: "r".into() }, ServerMessageRef::Refused { reason: "r" }),
            (
                ServerMessage::Event { sequence: 300, event: event.clone() },
                ServerMessageRef::Event { sequence: 300, event: &event },
            ),
            (ServerMessage::Pong { token: 9, now }, ServerMessageRef::Pong { token: 9, now }),
        ];
        for (owned, borrowed) in pairs {
            assert_eq!(encode(&owned), encode(&borrowed), "{owned:?}");
        }
        let scan = ScanFrame { sequence: 5, stamp: now, points: (0..=255).collect(), ..ScanFrame::default() };
        assert_eq!(encode(&scan), encode(&ScanFrameRef::numbered(&scan, 5)));
    }
}
