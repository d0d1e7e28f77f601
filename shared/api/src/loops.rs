//! Loop closure as clients see it: what was decided on each pair of keyframes, and why.

use serde::{Deserialize, Serialize};
use vocab::{KeyframeId, Pose};

/// Decisions of a session that are kept for clients that come later, newest last.
pub const MAX_LOOP_DECISIONS: usize = 500;

/// New decisions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LoopsChanged {
    /// Forget the decisions sent before.
    pub reset: bool,
    /// Decisions that came. A pair may have several; its last one counts.
    pub added: Vec<LoopDecision>,
}

/// What became of a pair, with its evidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopDecision {
    /// The older keyframe.
    pub from: KeyframeId,
    /// The newer one.
    pub to: KeyframeId,
    /// Why the pair was looked at.
    pub source: LoopSource,
    /// What became of it.
    pub verdict: LoopVerdict,
    /// Whether a person decided so.
    pub by_hand: bool,
    /// Why, one sentence.
    pub reason: String,
    /// Share of the newer cloud on surfaces of the older place, and the reverse.
    pub overlap: [f32; 2],
    /// Root mean square distance from those surfaces, metres.
    pub residual: f32,
    /// Share of the newer cloud through which the older place's rays went, and the reverse.
    pub through: [f32; 2],
    /// Fit of the best different place, as a share of this one's.
    pub rival: f32,
    /// Guess of `to` in `from` before the look.
    pub guess: Pose,
    /// Pose found of `to` in `from`.
    pub from_from_to: Pose,
}

/// Why a pair was looked at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LoopSource {
    /// The estimates say that they are near.
    Geometry,
    /// They look alike; how unlike they are, 0 to 1.
    Appearance(f32),
    /// A person pointed at them.
    Person,
}

/// What became of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LoopVerdict {
    /// It is an edge of the graph.
    Accepted,
    /// It fits, and waits for others to agree with it.
    Held,
    /// It is no loop.
    Rejected,
    /// It waited too long.
    Dropped,
}
