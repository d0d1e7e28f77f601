//! How well one keyframe's pose is known from another, over all edges of the graph.

use crate::UncertainPose;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

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
/// The pose of one keyframe in another is taken along the path whose edges have the least sum of variances (Dijkstra). Its covariance is an
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

    /// Dijkstra from the keyframe `from`, whose pose is `first`, until `last` is settled.
    fn search(&self, from: usize, first: UncertainPose, last: usize) -> Vec<Option<UncertainPose>> {
        let mut settled: Vec<Option<UncertainPose>> = vec![None; self.neighbours.len()];
        let mut queue = BinaryHeap::new();
        let mut least = vec![f64::INFINITY; self.neighbours.len()];
        if from < self.neighbours.len() {
            least[from] = 0.0;
            queue.push(QueueEntry { cost: 0.0, keyframe: from, via: None });
        }
        while let Some(QueueEntry { cost, keyframe, via }) = queue.pop() {
            if settled[keyframe].is_some() {
                continue;
            }
            settled[keyframe] = Some(match via {
                Some((parent, edge)) => {
                    let before: &Option<UncertainPose> = &settled[parent];
                    let before = before.unwrap_or_else(UncertainPose::identity);
                    before.compose(&self.neighbours[parent][edge].relative)
                }
                None => first,
            });
            if keyframe == last {
                break;
            }
            for (index, edge) in self.neighbours[keyframe].iter().enumerate() {
                let total = cost + edge.cost;
                if total < least[edge.to] {
                    least[edge.to] = total;
                    queue.push(QueueEntry { cost: total, keyframe: edge.to, via: Some((keyframe, index)) });
                }
            }
        }
        settled
    }

    /// Cost of an edge: the trace of its covariance, the rotation converted at the lever (equation 6), m².
    fn cost(&self, relative: &UncertainPose) -> f64 {
        let lever_m = self.config.rotation_lever_m;
        let variance = |index: usize| relative.covariance[(index, index)];
        let sum = (0..3).map(|i| variance(i) * lever_m * lever_m + variance(i + 3)).sum::<f64>();
        if sum.is_finite() { sum.max(1e-12) } else { f64::MAX }
    }
}

/// Least cost first out of a max-heap. Ties go to the older keyframe.
#[derive(PartialEq)]
struct QueueEntry {
    cost: f64,
    keyframe: usize,
    /// The keyframe that this one was reached from, and the index of the edge there.
    via: Option<(usize, usize)>,
}

impl Eq for QueueEntry {}

impl Ord for QueueEntry {
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then(other.keyframe.cmp(&self.keyframe))
    }
}

impl PartialOrd for QueueEntry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::odometry_chain::OdometryChain;
    use crate::testing::{near, step};

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
}
