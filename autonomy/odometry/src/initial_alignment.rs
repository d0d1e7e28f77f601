//! The first second: which way is up, how far the gyroscope is off, and whether the robot stood still for it.

use crate::imu_queue::ImuReading;
use geometry::{Rotation, Vector3, so3};

/// Standing still: standard deviation of each axis below these, rad/s and m/s².
const STILL_GYRO: f64 = 0.03;
const STILL_ACCEL: f64 = 0.35;
/// And the mean turn rate below this, rad/s: more than any bias of a working part.
const STILL_RATE: f64 = 0.15;

/// What a stretch of inertial readings says about the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialAlignment {
    /// Mean specific force in the body frame of the first reading, m/s²: up.
    pub up: Vector3,
    /// Mean of the gyroscope, rad/s: its bias, when still.
    pub rate: Vector3,
    /// Whether the robot stood still.
    pub still: bool,
}

/// Judges readings; `None` when there are fewer than 5.
pub fn initial_alignment<'a>(
    readings: impl Iterator<Item = &'a ImuReading> + Clone,
) -> Option<InitialAlignment> {
    let count = readings.clone().count();
    if count < 5 {
        return None;
    }
    let scale = 1.0 / count as f64;
    let mean = |value: fn(&ImuReading) -> Vector3| readings.clone().map(value).sum::<Vector3>() * scale;
    let (rate, force) = (mean(|r| r.gyro), mean(|r| r.specific_force));
    let spread = |value: fn(&ImuReading) -> Vector3, mean: Vector3| {
        readings.clone().map(|r| (value(r) - mean).component_mul(&(value(r) - mean))).sum::<Vector3>() * scale
    };
    let still = spread(|r| r.gyro, rate).max().sqrt() < STILL_GYRO
        && spread(|r| r.specific_force, force).max().sqrt() < STILL_ACCEL
        && rate.norm() < STILL_RATE;
    if still {
        return Some(InitialAlignment { up: force, rate, still });
    }
    Some(InitialAlignment { up: turned_mean(readings) * scale, rate, still })
}

/// Sum of the specific forces, each turned into the body frame of the first reading by the gyroscope: velocity changes
/// of a walking robot cancel over a second, gravity does not.
fn turned_mean<'a>(readings: impl Iterator<Item = &'a ImuReading>) -> Vector3 {
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

/// Rotation of the body in a level frame whose heading is the base's: `up` (body frame) points along z and
/// the base's x axis has no sideways part.
pub fn level(up: &Vector3, body_from_base: &Rotation) -> Rotation {
    let up_in_base = body_from_base.inverse() * up;
    let Some(level_from_base) = Rotation::rotation_between(&up_in_base, &Vector3::z()) else {
        // Exactly upside down: turn about x.
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
    fn level_puts_up_up_and_keeps_the_heading() {
        let mut rng = RngTree::new(31).child("level").rng();
        for _ in 0..100 {
            let up = Vector3::new(rng.normal(), rng.normal(), rng.normal()).normalize() * 9.8;
            let body_from_base = so3::exp(&Vector3::new(rng.normal(), rng.normal(), rng.normal()));
            let odom_from_body = level(&up, &body_from_base);
            assert!((odom_from_body * up - Vector3::z() * 9.8).norm() < 1e-9);
            assert!((odom_from_body * body_from_base * Vector3::x()).y.abs() < 1e-9);
        }
    }

    #[test]
    fn still_and_walking_are_told_apart_and_both_give_up() {
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
                        saturated: false,
                    }
                })
                .collect()
        };
        let standing = readings(0.0);
        let Some(found) = initial_alignment(standing.iter()) else { panic!("nothing") };
        assert!(found.still && (found.rate - bias).norm() < 2e-3);
        let walking = readings(1.0);
        let Some(found) = initial_alignment(walking.iter()) else { panic!("nothing") };
        assert!(!found.still && found.up.angle(&Vector3::z()) < 0.05, "{found:?}");
        assert_eq!(initial_alignment(walking[..3].iter()), None);
    }
}
