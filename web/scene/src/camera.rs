//! The camera: looks at a target from a distance, moves by gestures, flies to new places.
//!
//! Gestures act at once and end a flight. All methods are total: odd input leaves a usable camera.

use crate::eye::Eye;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// How long a flight takes.
pub const FLIGHT_SECONDS: f64 = 0.3;

const DISTANCE_RANGE: [f64; 2] = [0.3, 3000.0];
/// Straight down is allowed; below the horizon a little, to look up at ceilings.
const PITCH_RANGE: [f64; 2] = [-0.45 * PI, 0.5 * PI];
/// Radians for each logical pixel of an orbiting drag.
const ORBIT_RATE: f64 = 0.006;

/// Where the camera is: it looks at `target` from `distance` away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPose {
    /// The point in the middle of the picture, metres, map frame.
    pub target: DVec3,
    /// Heading of the line of sight, radians, counter-clockwise from the x axis seen from above.
    pub yaw: f64,
    /// How far the line of sight points downwards, radians; half a turn quarter is straight down.
    pub pitch: f64,
    /// From the eye to the target, metres.
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

    /// Unit vector to the right of the picture; horizontal.
    pub fn right(&self) -> DVec3 {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        DVec3::new(sin_yaw, -cos_yaw, 0.0)
    }

    /// Where the eye is, metres, map frame.
    pub fn eye_position(&self) -> DVec3 {
        self.target - self.forward() * self.distance
    }

    /// The same with every number in its range.
    fn sane(mut self, fallback: &Self) -> Self {
        let finite = self.target.is_finite() && self.yaw.is_finite() && self.pitch.is_finite();
        if !finite || !self.distance.is_finite() {
            return *fallback;
        }
        self.pitch = self.pitch.clamp(PITCH_RANGE[0], PITCH_RANGE[1]);
        self.distance = self.distance.clamp(DISTANCE_RANGE[0], DISTANCE_RANGE[1]);
        self.yaw = self.yaw.rem_euclid(TAU);
        self
    }
}

/// A camera that people move.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Camera {
    pose: CameraPose,
    flight: Option<Flight>,
}

#[derive(Clone, Debug, PartialEq)]
struct Flight {
    from: CameraPose,
    to: CameraPose,
    seconds_done: f64,
}

impl Camera {
    /// A camera at rest.
    pub fn new(pose: CameraPose) -> Self {
        Self { pose: pose.sane(&CameraPose::default()), flight: None }
    }

    /// Where it is now.
    pub fn pose(&self) -> CameraPose {
        self.pose
    }

    /// Whether a flight is under way, so that another frame is due.
    pub fn flying(&self) -> bool {
        self.flight.is_some()
    }

    /// Goes there at once.
    pub fn jump_to(&mut self, pose: CameraPose) {
        self.flight = None;
        self.pose = pose.sane(&self.pose);
    }

    /// Flies there in [`FLIGHT_SECONDS`], the shorter way round.
    pub fn fly_to(&mut self, pose: CameraPose) {
        let mut to = pose.sane(&self.pose);
        let turn = (to.yaw - self.pose.yaw + PI).rem_euclid(TAU) - PI;
        to.yaw = self.pose.yaw + turn;
        self.flight = Some(Flight { from: self.pose, to, seconds_done: 0.0 });
    }

    /// Lets time pass; returns whether the camera moved.
    pub fn advance(&mut self, seconds: f64) -> bool {
        let Some(flight) = &mut self.flight else {
            return false;
        };
        flight.seconds_done += seconds.max(0.0);
        let done = (flight.seconds_done / FLIGHT_SECONDS).min(1.0);
        let eased = done * done * (3.0 - 2.0 * done);
        let (from, to) = (&flight.from, &flight.to);
        let mix = |a: f64, b: f64| a + (b - a) * eased;
        let pose = CameraPose {
            target: from.target.lerp(to.target, eased),
            yaw: mix(from.yaw, to.yaw),
            pitch: mix(from.pitch, to.pitch),
            // Along the logarithm, so that zooming out by ten feels as even as zooming in.
            distance: mix(from.distance.ln(), to.distance.ln()).exp(),
        };
        if done >= 1.0 {
            self.flight = None;
        }
        self.pose = pose.sane(&self.pose);
        true
    }

    /// Turns about the target by a drag in logical pixels (y down).
    pub fn orbit(&mut self, drag_pt: DVec2) {
        self.change(|pose| {
            pose.yaw -= drag_pt.x * ORBIT_RATE;
            pose.pitch += drag_pt.y * ORBIT_RATE;
        });
    }

    /// Moves the target so that the plane through it follows a drag in pixels (y down), where the picture is
    /// `height_px` pixels high. Seen from above the horizon, a drag moves along the ground.
    pub fn pan(&mut self, drag_px: DVec2, height_px: f64) {
        self.change(|pose| {
            let metres_per_px = 2.0 * pose.distance * Eye::TAN_HALF_FOV / height_px.max(1.0);
            let (sin_yaw, cos_yaw) = pose.yaw.sin_cos();
            let ahead = DVec3::new(cos_yaw, sin_yaw, 0.0);
            // The ground is foreshortened by the pitch; near the horizon dragging would run away.
            let foreshortening = pose.pitch.sin().abs().max(0.35);
            pose.target += ahead * (drag_px.y * metres_per_px / foreshortening);
            pose.target -= pose.right() * (drag_px.x * metres_per_px);
        });
    }

    /// Moves the target up (metres).
    pub fn lift(&mut self, metres: f64) {
        self.change(|pose| pose.target.z += metres);
    }

    /// Zooms by `factor` (above 1 goes nearer), keeping `focus` (metres, map frame) where it is in the picture.
    pub fn zoom(&mut self, factor: f64, focus: DVec3) {
        self.change(|pose| {
            if factor > 0.0 && focus.is_finite() {
                let distance = (pose.distance / factor).clamp(DISTANCE_RANGE[0], DISTANCE_RANGE[1]);
                let applied = distance / pose.distance;
                pose.target = focus + (pose.target - focus) * applied;
                pose.distance = distance;
            }
        });
    }

    /// Walks or flies: moves eye and target by `metres` along the line of sight, to the right and up.
    pub fn walk(&mut self, ahead_right_up: DVec3) {
        self.change(|pose| {
            let step = ahead_right_up;
            pose.target += pose.forward() * step.x + pose.right() * step.y + DVec3::Z * step.z;
        });
    }

    /// A pose from the present direction that shows a whole box (metres, map frame); the present one for an empty box.
    pub fn fitting(&self, min: DVec3, max: DVec3, viewport_px: [u32; 2]) -> CameraPose {
        let radius = 0.5 * (max - min).length();
        let aspect = f64::from(viewport_px[0].max(1)) / f64::from(viewport_px[1].max(1));
        let narrow = Eye::TAN_HALF_FOV * aspect.min(1.0);
        // The sphere around the box touches the narrower side; boxes of rooms are flat, so a little nearer still fits.
        let distance = 0.85 * radius / narrow.atan().sin();
        let fitted = CameraPose { target: 0.5 * (min + max), distance, ..self.pose };
        if min.cmple(max).all() { fitted.sane(&self.pose) } else { self.pose }
    }

    fn change(&mut self, with: impl FnOnce(&mut CameraPose)) {
        self.flight = None;
        let mut pose = self.pose;
        with(&mut pose);
        self.pose = pose.sane(&self.pose);
    }
}
