//! Aims a robot's camera at a target in the map, by the robot's own estimate of its pose.

use crate::texts;
use geometry::Vector3;
use serde::Deserialize;
use site_model::{GaugeDial, LocalisationQuality, ReportPlace};
use vocab::{CameraAim, CameraHead, MapId, Pose, Vec3};

/// Parameters of [`aim`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AimConfig {
    /// A target nearer to the head than this gives no direction, metres. Chosen: the size of the camera itself.
    pub min_target_distance_m: f64,
}

impl Default for AimConfig {
    fn default() -> Self {
        Self { min_target_distance_m: 0.05 }
    }
}

/// Parameters of actions that take pictures.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct PictureParameters {
    /// What is to be in the middle of the picture, metres, map frame. Without it the angles count.
    pub target_m: Option<[f64; 3]>,
    /// To the left, radians.
    #[serde(default)]
    pub pan_rad: f64,
    /// Upwards, radians.
    #[serde(default)]
    pub tilt_rad: f64,
    /// Focal length relative to the shortest one.
    pub zoom: Option<f64>,
    /// The gauge that is read in the picture.
    #[serde(default)]
    pub gauge: Option<GaugeDial>,
}

/// Why the camera cannot be aimed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AimFailure {
    /// The robot's pose in the map is not known.
    PlaceUnknown,
    /// The target is at the head, or no number.
    NoDirection,
    /// The head does not pan that far: the body has to turn by at least this to the left (negative: to the right), radians.
    BeyondPan {
        /// The turn.
        turn_rad: f64,
    },
    /// The head does not tilt that far: the target is too high (negative: too low) by this, radians.
    BeyondTilt {
        /// Beyond the limit.
        excess_rad: f64,
    },
}

impl AimFailure {
    /// For people.
    pub fn sentence(self) -> String {
        match self {
            Self::PlaceUnknown => texts::AIM_WITHOUT_PLACE.to_owned(),
            Self::NoDirection => texts::AIM_WITHOUT_DIRECTION.to_owned(),
            Self::BeyondPan { turn_rad } => texts::aim_beyond_pan(turn_rad),
            Self::BeyondTilt { excess_rad } => texts::aim_beyond_tilt(excess_rad),
        }
    }
}

/// The cameras in the map, and the target, both metres in the map frame. None without a target or a place.
pub fn sight_line(
    head: &CameraHead,
    parameters: &PictureParameters,
    place: Option<&ReportPlace>,
) -> Option<(MapId, [Vector3; 2])> {
    let (place, target) = (place?, parameters.target_m?);
    let map_from_base = geometry::isometry_from_pose(&place.map_from_base)?;
    let camera = map_from_base * nalgebra::Point3::from(head.base_from_head_m);
    Some((place.map?, [camera.coords, Vector3::from(target)]))
}

/// The aim that these parameters ask for, with the robot at this place.
///
/// # Errors
/// When the head cannot point there.
pub fn aim(
    config: &AimConfig,
    head: &CameraHead,
    parameters: &PictureParameters,
    place: Option<&ReportPlace>,
) -> Result<CameraAim, AimFailure> {
    let zoom =
        parameters.zoom.filter(|zoom| zoom.is_finite()).unwrap_or(1.0).clamp(1.0, head.zoom_max.max(1.0));
    let (pan_rad, tilt_rad) = match parameters.target_m {
        None => (parameters.pan_rad, parameters.tilt_rad),
        Some(target) => {
            let place = place.filter(|place| place.quality != LocalisationQuality::Lost);
            let map_from_base = place.ok_or(AimFailure::PlaceUnknown)?.map_from_base;
            direction(config, head, &map_from_base, Vec3::from(target))?
        }
    };
    if !pan_rad.is_finite() || !tilt_rad.is_finite() {
        return Err(AimFailure::NoDirection);
    }
    if pan_rad.abs() > head.pan_max_rad {
        let turn_rad = (pan_rad.abs() - head.pan_max_rad).copysign(pan_rad);
        return Err(AimFailure::BeyondPan { turn_rad });
    }
    // Limits of a robot that contradict each other are no panic.
    let excess_rad = tilt_rad - tilt_rad.max(head.tilt_min_rad).min(head.tilt_max_rad);
    if excess_rad != 0.0 {
        return Err(AimFailure::BeyondTilt { excess_rad });
    }
    Ok(CameraAim { pan_rad, tilt_rad, zoom })
}

/// Pan and tilt towards a point of the map, radians.
fn direction(
    config: &AimConfig,
    head: &CameraHead,
    map_from_base: &Pose,
    target: Vec3,
) -> Result<(f64, f64), AimFailure> {
    let map_from_base = geometry::isometry_from_pose(map_from_base).ok_or(AimFailure::PlaceUnknown)?;
    let in_base = map_from_base.inverse_transform_point(&geometry::vec_from_plain(target).into());
    let offset = in_base.coords - Vector3::from(head.base_from_head_m);
    let is_direction = offset.norm() >= config.min_target_distance_m && offset.norm().is_finite();
    is_direction
        .then(|| (offset.y.atan2(offset.x), offset.z.atan2(offset.x.hypot(offset.y))))
        .ok_or(AimFailure::NoDirection)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::{Covariance6, Quat};

    const HEAD: CameraHead = CameraHead {
        base_from_head_m: [0.3, 0.0, 0.2],
        pan_max_rad: 2.9,
        tilt_min_rad: -0.7,
        tilt_max_rad: 1.4,
        zoom_max: 20.0,
        field_of_view_rad: 1.0,
    };

    /// At (1, 2, 0.5), turned a quarter to the left.
    fn place(quality: LocalisationQuality) -> ReportPlace {
        let root = std::f64::consts::FRAC_1_SQRT_2;
        let orientation = Quat { w: root, x: 0.0, y: 0.0, z: root };
        let map_from_base = Pose { position: Vec3::new(1.0, 2.0, 0.5), orientation };
        ReportPlace { map: None, map_from_base, covariance: Covariance6::default(), quality }
    }

    fn aim_at(target: [f64; 3]) -> Result<CameraAim, AimFailure> {
        let parameters = PictureParameters { target_m: Some(target), ..PictureParameters::default() };
        aim(&AimConfig::default(), &HEAD, &parameters, Some(&place(LocalisationQuality::Good)))
    }

    #[test]
    fn a_target_in_the_map_gives_angles_in_the_frame_of_the_base() {
        // Straight ahead of the head, at its height.
        let ahead = aim_at([1.0, 6.0, 0.7]).expect("in reach");
        assert!(
            ahead.pan_rad.abs() < 1e-12 && ahead.tilt_rad.abs() < 1e-12 && ahead.zoom == 1.0,
            "{ahead:?}"
        );
        // The robot looks along y, so what has a smaller x is on its left.
        let left = aim_at([-1.0, 4.3, 2.7]).expect("in reach");
        assert!((left.pan_rad - std::f64::consts::FRAC_PI_4).abs() < 1e-12, "{left:?}");
        assert!((left.tilt_rad - (2.0_f64 / 8.0_f64.sqrt()).atan()).abs() < 1e-12, "{left:?}");
    }

    #[test]
    fn what_is_behind_says_how_far_the_body_must_turn() {
        // Behind the head, 0.1 rad to the left of straight back.
        let back = [1.0 - 4.0 * 0.1_f64.sin(), 2.3 - 4.0 * 0.1_f64.cos(), 0.7];
        let Err(AimFailure::BeyondPan { turn_rad }) = aim_at(back) else { panic!("in reach") };
        assert!((turn_rad - (std::f64::consts::PI - 0.1 - 2.9)).abs() < 1e-9, "{turn_rad}");
        let right = [1.0 + 4.0 * 0.1_f64.sin(), back[1], 0.7];
        assert!(matches!(aim_at(right), Err(AimFailure::BeyondPan { turn_rad }) if turn_rad < 0.0));
        assert!(AimFailure::BeyondPan { turn_rad: -0.3 }.sentence().contains("18° to the right"));
    }

    #[test]
    fn what_is_too_high_or_nowhere_is_refused() {
        assert!(
            matches!(aim_at([1.0, 2.31, 4.0]), Err(AimFailure::BeyondTilt { excess_rad }) if excess_rad > 0.0)
        );
        assert!(
            matches!(aim_at([1.0, 3.0, 0.0 - 3.0]), Err(AimFailure::BeyondTilt { excess_rad }) if excess_rad < 0.0)
        );
        assert_eq!(aim_at([1.0, 2.3, 0.7]), Err(AimFailure::NoDirection));
        assert_eq!(aim_at([f64::NAN, 2.0, 0.0]), Err(AimFailure::NoDirection));
        let target = PictureParameters { target_m: Some([1.0, 6.0, 0.7]), ..PictureParameters::default() };
        assert_eq!(aim(&AimConfig::default(), &HEAD, &target, None), Err(AimFailure::PlaceUnknown));
        let lost = place(LocalisationQuality::Lost);
        assert_eq!(aim(&AimConfig::default(), &HEAD, &target, Some(&lost)), Err(AimFailure::PlaceUnknown));
    }

    #[test]
    fn without_a_target_the_angles_count_and_zoom_stays_within_its_range() {
        let given =
            PictureParameters { pan_rad: -0.5, tilt_rad: 0.2, zoom: Some(99.0), target_m: None, gauge: None };
        assert_eq!(
            aim(&AimConfig::default(), &HEAD, &given, None),
            Ok(CameraAim { pan_rad: -0.5, tilt_rad: 0.2, zoom: 20.0 })
        );
        let behind = PictureParameters { pan_rad: 3.0, ..given };
        assert!(matches!(
            aim(&AimConfig::default(), &HEAD, &behind, None),
            Err(AimFailure::BeyondPan { .. })
        ));
    }
}
