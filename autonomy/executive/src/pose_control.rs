//! How the last steps into a pose are controlled, on the floor and into docks.

use vocab::Span;

/// Gains of the last steps, and when the robot has come to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseControlConfig {
    /// Speed for each metre of distance, 1/s.
    pub position_gain_per_s: f64,
    /// Turning speed for each radian of heading error, 1/s.
    pub heading_gain_per_s: f64,
    /// The robot stands in the pose for this time before the walk has ended, so that nothing of its motion is left.
    pub settle_time: Span,
}

impl Default for PoseControlConfig {
    fn default() -> Self {
        Self { position_gain_per_s: 1.2, heading_gain_per_s: 1.8, settle_time: Span::from_millis(400) }
    }
}
