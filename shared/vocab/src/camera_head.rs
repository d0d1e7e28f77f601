//! The head that carries a robot's cameras: where it is, how far it can be aimed, and an aim.

use serde::{Deserialize, Serialize};

/// The head of a robot's cameras, so that whoever knows the robot's pose can aim it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraHead {
    /// Where the axes of pan and tilt meet, which is also where the cameras are, metres, frame of the base.
    pub base_from_head_m: [f64; 3],
    /// It pans by at most this to either side, radians.
    pub pan_max_rad: f64,
    /// Lowest tilt, radians; negative is down.
    pub tilt_min_rad: f64,
    /// Highest tilt, radians.
    pub tilt_max_rad: f64,
    /// Greatest zoom.
    pub zoom_max: f64,
    /// Horizontal field of view at zoom 1, radians.
    pub field_of_view_rad: f64,
}

impl CameraHead {
    /// A common pan-tilt-zoom payload of walking robots. It is the default of the robot profile.
    pub const COMMON: Self = Self {
        base_from_head_m: [0.32, 0.0, 0.2],
        pan_max_rad: 170_f64.to_radians(),
        tilt_min_rad: -40_f64.to_radians(),
        tilt_max_rad: 80_f64.to_radians(),
        zoom_max: 20.0,
        field_of_view_rad: 60_f64.to_radians(),
    };
}

/// Where the head points, frame of the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraAim {
    /// To the left, radians.
    pub pan_rad: f64,
    /// Upwards, radians.
    pub tilt_rad: f64,
    /// Focal length relative to the shortest one.
    #[serde(default = "no_zoom")]
    pub zoom: f64,
}

fn no_zoom() -> f64 {
    1.0
}
