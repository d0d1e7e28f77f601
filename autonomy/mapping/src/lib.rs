//! From odometry to a map: keyframes, the pose graph between them, place recognition, loop closure, and known ground.
//!
//! A [`Session`] owns the [`PoseGraph`] and the trajectory (about 1.5 kB a keyframe and 68 B a scan). Full clouds go to the caller. A [`LoopFinder`]
//! keeps a thinned cloud of every keyframe (about 33 kB) and finds loops in four steps: `scan_context` and `scan_context_index` recognise,
//! `candidates` selects, `verification` registers, `consistency` decides. On known ground it anchors the robot's pose to old keyframes instead
//! (`known_ground`). [`LoopClosing`] runs these steps with jobs and people's decisions, and moves the map. [`MapMatcher`] finds one finished map in
//! another, [`MapSearch`] the robot in a finished map. `dynamic_points` removes people, `map_changes` finds what changed, `virtual_viewpoint` makes
//! keyframes of clouds that no robot has walked. docs/maths/loops.md describes the methods and their parameters.

pub mod candidates;
pub mod clique;
pub mod consistency;
pub mod covariance_graph;
pub mod dynamic_points;
mod floor_detection;
mod graph_element;
mod graph_optimiser;
mod graph_publisher;
pub mod ground_surface;
mod keyframe_descriptor;
mod known_ground;
mod last_map;
mod loop_closing;
mod loop_finder;
pub mod map_changes;
mod map_matcher;
mod map_search;
mod odometer;
pub mod odometry_chain;
mod packed_indices;
mod pose_graph;
mod quality;
mod recent_scans;
mod registration_floor;
mod revisits;
pub mod scan_context;
pub mod scan_context_index;
mod session;
pub mod submap;
#[cfg(test)]
mod testing;
mod uncertain_pose;
mod verification;
mod verification_queue;
mod vertical;
pub mod virtual_viewpoint;

pub use consistency::{Decision, LoopConsistencyCheck, LoopConsistencyConfig, Verdict};
pub use floor_detection::{FloorDetectionConfig, estimate_base_height};
pub use graph_element::{PoseGraphEdge, PoseGraphNode, renormalised};
pub use graph_optimiser::{GraphError, KeyframePair, OptimiserConfig, Relinearisation};
pub use graph_publisher::{GraphChanges, GraphPublisher, GraphPublisherConfig};
pub use keyframe_descriptor::{
    KEYFRAME_DESCRIPTOR_VERSION, KeyframeDescriptor, KeyframeDescriptorParts, VIEW_ORIGINS,
};
pub use last_map::{LastSavedMap, LastSavedMapConfig};
pub use loop_closing::{
    AddedWaypoint, ComparedPair, LoopClosing, LoopClosingConfig, LoopCommandError, LoopEvents, LoopOutcome,
    LoopRecord, ReanchoredEvent, RevisitCounts,
};
pub use loop_finder::{LoopConfig, LoopFinder, MapKeyframe, NewKeyframe};
pub use map_matcher::{AlignmentError, MapAlignment, MapMatcher, MapMatcherConfig};
pub use map_search::{MapSearch, MapSearchConfig, MapSearchData, MapSearchFix};
pub use odometer::{Odometer, OdometerConfig};
pub use packed_indices::PackedIndices;
pub use points::{line_of_sight, range_image};
pub use pose_graph::PoseGraph;
pub use quality::{MapQuality, MapQualityConfig, MapQualityData, SurveyReason, SurveyTarget};
pub use revisits::{Novelty, Reanchoring, Revisit, RevisitConfig, RevisitResult};
pub use session::{
    DegenerateSegment, KeyframePolicy, OdometryStep, ScanPose, Session, SessionConfig, Waypoint,
};
pub use submap::SubmapConfig;
pub use uncertain_pose::{CHI_SQUARED_6_999, PoseCertaintyConfig, UncertainPose};
pub use verification::{
    CandidateSource, Comparison, ComparisonResult, PairEvidence, RejectionReason, VerificationConfig,
    VerificationTask, VerifiedPair, compare, verify,
};
pub use verification_queue::{QueuedComparison, VerificationQueueConfig};
pub use vertical::{MeasuredVertical, RelativeTilt};
