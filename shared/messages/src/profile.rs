//! The robot profile: everything about a robot's body and its limits that the stack needs. None of it is compiled in.

use serde::{Deserialize, Serialize};
use vocab::{Aabb, CameraHead, Span};

/// Body and limits of a robot. [`Default`] is a common robot with four legs, about 1 m long. The simulated walker of `autonomy/sim` differs from it in its standing height, 0.52 m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotProfile {
    /// Name of the robot, for people.
    pub name: String,
    /// Radius of the circle that the robot turns in, metres. Its footprint for planning.
    pub footprint_radius_m: f64,
    /// Height over the ground that must be free for the robot to pass, metres.
    pub clearance_height_m: f64,
    /// Height of the base over the ground while the robot stands, metres.
    pub standing_height_m: f64,
    /// Highest step that the robot takes, metres.
    pub step_height_m: f64,
    /// Speed limits while the robot walks by itself.
    pub autonomous_limits: SpeedLimits,
    /// Speed limits while a person drives.
    pub manual_limits: SpeedLimits,
    /// A robot that is driven by hand stops when no velocity has come for this time.
    pub manual_watchdog: Span,
    /// Box in the base frame that the robot's own body fills, metres. LiDAR points inside are dropped. None drops none.
    pub self_filter: Option<Aabb>,
    /// A keyframe is made after this distance, metres.
    pub keyframe_distance_m: f64,
    /// A keyframe is made after this rotation, radians.
    pub keyframe_rotation_rad: f64,
    /// The head of its cameras, by which whoever knows its pose aims them.
    pub camera_head: CameraHead,
}

/// Greatest speeds of the base in its own frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedLimits {
    /// Forwards and backwards, m/s.
    pub forward_m_s: f64,
    /// To either side, m/s.
    pub sideways_m_s: f64,
    /// Turning to either side, rad/s.
    pub turn_rad_s: f64,
}

impl Default for RobotProfile {
    fn default() -> Self {
        Self {
            name: String::new(),
            footprint_radius_m: 0.38,
            clearance_height_m: 0.95,
            standing_height_m: 0.55,
            step_height_m: 0.22,
            autonomous_limits: SpeedLimits { forward_m_s: 0.9, sideways_m_s: 0.25, turn_rad_s: 0.9 },
            manual_limits: SpeedLimits { forward_m_s: 1.2, sideways_m_s: 0.5, turn_rad_s: 1.0 },
            manual_watchdog: Span::from_millis(500),
            self_filter: None,
            // Neighbouring scans of a Hesai XT-32 then overlap by more than 80 % indoors.
            keyframe_distance_m: 1.0,
            keyframe_rotation_rad: 0.7,
            camera_head: CameraHead::COMMON,
        }
    }
}
