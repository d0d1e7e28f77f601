//! Downloads and scans between their arrival and the frame that decodes them.

use api::TileHash;
use std::collections::VecDeque;
use vocab::{KeyframeId, Pose, SessionId};

/// Downloads and scans that wait to be decoded in a frame.
#[derive(Default)]
pub(crate) struct DecodeQueue {
    tiles: VecDeque<(TileHash, Vec<u8>)>,
    keyframe_scans: VecDeque<EncodedKeyframeScan>,
    live_scan: Option<EncodedScan>,
}

/// The latest live scan.
pub(crate) struct EncodedScan {
    pub(crate) points: Vec<u8>,
    pub(crate) map_from_base: Pose,
    pub(crate) sequence: u64,
}

/// The scan of a keyframe.
pub(crate) struct EncodedKeyframeScan {
    pub(crate) session: SessionId,
    pub(crate) keyframe: KeyframeId,
    pub(crate) bytes: Vec<u8>,
}

impl DecodeQueue {
    /// Whether tiles wait.
    pub(crate) fn has_tiles(&self) -> bool {
        !self.tiles.is_empty()
    }

    pub(crate) fn push_tile(&mut self, hash: TileHash, bytes: Vec<u8>) {
        self.tiles.push_back((hash, bytes));
    }

    /// The oldest tile.
    pub(crate) fn pop_tile(&mut self) -> Option<(TileHash, Vec<u8>)> {
        self.tiles.pop_front()
    }

    /// Drops a tile that is no longer needed.
    pub(crate) fn remove_tile(&mut self, hash: &TileHash) {
        self.tiles.retain(|(other, _)| other != hash);
    }

    pub(crate) fn push_keyframe_scan(&mut self, scan: EncodedKeyframeScan) {
        self.keyframe_scans.push_back(scan);
    }

    /// The oldest scan of a keyframe.
    pub(crate) fn pop_keyframe_scan(&mut self) -> Option<EncodedKeyframeScan> {
        self.keyframe_scans.pop_front()
    }

    /// Replaces the live scan.
    pub(crate) fn set_live_scan(&mut self, scan: EncodedScan) {
        self.live_scan = Some(scan);
    }

    /// The live scan, if it was not taken.
    pub(crate) fn take_live_scan(&mut self) -> Option<EncodedScan> {
        self.live_scan.take()
    }
}
