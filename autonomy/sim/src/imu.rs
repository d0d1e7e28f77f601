//! The inertial unit: the true derivative of the simulated motion, plus the errors of a BMI085-class part.
//!
//! A sample is the mean over one sample period centred on its stamp, as the decimation filter of the real part does, so
//! summing samples gives back the motion. Noise densities: Bosch BMI085 datasheet (gyroscope 0.014 °/s/√Hz,
//! accelerometer 120 µg/√Hz in x and y, 160 in z). Bias walks are of the size that Allan plots of such parts show.

use crate::body::Motion;
use crate::{IMU_HZ, TICK_SECONDS, TICKS_PER_IMU};
use geometry::{Isometry, Rng, Vector3, so3};
use messages::ImuSample;
use vocab::Stamp;

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;

/// rad/s/√Hz.
const GYRO_DENSITY: f64 = 0.014 * std::f64::consts::PI / 180.0;
/// m/s²/√Hz.
const ACCEL_DENSITY: [f64; 3] = [120e-6 * GRAVITY, 120e-6 * GRAVITY, 160e-6 * GRAVITY];
/// rad/s/√s.
const GYRO_WALK: f64 = 1.5e-5;
/// m/s²/√s.
const ACCEL_WALK: f64 = 2e-4;
/// Standard deviation of the bias at switch-on, rad/s (the datasheet allows up to 1 °/s) and m/s² (up to 20 mg).
const GYRO_TURN_ON: f64 = 4e-3;
const ACCEL_TURN_ON: f64 = 0.06;
/// Where the readings saturate: 1000 °/s and 12 g.
const GYRO_RANGE: f64 = 1000.0 * std::f64::consts::PI / 180.0;
const ACCEL_RANGE: f64 = 12.0 * GRAVITY;

/// The inertial unit.
#[derive(Clone, Debug)]
pub(crate) struct Imu {
    base_from_imu: Isometry,
    /// `None` for a part without errors.
    errors: Option<Errors>,
}

#[derive(Clone, Debug)]
struct Errors {
    rng: Rng,
    gyro_bias: Vector3,
    accel_bias: Vector3,
}

fn gaussian(rng: &mut Rng) -> Vector3 {
    Vector3::new(rng.normal(), rng.normal(), rng.normal())
}

impl Imu {
    /// A unit at `base_from_imu`; without `rng` it makes no errors.
    pub(crate) fn new(base_from_imu: Isometry, rng: Option<Rng>) -> Self {
        let errors = rng.map(|mut rng| Errors {
            gyro_bias: gaussian(&mut rng) * GYRO_TURN_ON,
            accel_bias: gaussian(&mut rng) * ACCEL_TURN_ON,
            rng,
        });
        Self { base_from_imu, errors }
    }

    /// The sample of a tick, taken at `stamp`. Looks three ticks back and forth.
    pub(crate) fn sample(&mut self, motion: &Motion, tick: isize, stamp: Stamp) -> ImuSample {
        let half = TICKS_PER_IMU / 2;
        let at = |tick| motion.at(tick) * self.base_from_imu;
        let period = TICK_SECONDS * TICKS_PER_IMU as f64;
        let speed = |middle| {
            (at(middle + 1).translation.vector - at(middle - 1).translation.vector) / (2.0 * TICK_SECONDS)
        };
        let acceleration = (speed(tick + half) - speed(tick - half)) / period;
        let site_from_imu = at(tick).rotation;
        let mut specific_force = site_from_imu.inverse() * (acceleration + Vector3::z() * GRAVITY);
        let turned = at(tick - half).rotation.inverse() * at(tick + half).rotation;
        let mut angular_velocity = so3::log(&turned) / period;
        if let Some(errors) = &mut self.errors {
            errors.corrupt(&mut angular_velocity, &mut specific_force);
        }
        ImuSample {
            stamp,
            angular_velocity: geometry::vec_to_plain(&angular_velocity),
            specific_force: geometry::vec_to_plain(&specific_force),
        }
    }
}

impl Errors {
    fn corrupt(&mut self, angular_velocity: &mut Vector3, specific_force: &mut Vector3) {
        // Datasheet densities are one-sided: noise power up to half the sample rate.
        let band = (IMU_HZ as f64 / 2.0).sqrt();
        let walk = (1.0 / IMU_HZ as f64).sqrt();
        self.gyro_bias += gaussian(&mut self.rng) * (GYRO_WALK * walk);
        self.accel_bias += gaussian(&mut self.rng) * (ACCEL_WALK * walk);
        *angular_velocity += self.gyro_bias + gaussian(&mut self.rng) * (GYRO_DENSITY * band);
        let noise = gaussian(&mut self.rng).component_mul(&Vector3::from(ACCEL_DENSITY)) * band;
        *specific_force += self.accel_bias + noise;
        angular_velocity.apply(|w| *w = w.clamp(-GYRO_RANGE, GYRO_RANGE));
        specific_force.apply(|a| *a = a.clamp(-ACCEL_RANGE, ACCEL_RANGE));
    }
}
