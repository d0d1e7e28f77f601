//! Loop closure: pairs of keyframes that were compared, the figures of the comparison, and the decision.

use serde::{Deserialize, Serialize};
use vocab::{KeyframeId, Pose, SessionId, Stamp};

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

/// A pair to be compared. The stack keeps the clouds until the job fetches them with `Stack::take_compute_job`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopTask {
    /// The mapping session.
    pub session: SessionId,
    /// The older keyframe.
    pub from: KeyframeId,
    /// The newer one.
    pub to: KeyframeId,
    /// Why it was proposed.
    pub source: LoopSource,
    /// Guess of `to` in `from`.
    pub guess: Pose,
}

/// The figures on which a pair is decided. Saved maps hold them as JSON; the other names are those of maps of format version 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LoopEvidence {
    /// Registration score of the whole cloud, 0 to 1.
    pub score: f64,
    /// Share of the newer cloud on surfaces of the older place, and the reverse.
    pub overlap: [f64; 2],
    /// Root mean square distance of those points from the surfaces, metres.
    #[serde(alias = "residual")]
    pub residual_m: f64,
    /// Share of the newer cloud that stands in free space of the older place, and the reverse.
    #[serde(alias = "through")]
    pub free_space_violation: [f64; 2],
    /// Score of the best different pose, as a share of this one's.
    #[serde(alias = "rival")]
    pub runner_up_ratio: f64,
    /// Number of directions of translation that are not observed, 0 to 3.
    #[serde(alias = "blind")]
    pub degenerate_directions: u32,
    /// Information of the weakest direction of translation as a share of the strongest.
    #[serde(alias = "grip")]
    pub conditioning: f64,
    /// From the guess to the result.
    #[serde(alias = "moved")]
    pub correction: PoseCorrection,
    /// Squared Mahalanobis distance from the pose that the graph expected, if it expected one.
    #[serde(alias = "surprise")]
    pub mahalanobis_squared: Option<f64>,
}

/// How far two poses of a keyframe are apart. In maps of format version 1 it is a pair of numbers, in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseCorrection {
    /// Distance between them, metres.
    pub distance_m: f64,
    /// Angle of the rotation between them, radians.
    pub rotation_rad: f64,
}

/// Why a pair is not a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LoopRejection {
    /// The registration did not converge from any start.
    NoFit,
    /// Too little of one cloud lies on the other.
    Overlap,
    /// The points that lie on the other cloud are too far from its surfaces.
    Residual,
    /// One scan looked through surfaces of the other.
    FreeSpaceViolation,
    /// Another pose fits as well.
    Ambiguous,
    /// Some direction is not observed, and the graph does not know it either.
    Degenerate,
}

/// The result of comparing a pair.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerifiedLoop {
    /// The task.
    pub task: LoopTask,
    /// Pose found of `to` in `from`.
    pub from_from_to: Pose,
    /// Information (inverse covariance) of that pose, `[rotation; translation]`.
    pub information: [[f64; 6]; 6],
    /// The figures on which it is decided.
    pub evidence: LoopEvidence,
    /// Why it is rejected, if it is.
    pub rejection: Option<LoopRejection>,
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

/// A decision with its figures. A pair may get several, and the last one counts: held first and then accepted, or changed by a person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopDecision {
    /// The pair, why it was proposed, and the guess.
    pub task: LoopTask,
    /// Pose found of `to` in `from`.
    pub from_from_to: Pose,
    /// The figures on which it is decided.
    pub evidence: LoopEvidence,
    /// The outcome.
    pub verdict: LoopVerdict,
    /// Whether a person decided.
    pub by_hand: bool,
    /// One sentence for people: why.
    pub reason: String,
}

/// A revisit of known ground, to be compared with an old keyframe. The stack keeps the clouds until the job fetches them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RevisitTask {
    /// The mapping session.
    pub session: SessionId,
    /// Number of the waypoint, counted along the walk.
    pub waypoint: u64,
    /// When the robot was there.
    pub stamp: Stamp,
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Guess of the base in it.
    pub guess: Pose,
}

/// The result of comparing a revisit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComparedRevisit {
    /// The task.
    pub task: RevisitTask,
    /// Pose found of the base in the keyframe.
    pub keyframe_from_base: Pose,
    /// Information (inverse covariance) of that pose, `[rotation; translation]`.
    pub information: [[f64; 6]; 6],
    /// The figures on which it is decided.
    pub evidence: LoopEvidence,
    /// Why it is rejected, if it is.
    pub rejection: Option<LoopRejection>,
}

/// A confirmed revisit. The robot's pose is relative to this keyframe from now on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reanchored {
    /// The mapping session.
    pub session: SessionId,
    /// When the robot was there.
    pub stamp: Stamp,
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Pose of the base in it then.
    pub keyframe_from_base: Pose,
    /// Information (inverse covariance) of that pose, `[rotation; translation]`. Zero along a bare corridor.
    pub information: [[f64; 6]; 6],
}
