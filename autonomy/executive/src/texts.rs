//! Refusals of the executive for people, by key. Why a goal failed says [`messages::GoalFailure::sentence`].

pub(crate) const VELOCITY_NOT_FINITE: &str = "That velocity is not a number. Reload the page and try again.";
pub(crate) const NOT_LOCALISED: &str =
    "The robot is not localised in the map yet. Wait until it is, or drive it by hand.";
pub(crate) const NO_POSE_TO_FIND: &str =
    "The robot does not search for its pose in a map. Choose \"Use this map\" on a saved map first.";
pub(crate) const MOTION_STOPPED: &str = "Motion is stopped. Press \"Allow motion\" first.";
pub(crate) const POINT_NOT_FINITE: &str = "That point is not on the map. Choose another.";
