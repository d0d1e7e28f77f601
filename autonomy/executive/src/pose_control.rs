//! How the last steps into a pose are controlled, on the floor and into docks.

use vocab::Span;

/// Gains of the last steps, and when the robot has come to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseControlConfig {
    /// Speed for each metre of distance, 1/s. Chosen: errors fall by a factor of e in 0.8 s, several times the delay of scan and legs (0.2 s,
    /// [`navigation::MotionGuardConfig`]). More makes the robot swing.
    pub position_gain_per_s: f64,
    /// Turning speed for each radian of heading error, 1/s. Chosen: errors fall by a factor of e in 0.6 s, so that the heading is right before the position.
    pub heading_gain_per_s: f64,
    /// The robot stands in the pose for this time before the walk has ended, so that nothing of its motion is left. Chosen: twice the delay of scan and legs.
    pub settle_time: Span,
}

impl Default for PoseControlConfig {
    fn default() -> Self {
        Self { position_gain_per_s: 1.2, heading_gain_per_s: 1.8, settle_time: Span::from_millis(400) }
    }
}
