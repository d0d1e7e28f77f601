//! Getting from here to a point without hitting anything.
//!
//! Three parts, each usable alone: a [`Terrain`] grid that learns ground and obstacles from motion-corrected scans, a
//! [`plan`] over it, and a [`Follower`] that turns a path into velocities.

mod follower;
mod planner;
mod terrain;

pub use follower::{Follower, FollowerConfig, Velocity};
pub use planner::{PlanError, plan};
pub use terrain::{Cell, CellIndex, RobotShape, Terrain};
