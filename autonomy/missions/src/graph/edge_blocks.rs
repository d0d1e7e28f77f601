//! Edges that are not used for a time, because they could not be walked.

use site_model::{EdgeBlock, EdgeId};
use vocab::{Span, Stamp};

/// Parameters of [`next_block`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeBlockConfig {
    /// Time for which an edge is blocked after its first failure. Chosen: people who stand in a way for longer than the executive waits have
    /// usually gone after a minute.
    pub first: Span,
    /// The longest block. Chosen: what blocks an edge for hours is looked at again several times in a shift.
    pub longest: Span,
    /// An edge that was not tried for this time after its block has ended counts as never failed. Chosen: a shift and a half, so that a block of another day does not
    /// count.
    pub forget_after: Span,
    /// Where there is no other route, the robot waits for the end of a block that is not longer than this. Chosen: the first two blocks.
    pub max_wait: Span,
}

impl Default for EdgeBlockConfig {
    /// One minute, two, four and so on, up to 2 hours; forgotten after 12 hours.
    fn default() -> Self {
        Self {
            first: Span::from_millis(60_000),
            longest: Span::from_millis(2 * 3_600_000),
            forget_after: Span::from_millis(12 * 3_600_000),
            max_wait: Span::from_millis(150_000),
        }
    }
}

/// The block after an edge could not be walked at `now`. `previous` is the one that is recorded for the edge, if any: its time is doubled. A traversal that succeeds
/// removes the record.
pub fn next_block(
    edge: EdgeId,
    previous: Option<&EdgeBlock>,
    now: Stamp,
    reason: String,
    config: &EdgeBlockConfig,
) -> EdgeBlock {
    let remembered = previous.filter(|block| now < block.until + config.forget_after);
    let failures = remembered.map_or(1, |block| block.failures.saturating_add(1));
    let doublings = failures.saturating_sub(1).min(30);
    let time = (config.first * (1_i64 << doublings)).min(config.longest);
    EdgeBlock { edge, until: now + time, failures, reason }
}

/// Whether a block holds at `now`.
pub fn is_blocked(block: &EdgeBlock, now: Stamp) -> bool {
    now < block.until
}
