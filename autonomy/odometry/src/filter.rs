//! An iterated error-state Kalman filter over [`State`].

use crate::config::NoiseConfig;
use crate::motion_model::MotionModel;
use crate::state::{
    ACCEL_BIAS, DIMENSION, ErrorMatrix, ErrorVector, GYRO_BIAS, POSITION, ROTATION, State, VELOCITY,
};
use geometry::{Isometry, Matrix3, Matrix6, Vector3, Vector6, se3};
use nalgebra::SMatrix;

/// What is added to the expected pose's deviation before it is compared: radians and metres.
const SPARE: (f64, f64) = (0.005, 0.03);

/// A state and how sure of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorStateFilter {
    /// The mean.
    pub state: State,
    /// Of the error.
    pub covariance: ErrorMatrix,
}

impl ErrorStateFilter {
    /// Starts with independent errors of these standard deviations.
    pub fn new(state: State, deviations: &ErrorVector) -> Self {
        Self { state, covariance: ErrorMatrix::from_diagonal(&deviations.component_mul(deviations)) }
    }

    /// Moves on by `dt` seconds.
    pub fn propagate(&mut self, motion: &MotionModel, dt: f64, noise: &NoiseConfig) {
        let next = motion.propagate_mean(&self.state, dt);
        let f = motion.compute_jacobian(&self.state, &next, dt);
        self.covariance = f * self.covariance * f.transpose();
        self.add_noise(motion, dt, noise);
        self.state = next;
    }

    fn add_noise(&mut self, motion: &MotionModel, dt: f64, noise: &NoiseConfig) {
        let mut add = |first: usize, variance: f64| {
            for index in first..first + 3 {
                self.covariance[(index, index)] += variance;
            }
        };
        match *motion {
            MotionModel::Inertial { .. } => {
                add(ROTATION, noise.gyro * noise.gyro * dt);
                add(VELOCITY, noise.accel * noise.accel * dt);
                add(GYRO_BIAS, noise.gyro_walk * noise.gyro_walk * dt);
                add(ACCEL_BIAS, noise.accel_walk * noise.accel_walk * dt);
            }
            MotionModel::Twist { turn_rate, velocity } => {
                // A share of the motion, and a little for standing still.
                let share = noise.external * noise.external;
                let (turning, moving) = (turn_rate.norm_squared() + 0.05, velocity.norm_squared() + 0.05);
                add(ROTATION, share * turning * dt);
                add(POSITION, share * moving * dt);
                add(VELOCITY, share * moving);
                add(GYRO_BIAS, share * turning);
            }
            MotionModel::DecayingVelocity => {
                add(VELOCITY, noise.velocity_walk * noise.velocity_walk * dt);
                add(GYRO_BIAS, noise.rate_walk * noise.rate_walk * dt);
            }
        }
    }

    /// Deviation of the best state from this one (the prior), given that a scan was linearised at `at`: its
    /// information and gradient there. Called again at the new point until it rests.
    ///
    /// With prior covariance P, its pose columns Pp and pose block Ppp, and `e` the pose deviation of `at`, the minimum
    /// of `d' P^-1 d + (d-e)' H (d-e) + 2 g' (d-e)` is `d = Pp (I + H Ppp)^-1 (H e - g)`: one 6x6 solve.
    pub fn compute_pose_step(
        &self,
        at: &State,
        information: &Matrix6,
        gradient: &Vector6,
    ) -> Option<ErrorVector> {
        let deviation = se3::local(&self.state.odom_from_body, &at.odom_from_body);
        let inner = self.information_and_identity(information).try_inverse()?;
        let pull = inner * (information * deviation - gradient);
        Some(self.covariance.fixed_view::<DIMENSION, 6>(0, 0) * pull)
    }

    /// Moves to `posterior` and shrinks the covariance by a scan's information.
    pub fn correct_pose(&mut self, posterior: State, information: &Matrix6) {
        if let Some(inner) = self.information_and_identity(information).try_inverse() {
            let columns: SMatrix<f64, DIMENSION, 6> = self.covariance.fixed_view::<DIMENSION, 6>(0, 0).into();
            self.covariance -= columns * (inner * information) * columns.transpose();
            self.symmetrise();
        }
        self.state = posterior;
    }

    fn information_and_identity(&self, information: &Matrix6) -> Matrix6 {
        let pose: Matrix6 = self.covariance.fixed_view::<6, 6>(0, 0).into();
        Matrix6::identity() + information * pose
    }

    /// Takes in a 3-vector measurement: `innovation` is measured minus expected, `h` its derivative by the error,
    /// `noise` its covariance. Innovations beyond 3 standard deviations weigh less and less: their noise is grown
    /// until they are 3 long (Huber). Returns the squared normalised innovation.
    pub fn update(&mut self, innovation: &Vector3, h: &SMatrix<f64, 3, DIMENSION>, noise: &Matrix3) -> f64 {
        let cross = self.covariance * h.transpose();
        let prior = h * cross;
        let Some(inverse) = (prior + noise).try_inverse() else { return 0.0 };
        let squared = innovation.dot(&(inverse * innovation));
        let grown = noise * (squared / 9.0).max(1.0);
        let Some(inverse) = (prior + grown).try_inverse() else { return squared };
        let gain = cross * inverse;
        self.state = self.state.retract(&(gain * innovation));
        self.covariance -= gain * cross.transpose();
        self.symmetrise();
        squared
    }

    /// Whether a pose is within so many standard deviations, with some centimetres to spare, of the one that is expected.
    pub fn is_within_gate(&self, odom_from_body: &Isometry, deviations: f64) -> bool {
        let off = se3::local(&self.state.odom_from_body, odom_from_body);
        let mut covariance: Matrix6 = self.covariance.fixed_view::<6, 6>(0, 0).into();
        for index in 0..3 {
            covariance[(index, index)] += SPARE.0 * SPARE.0;
            covariance[(index + 3, index + 3)] += SPARE.1 * SPARE.1;
        }
        covariance.cholesky().is_some_and(|root| off.dot(&root.solve(&off)) <= deviations * deviations)
    }

    /// Forgets all about the gyroscope's bias and starts anew at a value with that standard deviation, rad/s.
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
        // Rounding must not make a variance negative where a scan said everything.
        for index in 0..DIMENSION {
            let variance = &mut self.covariance[(index, index)];
            *variance = variance.max(1e-14);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    /// The reduced 6x6 form agrees with the full information form.
    #[test]
    fn absorbing_a_scan_agrees_with_the_information_form() {
        let mut rng = RngTree::new(21).child("filter").rng();
        let root = ErrorMatrix::from_fn(|_, _| rng.normal() * 0.1);
        let mut filter = ErrorStateFilter::new(State::at(Isometry::identity()), &ErrorVector::repeat(0.1));
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
    fn a_wild_measurement_moves_the_state_little() {
        let mut filter = ErrorStateFilter::new(State::at(Isometry::identity()), &ErrorVector::repeat(0.05));
        let mut h = SMatrix::<f64, 3, DIMENSION>::zeros();
        h.fixed_view_mut::<3, 3>(0, VELOCITY).copy_from(&Matrix3::identity());
        let noise = Matrix3::identity() * 0.01;
        let mut sober = filter.clone();
        assert!(sober.update(&Vector3::new(0.1, 0.0, 0.0), &h, &noise) < 1.0);
        assert!(filter.update(&Vector3::new(10.0, 0.0, 0.0), &h, &noise) > 100.0);
        assert!(filter.state.velocity.norm() < 0.02, "{}", filter.state.velocity);
        assert!(filter.covariance[(VELOCITY, VELOCITY)] > sober.covariance[(VELOCITY, VELOCITY)]);
    }
}
