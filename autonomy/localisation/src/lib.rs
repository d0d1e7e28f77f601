//! Keeping the robot's pose in a known map, and knowing how far it can be believed.
//!
//! A [`LocalisationMap`] is what the known map says of the site: its surfaces, and what its keyframes saw through. A [`PoseTracker`] carries the
//! pose from scan to scan by odometry's motion, corrects it by fitting each scan to those surfaces, and asks the keyframes' sight
//! whether the scan can have been taken there at all: a person or a rack that was moved contradicts a little of what they saw, a wrong
//! place most of it. `docs/maths/localisation.md` has the method and its numbers.

mod adaptive_voxel_filter;
mod bit_grid;
mod correlative_matcher;
mod disambiguation;
mod global_localiser;
mod localisation_map;
mod localisation_monitor;
mod pose_tracker;
mod tiled_surfaces;

pub use adaptive_voxel_filter::AdaptiveVoxelFilter;
pub use global_localiser::{
    GlobalLocaliser, PoseHypothesis, RelocalisationResult, classify_hypotheses, is_same_place,
};
pub use localisation_map::{FreeSpaceCheck, LocalisationMap};
pub use localisation_monitor::{DegradationReason, LocalisationStatus, PoseEvidence};
pub use pose_tracker::{DownsampledScan, PoseTracker, TrackedPose};
pub use tiled_surfaces::TiledSurfaces;
