//! The executive: the only component that decides what moves the robot, and the behaviours that move it.
//!
//! [`TABLE`] holds all states and transitions. `docs/executive.md` is printed from it. [`Executive`] applies the table: it handles commands and
//! events, keeps the running goal until its outcome, and lets one [`Behaviour`] at a time set the velocity. Mapping and localisation are
//! services: the executive reads their state ([`Situation`]) and does not know how they work.

mod back_up;
#[cfg(test)]
mod back_up_tests;
mod behaviour;
mod docking;
#[cfg(test)]
mod docking_tests;
mod executive;
mod manual_driving;
mod pose_control;
mod pose_walk;
mod relocalisation;
mod route_goals;
mod running_goal;
mod surroundings;
mod table;
#[cfg(test)]
mod tests;
mod texts;
#[cfg(test)]
mod transcript_tests;
mod walk;
mod zones;

pub use back_up::BackUpConfig;
pub use behaviour::{Behaviour, BehaviourContext, BehaviourOutcome, Frames};
pub use docking::{DockGoal, DockingBehaviour, DockingConfig};
pub use executive::{Executive, ExecutiveConfig, Situation};
pub use manual_driving::{ManualDriving, StandBehaviour};
pub use pose_control::PoseControlConfig;
pub use pose_walk::{PoseWalkBehaviour, PoseWalkConfig};
pub use relocalisation::{RelocalisationBehaviour, RelocalisationConfig};
pub use running_goal::{GoalEvent, RouteLeg, RouteRemainder};
pub use surroundings::{Surroundings, SurroundingsConfig};
pub use table::{Action, Guard, TABLE, Transition, to_markdown};
pub use walk::{WalkBehaviour, WalkConfig};
pub use zones::{MapZone, MapZones, ZonesConfig};
