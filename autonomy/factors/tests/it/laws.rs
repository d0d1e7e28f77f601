//! Laws that hold for every graph, on random graphs.

use crate::jacobians::{random_information, random_pose};
use factors::{
    BatchConfig, Between, FactorGraph, Incremental, IncrementalConfig, Key, Marginals, Prior, Value, Values,
    optimise,
};
use geometry::{Isometry, Matrix6, Rng, RngTree, Vector6, se3};
use proptest::prelude::*;

/// A measured relative pose: the two poses, the measurement and its information.
type Edge = (usize, usize, Isometry, Matrix6);

/// Poses that are joined by a chain of measurements and some loops.
#[derive(Clone, Debug)]
struct Network {
    truth: Vec<Isometry>,
    /// Start values, some centimetres and half a degree from the truth.
    start: Vec<Isometry>,
    edges: Vec<Edge>,
}

impl Network {
    fn new(poses: usize, loops: &[(usize, usize)], noise: f64, seed: u64) -> Self {
        let mut rng = RngTree::new(seed).child("network").rng();
        let truth: Vec<Isometry> = (0..poses).map(|_| random_pose(&mut rng, 0.6)).collect();
        let start = truth.iter().map(|pose| moved(pose, 0.01, &mut rng)).collect();
        let loops = loops.iter().map(|(a, b)| (a % poses, b % poses)).filter(|(a, b)| a != b);
        let pairs = (1..poses).map(|index| (index - 1, index)).chain(loops);
        let edges = pairs
            .map(|(a, b)| {
                let measured = moved(&(truth[a].inverse() * truth[b]), noise, &mut rng);
                (a, b, measured, random_information(&mut rng))
            })
            .collect();
        Self { truth, start, edges }
    }

    fn values(&self) -> Values {
        let mut values = Values::default();
        for pose in &self.start {
            values.insert(Value::Pose(*pose));
        }
        values
    }

    /// Its first pose is fixed at the truth.
    fn graph<'a>(&self, edges: impl IntoIterator<Item = &'a Edge>) -> FactorGraph {
        let (mut graph, values) = (FactorGraph::default(), self.values());
        graph.add(Prior::new(Key(0), &self.truth[0], &Matrix6::identity()).unwrap(), &values).unwrap();
        for edge in edges {
            graph.add(between(edge), &values).unwrap();
        }
        graph
    }
}

fn between((a, b, measured, information): &Edge) -> Between {
    Between::new(Key(*a as u32), Key(*b as u32), measured, information).unwrap()
}

fn moved(pose: &Isometry, deviation: f64, rng: &mut Rng) -> Isometry {
    se3::retract(pose, &Vector6::from_fn(|_, _| rng.normal() * deviation))
}

fn networks(noise: f64) -> impl Strategy<Value = Network> {
    (2..25_usize, prop::collection::vec((0..25_usize, 0..25_usize), 0..12), any::<u64>())
        .prop_map(move |(poses, loops, seed)| Network::new(poses, &loops, noise, seed))
}

fn precise() -> BatchConfig {
    BatchConfig { min_relative_decrease: 1e-13, ..BatchConfig::default() }
}

fn distance(a: &Values, b: &Values) -> f64 {
    a.iter().zip(b.iter()).map(|((_, a), (_, b))| a.local(b).norm()).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn a_graph_without_noise_is_solved_to_the_truth(network in networks(0.0)) {
        let solution = optimise(&network.graph(&network.edges), &network.values(), &precise()).unwrap();
        let truth = Network { start: network.truth.clone(), ..network.clone() }.values();
        prop_assert!(distance(&solution.values, &truth) < 1e-6);
    }

    #[test]
    fn optimising_never_raises_the_cost(network in networks(0.02)) {
        let (graph, start) = (network.graph(&network.edges), network.values());
        let solution = optimise(&graph, &start, &BatchConfig::default()).unwrap();
        let (before, after) = (graph.chi_squared(&start).unwrap(), graph.chi_squared(&solution.values).unwrap());
        prop_assert!(after <= before * (1.0 + 1e-12), "{after} after {before}");
    }

    #[test]
    fn the_order_of_the_factors_changes_nothing(network in networks(0.01)) {
        let start = network.values();
        let there = optimise(&network.graph(&network.edges), &start, &precise()).unwrap();
        let back = optimise(&network.graph(network.edges.iter().rev()), &start, &precise()).unwrap();
        prop_assert!(distance(&there.values, &back.values) < 1e-5);
    }

    #[test]
    fn relative_measurements_do_not_see_a_motion_of_all_poses(network in networks(0.02), seed in any::<u64>()) {
        let motion = random_pose(&mut RngTree::new(seed).child("motion").rng(), 1.0);
        let (mut graph, values) = (FactorGraph::default(), network.values());
        for edge in &network.edges {
            graph.add(between(edge), &values).unwrap();
        }
        let start = network.start.iter().map(|pose| motion * pose).collect();
        let carried = Network { start, ..network.clone() }.values();
        let (here, there) = (graph.chi_squared(&values).unwrap(), graph.chi_squared(&carried).unwrap());
        prop_assert!((here - there).abs() <= 1e-8 * (1.0 + here), "{here} and {there}");
    }

    #[test]
    fn a_further_measurement_never_raises_an_uncertainty(network in networks(0.01)) {
        let (last, values) = (Key(network.truth.len() as u32 - 1), network.values());
        let covariance = |edges: usize| {
            let graph = network.graph(&network.edges[..edges]);
            Marginals::new(&graph, &values).unwrap().covariance(&[last]).unwrap()
        };
        let (chain, all) = (covariance(network.truth.len() - 1), covariance(network.edges.len()));
        prop_assert!((&all - all.transpose()).amax() <= 1e-12 * all.amax());
        let least = (&chain - &all).symmetric_eigenvalues().min();
        prop_assert!(least >= -1e-9 * chain.amax(), "{least}");
        prop_assert!(all.symmetric_eigenvalues().min() > 0.0);
    }

    #[test]
    fn the_incremental_solution_equals_the_batch_solution(network in networks(0.01)) {
        let mut solver = Incremental::new(IncrementalConfig::default());
        for (newest, pose) in network.start.iter().enumerate() {
            let key = solver.insert(Value::Pose(*pose));
            if newest == 0 {
                solver.add(Prior::new(key, &network.truth[0], &Matrix6::identity()).unwrap()).unwrap();
            }
            for edge in network.edges.iter().filter(|(a, b, ..)| *a.max(b) == newest) {
                solver.add(between(edge)).unwrap();
            }
            solver.update().unwrap();
        }
        for _ in 0..8 {
            solver.relinearise_all().unwrap();
        }
        let batch = optimise(solver.graph(), &network.values(), &precise()).unwrap();
        prop_assert!(distance(&solver.estimates(), &batch.values) < 1e-5);
    }
}
