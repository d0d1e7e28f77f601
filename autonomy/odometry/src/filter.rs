//! The iterated error-state Kalman filter over a [`State`].

use crate::motion_model::{DecayConfig, MotionModel};
use crate::state::{
    ACCEL_BIAS, DIMENSION, ErrorMatrix, ErrorVector, GYRO_BIAS, POSITION, ROTATION, State, VELOCITY,
};
use geometry::{Isometry, Matrix3, Matrix6, Vector3, Vector6, se3};
use nalgebra::SMatrix;

/// Noise densities of the inertial readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuNoise {
    /// Gyroscope, rad/s/√Hz.
    pub gyro_density_rad_s_per_sqrt_hz: f64,
    /// Accelerometer, m/s²/√Hz.
    pub accel_density_m_s2_per_sqrt_hz: f64,
}

/// Noise of the sources, and robustness of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterConfig {
    /// Noise of the IMU. Larger than in a datasheet: errors of timing and vibration are added. Chosen: far above the densities of a BMI085's datasheet.
    pub imu_noise: ImuNoise,
    /// Noise of IMU readings at the end of their range. Chosen: such a reading tells only that the true value is beyond the range.
    pub saturated_imu_noise: ImuNoise,
    /// Random walk of the gyroscope's bias, rad/s/√s. Chosen: a bias moves by 0.02 degrees a second in two minutes. More lets scans pull it, less follows temperature too
    /// slowly.
    pub gyro_bias_walk_rad_s_per_sqrt_s: f64,
    /// Random walk of the accelerometer's bias, m/s²/√s. Chosen: a bias moves by 5 mm/s² in two minutes. More lets scans pull it, less follows temperature too slowly.
    pub accel_bias_walk_m_s2_per_sqrt_s: f64,
    /// Standard deviation of each axis of a leg velocity while the robot walks, m/s. Consecutive measurements are treated as
    /// independent. Chosen: larger than the noise of one measurement, because feet slip for several in a row.
    pub leg_velocity_m_s: f64,
    /// Error of the external odometry as a share of its rotation and its distance in one second, 1/√s. Its clock may lag. Chosen as a round number, the root of 0.02:
    /// with more it is ignored, with less its lag bends the path.
    pub external_share_per_sqrt_s: f64,
    /// Standard deviation of an external velocity at standstill, m/s, when an IMU is used as well. Chosen: as that of the legs.
    pub min_external_velocity_m_s: f64,
    /// Added to the squared turn rate of the external odometry, (rad/s)², so that its error is not zero at standstill. Chosen: the square of 0.22 rad/s, a slow turn.
    /// With less, a standing robot that is pushed is not followed; with more, its pose drifts.
    pub min_external_turn_rate_squared_rad2_s2: f64,
    /// Added to the squared velocity of the external odometry, (m/s)², so that its error is not zero at standstill. Chosen: the square of 0.22 m/s, for the same reasons.
    pub min_external_velocity_squared_m2_s2: f64,
    /// Random walk of the velocity when nothing measures it, m/s/√s. Chosen: with [`DecayConfig::velocity_time_constant_s`] it makes 1.5 m/s, the speed of walkers.
    pub velocity_walk_m_s_per_sqrt_s: f64,
    /// Random walk of the turn rate when nothing measures it, rad/s/√s. Chosen: with [`DecayConfig::turn_rate_time_constant_s`] it makes 1 rad/s, the turn rate of
    /// walkers.
    pub turn_rate_walk_rad_s_per_sqrt_s: f64,
    /// Decay of velocity and turn rate when nothing measures them.
    pub decay: DecayConfig,
    /// Innovations longer than this many standard deviations get less weight (Huber). Source: the usual three standard deviations.
    pub huber_deviations: f64,
    /// Standard deviation added to the predicted rotation before a pose is compared with it, radians. Chosen: 5 cm at 10 m, about the effect of an error of calibration.
    pub gate_rotation_slack_rad: f64,
    /// Standard deviation added to the predicted position before a pose is compared with it, metres. Chosen: as that of a degenerate direction
    /// ([`crate::TrackingConfig::degenerate_deviation_m`]).
    pub gate_position_slack_m: f64,
    /// Lower bound of every variance, in the square of its own unit. Rounding must not make one negative. Chosen: a deviation of 1e-7, far below that of any measurement.
    pub min_variance: f64,
}

impl Default for FilterConfig {
    fn default() -> Self {
        Self {
            imu_noise: ImuNoise {
                gyro_density_rad_s_per_sqrt_hz: 1e-3,
                accel_density_m_s2_per_sqrt_hz: 2e-2,
            },
            saturated_imu_noise: ImuNoise {
                gyro_density_rad_s_per_sqrt_hz: 3.0,
                accel_density_m_s2_per_sqrt_hz: 10.0,
            },
            gyro_bias_walk_rad_s_per_sqrt_s: 3e-5,
            accel_bias_walk_m_s2_per_sqrt_s: 5e-4,
            leg_velocity_m_s: 0.1,
            external_share_per_sqrt_s: 0.14,
            min_external_velocity_m_s: 0.1,
            min_external_turn_rate_squared_rad2_s2: 0.05,
            min_external_velocity_squared_m2_s2: 0.05,
            velocity_walk_m_s_per_sqrt_s: 1.5,
            turn_rate_walk_rad_s_per_sqrt_s: 2.0,
            decay: DecayConfig::default(),
            huber_deviations: 3.0,
            gate_rotation_slack_rad: 0.005,
            gate_position_slack_m: 0.03,
            min_variance: 1e-14,
        }
    }
}

/// Variance of a random walk of this `density`, per √s, after `dt` seconds.
fn walk_variance(density: f64, dt: f64) -> f64 {
    density * density * dt
}

/// A state and the covariance of its error.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorStateFilter {
    config: FilterConfig,
    /// The mean.
    pub state: State,
    /// Covariance of the error.
    pub covariance: ErrorMatrix,
}

impl ErrorStateFilter {
    /// Starts with independent errors of the given standard deviations.
    pub fn new(config: FilterConfig, state: State, deviations: &ErrorVector) -> Self {
        let covariance = ErrorMatrix::from_diagonal(&deviations.component_mul(deviations));
        Self { config, state, covariance }
    }

    /// Propagates state and covariance by `dt` seconds (docs/maths/odometry.md, equations 4 to 7). `imu_noise` is that of the
    /// readings of this step.
    pub fn propagate(&mut self, motion: &MotionModel, dt: f64, imu_noise: &ImuNoise) {
        let next = motion.propagate_mean(&self.state, dt);
        let f = motion.compute_jacobian(&self.state, &next, dt);
        self.covariance = f * self.covariance * f.transpose();
        self.add_process_noise(motion, dt, imu_noise);
        self.state = next;
    }

    fn add_process_noise(&mut self, motion: &MotionModel, dt: f64, imu_noise: &ImuNoise) {
        let config = self.config;
        let mut add = |first: usize, variance: f64| {
            for index in first..first + 3 {
                self.covariance[(index, index)] += variance;
            }
        };
        match *motion {
            MotionModel::Inertial { .. } => {
                add(ROTATION, walk_variance(imu_noise.gyro_density_rad_s_per_sqrt_hz, dt));
                add(VELOCITY, walk_variance(imu_noise.accel_density_m_s2_per_sqrt_hz, dt));
                add(GYRO_BIAS, walk_variance(config.gyro_bias_walk_rad_s_per_sqrt_s, dt));
                add(ACCEL_BIAS, walk_variance(config.accel_bias_walk_m_s2_per_sqrt_s, dt));
            }
            MotionModel::Twist { turn_rate, velocity } => {
                let share_squared = config.external_share_per_sqrt_s * config.external_share_per_sqrt_s;
                let turn_rate_squared =
                    turn_rate.norm_squared() + config.min_external_turn_rate_squared_rad2_s2;
                let velocity_squared = velocity.norm_squared() + config.min_external_velocity_squared_m2_s2;
                add(ROTATION, share_squared * turn_rate_squared * dt);
                add(POSITION, share_squared * velocity_squared * dt);
                add(VELOCITY, share_squared * velocity_squared);
                add(GYRO_BIAS, share_squared * turn_rate_squared);
            }
            MotionModel::DecayingVelocity(_) => {
                add(VELOCITY, walk_variance(config.velocity_walk_m_s_per_sqrt_s, dt));
                add(GYRO_BIAS, walk_variance(config.turn_rate_walk_rad_s_per_sqrt_s, dt));
            }
        }
    }

    /// Deviation of the most probable state from the prior (this filter), given the information and gradient of a scan that was
    /// linearised at `at` (docs/maths/odometry.md, equation 15). Called again at the resulting state until it converges. `None` if
    /// the equations are singular.
    pub fn compute_pose_step(
        &self,
        at: &State,
        information: &Matrix6,
        gradient: &Vector6,
    ) -> Option<ErrorVector> {
        let deviation = se3::local(&self.state.odom_from_body, &at.odom_from_body);
        let inner = self.identity_plus_information(information).try_inverse()?;
        let pull = inner * (information * deviation - gradient);
        Some(self.covariance.fixed_view::<DIMENSION, 6>(0, 0) * pull)
    }

    /// Moves to the posterior state and reduces the covariance by a scan's information (docs/maths/odometry.md, equation 17).
    pub fn correct_pose(&mut self, posterior: State, information: &Matrix6) {
        if let Some(inner) = self.identity_plus_information(information).try_inverse() {
            let columns: SMatrix<f64, DIMENSION, 6> = self.covariance.fixed_view::<DIMENSION, 6>(0, 0).into();
            self.covariance -= columns * (inner * information) * columns.transpose();
            self.symmetrise();
        }
        self.state = posterior;
    }

    fn identity_plus_information(&self, information: &Matrix6) -> Matrix6 {
        let pose: Matrix6 = self.covariance.fixed_view::<6, 6>(0, 0).into();
        Matrix6::identity() + information * pose
    }

    /// Corrects by a measurement of three components: `innovation` is measured minus predicted, `h` the Jacobian of the prediction
    /// by the error, `noise` the covariance of the measurement. The noise of long innovations is enlarged (docs/maths/odometry.md,
    /// equation 9). Returns the squared normalised innovation.
    pub fn update(&mut self, innovation: &Vector3, h: &SMatrix<f64, 3, DIMENSION>, noise: &Matrix3) -> f64 {
        let cross = self.covariance * h.transpose();
        let prior = h * cross;
        let Some(inverse) = (prior + noise).try_inverse() else { return 0.0 };
        let squared = innovation.dot(&(inverse * innovation));
        let limit_squared = self.config.huber_deviations * self.config.huber_deviations;
        let enlarged = noise * (squared / limit_squared).max(1.0);
        let Some(inverse) = (prior + enlarged).try_inverse() else { return squared };
        let gain = cross * inverse;
        self.state = self.state.retract(&(gain * innovation));
        self.covariance -= gain * cross.transpose();
        self.symmetrise();
        squared
    }

    /// Whether a pose is within a number of standard deviations of the predicted one, with some slack added.
    pub fn is_within_gate(&self, odom_from_body: &Isometry, deviations: f64) -> bool {
        let error = se3::local(&self.state.odom_from_body, odom_from_body);
        let mut covariance: Matrix6 = self.covariance.fixed_view::<6, 6>(0, 0).into();
        let (rotation, position) = (self.config.gate_rotation_slack_rad, self.config.gate_position_slack_m);
        for index in 0..3 {
            covariance[(index, index)] += rotation * rotation;
            covariance[(index + 3, index + 3)] += position * position;
        }
        covariance.cholesky().is_some_and(|root| error.dot(&root.solve(&error)) <= deviations * deviations)
    }

    /// Replaces the gyroscope bias by a value with a standard deviation (rad/s) that is independent of all other errors.
    pub fn replace_gyro_bias(&mut self, bias: Vector3, deviation: f64) {
        self.state.gyro_bias = bias;
        self.covariance.fixed_rows_mut::<3>(GYRO_BIAS).fill(0.0);
        self.covariance.fixed_columns_mut::<3>(GYRO_BIAS).fill(0.0);
        for index in GYRO_BIAS..GYRO_BIAS + 3 {
            self.covariance[(index, index)] = deviation * deviation;
        }
    }

    fn symmetrise(&mut self) {
        self.covariance = (self.covariance + self.covariance.transpose()) * 0.5;
        for index in 0..DIMENSION {
            let variance = &mut self.covariance[(index, index)];
            *variance = variance.max(self.config.min_variance);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    /// The reduced 6x6 form agrees with the full information form.
    #[test]
    fn correcting_by_a_scan_agrees_with_the_information_form() {
        let mut rng = RngTree::new(21).child("filter").rng();
        let root = ErrorMatrix::from_fn(|_, _| rng.normal() * 0.1);
        let mut filter = ErrorStateFilter::new(
            FilterConfig::default(),
            State::at(Isometry::identity()),
            &ErrorVector::repeat(0.1),
        );
        filter.covariance += root * root.transpose();
        let columns = SMatrix::<f64, 6, 9>::from_fn(|_, _| rng.normal());
        let information = columns * columns.transpose() * 30.0;
        let gradient = Vector6::from_fn(|_, _| rng.normal());

        let mut full = ErrorMatrix::zeros();
        full.fixed_view_mut::<6, 6>(0, 0).copy_from(&information);
        let Some(prior) = filter.covariance.try_inverse() else { panic!("singular") };
        let Some(posterior) = (prior + full).try_inverse() else { panic!("singular") };
        let mut pull = ErrorVector::zeros();
        pull.fixed_rows_mut::<6>(0).copy_from(&-gradient);
        let step = filter.compute_pose_step(&filter.state, &information, &gradient);
        assert!(step.is_some_and(|step| (step - posterior * pull).norm() < 1e-9));
        let state = filter.state;
        filter.correct_pose(state, &information);
        assert!((filter.covariance - posterior).norm() < 1e-9);
    }

    #[test]
    fn an_outlier_moves_the_state_little() {
        let mut filter = ErrorStateFilter::new(
            FilterConfig::default(),
            State::at(Isometry::identity()),
            &ErrorVector::repeat(0.05),
        );
        let mut h = SMatrix::<f64, 3, DIMENSION>::zeros();
        h.fixed_view_mut::<3, 3>(0, VELOCITY).copy_from(&Matrix3::identity());
        let noise = Matrix3::identity() * 0.01;
        let mut plausible = filter.clone();
        assert!(plausible.update(&Vector3::new(0.1, 0.0, 0.0), &h, &noise) < 1.0);
        assert!(filter.update(&Vector3::new(10.0, 0.0, 0.0), &h, &noise) > 100.0);
        assert!(filter.state.velocity.norm() < 0.02, "{}", filter.state.velocity);
        assert!(filter.covariance[(VELOCITY, VELOCITY)] > plausible.covariance[(VELOCITY, VELOCITY)]);
    }
}
