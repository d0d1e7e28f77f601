//! Navigation: walking to a point without collisions.
//!
//! The parts can be used alone: an elevation map ([`ElevationMap`]) that learns ground and obstacles from motion-corrected scans, a path planner over
//! it ([`plan`]), a choice of the next path for a robot whose pose is unknown ([`explore`]), and a [`PathFollower`] that computes velocities along a
//! path.

mod cell_index;
mod elevation_map;
mod exploration;
mod path_follower;
mod planner;
mod scan_cells;
mod texts;

pub use cell_index::CellIndex;
pub use elevation_map::{Cell, ElevationMap, ElevationMapConfig, RobotShape};
pub use exploration::{ExplorationConfig, explore};
pub use path_follower::{PathFollower, PathFollowerConfig, Velocity};
pub use planner::{PlanError, PlannerConfig, plan};
