//! Sentences for people, by key: refusals of the executive and descriptions of failed goals.

use messages::GoalFailure;

pub(crate) const VELOCITY_NOT_FINITE: &str = "That velocity is not a number. Reload the page and try again.";
pub(crate) const NOT_LOCALISED: &str =
    "The robot is not localised in the map yet. Wait until it is, or drive it by hand.";
pub(crate) const NO_POSE_TO_FIND: &str =
    "The robot does not search for its pose in a map. Choose \"Use this map\" on a saved map first.";
pub(crate) const MOTION_STOPPED: &str = "Motion is stopped. Press \"Allow motion\" first.";
pub(crate) const POINT_NOT_FINITE: &str = "That point is not on the map. Choose another.";

/// Why a goal failed, with what to do.
pub(crate) fn failure(reason: GoalFailure) -> &'static str {
    match reason {
        GoalFailure::PathBlocked => "The path stayed blocked. Choose another point or drive round by hand.",
        GoalFailure::PoseNotFound => {
            "The robot searched for its pose in the map and did not find it. Set the pose on the map, or drive the robot to a part where the map is right."
        }
        GoalFailure::MapReplaced => "The map was replaced. Choose a point of the new one.",
        GoalFailure::NoSuchPlace => "The topological map has no such place. Choose another.",
        GoalFailure::NoRoute => "No open route leads there. Open edges that are disabled or blocked.",
        GoalFailure::NotDocked => "The robot was not charged. Look at the dock and its place on the map.",
        GoalFailure::DockNotSeen => {
            "The robot saw no dock where the map has it. Clear the view of the dock, or correct its place on the map."
        }
        GoalFailure::NotUndocked => "The robot could not leave its dock. Clear the way in front of it.",
    }
}
