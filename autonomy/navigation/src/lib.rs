//! Getting from here to a point without hitting anything.
//!
//! Parts, each usable alone: a [`Terrain`] grid that learns ground and obstacles from motion-corrected scans, a [`plan`] over it or, for
//! a robot that is lost, somewhere to [`roam`] to, and a [`Follower`] that turns a path into velocities.

mod follower;
mod planner;
mod roam;
mod terrain;

pub use follower::{Follower, FollowerConfig, Velocity};
pub use planner::{PlanError, plan};
pub use roam::roam;
pub use terrain::{Cell, CellIndex, RobotShape, Terrain};
