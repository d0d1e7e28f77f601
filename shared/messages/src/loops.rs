//! Loop closure: pairs of keyframes looked at, what spoke for and against them, and what became of them.

use serde::{Deserialize, Serialize};
use vocab::{KeyframeId, Pose, SessionId, Stamp};

/// What made somebody think of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LoopSource {
    /// The estimates say that they are near.
    Geometry,
    /// They look alike; the distance of their descriptors, 0 to 1.
    Appearance(f32),
    /// A person said so.
    Person,
}

/// A pair to be looked at. What the work needs besides lies with the stack, see `Stack::take_compute_job`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopTask {
    /// The mapping session.
    pub session: SessionId,
    /// The older keyframe.
    pub from: KeyframeId,
    /// The newer one.
    pub to: KeyframeId,
    /// Why.
    pub source: LoopSource,
    /// Guess of `to` in `from`.
    pub guess: Pose,
}

/// What speaks for and against a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LoopEvidence {
    /// Fit of the whole cloud, 0 to 1.
    pub score: f64,
    /// Share of the newer cloud on surfaces of the older place, and the reverse.
    pub overlap: [f64; 2],
    /// Root mean square distance from those surfaces, metres.
    pub residual: f64,
    /// Share of the newer cloud through which the older place's rays went, and the reverse.
    pub through: [f64; 2],
    /// Fit of the best different place, as a share of this one's.
    pub rival: f64,
    /// Directions of translation that the pair cannot see, 0 to 3.
    pub blind: u32,
    /// Information about the weakest direction as a share of that about the strongest.
    pub grip: f64,
    /// How far the result is from the guess, metres and radians.
    pub moved: (f64, f64),
    /// Squared Mahalanobis distance from what the graph expected, where it expected anything.
    pub surprise: Option<f64>,
}

/// Why a pair is no loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LoopRejection {
    /// No start led anywhere.
    NoFit,
    /// Too little of one lies on the other.
    Overlap,
    /// What lies on the other lies badly.
    Residual,
    /// Rays of one went through surfaces of the other.
    FreeSpaceViolation,
    /// Another place fits as well.
    Ambiguous,
    /// Blind in some direction and nothing else to hold it there.
    Degenerate,
}

/// A pair that was looked at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerifiedLoop {
    /// What was asked.
    pub task: LoopTask,
    /// Pose found of `to` in `from`.
    pub from_from_to: Pose,
    /// Information (inverse covariance) of that pose, `[rotation; translation]`.
    pub information: [[f64; 6]; 6],
    /// What speaks for and against it.
    pub evidence: LoopEvidence,
    /// What is wrong with it, or nothing.
    pub rejection: Option<LoopRejection>,
}

/// What became of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LoopVerdict {
    /// It is an edge of the graph.
    Accepted,
    /// It passed all gates, but waits for others to agree with it.
    Held,
    /// It is not what it seemed.
    Rejected,
    /// It waited too long.
    Dropped,
}

/// A verdict with its reasons. A pair may get several, the last one counts: held first and then accepted, or changed by
/// hand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopDecision {
    /// The pair, why it was looked at and what was guessed.
    pub task: LoopTask,
    /// Pose found of `to` in `from`.
    pub from_from_to: Pose,
    /// What speaks for and against it.
    pub evidence: LoopEvidence,
    /// What became of it.
    pub verdict: LoopVerdict,
    /// Whether a person decided so.
    pub by_hand: bool,
    /// One sentence for people: why.
    pub reason: String,
}

/// A visit to known ground, to be compared with an old keyframe. What the work needs besides lies with the stack.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RevisitTask {
    /// The mapping session.
    pub session: SessionId,
    /// Number of the waypoint, counted along the walk.
    pub visit: u64,
    /// When it was.
    pub stamp: Stamp,
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Guess of the base in it.
    pub guess: Pose,
}

/// A visit that was compared.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComparedRevisit {
    /// What was asked.
    pub task: RevisitTask,
    /// Pose found of the base in the keyframe.
    pub keyframe_from_base: Pose,
    /// Information (inverse covariance) of that pose, `[rotation; translation]`.
    pub information: [[f64; 6]; 6],
    /// What speaks for and against it.
    pub evidence: LoopEvidence,
    /// What is wrong with it, or nothing.
    pub rejection: Option<LoopRejection>,
}

/// A visit to known ground that was found to be where it was expected, or nearly: the robot's place is told from that keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reanchored {
    /// The mapping session.
    pub session: SessionId,
    /// When the robot was there.
    pub stamp: Stamp,
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// The base in it then.
    pub keyframe_from_base: Pose,
    /// Information (inverse covariance) of that pose, `[rotation; translation]`: nothing along a bare corridor.
    pub information: [[f64; 6]; 6],
}
