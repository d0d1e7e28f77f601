//! Covariance of the pose of one keyframe in another, over all edges of the graph.

use crate::UncertainPose;
use ordered_float::OrderedFloat;
use pathfinding::directed::dijkstra::{DijkstraReachableItem, dijkstra_reach};
use pathfinding::num_traits::Zero;
use std::ops::Add;

/// Parameters of [`CovarianceGraph`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CovarianceGraphConfig {
    /// Lever at which a rotation variance is converted to a translation variance where one number stands for a covariance, metres. Half of
    /// the range that an XT-32 overlooks indoors.
    pub rotation_lever_m: f64,
}

impl Default for CovarianceGraphConfig {
    fn default() -> Self {
        Self { rotation_lever_m: 10.0 }
    }
}

/// All edges between keyframes, of odometry and loops, with their covariances.
///
/// The pose of one keyframe in another is taken along the path whose edges have the least sum of variances (`dijkstra_reach` of the crate
/// `pathfinding`). Of equally uncertain paths, that over the older keyframe is taken. Its covariance is an
/// upper bound, because other paths can only add information. This needs no solver, and a wrong solution of the solver cannot spoil it.
///
/// Source of the idea: Olson, *Recognizing places using spectrally clustered local matches*, RAS 2009.
#[derive(Clone, Debug, Default)]
pub struct CovarianceGraph {
    config: CovarianceGraphConfig,
    /// For each keyframe: the edges to its neighbours.
    neighbours: Vec<Vec<Neighbour>>,
}

#[derive(Clone, Debug)]
struct Neighbour {
    to: usize,
    /// Pose of the neighbour in this keyframe.
    relative: UncertainPose,
    cost: f64,
    kind: EdgeKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EdgeKind {
    Odometry,
    Loop,
}

impl CovarianceGraph {
    /// Adds a loop. Keyframes with these numbers exist from then on.
    pub fn add_loop(&mut self, from: usize, to: usize, relative: &UncertainPose) {
        self.add(from, to, relative, EdgeKind::Loop);
    }

    /// Adds an odometry edge, which is never removed. Keyframes with these numbers exist from then on.
    pub fn add_odometry(&mut self, from: usize, to: usize, relative: &UncertainPose) {
        self.add(from, to, relative, EdgeKind::Odometry);
    }

    fn add(&mut self, from: usize, to: usize, relative: &UncertainPose, kind: EdgeKind) {
        let needed = from.max(to) + 1;
        if self.neighbours.len() < needed {
            self.neighbours.resize_with(needed, Vec::new);
        }
        let (back, cost) = (relative.inverse(), self.cost(relative));
        self.neighbours[from].push(Neighbour { to, relative: *relative, cost, kind });
        self.neighbours[to].push(Neighbour { to: from, relative: back, cost, kind });
    }

    /// Removes the last loop between two keyframes. Returns whether there was one.
    pub fn remove_loop(&mut self, from: usize, to: usize) -> bool {
        let mut cut = |a: usize, b: usize| {
            let neighbours = self.neighbours.get_mut(a)?;
            let index = neighbours.iter().rposition(|edge| edge.to == b && edge.kind == EdgeKind::Loop)?;
            Some(neighbours.remove(index))
        };
        cut(from, to).is_some() & cut(to, from).is_some()
    }

    /// Pose of every keyframe in `from`; `None` where no path leads. `O((n + e) log n)`.
    pub fn poses_in(&self, from: usize) -> Vec<Option<UncertainPose>> {
        self.search(from, UncertainPose::identity(), usize::MAX)
    }

    /// As [`Self::poses_in`], in a frame whose pose in the keyframe `from` is `from_from_frame`.
    pub fn poses_in_frame(&self, from: usize, from_from_frame: &UncertainPose) -> Vec<Option<UncertainPose>> {
        self.search(from, from_from_frame.inverse(), usize::MAX)
    }

    /// Pose of `to` in `from`, as [`Self::poses_in`] has it. The search stops once it is found.
    pub fn relative_pose(&self, from: usize, to: usize) -> Option<UncertainPose> {
        self.search(from, UncertainPose::identity(), to).get(to).copied().flatten()
    }

    /// Dijkstra from the keyframe `from`, whose pose is `first`, until `last` is reached.
    fn search(&self, from: usize, first: UncertainPose, last: usize) -> Vec<Option<UncertainPose>> {
        let mut poses: Vec<Option<UncertainPose>> = vec![None; self.neighbours.len()];
        let mut costs = vec![f64::INFINITY; self.neighbours.len()];
        if from >= self.neighbours.len() {
            return poses;
        }
        let steps = |keyframe: &usize| {
            let step = |edge: &Neighbour| (edge.to, PathCost { cost: edge.cost.into(), keyframe: edge.to });
            self.neighbours[*keyframe].iter().map(step)
        };
        for DijkstraReachableItem { node, parent, total_cost } in dijkstra_reach(&from, steps) {
            let cost = total_cost.cost.into_inner();
            // Two consecutive edges without information: no pose is known beyond them.
            if cost == f64::INFINITY {
                break;
            }
            costs[node] = cost;
            poses[node] = match parent {
                None => Some(first),
                Some(parent) => {
                    // Of several edges between the two, the first that makes the path as short as it is.
                    let is_step = |edge: &&Neighbour| edge.to == node && costs[parent] + edge.cost == cost;
                    let edge = self.neighbours[parent].iter().find(is_step);
                    poses[parent].zip(edge).map(|(before, edge)| before.compose(&edge.relative))
                }
            };
            if node == last {
                break;
            }
        }
        poses
    }

    /// Cost of an edge: the trace of its covariance, the rotation converted at the lever (equation 6), m².
    fn cost(&self, relative: &UncertainPose) -> f64 {
        let lever_m = self.config.rotation_lever_m;
        let variance = |index: usize| relative.covariance[(index, index)];
        let sum = (0..3).map(|i| variance(i) * lever_m * lever_m + variance(i + 3)).sum::<f64>();
        if sum.is_finite() { sum.max(1e-12) } else { f64::MAX }
    }
}

/// Cost of a path to a keyframe. Of equal costs that to the older keyframe is the less, so that ties are settled in the order of the walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct PathCost {
    /// Sum of the costs of the edges, m².
    cost: OrderedFloat<f64>,
    /// The keyframe at the end of the path.
    keyframe: usize,
}

impl Add for PathCost {
    type Output = Self;

    /// The path longer by a step.
    fn add(self, step: Self) -> Self {
        Self { cost: self.cost + step.cost, keyframe: step.keyframe }
    }
}

impl Zero for PathCost {
    fn zero() -> Self {
        Self { cost: OrderedFloat(0.0), keyframe: 0 }
    }

    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::odometry_chain::OdometryChain;
    use crate::testing::{near, step};
    use geometry::{Isometry, Matrix6, RngTree, Vector6};

    #[test]
    fn a_loop_lowers_the_uncertainty_of_old_keyframes() {
        let (mut graph, mut chain) = (CovarianceGraph::default(), OdometryChain::default());
        for index in 0..100 {
            // A circle of 100 steps.
            let step = step(std::f64::consts::TAU / 100.0, 0.02);
            graph.add_odometry(index, index + 1, &step);
            chain.push(&step);
        }
        let before = graph.poses_in(100);
        let Some(open) = before[0] else { panic!("not reached") };
        assert!(chain.relative_pose(100, 0).is_some_and(|walked| near(&walked, &open)), "odometry alone");
        // 0.2 m of steps and 20 mrad over the circle's lever of 16 m.
        assert!((0.3..0.6).contains(&open.translation_std_m()), "{}", open.translation_std_m());
        graph.add_loop(2, 100, &UncertainPose { pose: step(0.0, 0.0).pose, ..step(0.0, 0.01) });
        let Some(closed) = graph.poses_in(100)[0] else { panic!("not reached") };
        assert_eq!((graph.relative_pose(100, 0), graph.relative_pose(100, 4_000)), (Some(closed), None));
        let ahead = step(0.2, 0.01);
        let seen = graph.poses_in_frame(100, &ahead)[0];
        assert!(seen.is_some_and(|seen| near(&seen, &ahead.inverse().compose(&closed))));
        assert!(closed.translation_std_m() < 0.04, "{}", closed.translation_std_m());
        assert!(graph.remove_loop(2, 100) && !graph.remove_loop(2, 100) && !graph.remove_loop(7, 4_000));
        assert!(!graph.remove_loop(2, 3), "odometry stays");
        assert_eq!(graph.poses_in(100), before);
        assert!(graph.poses_in(1000).iter().all(Option::is_none));
    }

    #[test]
    fn every_pose_is_taken_along_a_path_of_least_cost() {
        for seed in 0..20 {
            let mut rng = RngTree::new(seed).child("graph").rng();
            let mut graph = CovarianceGraph::default();
            let mut edges = Vec::new();
            for _ in 0..40 {
                let [from, to] = [(); 2].map(|()| (rng.uniform() * 20.0) as usize);
                // Few different variances, so that many paths are equally uncertain.
                let variance = 1e-4 * (1.0 + (rng.uniform() * 4.0).floor());
                let variances = Vector6::new(0.0, 0.0, 0.0, variance, variance, variance);
                let covariance = Matrix6::from_diagonal(&variances);
                let pose = Isometry::translation(1.0, 0.0, 0.0);
                graph.add_loop(from, to, &UncertainPose { pose, covariance });
                edges.push((from, to, 3.0 * variance));
            }
            // Bellman and Ford: every edge shortens what it can, as often as there are keyframes.
            let mut least = [f64::INFINITY; 20];
            least[0] = 0.0;
            for _ in 0..20 {
                for &(from, to, cost) in &edges {
                    least[to] = least[to].min(least[from] + cost);
                    least[from] = least[from].min(least[to] + cost);
                }
            }
            for (pose, least) in graph.poses_in(0).iter().zip(least) {
                // Without rotation variances, the translation's variances of a path add up to its cost.
                let trace =
                    pose.map_or(f64::INFINITY, |pose| pose.covariance.fixed_view::<3, 3>(3, 3).trace());
                assert!(trace == least || (trace - least).abs() < 1e-12, "seed {seed}: {trace} {least}");
            }
        }
    }

    #[test]
    fn of_equally_uncertain_paths_that_over_the_older_keyframe_is_taken_and_of_equal_edges_the_first() {
        let mut graph = CovarianceGraph::default();
        // From 0 to 3 over 1 and over 2. The path over 2 is added first.
        let [over_1, over_2] = [step(0.1, 0.02), step(0.2, 0.02)];
        for (from, to, edge) in [(0, 2, over_2), (2, 3, over_2), (0, 1, over_1), (1, 3, over_1)] {
            graph.add_odometry(from, to, &edge);
        }
        assert_eq!(graph.relative_pose(0, 3), Some(over_1.compose(&over_1)));
        // A second edge that is as uncertain changes nothing; one that is less uncertain does.
        graph.add_loop(0, 1, &step(0.3, 0.02));
        assert_eq!(graph.relative_pose(0, 3), Some(over_1.compose(&over_1)));
        let better = step(0.3, 0.01);
        graph.add_loop(0, 1, &better);
        assert_eq!(graph.relative_pose(0, 3), Some(better.compose(&over_1)));
    }

    #[test]
    fn nothing_is_known_beyond_two_edges_without_a_finite_covariance() {
        let mut graph = CovarianceGraph::default();
        let unknown = UncertainPose { covariance: Matrix6::repeat(f64::INFINITY), ..step(0.0, 0.02) };
        graph.add_odometry(0, 1, &unknown);
        graph.add_odometry(1, 2, &step(0.0, 0.02));
        graph.add_odometry(2, 3, &unknown);
        let reached: Vec<bool> = graph.poses_in(0).iter().map(Option::is_some).collect();
        assert_eq!(reached, [true, true, true, false]);
    }
}
