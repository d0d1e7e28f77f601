//! Sentences for people, by key: why there is no path.

pub(crate) const GOAL_BLOCKED: &str = "Something stands at that point. Choose a free place on the floor.";
pub(crate) const GOAL_KEPT_OUT: &str =
    "That point lies in a keep-out zone. Choose another, or change the zone on the Site screen.";
pub(crate) const START_BLOCKED: &str =
    "The robot is too close to an obstacle to plan a way. Drive it clear by hand first.";
pub(crate) const NO_PATH: &str =
    "No free way to that point is known yet. Drive closer by hand, or choose another point.";
pub(crate) const TOO_FAR: &str = "That point is too far away for one walk. Choose a nearer one on the way.";
