//! Localisation in a known map: finding the robot's pose, tracking it, and judging its reliability.
//!
//! A [`LocalisationMap`] holds the surfaces of the known map and the free space that its keyframes saw. A [`GlobalLocaliser`] finds the poses at
//! which one scan may have been taken, a [`MultiHypothesisTracker`] follows them until one is left, and a [`PoseTracker`] keeps that one from scan to
//! scan. [`plan_disambiguation`] plans a path that distinguishes poses which look alike. A [`Localiser`] combines all of these. Each scan is compared
//! with the free space of the keyframes near it: a person or a moved rack violates a small part of it, and a wrong pose violates most of it.
//! `docs/maths/localisation.md` has the method, its symbols and its numbered equations.

mod adaptive_voxel_filter;
mod bit_grid;
mod correlative_matcher;
mod disambiguation;
mod disambiguation_schedule;
mod dock_registry;
mod global_localiser;
mod localisation_map;
mod localisation_monitor;
mod localiser;
mod low_confidence;
mod multi_hypothesis_tracker;
mod periodic_global_check;
mod pose_hypothesis;
mod pose_tracker;
mod relocalisation_request;
mod request_progress;
#[cfg(test)]
mod testing;
mod tiled_surfaces;

pub use adaptive_voxel_filter::{AdaptiveVoxelFilter, AdaptiveVoxelFilterConfig};
pub use correlative_matcher::CorrelativeMatcherConfig;
pub use disambiguation::{DisambiguationConfig, plan_disambiguation};
pub use disambiguation_schedule::{DisambiguationWork, ExplorationHint};
pub use dock_registry::{DockRegistry, DockRegistryConfig, MapDock};
pub use global_localiser::{GlobalLocaliser, GlobalLocaliserConfig, PosePrior};
pub use localisation_map::{FreeSpaceCheck, FreeSpaceCheckConfig, LocalisationMap, LocalisationMapConfig};
pub use localisation_monitor::{
    DegradationReason, LocalisationMonitorConfig, LocalisationStatus, PoseEvidence,
};
pub use localiser::{
    InitialPose, LocalisationTransition, LocalisationWork, Localiser, LocaliserConfig, LocaliserState,
    OdometryScan,
};
pub use low_confidence::LowConfidenceConfig;
pub use multi_hypothesis_tracker::{MultiHypothesisConfig, MultiHypothesisTracker};
pub use periodic_global_check::PeriodicGlobalCheckConfig;
pub use pose_hypothesis::{AcceptanceConfig, HypothesisTolerance, PoseHypothesis, RelocalisationResult};
pub use pose_tracker::{DownsampledScan, PoseTracker, PoseTrackerConfig, TrackedPose};
pub use relocalisation_request::{RelocalisationRequestConfig, RelocalisationWork};
pub use tiled_surfaces::{TiledSurfaces, TiledSurfacesConfig};
