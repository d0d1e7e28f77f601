//! The motion that trotting adds to the path of the body: bounce, roll, pitch, sway and the jolt of each footfall.
//!
//! A trot of about 2 strides a second sets down two diagonal pairs of feet per stride. So height and pitch oscillate at twice the stride
//! frequency, roll and yaw at the stride frequency. Each footfall adds a damped 28 Hz oscillation and a small lasting offset. Both differ from
//! footfall to footfall.

use crate::low_pass::LowPassFilter;
use crate::timing::TICK_SECONDS;
use geometry::Rng;
use std::f64::consts::{PI, TAU};

/// Frequency of the oscillation of the structure after a footfall, Hz.
const JOLT_HZ: f64 = 28.0;
/// Rise and decay time of that oscillation, seconds.
const JOLT_TIME_CONSTANT_S: f64 = 0.008;

/// A small displacement of the base from its smooth path, in the axes of the base.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PoseOffset {
    /// Forward, left, up, metres.
    pub(crate) translation_m: [f64; 3],
    /// Roll, pitch, yaw, radians.
    pub(crate) rotation_rad: [f64; 3],
}

impl PoseOffset {
    /// The sum of two small displacements.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let sum = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|axis| a[axis] + b[axis]);
        Self {
            translation_m: sum(self.translation_m, other.translation_m),
            rotation_rad: sum(self.rotation_rad, other.rotation_rad),
        }
    }
}

/// The trot: its phase, and the effects of the last footfall.
#[derive(Clone, Debug)]
pub(crate) struct Gait {
    rng: Rng,
    /// Phase of the stride, radians. A footfall happens at every multiple of π.
    phase: f64,
    /// Strength of the gait: 0 standing, 1 full trot.
    effort: LowPassFilter,
    /// Time since the last footfall, seconds.
    since_footfall_s: f64,
    /// Amplitude of the last jolt: up (m), roll, pitch (rad).
    jolt: [f64; 3],
    /// Lasting offset after the last footfall: left, up (m), roll, pitch, yaw (rad).
    footfall_offset: [f64; 5],
    footfall_offset_filters: [LowPassFilter; 5],
}

impl Gait {
    /// A gait at rest.
    pub(crate) fn new(rng: Rng) -> Self {
        Self {
            rng,
            phase: 0.0,
            effort: LowPassFilter::new(0.0, 0.07),
            since_footfall_s: 1.0,
            jolt: [0.0; 3],
            footfall_offset: [0.0; 5],
            footfall_offset_filters: [LowPassFilter::new(0.0, 0.04); 5],
        }
    }

    /// Advances by one tick at the given path speed (m/s) and turning rate (rad/s).
    pub(crate) fn update(&mut self, speed: f64, turning: f64) -> PoseOffset {
        let activity = speed + 0.3 * turning.abs();
        let effort = self.effort.update(if activity > 0.02 { (0.4 + activity).min(1.0) } else { 0.0 });
        self.since_footfall_s += TICK_SECONDS;
        if activity > 0.02 {
            self.advance_stride(activity, effort);
        } else {
            self.footfall_offset = [0.0; 5];
        }
        for (filter, target) in self.footfall_offset_filters.iter_mut().zip(self.footfall_offset) {
            filter.update(target);
        }
        self.pose_offset(effort)
    }

    fn advance_stride(&mut self, activity: f64, effort: f64) {
        let before = (self.phase / PI).floor();
        self.phase += TAU * (1.5 + 0.6 * activity.min(1.2)) * TICK_SECONDS;
        // The oscillation of one footfall has decayed when the next one comes, so the sum never jumps.
        if (self.phase / PI).floor() > before {
            self.since_footfall_s = 0.0;
            let mut draw = |scale: f64| scale * effort * self.rng.normal();
            self.jolt = [2.2e-4 * effort + draw(6e-5), draw(3e-4), draw(3e-4)];
            self.footfall_offset = [draw(2e-3), draw(1.5e-3), draw(4e-3), draw(4e-3), draw(3e-3)];
        }
    }

    fn pose_offset(&self, effort: f64) -> PoseOffset {
        let (stride, step) = (self.phase, 2.0 * self.phase);
        let s = self.since_footfall_s / JOLT_TIME_CONSTANT_S;
        let ring = s.powi(3) * (-s).exp() * (TAU * JOLT_HZ * self.since_footfall_s).sin();
        let [left, up, roll, pitch, yaw] = self.footfall_offset_filters.map(|filter| filter.value());
        PoseOffset {
            translation_m: [
                effort * 0.004 * step.sin(),
                effort * 0.007 * stride.sin() + left,
                effort * 0.009 * step.cos() - effort * 0.009 + up - self.jolt[0] * ring,
            ],
            rotation_rad: [
                effort * 0.016 * (stride + 0.4).sin() + roll + self.jolt[1] * ring,
                effort * 0.010 * (step + 0.8).sin() + pitch + self.jolt[2] * ring,
                effort * 0.010 * (stride - 0.3).sin() + yaw,
            ],
        }
    }
}
