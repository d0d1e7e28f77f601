//! What the legs, or another odometry, say of the velocity.

use crate::filter::ErrorStateFilter;
use crate::state::{DIMENSION, GYRO_BIAS, LEG_SCALE, ROTATION, State, VELOCITY};
use geometry::{Isometry, Matrix3, Vector3, so3};
use nalgebra::SMatrix;

/// A measured velocity of a frame that is fixed to the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityMeasurement {
    /// Velocity of that frame in its own coordinates, m/s.
    pub velocity: Vector3,
    /// That frame in the body.
    pub body_from_frame: Isometry,
    /// What the gyroscope reads, rad/s, body frame.
    pub gyro: Vector3,
    /// Standard deviation of each axis, m/s.
    pub deviation: f64,
    /// Whether the estimated leg scale applies.
    pub scaled: bool,
}

impl VelocityMeasurement {
    /// The velocity that a state predicts: that of the body plus the lever arm's, in the frame's axes, times the scale.
    fn expected(&self, state: &State) -> Vector3 {
        let in_body = state.odom_from_body.rotation.inverse() * state.velocity;
        let lever = (self.gyro - state.gyro_bias).cross(&self.body_from_frame.translation.vector);
        let scale = if self.scaled { state.leg_scale } else { 1.0 };
        self.body_from_frame.rotation.inverse() * (in_body + lever) * scale
    }

    /// Derivative of [`expected`](Self::expected) by the error.
    fn compute_jacobian(&self, state: &State) -> SMatrix<f64, 3, DIMENSION> {
        let scale = if self.scaled { state.leg_scale } else { 1.0 };
        let frame_from_body =
            self.body_from_frame.rotation.inverse().to_rotation_matrix().into_inner() * scale;
        let body_from_odom = state.odom_from_body.rotation.inverse().to_rotation_matrix().into_inner();
        let mut h = SMatrix::<f64, 3, DIMENSION>::zeros();
        let mut set = |column: usize, block: Matrix3| h.fixed_view_mut::<3, 3>(0, column).copy_from(&block);
        set(ROTATION, frame_from_body * so3::hat(&(body_from_odom * state.velocity)));
        set(VELOCITY, frame_from_body * body_from_odom);
        set(GYRO_BIAS, frame_from_body * so3::hat(&self.body_from_frame.translation.vector));
        if self.scaled {
            let unscaled = self.expected(state) / scale;
            h.fixed_view_mut::<3, 1>(0, LEG_SCALE).copy_from(&unscaled);
        }
        h
    }

    /// Takes the measurement in. Slips are outliers, which the filter weighs down.
    pub fn apply(&self, filter: &mut ErrorStateFilter) {
        let innovation = self.velocity - self.expected(&filter.state);
        let h = self.compute_jacobian(&filter.state);
        filter.update(&innovation, &h, &(Matrix3::identity() * (self.deviation * self.deviation)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::ErrorVector;
    use geometry::RngTree;

    #[test]
    fn the_derivative_matches_central_differences() {
        let mut rng = RngTree::new(17).child("velocity").rng();
        for round in 0..50 {
            let mut random = || Vector3::new(rng.normal(), rng.normal(), rng.normal());
            let state = State {
                velocity: random(),
                gyro_bias: random() * 0.1,
                leg_scale: 1.1,
                ..State::at(Isometry::new(random(), random()))
            };
            let measurement = VelocityMeasurement {
                velocity: random(),
                body_from_frame: Isometry::new(random(), random()),
                gyro: random(),
                deviation: 0.1,
                scaled: round % 2 == 0,
            };
            let analytic = measurement.compute_jacobian(&state);
            for column in 0..DIMENSION {
                let mut step = ErrorVector::zeros();
                step[column] = 1e-6;
                let numeric = (measurement.expected(&state.retract(&step))
                    - measurement.expected(&state.retract(&-step)))
                    / 2e-6;
                assert!((numeric - analytic.column(column)).norm() < 1e-7, "column {column}");
            }
        }
    }
}
