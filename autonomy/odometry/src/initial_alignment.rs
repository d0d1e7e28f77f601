//! Initial alignment: the direction of gravity, the bias of the gyroscope and whether the robot stood still, from the first second
//! of inertial readings.

use crate::imu_queue::ImuReading;
use crate::state::{
    ACCEL_BIAS, DIMENSION, ErrorVector, GRAVITY, GYRO_BIAS, LEG_SCALE, POSITION, ROTATION, VELOCITY,
};
use geometry::{Rotation, Vector3, so3};
use vocab::Span;

/// Parameters of the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialAlignmentConfig {
    /// Length of the interval that is checked for standstill. Chosen: the mean of 50 readings and more at 100 Hz; a longer one delays the start.
    pub stationary_window: Span,
    /// After this time without standstill, the estimate starts in motion. Chosen: a step or two of a walk.
    pub max_window: Span,
    /// Fewer readings than this give no alignment. Chosen: a standard deviation of fewer says little.
    pub min_readings: usize,
    /// Standstill: greatest standard deviation of each axis of the gyroscope, rad/s. Chosen: above the noise of poor IMUs and the vibration of motors at rest, below the
    /// turns of a step.
    pub max_gyro_deviation_rad_s: f64,
    /// Standstill: greatest standard deviation of each axis of the accelerometer, m/s². Chosen: above the noise of poor IMUs and the vibration of motors at rest; steps
    /// make more than 1 m/s².
    pub max_accel_deviation_m_s2: f64,
    /// Standstill: greatest mean turn rate, rad/s. More than the bias of any working gyroscope. Chosen: 9 degrees a second.
    pub max_turn_rate_rad_s: f64,
    /// Greatest plausible difference between the accelerometer's reading at rest and gravity, m/s²: a bias and a scale error of 3 %.
    pub gravity_tolerance_m_s2: f64,
    /// An accelerometer whose reading at rest differs from 1 by less than this is said to report multiples of gravity. Chosen: as a round number, far from readings in
    /// m/s².
    pub gravity_multiple_tolerance: f64,
    /// Greatest plausible tilt of a robot that starts, radians. Chosen: 34 degrees, steeper than a ramp on which a robot stands.
    pub max_tilt_rad: f64,
    /// An IMU with a larger tilt is said to be upside down, radians: 42 degrees less than half a turn. Chosen: no robot lies on its back by less.
    pub upside_down_rad: f64,
    /// Initial standard deviation of rotation (rad) and position (m). The pose is the origin by definition. Chosen: above zero, so that the covariance stays invertible.
    pub pose_deviation: f64,
    /// Initial standard deviation of the scale of the legs. Chosen: 5 % as a round number; the filter estimates the scale.
    pub leg_scale_deviation: f64,
    /// Initial standard deviation of the accelerometer bias, m/s². Chosen: 10 mg; the datasheet of a BMI085 allows up to 20 mg.
    pub accel_bias_deviation_m_s2: f64,
    /// Initial standard deviations after a standstill. Chosen: what the mean of a standing IMU leaves; 0.1 m/s² of gravity is a tilt of 0.6 degrees.
    pub stationary: InitialDeviations,
    /// Initial standard deviations after a start in motion. Chosen: the speed of a walk, a bias that is not known yet, and a tilt of 3.5 degrees.
    pub moving: InitialDeviations,
    /// Initial standard deviation of the velocity without an IMU, m/s. Chosen: the speed of a vehicle in a yard, because nothing else says how fast it is.
    pub no_imu_velocity_deviation_m_s: f64,
    /// Initial standard deviation of the turn rate without an IMU, rad/s. Chosen: a usual turning speed.
    pub no_imu_turn_rate_deviation_rad_s: f64,
}

/// Initial standard deviations of what the first second of inertial readings determines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialDeviations {
    /// Velocity, m/s.
    pub velocity_m_s: f64,
    /// Gyroscope bias, rad/s.
    pub gyro_bias_rad_s: f64,
    /// Horizontal components of gravity, m/s².
    pub gravity_m_s2: f64,
}

impl Default for InitialAlignmentConfig {
    fn default() -> Self {
        Self {
            stationary_window: Span::from_millis(500),
            max_window: Span::from_millis(1_000),
            min_readings: 5,
            max_gyro_deviation_rad_s: 0.03,
            max_accel_deviation_m_s2: 0.35,
            max_turn_rate_rad_s: 0.15,
            gravity_tolerance_m_s2: 0.6,
            gravity_multiple_tolerance: 0.2,
            max_tilt_rad: 0.6,
            upside_down_rad: 2.4,
            pose_deviation: 1e-4,
            leg_scale_deviation: 0.05,
            accel_bias_deviation_m_s2: 0.1,
            stationary: InitialDeviations { velocity_m_s: 0.01, gyro_bias_rad_s: 1e-3, gravity_m_s2: 0.1 },
            moving: InitialDeviations { velocity_m_s: 1.0, gyro_bias_rad_s: 2e-2, gravity_m_s2: 0.6 },
            no_imu_velocity_deviation_m_s: 5.0,
            no_imu_turn_rate_deviation_rad_s: 1.0,
        }
    }
}

impl InitialAlignmentConfig {
    /// Initial standard deviations of the error state with an IMU.
    pub fn deviations_with_imu(&self, is_stationary: bool) -> ErrorVector {
        let known = if is_stationary { self.stationary } else { self.moving };
        let mut deviations = self.common_deviations();
        set(&mut deviations, VELOCITY, known.velocity_m_s);
        set(&mut deviations, GYRO_BIAS, known.gyro_bias_rad_s);
        set(&mut deviations, ACCEL_BIAS, self.accel_bias_deviation_m_s2);
        deviations[GRAVITY] = known.gravity_m_s2;
        deviations[GRAVITY + 1] = known.gravity_m_s2;
        deviations
    }

    /// Initial standard deviations of the error state without an IMU.
    pub fn deviations_without_imu(&self) -> ErrorVector {
        let mut deviations = self.common_deviations();
        set(&mut deviations, VELOCITY, self.no_imu_velocity_deviation_m_s);
        set(&mut deviations, GYRO_BIAS, self.no_imu_turn_rate_deviation_rad_s);
        deviations
    }

    /// Standard deviations that are the same for every start. Components that no source of this start determines keep the small deviation of the
    /// pose.
    fn common_deviations(&self) -> ErrorVector {
        let mut deviations = ErrorVector::repeat(self.pose_deviation);
        set(&mut deviations, ROTATION, self.pose_deviation);
        set(&mut deviations, POSITION, self.pose_deviation);
        deviations[LEG_SCALE] = self.leg_scale_deviation;
        debug_assert_eq!(LEG_SCALE + 1, DIMENSION);
        deviations
    }
}

fn set(deviations: &mut ErrorVector, first: usize, value: f64) {
    deviations.fixed_rows_mut::<3>(first).fill(value);
}

/// Result of the initial alignment from an interval of inertial readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialAlignment {
    /// Mean specific force in the body frame of the first reading, m/s²: the direction of up.
    pub up: Vector3,
    /// Mean turn rate, rad/s: the gyroscope's bias at standstill.
    pub turn_rate: Vector3,
    /// Whether the robot stood still.
    pub is_stationary: bool,
}

/// The alignment from an interval of readings; `None` if there are too few.
pub fn estimate_alignment<'a>(
    readings: impl Iterator<Item = &'a ImuReading> + Clone,
    config: &InitialAlignmentConfig,
) -> Option<InitialAlignment> {
    let count = readings.clone().count();
    if count < config.min_readings {
        return None;
    }
    let scale = 1.0 / count as f64;
    let mean = |value: fn(&ImuReading) -> Vector3| readings.clone().map(value).sum::<Vector3>() * scale;
    let (turn_rate, force) = (mean(|r| r.gyro), mean(|r| r.specific_force));
    let variance = |value: fn(&ImuReading) -> Vector3, mean: Vector3| {
        readings.clone().map(|r| (value(r) - mean).component_mul(&(value(r) - mean))).sum::<Vector3>() * scale
    };
    let is_stationary = variance(|r| r.gyro, turn_rate).max().sqrt() < config.max_gyro_deviation_rad_s
        && variance(|r| r.specific_force, force).max().sqrt() < config.max_accel_deviation_m_s2
        && turn_rate.norm() < config.max_turn_rate_rad_s;
    let up = if is_stationary { force } else { sum_of_rotated_forces(readings) * scale };
    Some(InitialAlignment { up, turn_rate, is_stationary })
}

/// Sum of the specific forces, each rotated by the gyroscope into the body frame of the first reading. The accelerations of a
/// walking robot cancel over a second, gravity does not.
fn sum_of_rotated_forces<'a>(readings: impl Iterator<Item = &'a ImuReading>) -> Vector3 {
    let mut first_from_body = Rotation::identity();
    let mut previous: Option<&ImuReading> = None;
    let mut sum = Vector3::zeros();
    for reading in readings {
        if let Some(previous) = previous {
            let dt = (reading.stamp - previous.stamp).secs_f64();
            first_from_body *= so3::exp(&((previous.gyro + reading.gyro) * (0.5 * dt)));
        }
        sum += first_from_body * reading.specific_force;
        previous = Some(reading);
    }
    sum
}

/// Rotation of the body in a level frame with the base's heading: `up` (body frame) points along z, and the base's x axis has no
/// y component.
pub fn level_from_body(up: &Vector3, body_from_base: &Rotation) -> Rotation {
    let up_in_base = body_from_base.inverse() * up;
    let Some(level_from_base) = Rotation::rotation_between(&up_in_base, &Vector3::z()) else {
        // Exactly upside down: half a turn about x.
        return Rotation::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
            * body_from_base.inverse();
    };
    let ahead = level_from_base * Vector3::x();
    let heading = Rotation::from_axis_angle(&Vector3::z_axis(), -ahead.y.atan2(ahead.x));
    heading * level_from_base * body_from_base.inverse()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;
    use vocab::Stamp;

    #[test]
    fn levelling_puts_up_along_z_and_keeps_the_heading() {
        let mut rng = RngTree::new(31).child("level").rng();
        for _ in 0..100 {
            let up = Vector3::new(rng.normal(), rng.normal(), rng.normal()).normalize() * 9.8;
            let body_from_base = so3::exp(&Vector3::new(rng.normal(), rng.normal(), rng.normal()));
            let odom_from_body = level_from_body(&up, &body_from_base);
            assert!((odom_from_body * up - Vector3::z() * 9.8).norm() < 1e-9);
            assert!((odom_from_body * body_from_base * Vector3::x()).y.abs() < 1e-9);
        }
    }

    #[test]
    fn standing_and_walking_are_told_apart_and_both_give_up() {
        let config = InitialAlignmentConfig::default();
        let mut rng = RngTree::new(32).child("bearing").rng();
        let bias = Vector3::new(0.01, -0.02, 0.005);
        let mut readings = |shake: f64| -> Vec<ImuReading> {
            (0..400)
                .map(|index| {
                    let mut noise =
                        |scale: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * scale;
                    let swing = (f64::from(index) * 0.05).sin() * shake;
                    ImuReading {
                        stamp: Stamp::from_nanos(i64::from(index) * 2_500_000),
                        gyro: bias + noise(0.005) + Vector3::new(0.0, 0.3 * swing, 0.0),
                        specific_force: Vector3::new(swing * 3.0, 0.0, 9.81) + noise(0.03),
                        is_saturated: false,
                    }
                })
                .collect()
        };
        let standing = readings(0.0);
        let Some(found) = estimate_alignment(standing.iter(), &config) else { panic!("nothing") };
        assert!(found.is_stationary && (found.turn_rate - bias).norm() < 2e-3);
        let walking = readings(1.0);
        let Some(found) = estimate_alignment(walking.iter(), &config) else { panic!("nothing") };
        assert!(!found.is_stationary && found.up.angle(&Vector3::z()) < 0.05, "{found:?}");
        assert_eq!(estimate_alignment(walking[..3].iter(), &config), None);
    }
}
