//! Every analytic Jacobian against central differences, at random states.

use factors::{Between, PlanarBetween, PlanarPrior, Prior, Residual, VectorPrior};
use factors::{Factor, Key, Linearised, Planar, Value, Values};
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
        // From tiny errors to turns of about two radians.
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
fn information_that_is_none_is_refused() {
    let key = Key(0);
    let pose = Isometry::identity();
    for (row, column, value) in [(2, 2, f64::NAN), (0, 1, 5.0), (4, 4, -1.0), (1, 1, f64::INFINITY)] {
        let mut information = Matrix6::identity();
        information[(row, column)] = value;
        assert!(Prior::new(key, &pose, &information).is_err(), "{row} {column} {value}");
    }
    let mut planar = Matrix3::identity();
    planar[(2, 2)] = 0.0;
    // Nothing known about the yaw is fine.
    assert!(PlanarPrior::new(key, &Planar::identity(), &planar).is_ok());
    let nowhere = Isometry::translation(f64::NAN, 0.0, 0.0);
    assert!(Prior::new(key, &nowhere, &Matrix6::identity()).is_err());
}
