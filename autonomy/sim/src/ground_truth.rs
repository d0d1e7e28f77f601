//! The robot's true state, for scorers and recordings.

use vocab::{Pose, Stamp, Twist};

/// The true state of the robot at one instant. Only scorers and recordings may use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundTruth {
    /// The instant.
    pub stamp: Stamp,
    /// Pose of the base in the site.
    pub site_from_base: Pose,
    /// Velocity of the base in its own frame.
    pub velocity: Twist,
}
