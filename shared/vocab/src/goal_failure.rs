//! Why a goal of the robot was not reached, in the core, on the wire and in the client.

use serde::{Deserialize, Serialize};

/// Why a goal was not reached. Recordings and messages hold the number of the variant, so new ones come last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum GoalFailure {
    /// No path was free for too long.
    PathBlocked,
    /// The robot's pose in the map was not found in time.
    PoseNotFound,
    /// The map or its frame was replaced, so that a point in it means nothing any more.
    MapReplaced,
    /// The topological map has no such place.
    NoSuchPlace,
    /// No route leads there over edges that are open.
    NoRoute,
    /// The robot was not charged after all attempts to dock.
    NotDocked,
    /// The robot could not leave its dock.
    NotUndocked,
    /// The scans showed no dock where the map has it.
    DockNotSeen,
}

impl GoalFailure {
    /// For people: what happened and what to do. English.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::PathBlocked => "The path stayed blocked. Choose another point or drive round by hand.",
            Self::PoseNotFound => {
                "The robot searched for its pose in the map and did not find it. Set the pose on the map, or drive the robot to a part where the map is right."
            }
            Self::MapReplaced => "The map was replaced. Choose a point of the new one.",
            Self::NoSuchPlace => "The topological map has no such place. Choose another.",
            Self::NoRoute => "No open route leads there. Open edges that are disabled or blocked.",
            Self::NotDocked => "The robot was not charged. Look at the dock and its place on the map.",
            Self::DockNotSeen => {
                "The robot saw no dock where the map has it. Clear the view of the dock, or correct its place on the map."
            }
            Self::NotUndocked => "The robot could not leave its dock. Clear the way in front of it.",
        }
    }
}
