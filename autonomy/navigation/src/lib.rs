//! Navigation: walking to a point without collisions.
//!
//! The parts can be used alone: an elevation map ([`ElevationMap`]) that learns ground and obstacles from motion-corrected scans, a path planner over
//! it ([`plan`]), a choice of the next path for a robot whose pose is unknown ([`explore`]), a [`PathFollower`] that computes velocities along a
//! path, a [`MotionGuard`] that lets no velocity pass with which the robot could not stop in time, and a [`DockDetector`] that finds charging docks in scans.

mod cell_index;
mod clearance_field;
mod dock_config;
mod dock_detector;
#[cfg(test)]
mod dock_detector_tests;
mod dock_outline;
mod elevation_map;
mod elevation_map_config;
mod exploration;
mod lowest_beams;
mod motion_guard;
mod path_follower;
mod planner;
mod scan_cells;
mod texts;
mod zones;

pub use cell_index::CellIndex;
pub use dock_config::{DockDetectorConfig, DockMarker};
pub use dock_detector::{DockDetection, DockDetector, DockNotFound, DockScans};
pub use elevation_map::{Cell, ElevationMap, RobotShape};
pub use elevation_map_config::ElevationMapConfig;
pub use exploration::{ExplorationConfig, explore};
pub use motion_guard::{MotionGuard, MotionGuardConfig};
pub use path_follower::{PathFollower, PathFollowerConfig, Velocity};
pub use planner::{PlanError, PlannerConfig, plan};
pub use zones::{GroundZones, ZoneArea, ZoneRule};
