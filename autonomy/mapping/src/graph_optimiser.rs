//! Incremental optimisation of a pose graph while keyframes and loops are added and loops are removed (docs/maths/factors.md).

use crate::graph_element::{PoseGraphEdge, PoseGraphNode, renormalised};
use factors::{
    Between, FactorError, FactorId, Incremental, IncrementalConfig, IncrementalSnapshot, Key, Prior,
    SolveError, Value,
};
use geometry::{Isometry, Matrix6};
use std::collections::BTreeMap;
use std::fmt;
use vocab::KeyframeId;

/// Parameters of the optimiser of a pose graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OptimiserConfig {
    /// Information of the first keyframe's pose, 1/rad² and 1/m². It is the origin of the map. Chosen: a standard deviation of 0.1 mm and 0.1 mrad, far below that of any
    /// measurement.
    pub origin_information: f64,
    /// Least information of an odometry edge, 1/rad² and 1/m²: a standard deviation of a kilometre or radian. It keeps the graph connected where
    /// the filter knows nothing.
    pub min_odometry_information: f64,
    /// Greatest number of further updates while linearisation points still move. A loop over 3 m of drift takes two. Chosen: twice that, which bounds the time of a step.
    pub max_further_updates: usize,
    /// Thresholds of the solver. With 0.01 rad, errors of the order of the square of that angle times the distance to the next keyframe stay below
    /// a tenth of a millimetre. Source: docs/maths/factors.md; five times finer than the default, because the map is what is saved.
    pub solver: IncrementalConfig,
}

impl Default for OptimiserConfig {
    fn default() -> Self {
        Self {
            origin_information: 1e8,
            min_odometry_information: 1e-6,
            max_further_updates: 4,
            solver: IncrementalConfig {
                relinearise_angle_rad: 0.01,
                relinearise_length_m: 0.1,
                min_change: 1e-5,
                ..IncrementalConfig::default()
            },
        }
    }
}

/// The older and the newer keyframe of a loop.
pub type KeyframePair = (KeyframeId, KeyframeId);

/// Why a graph cannot be optimised.
#[derive(Clone, Debug, PartialEq)]
pub enum GraphError {
    /// A pose or edge is not a valid factor.
    Factor(FactorError),
    /// The equations cannot be solved.
    Solve(SolveError),
}

impl fmt::Display for GraphError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Factor(error) => error.fmt(f),
            Self::Solve(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for GraphError {}

impl From<FactorError> for GraphError {
    fn from(error: FactorError) -> Self {
        Self::Factor(error)
    }
}

impl From<SolveError> for GraphError {
    fn from(error: SolveError) -> Self {
        Self::Solve(error)
    }
}

/// An incremental solver whose variables have the numbers of the keyframes.
#[derive(Debug)]
pub(crate) struct GraphOptimiser {
    config: OptimiserConfig,
    solver: Incremental,
    keyframes: u32,
    loops: BTreeMap<KeyframePair, FactorId>,
}

impl GraphOptimiser {
    /// Without keyframes.
    pub fn new(config: OptimiserConfig) -> Self {
        let solver = Incremental::new(config.solver);
        Self { config, solver, keyframes: 0, loops: BTreeMap::new() }
    }

    /// With the keyframes of a finished map, its odometry edges and loops. Linear in the map but for the ordering.
    ///
    /// # Errors
    /// When a pose or edge is not finite, or the graph cannot be solved.
    pub fn resume(
        config: OptimiserConfig,
        nodes: &[PoseGraphNode],
        edges: &[PoseGraphEdge],
        loops: &[PoseGraphEdge],
    ) -> Result<Self, GraphError> {
        let mut optimiser = Self::new(config);
        for node in nodes {
            optimiser.solver.insert(Value::Pose(renormalised(&node.map_from_keyframe)));
        }
        if let Some(origin) = nodes.first() {
            let information = Matrix6::identity() * config.origin_information;
            optimiser.solver.add(Prior::new(Key(0), &origin.map_from_keyframe, &information)?)?;
        }
        for edge in edges {
            optimiser.add_odometry(edge)?;
        }
        for edge in loops {
            optimiser.add_loop(edge)?;
        }
        optimiser.solver.update()?;
        optimiser.keyframes = nodes.len() as u32;
        Ok(optimiser)
    }

    fn add_odometry(&mut self, edge: &PoseGraphEdge) -> Result<(), GraphError> {
        let information = edge.information + Matrix6::identity() * self.config.min_odometry_information;
        let factor = Between::new(key_of(edge.from), key_of(edge.to), &edge.from_from_to, &information)?;
        self.solver.add(factor)?;
        Ok(())
    }

    /// Adds the next keyframe with the odometry edge that leads to it; none leads to the first. No other keyframe moves.
    /// Cost: a few cliques of the tree, and a pass over the keyframes.
    ///
    /// # Errors
    /// When the pose or edge is not finite. Nothing can be added after that.
    pub fn add_keyframe(
        &mut self,
        node: &PoseGraphNode,
        edge: Option<&PoseGraphEdge>,
    ) -> Result<(), GraphError> {
        let key = Key(self.keyframes);
        match edge {
            Some(edge) => {
                let pose = renormalised(&(self.pose(key_of(edge.from))? * edge.from_from_to));
                self.solver.insert(Value::Pose(pose));
                self.add_odometry(edge)?;
            }
            None => {
                let origin = node.map_from_keyframe;
                let factor =
                    Prior::new(key, &origin, &(Matrix6::identity() * self.config.origin_information))?;
                self.solver.insert(Value::Pose(origin));
                self.solver.add(factor)?;
            }
        }
        self.solver.update()?;
        self.keyframes += 1;
        Ok(())
    }

    /// Adds a loop. [`Self::solve`] applies it.
    ///
    /// # Errors
    /// When a keyframe is unknown or the edge is not a valid factor. It is left out then.
    pub fn add_loop(&mut self, edge: &PoseGraphEdge) -> Result<(), GraphError> {
        let (from, to) = (key_of(edge.from), key_of(edge.to));
        let factor = self.solver.add(Between::new(from, to, &edge.from_from_to, &edge.information)?)?;
        self.loops.insert((edge.from, edge.to), factor);
        Ok(())
    }

    /// Removes a loop. [`Self::solve`] applies that. Returns whether there was one.
    pub fn remove_loop(&mut self, pair: KeyframePair) -> bool {
        self.loops.remove(&pair).is_some_and(|factor| self.solver.remove(factor).is_ok())
    }

    /// Solves for what was added and removed. Returns the poses of all keyframes in the map. Cost: that of the cliques between the changed
    /// keyframes and the root, that is of the loop, and a few microseconds for every keyframe.
    ///
    /// # Errors
    /// When the graph cannot be solved. The solution is then the one before.
    pub fn solve(&mut self) -> Result<Vec<Isometry>, GraphError> {
        self.solver.update()?;
        for _ in 0..self.config.max_further_updates {
            if self.solver.update()?.relinearised == 0 {
                break;
            }
        }
        self.poses()
    }

    /// A snapshot that solves for the poses of all keyframes once more. What was added or removed since [`Self::solve`] is left out.
    pub fn relinearisation(&self) -> Relinearisation {
        Relinearisation { snapshot: self.solver.snapshot(), keyframes: self.keyframes }
    }

    fn poses(&self) -> Result<Vec<Isometry>, GraphError> {
        (0..self.keyframes).map(|keyframe| self.pose(Key(keyframe))).collect()
    }

    fn pose(&self, key: Key) -> Result<Isometry, GraphError> {
        match self.solver.estimate(key)? {
            Value::Pose(pose) => Ok(pose),
            // This graph holds poses only.
            _ => Err(SolveError::UnknownVariable { key }.into()),
        }
    }
}

/// The graph of one moment, to be solved with every factor linearised again at the solution. It owns what it needs, so that a job can do it.
#[derive(Debug)]
pub struct Relinearisation {
    snapshot: IncrementalSnapshot,
    keyframes: u32,
}

impl Relinearisation {
    /// The poses of all keyframes in the map: a pure function of the snapshot. Linear in the graph but for the ordering.
    ///
    /// # Errors
    /// When the graph cannot be solved.
    pub fn run(self) -> Result<Vec<Isometry>, GraphError> {
        let values = self.snapshot.relinearise()?;
        let pose = |keyframe| Ok(*values.pose(Key(keyframe))?);
        (0..self.keyframes).map(pose).collect()
    }
}

fn key_of(keyframe: KeyframeId) -> Key {
    Key(keyframe.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use factors::{BatchConfig, FactorGraph, Values, optimise};
    use geometry::Vector3;
    use vocab::Stamp;

    fn at(x: f64, y: f64, yaw: f64) -> Isometry {
        Isometry::new(Vector3::new(x, y, 0.0), Vector3::z() * yaw)
    }

    fn edge(from: u32, to: u32, from_from_to: Isometry) -> PoseGraphEdge {
        let information = Matrix6::identity() * 1e4;
        PoseGraphEdge { from: KeyframeId(from), to: KeyframeId(to), from_from_to, information }
    }

    /// Twice round a circle of 40 steps, turning too far by 5 mrad each; loops close the second round onto the first.
    fn walked() -> (GraphOptimiser, Vec<PoseGraphEdge>, Vec<PoseGraphEdge>) {
        let step = at(1.0, 0.0, std::f64::consts::TAU / 40.0);
        let mut optimiser = GraphOptimiser::new(OptimiserConfig::default());
        let (mut edges, mut loops) = (Vec::new(), Vec::new());
        for index in 0..80 {
            let node = PoseGraphNode {
                id: KeyframeId(index),
                stamp: Stamp::EPOCH,
                map_from_keyframe: at(2.0, 1.0, 0.5),
            };
            let odometry = index.checked_sub(1).map(|last| edge(last, index, step * at(0.0, 0.0, 5e-3)));
            assert!(optimiser.add_keyframe(&node, odometry.as_ref()).is_ok());
            edges.extend(odometry);
            if index >= 40 && index % 5 == 0 {
                let closed = edge(index - 40, index, Isometry::identity());
                assert!(optimiser.add_loop(&closed).is_ok() && optimiser.solve().is_ok());
                loops.push(closed);
            }
        }
        (optimiser, edges, loops)
    }

    /// The same graph in one go.
    fn batch(edges: &[PoseGraphEdge], loops: &[PoseGraphEdge]) -> Vec<Isometry> {
        let (mut values, mut graph) = (Values::default(), FactorGraph::default());
        let mut pose = at(2.0, 1.0, 0.5);
        let first = values.insert(Value::Pose(pose));
        for edge in edges {
            pose *= edge.from_from_to;
            values.insert(Value::Pose(pose));
        }
        let Ok(prior) = Prior::new(
            first,
            &at(2.0, 1.0, 0.5),
            &(Matrix6::identity() * OptimiserConfig::default().origin_information),
        ) else {
            panic!("no prior")
        };
        assert!(graph.add(prior, &values).is_ok());
        for edge in edges.iter().chain(loops) {
            let (from, to) = (key_of(edge.from), key_of(edge.to));
            let Ok(factor) = Between::new(from, to, &edge.from_from_to, &edge.information) else {
                panic!("no factor")
            };
            assert!(graph.add(factor, &values).is_ok());
        }
        let Ok(solution) = optimise(&graph, &values, &BatchConfig::default()) else { panic!("not solved") };
        (0..=edges.len()).filter_map(|k| solution.values.pose(Key(k as u32)).ok().copied()).collect()
    }

    fn apart(a: &[Isometry], b: &[Isometry]) -> f64 {
        assert_eq!(a.len(), b.len());
        let gap = |(a, b): (&Isometry, &Isometry)| (a.translation.vector - b.translation.vector).norm();
        a.iter().zip(b).map(gap).fold(0.0, f64::max)
    }

    #[test]
    fn the_incremental_solution_equals_the_batch_solution() {
        let (mut optimiser, edges, loops) = walked();
        let Ok(found) = optimiser.solve() else { panic!("not solved") };
        let expected = batch(&edges, &loops);
        assert!(apart(&found, &batch(&edges, &[])) > 0.5, "the loops should matter");
        assert!(apart(&found, &expected) < 2e-3, "{} m", apart(&found, &expected));
        let Ok(relinearised) = optimiser.relinearisation().run() else { panic!("not solved") };
        assert!(apart(&relinearised, &expected) < 1e-5, "{} m", apart(&relinearised, &expected));
    }

    #[test]
    fn removed_loops_leave_no_trace() {
        let (mut optimiser, edges, loops) = walked();
        for closed in &loops {
            let pair = (closed.from, closed.to);
            assert!(optimiser.remove_loop(pair) && !optimiser.remove_loop(pair));
        }
        let Ok(found) = optimiser.solve() else { panic!("not solved") };
        let expected = batch(&edges, &[]);
        assert!(apart(&found, &expected) < 1e-4, "{} m", apart(&found, &expected));
    }

    #[test]
    fn a_finished_graph_is_resumed() {
        let (walked, edges, loops) = walked();
        let Ok(found) = walked.relinearisation().run() else { panic!("not solved") };
        let nodes = found.iter().zip(0..).map(|(pose, index)| PoseGraphNode {
            id: KeyframeId(index),
            stamp: Stamp::EPOCH,
            map_from_keyframe: *pose,
        });
        let nodes: Vec<PoseGraphNode> = nodes.collect();
        let Ok(mut resumed) = GraphOptimiser::resume(OptimiserConfig::default(), &nodes, &edges, &loops)
        else {
            panic!("not resumed")
        };
        let Ok(same) = resumed.solve() else { panic!("not solved") };
        assert!(apart(&same, &found) < 1e-5, "{} m", apart(&same, &found));
        // On from a keyframe in the middle, with a loop to the end.
        let odometry = edge(30, 80, at(0.0, 1.0, 0.3));
        let next = PoseGraphNode { id: KeyframeId(80), ..nodes[30] };
        assert!(resumed.add_keyframe(&next, Some(&odometry)).is_ok());
        assert!(resumed.remove_loop((KeyframeId(0), KeyframeId(40))));
        let Ok(poses) = resumed.solve() else { panic!("not solved") };
        let expected = poses[30] * at(0.0, 1.0, 0.3);
        assert_eq!(poses.len(), 81);
        assert!((poses[80].translation.vector - expected.translation.vector).norm() < 1e-6);
    }

    #[test]
    fn invalid_edges_are_refused_and_change_nothing() {
        let (mut optimiser, edges, loops) = walked();
        assert!(optimiser.add_loop(&edge(3, 4_000, Isometry::identity())).is_err());
        assert!(optimiser.add_loop(&edge(3, 30, at(f64::NAN, 0.0, 0.0))).is_err());
        let Ok(found) = optimiser.relinearisation().run() else { panic!("not solved") };
        assert!(apart(&found, &batch(&edges, &loops)) < 1e-5);
    }
}
