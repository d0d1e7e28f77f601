//! Compares every analytic Jacobian with central differences at random states.

use factors::{
    BearingRange, Between, BodyVelocity, Factor, FactorError, GravityDirection, Inertial, InertialNoise, Key,
    Landmark, Linearised, Planar, PlanarBetween, PlanarPrior, Preintegrated, Prior, RandomWalk, Residual,
    Value, Values, VectorPrior,
};
use geometry::{Isometry, Matrix3, Matrix6, Rng, RngTree, Vector3, Vector6, se3};
use nalgebra::{SMatrix, Vector2};

pub fn random_pose(rng: &mut Rng, turn: f64) -> Isometry {
    let mut normal = |scale: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * scale;
    let (w, v) = (normal(turn), normal(2.0));
    se3::retract(&Isometry::identity(), &Vector6::new(w.x, w.y, w.z, v.x, v.y, v.z))
}

pub fn random_planar(rng: &mut Rng) -> Planar {
    Planar::new(Vector2::new(rng.normal(), rng.normal()), rng.normal())
}

/// A positive definite matrix with all entries in use.
pub fn random_information<const N: usize>(rng: &mut Rng) -> SMatrix<f64, N, N> {
    let root = SMatrix::<f64, N, N>::from_fn(|_, _| rng.normal());
    root.transpose() * root + SMatrix::identity()
}

/// Compares all Jacobians of `factor` at `values` with central differences.
pub fn check(factor: &dyn Factor, values: &Values) {
    let mut analytic = Linearised::default();
    analytic.reset(factor);
    factor.linearise(values, &mut analytic).unwrap();
    let columns: Vec<Vec<f64>> = analytic.columns().map(<[f64]>::to_vec).collect();
    let negated_residual = |values: &Values| {
        let mut out = Linearised::default();
        out.reset(factor);
        factor.residual(values, &mut out).unwrap();
        out.negated_residual().to_vec()
    };
    for (a, b) in negated_residual(values).iter().zip(analytic.negated_residual()) {
        assert!((a - b).abs() < 1e-12 * (1.0 + a.abs()), "{factor:?}: residual() and linearise() differ");
    }
    let mut column = 0;
    for (&key, kind) in factor.keys().iter().zip(factor.kinds()) {
        for axis in 0..kind.dimension() {
            let h = 1e-6;
            let moved = |step: f64| {
                let mut error = [0.0; 6];
                error[axis] = step;
                let mut moved = values.clone();
                moved.set(key, values.get(key).unwrap().retract(&error)).unwrap();
                negated_residual(&moved)
            };
            let (plus, minus) = (moved(h), moved(-h));
            let scale = 1.0 + columns[column].iter().map(|entry| entry.abs()).fold(0.0, f64::max);
            for row in 0..factor.rows() {
                let numeric = (minus[row] - plus[row]) / (2.0 * h);
                let got = columns[column][row];
                assert!(
                    (numeric - got).abs() < 1e-5 * scale,
                    "{factor:?}: row {row}, key {key}, axis {axis}: {got} is {numeric} by differences"
                );
            }
            column += 1;
        }
    }
}

#[test]
fn relative_poses_and_priors() {
    let mut rng = RngTree::new(11).child("jacobians").rng();
    for round in 0..60 {
        let mut values = Values::default();
        // Errors from 0.1 mrad up to rotations of about two radians.
        let turn = [1e-4, 0.05, 0.7][round % 3];
        let [a, b] = [0, 1].map(|_| values.insert(Value::Pose(random_pose(&mut rng, 0.8))));
        let relative = values.pose(a).unwrap().inv_mul(values.pose(b).unwrap());
        let measured = relative * random_pose(&mut rng, turn);
        for residual in [Residual::Split, Residual::Logarithm] {
            let between = Between::new(a, b, &measured, &random_information(&mut rng)).unwrap();
            check(&between.with_residual(residual), &values);
        }
        let known = values.pose(a).unwrap() * random_pose(&mut rng, turn);
        check(&Prior::new(a, &known, &random_information(&mut rng)).unwrap(), &values);

        let [a, b] = [0, 1].map(|_| values.insert(Value::Planar(random_planar(&mut rng))));
        for residual in [Residual::Split, Residual::Logarithm] {
            let between =
                PlanarBetween::new(a, b, &random_planar(&mut rng), &random_information(&mut rng)).unwrap();
            check(&between.with_residual(residual), &values);
        }
        check(
            &PlanarPrior::new(a, &random_planar(&mut rng), &random_information(&mut rng)).unwrap(),
            &values,
        );

        let plane = values.insert(Value::Vector2(Vector2::new(1.0, 2.0)));
        check(&VectorPrior::plane(plane, &Vector2::zeros(), &random_information(&mut rng)).unwrap(), &values);
        let space = values.insert(Value::Vector3(Vector3::new(1.0, 2.0, 3.0)));
        check(&VectorPrior::space(space, &Vector3::zeros(), &random_information(&mut rng)).unwrap(), &values);
        let six = values.insert(Value::Vector6(Vector6::from_element(0.5)));
        check(&VectorPrior::six(six, &Vector6::zeros(), &random_information(&mut rng)).unwrap(), &values);
    }
}

#[test]
fn retracting_undoes_local_for_every_kind() {
    let mut rng = RngTree::new(12).child("retract").rng();
    for _ in 0..50 {
        let mut vector = || Vector3::new(rng.normal(), rng.normal(), rng.normal());
        let (v, w) = (vector(), vector());
        let pairs = [
            (Value::Pose(random_pose(&mut rng, 0.8)), Value::Pose(random_pose(&mut rng, 0.8))),
            (Value::Planar(random_planar(&mut rng)), Value::Planar(random_planar(&mut rng))),
            (Value::Vector2(v.xy()), Value::Vector2(w.xy())),
            (Value::Vector3(v), Value::Vector3(w)),
            (Value::Vector6(Vector6::from_element(v.x)), Value::Vector6(Vector6::from_element(w.x))),
        ];
        for (from, to) in pairs {
            let error = from.local(&to);
            let back = from.retract(error.as_slice()).local(&to);
            assert!(back.norm() < 1e-9, "{from:?} {to:?}");
        }
    }
}

#[test]
fn invalid_information_matrices_are_refused() {
    let key = Key(0);
    let pose = Isometry::identity();
    for (row, column, value) in [(2, 2, f64::NAN), (0, 1, 5.0), (4, 4, -1.0), (1, 1, f64::INFINITY)] {
        let mut information = Matrix6::identity();
        information[(row, column)] = value;
        assert!(Prior::new(key, &pose, &information).is_err(), "{row} {column} {value}");
    }
    let mut planar = Matrix3::identity();
    planar[(2, 2)] = 0.0;
    // An information matrix without information on the yaw is valid.
    assert!(PlanarPrior::new(key, &Planar::identity(), &planar).is_ok());
    let nowhere = Isometry::translation(f64::NAN, 0.0, 0.0);
    assert!(Prior::new(key, &nowhere, &Matrix6::identity()).is_err());
}

fn random_vector(rng: &mut Rng, scale: f64) -> Vector3 {
    Vector3::new(rng.normal(), rng.normal(), rng.normal()) * scale
}

#[test]
fn landmarks_velocities_and_gravity() {
    let mut rng = RngTree::new(13).child("others").rng();
    for _ in 0..40 {
        let mut values = Values::default();
        let pose = values.insert(Value::Pose(random_pose(&mut rng, 0.8)));
        let vector = values.insert(Value::Vector3(random_vector(&mut rng, 3.0)));
        let seen = random_vector(&mut rng, 3.0);
        check(&Landmark::new(pose, vector, &seen, &random_information(&mut rng)).unwrap(), &values);
        check(&BodyVelocity::new(pose, vector, &seen, &random_information(&mut rng)).unwrap(), &values);
        check(&GravityDirection::new(pose, &Vector3::z(), &seen, 0.1).unwrap(), &values);
        let planar = values.insert(Value::Planar(random_planar(&mut rng)));
        let point = values.insert(Value::Vector2(Vector2::new(rng.normal() + 5.0, rng.normal())));
        let information = random_information(&mut rng);
        check(&BearingRange::new(planar, point, rng.normal(), 2.0, &information).unwrap(), &values);
        let [a, b] = [0, 1].map(|_| values.insert(Value::Vector6(Vector6::from_fn(|_, _| rng.normal()))));
        check(&RandomWalk::new(a, b, &random_information(&mut rng)).unwrap(), &values);
    }
}

#[test]
fn a_degenerate_measurement_is_reported_with_its_variable() {
    let mut values = Values::default();
    let pose = values.insert(Value::Planar(Planar::new(Vector2::new(1.0, 2.0), 0.3)));
    let point = values.insert(Value::Vector2(Vector2::new(1.0, 2.0)));
    let factor = BearingRange::new(pose, point, 0.0, 1.0, &nalgebra::Matrix2::identity()).unwrap();
    let mut out = Linearised::default();
    out.reset(&factor);
    let error = factor.linearise(&values, &mut out);
    assert!(matches!(error, Err(FactorError::Degenerate { key, .. }) if key == point), "{error:?}");
    assert!(BearingRange::new(pose, point, 0.0, -1.0, &nalgebra::Matrix2::identity()).is_err());
    assert!(GravityDirection::new(pose, &Vector3::z(), &Vector3::zeros(), 0.1).is_err());
    let noise = InertialNoise { gyro_density_rad_s_per_sqrt_hz: 1e-3, accel_density_m_s2_per_sqrt_hz: 1e-2 };
    let mut sum = Preintegrated::new(&Vector6::zeros(), noise).unwrap();
    assert!(sum.add(&Vector3::zeros(), &Vector3::zeros(), 0.0).is_err());
    assert!(sum.add(&Vector3::repeat(f64::NAN), &Vector3::zeros(), 0.1).is_err());
    let keys = [0, 1, 2, 3, 4].map(Key);
    assert!(matches!(Inertial::new(keys, sum, &Vector3::zeros()), Err(FactorError::Degenerate { .. })));
}

/// Readings of a body that turns and accelerates, at 200 Hz.
fn readings(rng: &mut Rng, bias: &Vector6, noise: InertialNoise) -> Preintegrated {
    let mut sum = Preintegrated::new(bias, noise).unwrap();
    let (turn, force) = (random_vector(rng, 0.5), random_vector(rng, 2.0) + Vector3::z() * 9.81);
    for index in 0..40 {
        let wobble = (f64::from(index) * 0.2).sin();
        sum.add(&(turn * (1.0 + wobble)), &(force * (1.0 - 0.3 * wobble)), 0.005).unwrap();
    }
    sum
}

#[test]
fn inertial_readings() {
    let mut rng = RngTree::new(14).child("inertial").rng();
    let noise = InertialNoise { gyro_density_rad_s_per_sqrt_hz: 1e-3, accel_density_m_s2_per_sqrt_hz: 1e-2 };
    for _ in 0..20 {
        let bias = Vector6::from_fn(|_, _| rng.normal() * 0.02);
        let sum = readings(&mut rng, &bias, noise);
        let mut values = Values::default();
        let from = random_pose(&mut rng, 0.8);
        let turned = from.rotation * sum.gained(&bias).0;
        let from_pose = values.insert(Value::Pose(from));
        let from_velocity = values.insert(Value::Vector3(random_vector(&mut rng, 1.0)));
        let to =
            Isometry::from_parts((from.translation.vector + random_vector(&mut rng, 0.2)).into(), turned);
        let to_pose = values.insert(Value::Pose(to * random_pose(&mut rng, 0.1)));
        let to_velocity = values.insert(Value::Vector3(random_vector(&mut rng, 1.0)));
        let moved = bias + Vector6::from_fn(|_, _| rng.normal() * 0.01);
        let bias = values.insert(Value::Vector6(moved));
        let keys = [from_pose, from_velocity, to_pose, to_velocity, bias];
        check(&Inertial::new(keys, sum, &(Vector3::z() * -9.81)).unwrap(), &values);
    }
}

#[test]
fn a_changed_bias_is_corrected_to_first_order_and_a_steady_turn_is_exact() {
    let noise = InertialNoise { gyro_density_rad_s_per_sqrt_hz: 1e-3, accel_density_m_s2_per_sqrt_hz: 1e-2 };
    let change = Vector6::new(1e-3, -2e-3, 1e-3, 0.01, 0.02, -0.01);
    let summed = |bias: &Vector6| readings(&mut RngTree::new(15).rng(), bias, noise);
    let (guessed, exact) = (summed(&Vector6::zeros()).gained(&change), summed(&change).gained(&change));
    assert!((guessed.0.inverse() * exact.0).angle() < 1e-6);
    assert!((guessed.1 - exact.1).norm() < 1e-5 && (guessed.2 - exact.2).norm() < 1e-6);

    let mut sum = Preintegrated::new(&Vector6::zeros(), noise).unwrap();
    for _ in 0..100 {
        sum.add(&(Vector3::z() * 0.5), &Vector3::zeros(), 0.01).unwrap();
    }
    let (rotation, velocity, _) = sum.gained(&Vector6::zeros());
    assert!((rotation.angle() - 0.5).abs() < 1e-12 && velocity.norm() < 1e-12);
    assert!((sum.seconds() - 1.0).abs() < 1e-12);
}
