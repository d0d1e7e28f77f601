//! Compares the incremental solver with the batch solvers.

use crate::jacobians::{random_information, random_pose};
use crate::support::{Published, load};
use factors::{
    BatchConfig, Between, FactorGraph, FactorId, Incremental, IncrementalConfig, Key, Marginals,
    PlanarBetween, PlanarPrior, Prior, RelativePose, SolveError, Value, Values, VectorPrior, optimise,
};
use geometry::{Isometry, Matrix3, Matrix6, Rng, RngTree, Vector3, Vector6, se3};

/// Adds the edge again, to another solver.
fn add_edge(solver: &mut Incremental, published: &Published, edge: usize) {
    let (from, to, id) = published.edges[edge];
    match published.graph.get(id).unwrap().factor.relative_pose().unwrap() {
        RelativePose::Space(measured, information) => {
            solver.add(Between::new(from, to, &measured, &information).unwrap()).unwrap();
        }
        RelativePose::Plane(measured, information) => {
            solver.add(PlanarBetween::new(from, to, &measured, &information).unwrap()).unwrap();
        }
    }
}

/// Predicts a new pose from one of its edges.
fn predict(solver: &Incremental, published: &Published, edge: usize, new: Key) -> Value {
    let (from, to, id) = published.edges[edge];
    let known = solver.estimate(if from == new { to } else { from }).unwrap();
    match (known, published.graph.get(id).unwrap().factor.relative_pose().unwrap()) {
        (Value::Pose(pose), RelativePose::Space(measured, _)) => {
            Value::Pose(pose * if to == new { measured } else { measured.inverse() })
        }
        (Value::Planar(pose), RelativePose::Plane(measured, _)) => {
            Value::Planar(pose * if to == new { measured } else { measured.inverse() })
        }
        _ => unreachable!("poses of one kind"),
    }
}

/// Adds the poses one by one, each with all its edges to earlier ones. Calls `after` each time.
fn walk(published: &Published, poses: usize, mut after: impl FnMut(usize, &mut Incremental)) -> Incremental {
    let mut solver = Incremental::new(IncrementalConfig::default());
    let mut edges: Vec<Vec<usize>> = vec![Vec::new(); published.values.len()];
    for (index, (from, to, _)) in published.edges.iter().enumerate() {
        edges[from.index().max(to.index())].push(index);
    }
    for (index, edges) in edges.iter().enumerate().take(poses) {
        let key = Key(index as u32);
        if index == 0 {
            let first = *published.values.get(key).unwrap();
            solver.insert(first);
            match first {
                Value::Pose(pose) => {
                    solver.add(Prior::new(key, &pose, &(Matrix6::identity() * 1e12)).unwrap()).unwrap()
                }
                Value::Planar(pose) => {
                    solver.add(PlanarPrior::new(key, &pose, &(Matrix3::identity() * 1e12)).unwrap()).unwrap()
                }
                _ => unreachable!("poses only"),
            };
        } else {
            let previous = |edge: &&usize| {
                let (from, to, _) = published.edges[**edge];
                from.index().min(to.index()) + 1 == index
            };
            let along = edges.iter().find(previous).or(edges.first()).unwrap();
            let start = predict(&solver, published, *along, key);
            solver.insert(start);
        }
        edges.iter().for_each(|&edge| add_edge(&mut solver, published, edge));
        solver.update().unwrap();
        after(index, &mut solver);
    }
    solver
}

/// The cost must be within 1 % of the optimum at the end, and at most 10 % above it at every hundredth step.
fn stays_near_the_optimum(name: &str) {
    let Some(published) = load(&format!("pose-graphs/{name}.g2o")) else { return };
    let mut worst = 0.0_f64;
    let solver = walk(&published, published.values.len(), |index, solver| {
        if index % 100 == 0 && index > 0 {
            let estimates = solver.estimates();
            let ours = solver.graph().chi_squared(&estimates).unwrap();
            let best = optimise(solver.graph(), &estimates, &BatchConfig::default()).unwrap().cost;
            // Before the first loop both costs are zero except for rounding.
            worst = worst.max((ours - 1e-9) / best.max(1e-9) - 1.0);
            assert!(worst <= 0.1, "{name} at {index}: {ours} instead of {best}");
        }
    });
    let ours = solver.graph().chi_squared(&solver.estimates()).unwrap();
    let best = optimise(&published.graph, &solver.estimates(), &BatchConfig::default()).unwrap().cost;
    println!("{name}: {ours} instead of {best}; at worst {:.2} % above on the way", worst * 100.0);
    assert!(ours <= best * 1.01, "{name}: {ours} instead of {best}");
}

mod nightly {
    use super::stays_near_the_optimum;

    #[test]
    fn the_sphere_added_pose_by_pose_stays_near_the_optimum() {
        stays_near_the_optimum("sphere2500");
    }
}

#[test]
fn the_garage_added_pose_by_pose_stays_near_the_optimum() {
    stays_near_the_optimum("parking-garage");
}

#[test]
fn a_planar_graph_added_pose_by_pose_stays_near_the_optimum() {
    stays_near_the_optimum("intel");
}

/// The pose with noise of about a centimetre and half a degree.
fn noisy(pose: &Isometry, rng: &mut Rng) -> Isometry {
    se3::retract(pose, &Vector6::from_fn(|_, _| rng.normal() * 0.01))
}

/// A small random graph: a chain with loops, anchored at its first pose.
fn random_chain(poses: usize, seed: u64) -> (FactorGraph, Values) {
    let mut rng = RngTree::new(seed).child("chain").rng();
    let mut values = Values::default();
    let mut graph = FactorGraph::default();
    let truth: Vec<Isometry> = (0..poses).map(|_| random_pose(&mut rng, 0.6)).collect();
    for pose in &truth {
        values.insert(Value::Pose(noisy(pose, &mut rng)));
    }
    graph.add(Prior::new(Key(0), &truth[0], &random_information(&mut rng)).unwrap(), &values).unwrap();
    let loops = (0..poses).map(|index| (index, (index * 7 + 3) % poses)).filter(|(a, b)| a != b);
    for (a, b) in (1..poses).map(|index| (index - 1, index)).chain(loops) {
        let measured = noisy(&(truth[a].inverse() * truth[b]), &mut rng);
        let factor =
            Between::new(Key(a as u32), Key(b as u32), &measured, &random_information(&mut rng)).unwrap();
        graph.add(factor, &values).unwrap();
    }
    (graph, values)
}

/// Builds the same graph in an incremental solver, `chunk` poses at a time.
fn incremental(graph: &FactorGraph, values: &Values, chunk: usize) -> Incremental {
    let mut solver = Incremental::new(IncrementalConfig::default());
    for (key, value) in values.iter() {
        solver.insert(*value);
        if key.index() % chunk == 0 || key.index() + 1 == values.len() {
            for (_, entry) in graph.iter() {
                let newest = entry.factor.keys().iter().map(|key| key.index()).max().unwrap();
                let before = key.index()
                    - (if key.index() % chunk == 0 { chunk } else { key.index() % chunk }).min(key.index());
                let is_new = newest > before || (key.index() == 0 && newest == 0);
                if newest <= key.index() && is_new {
                    match entry.factor.relative_pose() {
                        Some(RelativePose::Space(measured, information)) => {
                            let keys = entry.factor.keys();
                            solver
                                .add(Between::new(keys[0], keys[1], &measured, &information).unwrap())
                                .unwrap();
                        }
                        _ => {
                            let Some(Value::Pose(anchor)) = entry.factor.anchor() else { unreachable!() };
                            solver.add(Prior::new(Key(0), &anchor, &Matrix6::identity()).unwrap()).unwrap();
                        }
                    }
                }
            }
            solver.update().unwrap();
        }
    }
    solver
}

/// Relinearises until the solution no longer moves.
fn settle(solver: &mut Incremental) {
    for _ in 0..6 {
        solver.relinearise_all().unwrap();
    }
}

#[test]
fn a_snapshot_is_relinearised_as_the_solver_itself_to_the_last_bit() {
    for (seed, chunk) in [(1, 1), (2, 3), (3, 10)] {
        let (graph, values) = random_chain(40, seed);
        let mut solver = incremental(&graph, &values, chunk);
        solver.remove(FactorId(20)).unwrap();
        solver.update().unwrap();
        let snapshot = solver.snapshot();
        let before = solver.estimates();
        solver.relinearise_all().unwrap();
        assert!(distance(&before, &solver.estimates()) > 1e-6, "relinearising should matter");
        assert_eq!(snapshot.relinearise().unwrap(), solver.estimates());
    }
}

fn distance(a: &Values, b: &Values) -> f64 {
    a.iter().zip(b.iter()).map(|((_, a), (_, b))| a.local(b).norm()).fold(0.0, f64::max)
}

#[test]
fn the_converged_solution_equals_the_batch_solution_in_estimates_and_covariances() {
    for (seed, chunk) in [(1, 1), (2, 3), (3, 10)] {
        let (graph, values) = random_chain(40, seed);
        let mut solver = incremental(&graph, &values, chunk);
        assert_eq!(solver.graph().len(), graph.len());
        settle(&mut solver);
        let config = BatchConfig { min_relative_decrease: 1e-13, ..BatchConfig::default() };
        let best = optimise(solver.graph(), &values, &config).unwrap();
        assert!(distance(&solver.estimates(), &best.values) < 1e-5, "seed {seed}");

        let marginals = Marginals::new(solver.graph(), &solver.estimates()).unwrap();
        let keys = [Key(3), Key(39), Key(17)];
        let (ours, theirs) = (solver.covariance(&keys).unwrap(), marginals.covariance(&keys).unwrap());
        assert!((&ours - &theirs).amax() < 1e-6 * theirs.amax(), "seed {seed}");
        assert!((&ours - ours.transpose()).amax() < 1e-12);
        assert!(marginals.covariance(&[Key(40)]).is_err() && solver.covariance(&[Key(40)]).is_err());
    }
}

#[test]
fn covariance_is_the_inverse_of_the_information() {
    let information = Matrix3::new(4.0, 1.0, 0.0, 1.0, 3.0, 0.5, 0.0, 0.5, 2.0);
    let mut solver = Incremental::new(IncrementalConfig::default());
    let key = solver.insert(Value::Vector3(Vector3::new(1.0, 2.0, 3.0)));
    solver.add(VectorPrior::space(key, &Vector3::zeros(), &information).unwrap()).unwrap();
    solver.update().unwrap();
    let covariance = solver.covariance(&[key]).unwrap();
    let expected = information.try_inverse().unwrap();
    assert!((covariance - expected).amax() < 1e-12);
    assert!(solver.estimate(key).unwrap().local(&Value::Vector3(Vector3::zeros())).norm() < 1e-12);
}

#[test]
fn a_removed_factor_no_longer_influences_the_estimates() {
    let (graph, values) = random_chain(30, 9);
    let mut solver = incremental(&graph, &values, 5);
    settle(&mut solver);
    let before = solver.estimates();
    let wrong =
        Between::new(Key(2), Key(25), &Isometry::translation(5.0, 0.0, 0.0), &(Matrix6::identity() * 10.0));
    let id = solver.add(wrong.unwrap()).unwrap();
    solver.update().unwrap();
    settle(&mut solver);
    assert!(distance(&before, &solver.estimates()) > 0.01);
    solver.remove(id).unwrap();
    solver.update().unwrap();
    assert!(matches!(solver.remove(id), Err(SolveError::UnknownFactor { .. })));
    settle(&mut solver);
    assert!(distance(&before, &solver.estimates()) < 1e-5);
}

#[test]
fn a_failed_update_changes_nothing_and_names_the_variable() {
    let (graph, values) = random_chain(20, 4);
    let mut solver = incremental(&graph, &values, 4);
    settle(&mut solver);
    let (before, factors) = (solver.estimates(), solver.graph().len());
    // A pose without any measurement.
    let lonely = solver.insert(Value::Pose(Isometry::identity()));
    assert_eq!(solver.update(), Err(SolveError::Undetermined { key: lonely }));
    // Two poses connected only to each other. The valid factor between poses 0 and 9 is dropped with them.
    let [a, b] = [0, 1].map(|_| solver.insert(Value::Pose(Isometry::identity())));
    solver.add(Between::new(a, b, &Isometry::identity(), &Matrix6::identity()).unwrap()).unwrap();
    solver.add(Between::new(Key(0), Key(9), &Isometry::identity(), &Matrix6::identity()).unwrap()).unwrap();
    assert!(matches!(solver.update(), Err(SolveError::Undetermined { key }) if key == a || key == b));
    // Removal of the only anchor.
    let anchor = solver.graph().iter().find(|(_, entry)| entry.factor.anchor().is_some()).unwrap().0;
    solver.remove(anchor).unwrap();
    assert!(matches!(solver.update(), Err(SolveError::Undetermined { .. })));

    assert_eq!(solver.graph().len(), factors);
    assert!(distance(&before, &solver.estimates()) < 1e-9);
    let key = solver.insert(*values.get(Key(3)).unwrap());
    solver.add(Between::new(Key(3), key, &Isometry::identity(), &Matrix6::identity()).unwrap()).unwrap();
    solver.update().unwrap();
    assert_eq!(key, lonely);
    assert!(distance(&before, &solver.estimates()) < 1e-9);
}

#[test]
fn marginalising_keeps_estimates_and_covariances_of_the_other_variables() {
    let (graph, values) = random_chain(30, 6);
    let mut solver = incremental(&graph, &values, 5);
    settle(&mut solver);
    let before = solver.estimates();
    let kept: Vec<Key> = [12, 20, 29].map(Key).to_vec();
    let certain = solver.covariance(&kept).unwrap();
    let gone: Vec<Key> = (0..10).map(Key).collect();
    let marginals = solver.marginalise(&gone).unwrap();
    assert!(!marginals.is_empty());
    assert!((solver.covariance(&kept).unwrap() - &certain).amax() < 1e-7 * certain.amax());
    assert!(solver.estimate(Key(3)).is_err() && solver.covariance(&[Key(3)]).is_err());
    assert!(solver.marginalise(&[Key(3)]).is_err());
    assert!(solver.add(Prior::new(Key(3), &Isometry::identity(), &Matrix6::identity()).unwrap()).is_err());
    // The marginals were computed at the solution, so relinearising everything else does not move it.
    settle(&mut solver);
    assert!(distance(&before, &solver.estimates()) < 1e-4);
    // The solver still accepts new variables.
    let key = solver.insert(*values.get(Key(29)).unwrap());
    solver.add(Between::new(Key(29), key, &Isometry::identity(), &Matrix6::identity()).unwrap()).unwrap();
    solver.update().unwrap();
}

#[test]
fn a_fixed_lag_keeps_memory_bounded() {
    let Some(published) = load("pose-graphs/parking-garage.g2o") else { return };
    let mut largest = 0;
    let mut solver = Incremental::new(IncrementalConfig::default());
    let odometry: Vec<usize> = (0..published.edges.len())
        .filter(|&edge| published.edges[edge].1.index() == published.edges[edge].0.index() + 1)
        .collect();
    let first = *published.values.get(Key(0)).unwrap();
    let Value::Pose(pose) = first else { unreachable!("poses only") };
    solver.insert(first);
    solver.add(Prior::new(Key(0), &pose, &Matrix6::identity()).unwrap()).unwrap();
    for (index, &edge) in odometry.iter().enumerate().take(600) {
        let key = published.edges[edge].1;
        let start = predict(&solver, &published, edge, key);
        assert_eq!(solver.insert(start), key);
        add_edge(&mut solver, &published, edge);
        solver.update().unwrap();
        if index >= 20 {
            solver.marginalise(&[Key(index as u32 - 20)]).unwrap();
            largest = largest.max(solver.memory());
        }
    }
    println!("{largest} bytes at most for a lag of 20 poses");
    assert!(largest < 200_000);
}

#[test]
fn the_same_steps_give_the_same_bits() {
    let (graph, values) = random_chain(40, 2);
    let run = || incremental(&graph, &values, 2).estimates();
    assert_eq!(run(), run());
}
