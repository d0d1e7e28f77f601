//! Robust estimation with wrong loops, and robust kernels.

use crate::jacobians::random_pose;
use crate::support::{Published, load};
use factors::{
    BatchConfig, Between, ChordalConfig, FactorGraph, FactorId, Kernel, Key, Method, Planar, PlanarBetween,
    RelativePose, RobustConfig, Value, Values, VectorPrior, chordal, optimise, optimise_robustly,
};
use geometry::{Isometry, Matrix3, RngTree, Vector3};
use nalgebra::Vector2;

/// Position of a pose.
fn position(value: &Value) -> Vector3 {
    match value {
        Value::Pose(pose) => pose.translation.vector,
        Value::Planar(pose) => Vector3::new(pose.translation.x, pose.translation.y, 0.0),
        _ => unreachable!("poses only"),
    }
}

/// Root-mean-square distance of positions, and the diagonal of the first's bounding box.
fn rmse(truth: &Values, estimate: &Values) -> (f64, f64) {
    let pairs = truth.iter().zip(estimate.iter());
    let sum: f64 = pairs.map(|((_, a), (_, b))| (position(a) - position(b)).norm_squared()).sum();
    let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    for (_, value) in truth.iter() {
        low = low.inf(&position(value));
        high = high.sup(&position(value));
    }
    ((sum / truth.len() as f64).sqrt(), (high - low).norm())
}

/// Whether an edge joins poses that do not follow each other.
fn is_loop(keys: &[Key]) -> bool {
    keys.len() == 2 && keys[0].index().abs_diff(keys[1].index()) > 1
}

/// Adds loops between random poses with random relative poses and the information of random real loops.
fn add_wrong_loops(
    published: &Published,
    extent: f64,
    share: f64,
    seed: u64,
) -> (FactorGraph, Vec<FactorId>) {
    let mut rng = RngTree::new(seed).child("wrong").rng();
    let mut graph = published.graph.clone();
    let loops: Vec<FactorId> =
        published.edges.iter().filter(|(a, b, _)| is_loop(&[*a, *b])).map(|edge| edge.2).collect();
    let count = (loops.len() as f64 * share) as usize;
    let wrong = (0..count).map(|_| {
        let (a, b) = loop {
            let mut pick = || Key((rng.uniform() * published.values.len() as f64) as u32);
            let (a, b) = (pick(), pick());
            if is_loop(&[a, b]) {
                break (a, b);
            }
        };
        let model = loops[(rng.uniform() * loops.len() as f64) as usize];
        let relative = published.graph.get(model).unwrap().factor.relative_pose().unwrap();
        let mut shift = || (rng.uniform() - 0.5) * extent;
        let shift = Vector3::new(shift(), shift(), shift());
        let added = match relative {
            RelativePose::Space(_, information) => {
                let turn = random_pose(&mut rng, 1.0).rotation;
                let measured = Isometry::from_parts(shift.into(), turn);
                graph.add(Between::new(a, b, &measured, &information).unwrap(), &published.values)
            }
            RelativePose::Plane(_, information) => {
                let measured = Planar::new(Vector2::new(shift.x, shift.y), rng.normal() * 2.0);
                graph.add(PlanarBetween::new(a, b, &measured, &information).unwrap(), &published.values)
            }
        };
        added.unwrap()
    });
    let wrong = wrong.collect();
    (graph, wrong)
}

/// Initial poses from the odometry alone.
fn chained(published: &Published) -> Values {
    let mut graph = FactorGraph::default();
    for (_, entry) in published.graph.iter().filter(|(_, entry)| !is_loop(entry.factor.keys())) {
        let keys = entry.factor.keys();
        match (entry.factor.relative_pose(), entry.factor.anchor()) {
            (Some(RelativePose::Space(measured, information)), _) => {
                graph.add(Between::new(keys[0], keys[1], &measured, &information).unwrap(), &published.values)
            }
            (Some(RelativePose::Plane(measured, information)), _) => graph.add(
                PlanarBetween::new(keys[0], keys[1], &measured, &information).unwrap(),
                &published.values,
            ),
            (_, Some(Value::Pose(pose))) => {
                let prior = factors::Prior::new(keys[0], &pose, &nalgebra::Matrix6::identity());
                graph.add(prior.unwrap(), &published.values)
            }
            (_, Some(Value::Planar(pose))) => {
                let prior = factors::PlanarPrior::new(keys[0], &pose, &nalgebra::Matrix3::identity());
                graph.add(prior.unwrap(), &published.values)
            }
            _ => unreachable!("poses only"),
        }
        .unwrap();
    }
    chordal(&graph, &published.values, &ChordalConfig::default()).unwrap()
}

#[test]
fn a_fifth_of_wrong_loops_changes_the_trajectory_by_less_than_a_percent() {
    for name in ["smallGrid3D", "sphere2500", "parking-garage", "intel", "CSAIL", "kitti_05"] {
        let Some(published) = load(&format!("pose-graphs/{name}.g2o")) else { return };
        let start = if published.has_start { published.values.clone() } else { chained(&published) };
        let clean_start = if published.has_start {
            start.clone()
        } else {
            chordal(&published.graph, &published.values, &ChordalConfig::default()).unwrap()
        };
        let clean = optimise(&published.graph, &clean_start, &BatchConfig::default()).unwrap().values;
        let (_, extent) = rmse(&clean, &clean);
        let (graph, wrong) = add_wrong_loops(&published, extent, 0.2, 1);
        let solution =
            optimise_robustly(&graph, &start, |_, factor| is_loop(factor.keys()), &RobustConfig::default())
                .unwrap();
        let (error, _) = rmse(&clean, &solution.values);
        let found = wrong.iter().filter(|id| solution.rejected.contains(id)).count();
        println!(
            "{name}: RMSE {error:.5} m of {extent:.1} m ({:.3} %), {found} of {} wrong loops rejected and {} others, \
             {} iterations",
            100.0 * error / extent,
            wrong.len(),
            solution.rejected.len() - found,
            solution.iterations
        );
        assert!(error < 0.01 * extent, "{name}");
    }
}

#[test]
fn kernels_are_squares_near_zero_and_their_weights_are_their_slopes() {
    let kernels = [
        Kernel::None,
        Kernel::Huber(1.5),
        Kernel::Cauchy(1.5),
        Kernel::GemanMcClure(1.5),
        Kernel::DynamicCovarianceScaling(2.0),
    ];
    for kernel in kernels {
        assert!((kernel.evaluate(1e-8).0 / 1e-8 - 1.0).abs() < 1e-6, "{kernel:?}");
        for squared in [0.1, 1.0, 1.9, 2.3, 5.0, 100.0] {
            let h = 1e-6;
            let slope = (kernel.evaluate(squared + h).0 - kernel.evaluate(squared - h).0) / (2.0 * h);
            let (cost, weight) = kernel.evaluate(squared);
            assert!((slope - weight).abs() < 1e-6, "{kernel:?} at {squared}: {slope} {weight}");
            assert!(cost <= squared && cost >= 0.0 && (0.0..=1.0).contains(&weight));
        }
        assert!(kernel.is_valid());
    }
    for bad in [Kernel::Huber(0.0), Kernel::Cauchy(-1.0), Kernel::GemanMcClure(f64::NAN)] {
        assert!(!bad.is_valid());
    }
}

#[test]
fn kernels_resist_one_wrong_loop() {
    let Some(published) = load("pose-graphs/intel.g2o") else { return };
    let clean = optimise(&published.graph, &published.values, &BatchConfig::default()).unwrap().values;
    let mut errors = Vec::new();
    for kernel in [
        Kernel::None,
        Kernel::Huber(1.0),
        Kernel::Cauchy(1.0),
        Kernel::GemanMcClure(1.0),
        Kernel::DynamicCovarianceScaling(1.0),
    ] {
        let mut graph = published.graph.clone();
        let Some(RelativePose::Plane(_, information)) =
            graph.get(published.edges[0].2).unwrap().factor.relative_pose()
        else {
            unreachable!("a planar graph")
        };
        let wrong =
            PlanarBetween::new(Key(10), Key(900), &Planar::new(Vector2::new(9.0, 9.0), 2.0), &information);
        graph.add_robust(wrong.unwrap(), kernel, &published.values).unwrap();
        let config = BatchConfig { method: Method::LevenbergMarquardt, ..BatchConfig::default() };
        let solution = optimise(&graph, &published.values, &config).unwrap();
        errors.push(rmse(&clean, &solution.values).0);
    }
    println!("RMSE in metres without a kernel and with each: {errors:?}");
    // Huber's cost grows linearly with the residual. The costs of the later kernels grow more slowly or are bounded.
    assert!(errors[2..].iter().all(|error| *error < 0.05 * errors[0]), "{errors:?}");
    assert!(errors[3..].iter().all(|error| *error < 1e-3), "{errors:?}");
}

#[test]
fn hubers_kernel_turns_a_mean_into_a_median() {
    let estimate = |kernel: Kernel| {
        let mut values = Values::default();
        let key = values.insert(Value::Vector3(Vector3::zeros()));
        let mut graph = FactorGraph::default();
        for x in [0.0, 0.1, 0.2, 0.3, 100.0] {
            let prior = VectorPrior::space(key, &Vector3::new(x, 0.0, 0.0), &Matrix3::identity()).unwrap();
            graph.add_robust(prior, kernel, &values).unwrap();
        }
        let values = optimise(&graph, &values, &BatchConfig::default()).unwrap().values;
        values.vector3(key).unwrap().x
    };
    assert!((estimate(Kernel::None) - 20.12).abs() < 1e-6);
    assert!((estimate(Kernel::Huber(0.1)) - 0.2).abs() < 0.11);
}
