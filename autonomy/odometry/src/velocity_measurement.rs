//! Velocity measurements of the legs or of another odometry (docs/maths/odometry.md, equation 8).

use crate::filter::ErrorStateFilter;
use crate::state::{DIMENSION, GYRO_BIAS, LEG_SCALE, ROTATION, State, VELOCITY};
use geometry::{Isometry, Matrix3, Vector3, so3};
use nalgebra::SMatrix;

/// A measured velocity of a frame that is rigidly attached to the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityMeasurement {
    /// Velocity of that frame in its own axes, m/s.
    pub velocity: Vector3,
    /// Pose of that frame in the body.
    pub body_from_frame: Isometry,
    /// Reading of the gyroscope, rad/s, body frame.
    pub gyro: Vector3,
    /// Standard deviation of each axis, m/s.
    pub deviation: f64,
    /// Whether the estimated leg scale applies.
    pub uses_leg_scale: bool,
}

impl VelocityMeasurement {
    /// The velocity that a state predicts, m/s.
    fn predict(&self, state: &State) -> Vector3 {
        let in_body = state.odom_from_body.rotation.inverse() * state.velocity;
        let lever = (self.gyro - state.gyro_bias).cross(&self.body_from_frame.translation.vector);
        let scale = if self.uses_leg_scale { state.leg_scale } else { 1.0 };
        self.body_from_frame.rotation.inverse() * (in_body + lever) * scale
    }

    /// Jacobian of [`predict`](Self::predict) by the error (3x18).
    fn compute_jacobian(&self, state: &State) -> SMatrix<f64, 3, DIMENSION> {
        let scale = if self.uses_leg_scale { state.leg_scale } else { 1.0 };
        let frame_from_body =
            self.body_from_frame.rotation.inverse().to_rotation_matrix().into_inner() * scale;
        let body_from_odom = state.odom_from_body.rotation.inverse().to_rotation_matrix().into_inner();
        let mut h = SMatrix::<f64, 3, DIMENSION>::zeros();
        let mut set = |column: usize, block: Matrix3| h.fixed_view_mut::<3, 3>(0, column).copy_from(&block);
        set(ROTATION, frame_from_body * so3::hat(&(body_from_odom * state.velocity)));
        set(VELOCITY, frame_from_body * body_from_odom);
        set(GYRO_BIAS, frame_from_body * so3::hat(&self.body_from_frame.translation.vector));
        if self.uses_leg_scale {
            let unscaled = self.predict(state) / scale;
            h.fixed_view_mut::<3, 1>(0, LEG_SCALE).copy_from(&unscaled);
        }
        h
    }

    /// Corrects the filter by the measurement. Slipping feet are outliers, to which the filter gives less weight.
    pub fn apply(&self, filter: &mut ErrorStateFilter) {
        let innovation = self.velocity - self.predict(&filter.state);
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
    fn the_jacobian_matches_central_differences() {
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
                uses_leg_scale: round % 2 == 0,
            };
            let analytic = measurement.compute_jacobian(&state);
            for column in 0..DIMENSION {
                let mut step = ErrorVector::zeros();
                step[column] = 1e-6;
                let numeric = (measurement.predict(&state.retract(&step))
                    - measurement.predict(&state.retract(&-step)))
                    / 2e-6;
                assert!((numeric - analytic.column(column)).norm() < 1e-7, "column {column}");
            }
        }
    }
}
