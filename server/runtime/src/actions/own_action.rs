//! Actions that need no robot: waiting, a message to people, and gathering the scans that the stack publishes.

use geometry::Isometry;
use messages::CorrectedScan;
use nalgebra::Point3;
use serde::Deserialize;
use vocab::{Span, Stamp};

/// Their names in the catalogue.
pub const WAIT: &str = "wait";
pub const MESSAGE: &str = "message";
pub const POINT_CLOUD: &str = "point_cloud";
/// All of them.
pub const OWN_ACTIONS: [&str; 3] = [POINT_CLOUD, WAIT, MESSAGE];

/// Parameters of actions that take a time.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct TimedParameters {
    /// The time, seconds; none: that of the catalogue.
    pub duration_s: Option<f64>,
}

impl TimedParameters {
    /// The time. Not a number is none.
    pub fn duration(self, default_s: f64, max_s: f64) -> Span {
        let seconds = self.duration_s.unwrap_or(default_s);
        Span::from_secs_f64(if seconds.is_nan() { 0.0 } else { seconds.clamp(0.0, max_s) })
    }
}

/// Parameters of a message.
#[derive(Clone, Debug, Deserialize)]
pub struct MessageParameters {
    pub text: String,
}

/// An action of the core itself that is under way.
pub struct OwnAction {
    pub began: Stamp,
    pub ends: Stamp,
    pub kind: OwnActionKind,
}

pub enum OwnActionKind {
    Wait,
    Capture(Capture),
}

impl OwnAction {
    /// Share that is done at an instant.
    pub fn progress(&self, now: Stamp) -> f32 {
        let whole = (self.ends - self.began).secs_f64();
        if whole <= 0.0 { 1.0 } else { ((now - self.began).secs_f64() / whole).clamp(0.0, 1.0) as f32 }
    }
}

/// Scans put together, in the frame of the base at the first of them.
#[derive(Default)]
pub struct Capture {
    /// The first scan's instant and the base in the map then.
    pub first: Option<(Stamp, Isometry)>,
    /// Metres.
    pub xyz: Vec<[f32; 3]>,
    /// Of every point; empty if a scan had none.
    pub intensity: Vec<f32>,
}

impl Capture {
    /// Adds a scan, as many points of it as fit.
    pub fn add(&mut self, scan: &CorrectedScan, max_points: usize) {
        let Some(map_from_base) = geometry::isometry_from_pose(&scan.map_from_base) else { return };
        let (_, map_from_first) = *self.first.get_or_insert((scan.stamp, map_from_base));
        let first_from_base = map_from_first.inverse() * map_from_base;
        let has_intensity = self.intensity.len() == self.xyz.len();
        let room = max_points.saturating_sub(self.xyz.len());
        let points = scan.cloud.xyz.iter().take(room).map(|point| {
            let moved = first_from_base * Point3::from(point.map(f64::from));
            [moved.x as f32, moved.y as f32, moved.z as f32]
        });
        let added = points.len();
        self.xyz.extend(points);
        if has_intensity && scan.cloud.intensity.len() == scan.cloud.xyz.len() {
            self.intensity.extend_from_slice(&scan.cloud.intensity[..added]);
        } else {
            self.intensity.clear();
        }
    }
}
