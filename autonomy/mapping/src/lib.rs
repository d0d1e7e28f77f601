//! From odometry to a map: which scans become keyframes, the pose graph between them, the walked trajectory, and the places
//! where the walk came back to itself.
//!
//! A [`Session`] keeps poses only (about 1 kB a keyframe and 76 B a scan, 10 MB at most); full clouds go to its owner. A [`LoopFinder`] keeps a
//! small cloud of every keyframe (about 34 kB in all) and finds loops in four steps: `scan_context` and `places` recognise,
//! `candidates` chooses, `verify` registers, `consistency` decides. On known ground it ties the robot to old keyframes instead
//! (`visits`). `charts` finds one finished map in another. `dynamics` tells people from the site.
//! `vantage` makes keyframes of clouds that no robot has walked. `docs/maths/loops.md` has the method and its numbers.

pub mod candidates;
pub mod clique;
pub mod consistency;
pub mod drift;
pub mod dynamic_points;
mod ground_surface;
mod keyframe_descriptor;
mod loop_finder;
pub mod map_changes;
mod map_matcher;
mod odometer;
mod quality;
mod recent_scans;
mod revisits;
pub mod scan_context;
pub mod scan_context_index;
mod session;
pub mod submap;
#[cfg(test)]
mod testing;
mod uncertain_pose;
mod verify;
pub mod virtual_viewpoint;

pub use consistency::{ConsistencyConfig, Decision, LoopConsistencyCheck, Verdict};
pub use keyframe_descriptor::{
    KEYFRAME_DESCRIPTOR_VERSION, KeyframeDescriptor, KeyframeDescriptorParts, VIEW_ORIGINS,
};
pub use loop_finder::{LoopConfig, LoopFinder, MapKeyframe, NewKeyframe};
pub use map_matcher::{AlignmentError, MapAlignment, MapMatcher};
pub use odometer::Odometer;
pub use points::range_image;
pub use quality::{MapQuality, SurveyReason, SurveyTarget};
pub use revisits::{Novelty, Reanchoring, Revisit, RevisitResult};
pub use session::{DegenerateSegment, Edge, KeyframePolicy, Node, ScanPose, Session, Step, Waypoint, unit};
pub use uncertain_pose::UncertainPose;
pub use verify::{
    CandidateSource, Comparison, ComparisonResult, Evidence, RejectionReason, VerificationConfig,
    VerificationTask, VerifiedPair, compare, verify,
};
