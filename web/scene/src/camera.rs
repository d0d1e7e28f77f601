//! The camera: it looks at a target. Gestures move it, and it flies to new poses.
//!
//! A gesture acts at once and ends a flight. All methods accept any number: an input that is not finite changes nothing.

use crate::camera_pose::CameraPose;
use crate::projection::CameraProjection;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Parameters of [`Camera`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneCameraConfig {
    /// Duration of a flight, s. Chosen: people follow where the camera goes, and wait for nothing.
    pub flight_duration_s: f64,
    /// Shortest distance between camera and target, m. Ten times [`CameraProjection::NEAR_M`]; close
    /// enough to inspect a surface.
    pub min_distance_m: f64,
    /// Longest distance between camera and target, m. Chosen: three times the greatest coordinate of a building model, 1 km.
    pub max_distance_m: f64,
    /// Lowest pitch, rad. Below the horizon, so that ceilings can be looked at. Chosen: 81 degrees; at 90, the heading of the camera would be undefined.
    pub min_pitch_rad: f64,
    /// Highest pitch, rad: straight down. Chosen: beyond it, the picture would be upside down.
    pub max_pitch_rad: f64,
    /// Rotation for each logical pixel of an orbiting drag, rad. Chosen: a drag over half of a screen of 1,000 px is half a turn.
    pub orbit_rad_per_px: f64,
    /// Lower limit of the foreshortening of the ground while panning (sine of the pitch). Near the horizon a drag would otherwise move the target without limit. Chosen:
    /// 20 degrees; with less, the ground moves farther than the pointer seems to.
    pub min_foreshortening: f64,
    /// Share of the free area that a fitted box takes along its tighter side. Chosen: a margin of 3 % on each side.
    pub fitted_share: f64,
}

impl Default for SceneCameraConfig {
    fn default() -> Self {
        Self {
            flight_duration_s: 0.3,
            min_distance_m: 0.1,
            max_distance_m: 3000.0,
            min_pitch_rad: -0.45 * PI,
            max_pitch_rad: 0.5 * PI,
            orbit_rad_per_px: 0.006,
            min_foreshortening: 0.35,
            fitted_share: 0.94,
        }
    }
}

impl CameraPose {
    /// The same pose with every number in its range; `fallback` if a number is not finite.
    fn clamped(mut self, config: &SceneCameraConfig, fallback: &Self) -> Self {
        let finite = self.target.is_finite() && self.yaw.is_finite() && self.pitch.is_finite();
        if !finite || !self.distance.is_finite() {
            return *fallback;
        }
        self.pitch = self.pitch.clamp(config.min_pitch_rad, config.max_pitch_rad);
        self.distance = self.distance.clamp(config.min_distance_m, config.max_distance_m);
        self.yaw = self.yaw.rem_euclid(TAU);
        self
    }
}

/// The part of a viewport that nothing covers, pixels from its top left corner, y down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeArea {
    /// Top left corner.
    pub min_px: DVec2,
    /// Bottom right corner.
    pub max_px: DVec2,
}

impl FreeArea {
    /// The whole viewport.
    pub fn whole(viewport_px: [u32; 2]) -> Self {
        Self { min_px: DVec2::ZERO, max_px: DVec2::from_array(viewport_px.map(f64::from)) }
    }
}

/// A camera that gestures and flights move.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Camera {
    config: SceneCameraConfig,
    pose: CameraPose,
    flight: Option<Flight>,
}

#[derive(Clone, Debug, PartialEq)]
struct Flight {
    from: CameraPose,
    to: CameraPose,
    elapsed_s: f64,
}

impl Camera {
    /// A camera at rest.
    pub fn new(config: SceneCameraConfig, pose: CameraPose) -> Self {
        Self { pose: pose.clamped(&config, &CameraPose::default()), config, flight: None }
    }

    /// The present pose.
    pub fn pose(&self) -> CameraPose {
        self.pose
    }

    /// Whether a flight is under way, so that another frame is due.
    pub fn is_flying(&self) -> bool {
        self.flight.is_some()
    }

    /// Sets the pose without a flight.
    pub fn jump_to(&mut self, pose: CameraPose) {
        self.flight = None;
        self.pose = pose.clamped(&self.config, &self.pose);
    }

    /// Flies to a pose within [`SceneCameraConfig::flight_duration_s`], turning by the smaller angle.
    pub fn fly_to(&mut self, pose: CameraPose) {
        let mut to = pose.clamped(&self.config, &self.pose);
        let turn = (to.yaw - self.pose.yaw + PI).rem_euclid(TAU) - PI;
        to.yaw = self.pose.yaw + turn;
        self.flight = Some(Flight { from: self.pose, to, elapsed_s: 0.0 });
    }

    /// Advances a flight by `elapsed_s`; returns whether the camera moved.
    pub fn advance(&mut self, elapsed_s: f64) -> bool {
        let Some(flight) = &mut self.flight else {
            return false;
        };
        flight.elapsed_s += elapsed_s.max(0.0);
        let progress = (flight.elapsed_s / self.config.flight_duration_s).min(1.0);
        let eased = progress * progress * (3.0 - 2.0 * progress);
        let (from, to) = (&flight.from, &flight.to);
        let mix = |a: f64, b: f64| a + (b - a) * eased;
        let pose = CameraPose {
            target: from.target.lerp(to.target, eased),
            yaw: mix(from.yaw, to.yaw),
            pitch: mix(from.pitch, to.pitch),
            // Interpolated in the logarithm, so that the scale changes evenly.
            distance: mix(from.distance.ln(), to.distance.ln()).exp(),
        };
        if progress >= 1.0 {
            self.flight = None;
        }
        self.pose = pose.clamped(&self.config, &self.pose);
        true
    }

    /// Ends a flight and sets the pose that it would have reached.
    pub fn finish_flight(&mut self) {
        self.advance(self.config.flight_duration_s);
    }

    /// Turns about the target by a drag in logical pixels (y down).
    pub fn orbit(&mut self, drag_px: DVec2) {
        let rate = self.config.orbit_rad_per_px;
        self.change(|pose| {
            pose.yaw -= drag_px.x * rate;
            pose.pitch += drag_px.y * rate;
        });
    }

    /// Moves the target so that the plane through it follows a drag in pixels (y down), where the image is
    /// `height_px` pixels high. Seen from above the horizon, a drag moves along the ground.
    pub fn pan(&mut self, drag_px: DVec2, height_px: f64) {
        let min_foreshortening = self.config.min_foreshortening;
        self.change(|pose| {
            let metres_per_px = 2.0 * pose.distance * CameraProjection::TAN_HALF_FOV / height_px.max(1.0);
            let (sin_yaw, cos_yaw) = pose.yaw.sin_cos();
            let ahead = DVec3::new(cos_yaw, sin_yaw, 0.0);
            let foreshortening = pose.pitch.sin().abs().max(min_foreshortening);
            pose.target += ahead * (drag_px.y * metres_per_px / foreshortening);
            pose.target -= pose.right() * (drag_px.x * metres_per_px);
        });
    }

    /// Zooms by `factor` (above 1 goes nearer). `focus` (m, map frame) stays at its pixel.
    pub fn zoom(&mut self, factor: f64, focus: DVec3) {
        let config = self.config;
        self.change(|pose| {
            if factor > 0.0 && focus.is_finite() {
                let distance = (pose.distance / factor).clamp(config.min_distance_m, config.max_distance_m);
                let scale = distance / pose.distance;
                pose.target = focus + (pose.target - focus) * scale;
                pose.distance = distance;
            }
        });
    }

    /// Moves the target along the line of sight to the depth of `point` (m, map frame); the image stays as it is. Orbiting, panning and
    /// zooming then refer to this depth, and [`SceneCameraConfig::min_distance_m`] limits the distance to it. A point behind the camera
    /// changes nothing.
    pub fn move_target_to_depth_of(&mut self, point: DVec3) {
        let position = self.pose.position();
        let depth = (point - position).dot(self.pose.forward());
        if depth.is_finite() && depth >= self.config.min_distance_m {
            self.change(|pose| {
                pose.target = position + pose.forward() * depth;
                pose.distance = depth;
            });
        }
    }

    /// The pose with the present direction that shows a whole box (m, map frame) in the middle of the free area; the present pose for an
    /// empty box or area.
    pub fn pose_fitting(&self, min: DVec3, max: DVec3, viewport_px: [u32; 2], free: FreeArea) -> CameraPose {
        let viewport = DVec2::from_array(viewport_px.map(|side| f64::from(side.max(1))));
        let half_free = 0.5 * self.config.fitted_share * (free.max_px - free.min_px);
        if !min.cmple(max).all() || !half_free.cmpgt(DVec2::ZERO).all() {
            return self.pose;
        }
        let focal_px = 0.5 * viewport.y / CameraProjection::TAN_HALF_FOV;
        let offset_px = 0.5 * (free.min_px + free.max_px - viewport);
        let (forward, right, up) = (self.pose.forward(), self.pose.right(), self.pose.up());
        let centre = 0.5 * (min + max);
        // A corner at (across, depth) from the centre appears (focal across - offset depth) / (distance + depth) pixels from the centre's pixel.
        // The result is the distance at which this equals half the free area.
        let distance_for = |corner: DVec3| {
            let relative = corner - centre;
            let depth = relative.dot(forward);
            let across = DVec2::new(relative.dot(right), -relative.dot(up));
            let needed = (across * focal_px - offset_px * depth).abs() / half_free;
            needed.max_element() - depth
        };
        let corner = |index: usize| {
            DVec3::from_array(
                [0, 1, 2].map(|axis| if index >> axis & 1 == 1 { max[axis] } else { min[axis] }),
            )
        };
        let distance = (0..8).map(|index| distance_for(corner(index))).fold(0.0, f64::max);
        let distance = distance.clamp(self.config.min_distance_m, self.config.max_distance_m);
        let metres_per_px = distance / focal_px;
        let target = centre - right * (offset_px.x * metres_per_px) + up * (offset_px.y * metres_per_px);
        CameraPose { target, distance, ..self.pose }.clamped(&self.config, &self.pose)
    }

    fn change(&mut self, with: impl FnOnce(&mut CameraPose)) {
        self.flight = None;
        let mut pose = self.pose;
        with(&mut pose);
        self.pose = pose.clamped(&self.config, &self.pose);
    }
}
