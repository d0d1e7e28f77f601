//! What trotting adds to the body's path: bounce, roll, pitch, sway and the jolt of each footfall.
//!
//! A trot of about 2 strides a second puts down two diagonal pairs of feet per stride, so height and pitch swing at twice
//! the stride frequency, roll and yaw at the stride frequency itself. Each footfall adds a damped 28 Hz oscillation
//! and a small lasting lean of its own, both different every time.

use crate::TICK_SECONDS;
use crate::smooth::Smooth;
use geometry::Rng;
use std::f64::consts::{PI, TAU};

/// Frequency of the structure's ringing after a footfall, Hz.
const JOLT_HZ: f64 = 28.0;
/// Rise and decay time of the ringing, seconds.
const JOLT_SECONDS: f64 = 0.008;

/// Small displacement of the base from its smooth path, in the base's own axes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wobble {
    /// Forward, left, up; metres.
    pub(crate) shift: [f64; 3],
    /// Roll, pitch, yaw; radians.
    pub(crate) lean: [f64; 3],
}

impl Wobble {
    /// Both, which are small.
    pub(crate) fn and(&self, other: &Self) -> Self {
        let sum = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|axis| a[axis] + b[axis]);
        Self { shift: sum(self.shift, other.shift), lean: sum(self.lean, other.lean) }
    }
}

/// The stride.
#[derive(Clone, Debug)]
pub(crate) struct Gait {
    rng: Rng,
    /// Radians; a footfall at every multiple of π.
    phase: f64,
    /// 0 standing, 1 full trot.
    effort: Smooth,
    /// Seconds since the last footfall.
    since_footfall: f64,
    /// Strength of the last jolt: up (m), roll, pitch (rad).
    jolt: [f64; 3],
    /// What the last footfall left: left, up (m), roll, pitch, yaw (rad).
    uneven: [f64; 5],
    uneven_smooth: [Smooth; 5],
}

impl Gait {
    /// Standing.
    pub(crate) fn new(rng: Rng) -> Self {
        Self {
            rng,
            phase: 0.0,
            effort: Smooth::new(0.0, 0.07),
            since_footfall: 1.0,
            jolt: [0.0; 3],
            uneven: [0.0; 5],
            uneven_smooth: [Smooth::new(0.0, 0.04); 5],
        }
    }

    /// One tick at the given path speed (m/s) and turning rate (rad/s).
    pub(crate) fn step(&mut self, speed: f64, turning: f64) -> Wobble {
        let activity = speed + 0.3 * turning.abs();
        let effort = self.effort.step(if activity > 0.02 { (0.4 + activity).min(1.0) } else { 0.0 });
        self.since_footfall += TICK_SECONDS;
        if activity > 0.02 {
            self.stride(activity, effort);
        } else {
            self.uneven = [0.0; 5];
        }
        for (smooth, target) in self.uneven_smooth.iter_mut().zip(self.uneven) {
            smooth.step(target);
        }
        self.wobble(effort)
    }

    fn stride(&mut self, activity: f64, effort: f64) {
        let before = (self.phase / PI).floor();
        self.phase += TAU * (1.5 + 0.6 * activity.min(1.2)) * TICK_SECONDS;
        // The ringing of one footfall is long over when the next comes: the sum never jumps.
        if (self.phase / PI).floor() > before {
            self.since_footfall = 0.0;
            let mut draw = |scale: f64| scale * effort * self.rng.normal();
            self.jolt = [2.2e-4 * effort + draw(6e-5), draw(3e-4), draw(3e-4)];
            self.uneven = [draw(2e-3), draw(1.5e-3), draw(4e-3), draw(4e-3), draw(3e-3)];
        }
    }

    fn wobble(&self, effort: f64) -> Wobble {
        let (stride, step) = (self.phase, 2.0 * self.phase);
        let s = self.since_footfall / JOLT_SECONDS;
        let ring = s.powi(3) * (-s).exp() * (TAU * JOLT_HZ * self.since_footfall).sin();
        let [left, up, roll, pitch, yaw] = self.uneven_smooth.map(|smooth| smooth.value());
        Wobble {
            shift: [
                effort * 0.004 * step.sin(),
                effort * 0.007 * stride.sin() + left,
                effort * 0.009 * step.cos() - effort * 0.009 + up - self.jolt[0] * ring,
            ],
            lean: [
                effort * 0.016 * (stride + 0.4).sin() + roll + self.jolt[1] * ring,
                effort * 0.010 * (step + 0.8).sin() + pitch + self.jolt[2] * ring,
                effort * 0.010 * (stride - 0.3).sin() + yaw,
            ],
        }
    }
}
