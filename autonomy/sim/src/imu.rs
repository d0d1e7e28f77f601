//! The IMU: the true derivative of the simulated motion, plus the errors of a BMI085-class part.
//!
//! A sample is the mean over one sample period centred on its stamp, as the decimation filter of the real part computes it, so the sum of
//! the samples is the motion. Noise densities: Bosch BMI085 datasheet (gyroscope 0.014 °/s/√Hz,
//! accelerometer 120 µg/√Hz in x and y, 160 in z). Bias walks are of the size that Allan plots of such parts show.

use crate::body::MotionHistory;
use crate::timing::{IMU_HZ, TICK_SECONDS, TICKS_PER_IMU};
use geometry::{Isometry, Rng, STANDARD_GRAVITY_M_S2, Vector3, so3};
use messages::ImuSample;
use vocab::Stamp;

/// Noise density of the gyroscope, rad/s/√Hz.
const GYRO_NOISE_DENSITY: f64 = 0.014 * std::f64::consts::PI / 180.0;
/// Noise density of the accelerometer in x, y and z, m/s²/√Hz.
const ACCEL_NOISE_DENSITY: [f64; 3] =
    [120e-6 * STANDARD_GRAVITY_M_S2, 120e-6 * STANDARD_GRAVITY_M_S2, 160e-6 * STANDARD_GRAVITY_M_S2];
/// Random walk of the gyroscope's bias, rad/s/√s.
const GYRO_BIAS_WALK: f64 = 1.5e-5;
/// Random walk of the accelerometer's bias, m/s²/√s.
const ACCEL_BIAS_WALK: f64 = 2e-4;
/// Standard deviation of the gyroscope's bias at switch-on, rad/s. The datasheet allows up to 1 °/s.
const GYRO_TURN_ON_BIAS_RAD_S: f64 = 4e-3;
/// Standard deviation of the accelerometer's bias at switch-on, m/s². The datasheet allows up to 20 mg.
const ACCEL_TURN_ON_BIAS_M_S2: f64 = 0.06;
/// Greatest reading of the gyroscope, rad/s: 1000 °/s.
const GYRO_RANGE_RAD_S: f64 = 1000.0 * std::f64::consts::PI / 180.0;
/// Greatest reading of the accelerometer, m/s²: 12 g.
const ACCEL_RANGE_M_S2: f64 = 12.0 * STANDARD_GRAVITY_M_S2;

/// The inertial measurement unit.
#[derive(Clone, Debug)]
pub(crate) struct SimulatedImu {
    base_from_imu: Isometry,
    /// `None` for an IMU without errors.
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

impl SimulatedImu {
    /// An IMU at `base_from_imu`; without `rng` it has no errors.
    pub(crate) fn new(base_from_imu: Isometry, rng: Option<Rng>) -> Self {
        let errors = rng.map(|mut rng| Errors {
            gyro_bias: gaussian(&mut rng) * GYRO_TURN_ON_BIAS_RAD_S,
            accel_bias: gaussian(&mut rng) * ACCEL_TURN_ON_BIAS_M_S2,
            rng,
        });
        Self { base_from_imu, errors }
    }

    /// The sample of a tick, taken at `stamp`. It uses the poses of three ticks before and after.
    pub(crate) fn sample(&mut self, motion: &MotionHistory, tick: isize, stamp: Stamp) -> ImuSample {
        let half = TICKS_PER_IMU / 2;
        let at = |tick| motion.at(tick) * self.base_from_imu;
        let period = TICK_SECONDS * TICKS_PER_IMU as f64;
        let speed = |middle| {
            (at(middle + 1).translation.vector - at(middle - 1).translation.vector) / (2.0 * TICK_SECONDS)
        };
        let acceleration = (speed(tick + half) - speed(tick - half)) / period;
        let site_from_imu = at(tick).rotation;
        let mut specific_force =
            site_from_imu.inverse() * (acceleration + Vector3::z() * STANDARD_GRAVITY_M_S2);
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
        self.gyro_bias += gaussian(&mut self.rng) * (GYRO_BIAS_WALK * walk);
        self.accel_bias += gaussian(&mut self.rng) * (ACCEL_BIAS_WALK * walk);
        *angular_velocity += self.gyro_bias + gaussian(&mut self.rng) * (GYRO_NOISE_DENSITY * band);
        let noise = gaussian(&mut self.rng).component_mul(&Vector3::from(ACCEL_NOISE_DENSITY)) * band;
        *specific_force += self.accel_bias + noise;
        angular_velocity.apply(|w| *w = w.clamp(-GYRO_RANGE_RAD_S, GYRO_RANGE_RAD_S));
        specific_force.apply(|a| *a = a.clamp(-ACCEL_RANGE_M_S2, ACCEL_RANGE_M_S2));
    }
}
