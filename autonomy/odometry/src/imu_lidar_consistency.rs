//! Do IMU and LiDAR see the same turns at the same time? Compares the turn between scans with the gyroscope's over
//! shifted stretches of time.

use crate::event::{Finding, FindingKind, Severity};
use geometry::Vector3;
use std::collections::VecDeque;
use vocab::{Span, Stamp};

/// Shifts that are tried, both ways: so many steps of so long.
const STEPS: usize = 12;
const STEP: Span = Span::from_millis(10);
/// Scans judged together.
const BATCH: usize = 100;
/// The turns of a batch must be at least this large, radians (root of their sum of squares).
const TURNED_MIN: f64 = 0.15;
/// Lags below this are not told, seconds.
const LAG_MIN: f64 = 0.015;
/// A shift must explain the turns so much better than none (ratio of squared errors).
const BETTER: f64 = 0.5;
/// Share of the turns' squares that may differ before the gyroscope is doubted. Good clocks leave a hundredth of it.
const DIFFERENT: f64 = 5e-3;
/// How much noisier a doubted gyroscope is taken to be, so that scans turn the pose by themselves and show the lag.
const DOUBT: f64 = 30.0;
/// Turns that correlate less than this are about different axes.
const CORRELATION_MIN: f64 = 0.6;

/// One turn between the middles of two scans, as the LiDAR saw it. The middles, because a scan corrected by a
/// late gyroscope still lies right on average: its ends follow the gyroscope, its middle does not.
#[derive(Clone, Copy, Debug)]
struct Turn {
    from: Stamp,
    to: Stamp,
    /// Rotation vector, radians, body frame.
    seen: Vector3,
}

/// Collects turns until they say something.
#[derive(Clone, Debug, Default)]
pub struct ImuLidarConsistency {
    /// Integral of the turn rate since the first reading, radians.
    integral: VecDeque<(Stamp, Vector3)>,
    waiting: VecDeque<Turn>,
    /// Sum of squared differences for every shift.
    errors: [f64; 2 * STEPS + 1],
    seen_squared: f64,
    felt_squared: f64,
    common: f64,
    count: usize,
    /// Whether the last batch showed that the two differ.
    doubted: bool,
}

impl ImuLidarConsistency {
    /// A mean turn rate (rad/s, bias removed, body frame) over the time up to `stamp`.
    pub fn insert_turn_rate(&mut self, stamp: Stamp, dt: f64, rate: &Vector3) {
        let last = self.integral.back().map_or(Vector3::zeros(), |last| last.1);
        self.integral.push_back((stamp, last + rate * dt));
        while self.integral.front().is_some_and(|first| stamp - first.0 > Span::from_millis(1_000)) {
            self.integral.pop_front();
        }
    }

    /// The turn between the middles of two consecutive scans. Says what is wrong once enough turns were seen.
    pub fn insert_turn(&mut self, from: Stamp, to: Stamp, seen: Vector3) -> Option<Finding> {
        let reach = STEP * STEPS as i64;
        let newest = self.integral.back()?.0;
        self.waiting.push_back(Turn { from, to, seen });
        while let Some(&turn) = self.waiting.front() {
            if turn.to + reach > newest {
                break;
            }
            self.waiting.pop_front();
            self.compare(&turn);
        }
        if self.count < BATCH {
            return None;
        }
        let finding = self.classify();
        let differs =
            self.errors[STEPS] > DIFFERENT * self.seen_squared && self.seen_squared.sqrt() > TURNED_MIN;
        *self = Self {
            integral: std::mem::take(&mut self.integral),
            doubted: self.doubted || differs,
            ..Self::default()
        };
        finding
    }

    /// By how much to multiply the gyroscope's noise.
    pub fn gyro_noise_factor(&self) -> f64 {
        if self.doubted { DOUBT } else { 1.0 }
    }

    fn compare(&mut self, turn: &Turn) {
        let oldest = self.integral.front().map(|first| first.0);
        if oldest.is_none_or(|oldest| turn.from - STEP * STEPS as i64 <= oldest) {
            return;
        }
        for (index, error) in self.errors.iter_mut().enumerate() {
            let shift = STEP * (index as i64 - STEPS as i64);
            let felt = at(&self.integral, turn.to + shift) - at(&self.integral, turn.from + shift);
            *error += (felt - turn.seen).norm_squared();
            if index == STEPS {
                self.felt_squared += felt.norm_squared();
                self.common += felt.dot(&turn.seen);
            }
        }
        self.seen_squared += turn.seen.norm_squared();
        self.count += 1;
    }

    fn classify(&self) -> Option<Finding> {
        if self.seen_squared.min(self.felt_squared).sqrt() < TURNED_MIN {
            return None;
        }
        let (best, least) = self.errors.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let correlation = self.common / (self.seen_squared * self.felt_squared).sqrt();
        let lag = (best as f64 - STEPS as f64 + self.vertex(best)) * STEP.secs_f64();
        if lag.abs() > LAG_MIN && *least < BETTER * self.errors[STEPS] {
            return Some(Finding {
                kind: FindingKind::ImuLag,
                severity: Severity::Warning,
                what: format!(
                    "The IMU's stamps are about {:.0} ms {} the LiDAR's.",
                    lag.abs() * 1e3,
                    if lag > 0.0 { "behind" } else { "ahead of" }
                ),
                remedy: "Synchronise both sensors to one clock (PTP or a trigger), or correct the offset in the driver."
                    .into(),
            });
        }
        (correlation < CORRELATION_MIN).then(|| Finding {
            kind: FindingKind::MountingDisagrees,
            severity: Severity::Error,
            what: format!(
                "LiDAR and IMU do not turn about the same axes (correlation {correlation:.2}): the given mounting of one is wrong."
            ),
            remedy: "Check the rotations of base_from_lidar and base_from_imu.".into(),
        })
    }

    /// Where between the steps the parabola through the least error and its neighbours has its least value.
    fn vertex(&self, best: usize) -> f64 {
        if best == 0 || best == 2 * STEPS {
            return 0.0;
        }
        let (before, at, after) = (self.errors[best - 1], self.errors[best], self.errors[best + 1]);
        let bend = before - 2.0 * at + after;
        if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 }
    }
}

/// The integral at a stamp within the history, interpolated.
fn at(integral: &VecDeque<(Stamp, Vector3)>, stamp: Stamp) -> Vector3 {
    let after = integral.partition_point(|entry| entry.0 < stamp);
    match (after.checked_sub(1).and_then(|before| integral.get(before)), integral.get(after)) {
        (Some(a), Some(b)) => {
            a.1.lerp(&b.1, (stamp - a.0).nanos() as f64 / (b.0 - a.0).nanos().max(1) as f64)
        }
        (Some(only), None) | (None, Some(only)) => only.1,
        (None, None) => Vector3::zeros(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that swings about three axes, its gyroscope's stamps late by `lag`; `felt` is what the mounting makes of the
    /// turn rate.
    fn run(lag: Span, felt: impl Fn(Vector3) -> Vector3) -> Option<Finding> {
        let angle =
            |t: f64| Vector3::new(0.05 * (2.1 * t).sin(), 0.06 * (3.3 * t).sin(), 0.4 * (1.7 * t).sin());
        let mut imu_lidar_consistency = ImuLidarConsistency::default();
        let mut found = None;
        for tick in 1..8_000_i64 {
            let stamp = Stamp::from_nanos(tick * 2_500_000);
            let true_time = (stamp - lag).secs_f64();
            let rate = (angle(true_time) - angle(true_time - 0.0025)) / 0.0025;
            imu_lidar_consistency.insert_turn_rate(stamp, 0.0025, &felt(rate));
            if tick % 40 == 0 {
                let (from, to) = (stamp - Span::from_millis(100), stamp);
                let seen = angle(to.secs_f64()) - angle(from.secs_f64());
                found = found.or(imu_lidar_consistency.insert_turn(from, to, seen));
            }
        }
        found
    }

    #[test]
    fn lags_are_measured_and_good_clocks_are_not_blamed() {
        assert_eq!(run(Span::ZERO, |rate| rate), None);
        assert_eq!(run(Span::from_millis(5), |rate| rate), None);
        for (lag, words) in [(43, "43 ms behind"), (-60, "60 ms ahead of")] {
            let found = run(Span::from_millis(lag), |rate| rate);
            let Some(found) = found else { panic!("{lag} ms not found") };
            assert!(found.kind == FindingKind::ImuLag && found.what.contains(words), "{}", found.what);
        }
    }

    #[test]
    fn a_wrong_mounting_is_told() {
        let found = run(Span::ZERO, |rate| Vector3::new(rate.x, -rate.y, -rate.z));
        assert!(found.is_some_and(|found| found.kind == FindingKind::MountingDisagrees));
    }
}
