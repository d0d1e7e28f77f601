//! Getting to a point without hitting anything.
//!
//! The parts can be used alone: an elevation map ([`ElevationMap`]) that learns ground and obstacles from motion-corrected scans, a path planner over it
//! ([`plan`]), a search for somewhere to walk for a robot that is lost ([`explore`]), and a [`PathFollower`] that turns a path into velocities.

mod elevation_map;
mod exploration;
mod path_follower;
mod planner;

pub use elevation_map::{Cell, CellIndex, ElevationMap, ElevationMapConfig, RobotShape};
pub use exploration::{ExplorationConfig, explore};
pub use path_follower::{PathFollower, PathFollowerConfig, Velocity};
pub use planner::{PlanError, PlannerConfig, plan};
