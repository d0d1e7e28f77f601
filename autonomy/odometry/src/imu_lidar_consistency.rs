//! Checks that IMU and LiDAR measure the same rotations at the same time: the rotation between scans is compared with the integral
//! of the gyroscope over intervals shifted in time (docs/maths/odometry.md, equation 21).

use crate::event::Finding;
use crate::findings;
use geometry::Vector3;
use std::collections::VecDeque;
use vocab::{Span, Stamp};

/// Parameters of [`ImuLidarConsistency`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuLidarConsistencyConfig {
    /// Number of time shifts tried in each direction. Chosen: 120 ms, a little more than a sweep at 10 Hz.
    pub shift_steps: usize,
    /// Difference between neighbouring shifts. Chosen: a tenth of a sweep; the lag is interpolated between steps.
    pub shift_step: Span,
    /// Length of the history of the integrated turn rate. Chosen: several times the greatest shift and a sweep together.
    pub history: Span,
    /// Scans evaluated together. Chosen: ten seconds at 10 Hz: the noise of the scans averages out, and a lag is known soon.
    pub batch_scans: usize,
    /// Batches with less rotation than this (root of the sum of squares, radians) are not evaluated. Chosen: 9 degrees; with less, the noise of the scans hides a lag.
    pub min_rotation_rad: f64,
    /// Shorter lags are not reported, seconds. Chosen: one and a half steps of the shift.
    pub min_lag_s: f64,
    /// A lag is reported if its squared error is less than this share of the squared error without a shift. Chosen: half; noise alone has a smallest error near that
    /// without a shift.
    pub max_error_ratio: f64,
    /// The gyroscope is doubted if the squared error without a shift exceeds this share of the squared rotation. Synchronised clocks
    /// leave a hundredth of it. Chosen far above that share.
    pub max_error_share: f64,
    /// Factor on the noise density of a doubted gyroscope. Scans then determine the rotation by themselves and reveal the lag. Chosen: so large that the scans outweigh
    /// it.
    pub doubted_noise_factor: f64,
    /// Rotations with a lower correlation than this are about different axes. Chosen: the same axes have a correlation near 1, others of a wrong mounting near 0 or
    /// below.
    pub min_correlation: f64,
}

impl Default for ImuLidarConsistencyConfig {
    fn default() -> Self {
        Self {
            shift_steps: 12,
            shift_step: Span::from_millis(10),
            history: Span::from_millis(1_000),
            batch_scans: 100,
            min_rotation_rad: 0.15,
            min_lag_s: 0.015,
            max_error_ratio: 0.5,
            max_error_share: 5e-3,
            doubted_noise_factor: 30.0,
            min_correlation: 0.6,
        }
    }
}

/// The rotation between the middles of two scans as the LiDAR measured it. The middles are used because a scan that was corrected
/// with a late gyroscope is still right on average: its ends follow the gyroscope, its middle does not.
#[derive(Clone, Copy, Debug)]
struct LidarRotation {
    from: Stamp,
    to: Stamp,
    /// Rotation vector, radians, body frame.
    rotation: Vector3,
}

/// Collects rotations in batches and evaluates each batch.
#[derive(Clone, Debug)]
pub struct ImuLidarConsistency {
    config: ImuLidarConsistencyConfig,
    /// Integral of the turn rate since the first reading, radians.
    integral: VecDeque<(Stamp, Vector3)>,
    /// Rotations whose shifted intervals the gyroscope does not cover yet.
    waiting: VecDeque<LidarRotation>,
    batch: Batch,
    /// Whether a batch has shown that the two differ.
    is_doubted: bool,
}

/// Sums over the rotations of a batch.
#[derive(Clone, Debug)]
struct Batch {
    /// Sum of squared differences for every shift, rad².
    errors: Vec<f64>,
    lidar_squared: f64,
    gyro_squared: f64,
    /// Sum of the dot products of LiDAR and gyroscope rotations, rad².
    product: f64,
    count: usize,
}

impl Batch {
    fn new(config: &ImuLidarConsistencyConfig) -> Self {
        let errors = vec![0.0; 2 * config.shift_steps + 1];
        Self { errors, lidar_squared: 0.0, gyro_squared: 0.0, product: 0.0, count: 0 }
    }
}

impl ImuLidarConsistency {
    /// Without rotations.
    pub fn new(config: ImuLidarConsistencyConfig) -> Self {
        let batch = Batch::new(&config);
        Self { config, integral: VecDeque::new(), waiting: VecDeque::new(), batch, is_doubted: false }
    }

    /// Adds a mean turn rate (rad/s, without bias, body frame) over the `dt` seconds before `stamp`.
    pub fn insert_turn_rate(&mut self, stamp: Stamp, dt: f64, rate: &Vector3) {
        let last = self.integral.back().map_or(Vector3::zeros(), |last| last.1);
        self.integral.push_back((stamp, last + rate * dt));
        while self.integral.front().is_some_and(|first| stamp - first.0 > self.config.history) {
            self.integral.pop_front();
        }
    }

    /// Adds the rotation (vector, radians, body frame) between the middles of two consecutive scans. Returns a finding when a batch
    /// is complete and shows a fault.
    pub fn insert_rotation(&mut self, from: Stamp, to: Stamp, rotation: Vector3) -> Option<Finding> {
        let max_shift = self.max_shift();
        let newest = self.integral.back()?.0;
        self.waiting.push_back(LidarRotation { from, to, rotation });
        while let Some(&waiting) = self.waiting.front() {
            if waiting.to + max_shift > newest {
                break;
            }
            self.waiting.pop_front();
            self.compare(&waiting);
        }
        if self.batch.count < self.config.batch_scans {
            return None;
        }
        let finding = self.evaluate();
        self.is_doubted |= self.differs();
        self.waiting.clear();
        self.batch = Batch::new(&self.config);
        finding
    }

    /// Factor on the noise density of the gyroscope.
    pub fn gyro_noise_factor(&self) -> f64 {
        if self.is_doubted { self.config.doubted_noise_factor } else { 1.0 }
    }

    fn max_shift(&self) -> Span {
        self.config.shift_step * self.config.shift_steps as i64
    }

    fn compare(&mut self, lidar: &LidarRotation) {
        let oldest = self.integral.front().map(|first| first.0);
        if oldest.is_none_or(|oldest| lidar.from - self.max_shift() <= oldest) {
            return;
        }
        let unshifted = self.config.shift_steps;
        for (index, error) in self.batch.errors.iter_mut().enumerate() {
            let shift = self.config.shift_step * (index as i64 - unshifted as i64);
            let gyro = integral_at(&self.integral, lidar.to + shift)
                - integral_at(&self.integral, lidar.from + shift);
            *error += (gyro - lidar.rotation).norm_squared();
            if index == unshifted {
                self.batch.gyro_squared += gyro.norm_squared();
                self.batch.product += gyro.dot(&lidar.rotation);
            }
        }
        self.batch.lidar_squared += lidar.rotation.norm_squared();
        self.batch.count += 1;
    }

    /// Whether the two differ by more than synchronised clocks leave.
    fn differs(&self) -> bool {
        let Batch { errors, lidar_squared, .. } = &self.batch;
        errors[self.config.shift_steps] > self.config.max_error_share * lidar_squared
            && lidar_squared.sqrt() > self.config.min_rotation_rad
    }

    fn evaluate(&self) -> Option<Finding> {
        let Batch { errors, lidar_squared, gyro_squared, product, .. } = &self.batch;
        if lidar_squared.min(*gyro_squared).sqrt() < self.config.min_rotation_rad {
            return None;
        }
        let (best, least) = errors.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let correlation = product / (lidar_squared * gyro_squared).sqrt();
        let shift_steps = self.config.shift_steps as f64;
        let lag = (best as f64 - shift_steps + vertex(errors, best)) * self.config.shift_step.secs_f64();
        let is_better = *least < self.config.max_error_ratio * errors[self.config.shift_steps];
        if lag.abs() > self.config.min_lag_s && is_better {
            return Some(findings::imu_lag(lag));
        }
        (correlation < self.config.min_correlation).then(|| findings::mounting_inconsistent(correlation))
    }
}

/// Offset, in steps, of the minimum of the parabola through the least error and its two neighbours.
fn vertex(errors: &[f64], best: usize) -> f64 {
    if best == 0 || best + 1 == errors.len() {
        return 0.0;
    }
    let (before, at, after) = (errors[best - 1], errors[best], errors[best + 1]);
    let curvature = before - 2.0 * at + after;
    if curvature > 0.0 { 0.5 * (before - after) / curvature } else { 0.0 }
}

/// The integral at a stamp, by linear interpolation; outside the history its nearest entry.
fn integral_at(integral: &VecDeque<(Stamp, Vector3)>, stamp: Stamp) -> Vector3 {
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
    use crate::event::FindingKind;

    /// A body that oscillates about three axes. The gyroscope's stamps are late by `lag`; `mounted` is the effect of the mounting on
    /// the turn rate.
    fn run(lag: Span, mounted: impl Fn(Vector3) -> Vector3) -> Option<Finding> {
        let angle =
            |t: f64| Vector3::new(0.05 * (2.1 * t).sin(), 0.06 * (3.3 * t).sin(), 0.4 * (1.7 * t).sin());
        let mut consistency = ImuLidarConsistency::new(ImuLidarConsistencyConfig::default());
        let mut found = None;
        for tick in 1..8_000_i64 {
            let stamp = Stamp::from_nanos(tick * 2_500_000);
            let true_time = (stamp - lag).secs_f64();
            let rate = (angle(true_time) - angle(true_time - 0.0025)) / 0.0025;
            consistency.insert_turn_rate(stamp, 0.0025, &mounted(rate));
            if tick % 40 == 0 {
                let (from, to) = (stamp - Span::from_millis(100), stamp);
                let rotation = angle(to.secs_f64()) - angle(from.secs_f64());
                found = found.or(consistency.insert_rotation(from, to, rotation));
            }
        }
        found
    }

    #[test]
    fn lags_are_measured_and_synchronised_clocks_are_not_reported() {
        assert_eq!(run(Span::ZERO, |rate| rate), None);
        assert_eq!(run(Span::from_millis(5), |rate| rate), None);
        for (lag, words) in [(43, "43 ms behind"), (-60, "60 ms ahead of")] {
            let found = run(Span::from_millis(lag), |rate| rate);
            let Some(found) = found else { panic!("{lag} ms not found") };
            assert!(found.kind == FindingKind::ImuLag && found.what.contains(words), "{}", found.what);
        }
    }

    #[test]
    fn a_wrong_mounting_is_reported() {
        let found = run(Span::ZERO, |rate| Vector3::new(rate.x, -rate.y, -rate.z));
        assert!(found.is_some_and(|found| found.kind == FindingKind::MountingInconsistent));
    }
}
