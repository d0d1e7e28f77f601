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

/// A decision with its evidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopDecision {
    /// The older keyframe.
    pub from: KeyframeId,
    /// The newer one.
    pub to: KeyframeId,
    /// Why the pair was proposed.
    pub source: LoopSource,
    /// The outcome.
    pub verdict: LoopVerdict,
    /// Whether a person decided.
    pub by_hand: bool,
    /// Why, one sentence.
    pub reason: String,
    /// Share of the newer cloud on surfaces of the older place, and the reverse.
    pub overlap: [f32; 2],
    /// Root mean square distance from those surfaces, metres.
    pub residual_m: f32,
    /// Share of the newer cloud that stands in free space of the older place, and the reverse.
    pub free_space_violation: [f32; 2],
    /// Score of the best different pose, as a share of this one's.
    pub runner_up_ratio: f32,
    /// Guess of `to` in `from` before the comparison.
    pub guess: Pose,
    /// Pose found of `to` in `from`.
    pub from_from_to: Pose,
}

/// Why a pair was proposed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LoopSource {
    /// The estimates put the keyframes close together.
    Geometry,
    /// They look alike; the distance of their scan contexts, 0 to 1.
    Appearance(f32),
    /// A person proposed it.
    Person,
}

/// Outcome of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LoopVerdict {
    /// It is a loop of the graph.
    Accepted,
    /// It passed the verification, but waits for other loops to agree with it.
    Held,
    /// It failed the verification, or a person rejected it.
    Rejected,
    /// It was held for too long.
    Dropped,
}
