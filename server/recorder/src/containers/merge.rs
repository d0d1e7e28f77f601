//! Merges the messages of a file of blocks by log time, with few blocks in memory.

use super::{MessageOrder, RawMessage};
use crate::error::ReadError;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use vocab::Stamp;

/// A file as blocks of messages, each with the log time of its earliest one.
pub(super) trait BlockSource {
    /// Earliest log time in the next block, or `None` after the last.
    fn next_start(&self) -> Option<Stamp>;

    /// Loads the next block's wanted messages in file order, each with its position in the file as tie-breaker. Advances to the block after it
    /// even when that fails.
    fn load_next(&mut self, messages: &mut Vec<(u64, RawMessage)>) -> Result<(), ReadError>;
}

/// Messages of a file in the wanted order. Blocks must be sorted by position for [`MessageOrder::File`], and by start for [`MessageOrder::LogTime`].
pub(super) struct MergedMessages<B> {
    blocks: B,
    order: MessageOrder,
    pending: BinaryHeap<Reverse<Entry>>,
    pending_bytes: usize,
    error: Option<ReadError>,
    loaded: Vec<(u64, RawMessage)>,
}

/// Parameters of [`MergedMessages`].
#[derive(Clone, Copy, Debug)]
struct MergeConfig {
    /// Limit of memory for messages that wait for earlier ones, bytes. Blocks that overlap by more than this give messages out of order. Chosen: 36 s of a LiDAR at full
    /// resolution (1.4 MB a sweep).
    max_pending_bytes: usize,
}

const CONFIG: MergeConfig = MergeConfig { max_pending_bytes: 512 << 20 };

impl<B: BlockSource> MergedMessages<B> {
    pub fn new(blocks: B, order: MessageOrder) -> Self {
        Self { blocks, order, pending: BinaryHeap::new(), pending_bytes: 0, error: None, loaded: Vec::new() }
    }

    fn must_load(&self) -> bool {
        let Some(start) = self.blocks.next_start() else { return false };
        match (self.pending.peek(), self.order) {
            (None, _) => true,
            (Some(_), MessageOrder::File) => false,
            (Some(Reverse(first)), MessageOrder::LogTime) => {
                start <= first.message.at && self.pending_bytes < CONFIG.max_pending_bytes
            }
        }
    }

    fn load(&mut self) {
        let result = self.blocks.load_next(&mut self.loaded);
        for (place, message) in self.loaded.drain(..) {
            self.pending_bytes += message.bytes().len();
            let at = match self.order {
                MessageOrder::File => Stamp::EPOCH,
                MessageOrder::LogTime => message.at,
            };
            self.pending.push(Reverse(Entry { at, place, message }));
        }
        self.error = result.err();
    }
}

impl<B: BlockSource> Iterator for MergedMessages<B> {
    type Item = Result<RawMessage, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(error) = self.error.take() {
                return Some(Err(error));
            }
            if self.must_load() {
                self.load();
                continue;
            }
            let Reverse(entry) = self.pending.pop()?;
            self.pending_bytes -= entry.message.bytes().len();
            return Some(Ok(entry.message));
        }
    }
}

struct Entry {
    at: Stamp,
    place: u64,
    message: RawMessage,
}

impl Entry {
    fn key(&self) -> (Stamp, u64) {
        (self.at, self.place)
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Entry {}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key().cmp(&other.key())
    }
}
