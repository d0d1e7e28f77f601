//! Pose of the camera, with the directions that follow from it.

use glam::DVec3;

/// Pose of the camera, which looks at `target` from `distance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPose {
    /// The point in the middle of the image, m, map frame.
    pub target: DVec3,
    /// Heading of the line of sight, rad, counter-clockwise from the x axis seen from above.
    pub yaw: f64,
    /// Angle by which the line of sight points downwards, rad; a quarter turn is straight down.
    pub pitch: f64,
    /// Distance from the camera to the target, m.
    pub distance: f64,
}

impl Default for CameraPose {
    fn default() -> Self {
        Self { target: DVec3::ZERO, yaw: 0.7, pitch: 0.6, distance: 25.0 }
    }
}

impl CameraPose {
    /// Unit vector of the line of sight.
    pub fn forward(&self) -> DVec3 {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        DVec3::new(cos_yaw * cos_pitch, sin_yaw * cos_pitch, -sin_pitch)
    }

    /// Unit vector to the right of the image; horizontal.
    pub fn right(&self) -> DVec3 {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        DVec3::new(sin_yaw, -cos_yaw, 0.0)
    }

    /// Unit vector to the top of the image.
    pub fn up(&self) -> DVec3 {
        self.right().cross(self.forward())
    }

    /// Position of the camera, m, map frame.
    pub fn position(&self) -> DVec3 {
        self.target - self.forward() * self.distance
    }
}
