//! The head that pans and tilts, the pinhole model of its cameras, and zoom.

use geometry::{Isometry, Rotation, Vector3};
use messages::RobotProfile;
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, UnitQuaternion};
use vocab::{CameraAim, CameraHead};

/// The cameras on the head. By default the head is that of the default robot profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraConfig {
    /// Columns of a picture. Chosen: VGA; the time of rendering is in proportion to the pixels.
    pub width_px: u32,
    /// Rows of a picture. Chosen: VGA, as [`Self::width_px`].
    pub height_px: u32,
    /// Columns of a thermal picture. Chosen: the size of common thermal cameras, a quarter of the pixels of a photo.
    pub thermal_width_px: u32,
    /// Rows of a thermal picture. Chosen: as [`Self::thermal_width_px`].
    pub thermal_height_px: u32,
    /// Horizontal field of view at zoom 1, radians. Also that of the thermal camera, which does not zoom. It is that of the robot's profile.
    pub field_of_view_rad: f64,
    /// Greatest zoom. It is that of the robot's profile.
    pub zoom_max: f64,
    /// The head pans by at most this to either side, radians. It is that of the robot's profile.
    pub pan_max_rad: f64,
    /// Lowest tilt, radians; negative is down. It is that of the robot's profile.
    pub tilt_min_rad: f64,
    /// Highest tilt, radians. It is that of the robot's profile.
    pub tilt_max_rad: f64,
    /// Where the axes of pan and tilt meet, which is also where both cameras are, metres, frame of the base. It is that of the robot's profile.
    pub base_from_head_m: [f64; 3],
}

impl Default for CameraConfig {
    fn default() -> Self {
        let CameraHead {
            base_from_head_m,
            pan_max_rad,
            tilt_min_rad,
            tilt_max_rad,
            zoom_max,
            field_of_view_rad,
        } = RobotProfile::default().camera_head;
        Self {
            width_px: 640,
            height_px: 480,
            thermal_width_px: 320,
            thermal_height_px: 240,
            field_of_view_rad,
            zoom_max,
            pan_max_rad,
            tilt_min_rad,
            tilt_max_rad,
            base_from_head_m,
        }
    }
}

impl CameraConfig {
    /// The head, as the robot profile has it.
    pub fn head(&self) -> CameraHead {
        CameraHead {
            base_from_head_m: self.base_from_head_m,
            pan_max_rad: self.pan_max_rad,
            tilt_min_rad: self.tilt_min_rad,
            tilt_max_rad: self.tilt_max_rad,
            zoom_max: self.zoom_max,
            field_of_view_rad: self.field_of_view_rad,
        }
    }

    /// The nearest aim that the head can take.
    pub fn clamped(&self, aim: &CameraAim) -> CameraAim {
        let or_zero = |value: f64| if value.is_finite() { value } else { 0.0 };
        CameraAim {
            pan_rad: or_zero(aim.pan_rad).clamp(-self.pan_max_rad, self.pan_max_rad),
            tilt_rad: or_zero(aim.tilt_rad).clamp(self.tilt_min_rad, self.tilt_max_rad),
            zoom: if aim.zoom.is_finite() { aim.zoom.clamp(1.0, self.zoom_max) } else { 1.0 },
        }
    }

    /// Pose of both cameras in the base: x right, y down, z ahead.
    pub fn base_from_camera(&self, aim: &CameraAim) -> Isometry {
        let [x, y, z] = self.base_from_head_m;
        // Columns: the axes of the camera in the frame of a head that looks along x.
        let head_from_camera = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
        let head_from_camera = Rotation3::from_matrix_unchecked(head_from_camera);
        let base_from_head = Rotation::from_euler_angles(0.0, -aim.tilt_rad, aim.pan_rad);
        let rotation = base_from_head * UnitQuaternion::from_rotation_matrix(&head_from_camera);
        Isometry::from_parts(Translation3::new(x, y, z), rotation)
    }

    /// The aim at which a point is in the middle of the picture: `target_m` in the frame of the base, metres. The head's limits are not applied.
    pub fn aim_at(&self, target_m: &Vector3, zoom: f64) -> CameraAim {
        let offset = target_m - Vector3::from(self.base_from_head_m);
        CameraAim {
            pan_rad: offset.y.atan2(offset.x),
            tilt_rad: offset.z.atan2(offset.x.hypot(offset.y)),
            zoom,
        }
    }

    /// The camera at this zoom.
    pub fn intrinsics(&self, zoom: f64) -> Intrinsics {
        Intrinsics::new(self.width_px, self.height_px, self.field_of_view_rad, zoom)
    }

    /// The thermal camera.
    pub fn thermal_intrinsics(&self) -> Intrinsics {
        Intrinsics::new(self.thermal_width_px, self.thermal_height_px, self.field_of_view_rad, 1.0)
    }
}

/// The pinhole model of a camera without distortion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Columns.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
    /// Focal length, pixels, along both axes.
    pub focal_px: f64,
    /// Principal point, pixels from the outer corner of the top left pixel.
    pub centre_px: [f64; 2],
}

impl Intrinsics {
    fn new(width_px: u32, height_px: u32, field_of_view_rad: f64, zoom: f64) -> Self {
        let focal_px = 0.5 * f64::from(width_px) / (0.5 * field_of_view_rad).tan() * zoom;
        Self {
            width_px,
            height_px,
            focal_px,
            centre_px: [0.5 * f64::from(width_px), 0.5 * f64::from(height_px)],
        }
    }

    /// Direction of a point of the picture, not of unit length, frame of the camera.
    pub fn direction(&self, px: [f64; 2]) -> Vector3 {
        let [x, y] = [0, 1].map(|axis| (px[axis] - self.centre_px[axis]) / self.focal_px);
        Vector3::new(x, y, 1.0)
    }

    /// Where a point in the frame of the camera is in the picture, pixels; `None` behind the camera. It may be outside of the picture.
    pub fn project(&self, point: &Vector3) -> Option<[f64; 2]> {
        let scale = self.focal_px / point.z;
        (point.z > 1e-6).then(|| [point.x * scale + self.centre_px[0], point.y * scale + self.centre_px[1]])
    }
}

/// How far a target is from the centre of a picture, as a share of the picture along the axis on which it is greater, for scoring: the head is aimed by the estimate `map_from_base` at
/// `map_target_m`, and the picture is taken from the true pose `site_from_base` of what is at `site_target_m`. `None` where the head cannot point there, or the target is
/// behind it.
pub fn off_centre(
    site_from_base: &Isometry,
    map_from_base: &Isometry,
    map_target_m: &Vector3,
    site_target_m: &Vector3,
    zoom: f64,
) -> Option<f64> {
    let cameras = CameraConfig::default();
    let in_base = map_from_base.inverse_transform_point(&Point3::from(*map_target_m)).coords;
    let aim = cameras.aim_at(&in_base, zoom);
    if cameras.clamped(&aim) != aim {
        return None;
    }
    let site_from_camera = site_from_base * cameras.base_from_camera(&aim);
    let in_camera = site_from_camera.inverse_transform_point(&Point3::from(*site_target_m)).coords;
    let intrinsics = cameras.intrinsics(aim.zoom);
    let [x, y] = intrinsics.project(&in_camera)?;
    let [centre_x, centre_y] = intrinsics.centre_px;
    let across = (x - centre_x).abs() / f64::from(intrinsics.width_px);
    let down = (y - centre_y).abs() / f64::from(intrinsics.height_px);
    Some(across.max(down))
}
