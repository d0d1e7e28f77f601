//! The pose graph of a session, kept up to date while keyframes and loops come and loops go.

use factors::{
    Between, FactorError, FactorId, Incremental, IncrementalOptions, Key, Prior, SolveError, Value,
};
use geometry::{Isometry, Matrix6};
use mapping::{Edge, Node, unit};
use std::collections::BTreeMap;
use std::fmt;
use vocab::KeyframeId;

/// Information of the first keyframe's pose: it is the map's origin.
const ORIGIN: f64 = 1e8;
/// Least information of an odometry edge: a kilometre or radian. Keeps the walk in one piece where the filter knows nothing.
const LEAST: f64 = 1e-6;
/// A solution that still moves its linearisation points is taken further so often at most. A loop over 3 m of drift takes two.
const FURTHER: usize = 4;
/// Linearised anew from this on: errors of the order of its square times the distance to the next keyframe stay below a
/// tenth of a millimetre.
const OPTIONS: IncrementalOptions = IncrementalOptions {
    relinearise_angle: 0.01,
    relinearise_length: 0.1,
    change_min: 1e-5,
    afresh_share: 0.7,
};

/// Older and newer keyframe of a loop.
pub(crate) type Pair = (KeyframeId, KeyframeId);

/// Why the graph cannot be kept up to date.
#[derive(Debug)]
pub(crate) enum GraphError {
    Factor(FactorError),
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

/// An incremental solver over the keyframes of one session, whose numbers are the variables' too.
#[derive(Debug)]
pub(crate) struct Optimiser {
    solver: Incremental,
    keyframes: u32,
    loops: BTreeMap<Pair, FactorId>,
}

impl Default for Optimiser {
    fn default() -> Self {
        Self { solver: Incremental::new(OPTIONS), keyframes: 0, loops: BTreeMap::new() }
    }
}

impl Optimiser {
    /// Over the keyframes of a finished map, with the ways that were walked and the loops. Linear in the map but for the ordering.
    ///
    /// # Errors
    /// When a pose or edge is no number, or the graph cannot be solved.
    pub fn resume(nodes: &[Node], edges: &[Edge], loops: &[Edge]) -> Result<Self, GraphError> {
        let mut optimiser = Self::default();
        for node in nodes {
            optimiser.solver.insert(Value::Pose(unit(&node.map_from_keyframe)));
        }
        if let Some(origin) = nodes.first() {
            let information = Matrix6::identity() * ORIGIN;
            optimiser.solver.add(Prior::new(Key(0), &origin.map_from_keyframe, &information)?)?;
        }
        for edge in edges {
            optimiser.add_way(edge)?;
        }
        for edge in loops {
            optimiser.add_loop(edge)?;
        }
        optimiser.solver.update()?;
        optimiser.keyframes = nodes.len() as u32;
        Ok(optimiser)
    }

    fn add_way(&mut self, edge: &Edge) -> Result<(), GraphError> {
        let held = edge.information + Matrix6::identity() * LEAST;
        let factor = Between::new(key_of(edge.from), key_of(edge.to), &edge.from_from_to, &held)?;
        self.solver.add(factor)?;
        Ok(())
    }

    /// Adds the next keyframe, that the odometry's `edge` leads to from the last one; none leads to the first. Moves no other.
    /// Cost: a few cliques of the tree, and a look at every keyframe.
    ///
    /// # Errors
    /// When the pose or edge is no number. Nothing can be added after that.
    pub fn add_keyframe(&mut self, node: &Node, edge: Option<&Edge>) -> Result<(), GraphError> {
        let key = Key(self.keyframes);
        match edge {
            Some(edge) => {
                let pose = unit(&(self.pose(key_of(edge.from))? * edge.from_from_to));
                self.solver.insert(Value::Pose(pose));
                self.add_way(edge)?;
            }
            None => {
                let origin = node.map_from_keyframe;
                let factor = Prior::new(key, &origin, &(Matrix6::identity() * ORIGIN))?;
                self.solver.insert(Value::Pose(origin));
                self.solver.add(factor)?;
            }
        }
        self.solver.update()?;
        self.keyframes += 1;
        Ok(())
    }

    /// Whether the pair is connected by a loop.
    pub fn has(&self, pair: Pair) -> bool {
        self.loops.contains_key(&pair)
    }

    /// Adds a loop; [`Self::solve`] makes it count.
    ///
    /// # Errors
    /// When a keyframe is unknown or the edge is no measurement; it is left out then.
    pub fn add_loop(&mut self, edge: &Edge) -> Result<(), GraphError> {
        let (from, to) = (key_of(edge.from), key_of(edge.to));
        let factor = self.solver.add(Between::new(from, to, &edge.from_from_to, &edge.information)?)?;
        self.loops.insert((edge.from, edge.to), factor);
        Ok(())
    }

    /// Takes a loop out; [`Self::solve`] makes that count. Says whether it was there.
    pub fn remove_loop(&mut self, pair: Pair) -> bool {
        self.loops.remove(&pair).is_some_and(|factor| self.solver.remove(factor).is_ok())
    }

    /// Solves for what was added and removed; returns the poses of all keyframes in the map. Cost: that of the cliques between
    /// the changed keyframes and the root, so of the loop, and a few microseconds for every keyframe.
    ///
    /// # Errors
    /// When the graph cannot be solved; its solution is then that of before.
    pub fn solve(&mut self) -> Result<Vec<Isometry>, GraphError> {
        self.solver.update()?;
        for _ in 0..FURTHER {
            if self.solver.update()?.relinearised == 0 {
                break;
            }
        }
        self.poses()
    }

    /// Solves with every factor linearised at the solution. Linear in the graph.
    ///
    /// # Errors
    /// As for [`Self::solve`].
    pub fn settle(&mut self) -> Result<Vec<Isometry>, GraphError> {
        self.solver.relinearise_all()?;
        self.poses()
    }

    fn poses(&self) -> Result<Vec<Isometry>, GraphError> {
        (0..self.keyframes).map(|keyframe| self.pose(Key(keyframe))).collect()
    }

    fn pose(&self, key: Key) -> Result<Isometry, GraphError> {
        match self.solver.estimate(key)? {
            Value::Pose(pose) => Ok(pose),
            // This graph has no other kind.
            _ => Err(SolveError::UnknownVariable { key }.into()),
        }
    }
}

fn key_of(keyframe: KeyframeId) -> Key {
    Key(keyframe.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use factors::{Graph, Options, Values, optimise};
    use geometry::Vector3;
    use vocab::Stamp;

    fn at(x: f64, y: f64, yaw: f64) -> Isometry {
        Isometry::new(Vector3::new(x, y, 0.0), Vector3::z() * yaw)
    }

    fn edge(from: u32, to: u32, from_from_to: Isometry) -> Edge {
        let information = Matrix6::identity() * 1e4;
        Edge { from: KeyframeId(from), to: KeyframeId(to), from_from_to, information }
    }

    /// Twice round a circle of 40 steps, turning too far by 5 mrad each; loops close the second round onto the first.
    fn walked() -> (Optimiser, Vec<Edge>, Vec<Edge>) {
        let step = at(1.0, 0.0, std::f64::consts::TAU / 40.0);
        let mut optimiser = Optimiser::default();
        let (mut edges, mut loops) = (Vec::new(), Vec::new());
        for index in 0..80 {
            let node =
                Node { id: KeyframeId(index), stamp: Stamp::EPOCH, map_from_keyframe: at(2.0, 1.0, 0.5) };
            let way = index.checked_sub(1).map(|last| edge(last, index, step * at(0.0, 0.0, 5e-3)));
            assert!(optimiser.add_keyframe(&node, way.as_ref()).is_ok());
            edges.extend(way);
            if index >= 40 && index % 5 == 0 {
                let closed = edge(index - 40, index, Isometry::identity());
                assert!(optimiser.add_loop(&closed).is_ok() && optimiser.solve().is_ok());
                loops.push(closed);
            }
        }
        (optimiser, edges, loops)
    }

    /// The same graph in one go.
    fn batch(edges: &[Edge], loops: &[Edge]) -> Vec<Isometry> {
        let (mut values, mut graph) = (Values::default(), Graph::default());
        let mut pose = at(2.0, 1.0, 0.5);
        let first = values.insert(Value::Pose(pose));
        for edge in edges {
            pose *= edge.from_from_to;
            values.insert(Value::Pose(pose));
        }
        let Ok(prior) = Prior::new(first, &at(2.0, 1.0, 0.5), &(Matrix6::identity() * ORIGIN)) else {
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
        let Ok(solution) = optimise(&graph, &values, &Options::default()) else { panic!("not solved") };
        (0..=edges.len()).filter_map(|k| solution.values.pose(Key(k as u32)).ok().copied()).collect()
    }

    fn apart(a: &[Isometry], b: &[Isometry]) -> f64 {
        assert_eq!(a.len(), b.len());
        let gap = |(a, b): (&Isometry, &Isometry)| (a.translation.vector - b.translation.vector).norm();
        a.iter().zip(b).map(gap).fold(0.0, f64::max)
    }

    #[test]
    fn keyframe_by_keyframe_comes_to_the_same_as_all_at_once() {
        let (mut optimiser, edges, loops) = walked();
        let Ok(found) = optimiser.solve() else { panic!("not solved") };
        let expected = batch(&edges, &loops);
        assert!(apart(&found, &batch(&edges, &[])) > 0.5, "the loops should matter");
        assert!(apart(&found, &expected) < 2e-3, "{} m", apart(&found, &expected));
        let Ok(settled) = optimiser.settle() else { panic!("not solved") };
        assert!(apart(&settled, &expected) < 1e-5, "{} m", apart(&settled, &expected));
    }

    #[test]
    fn loops_taken_out_leave_no_trace() {
        let (mut optimiser, edges, loops) = walked();
        for closed in &loops {
            let pair = (closed.from, closed.to);
            assert!(optimiser.has(pair) && optimiser.remove_loop(pair) && !optimiser.remove_loop(pair));
        }
        let Ok(found) = optimiser.solve() else { panic!("not solved") };
        let expected = batch(&edges, &[]);
        assert!(apart(&found, &expected) < 1e-4, "{} m", apart(&found, &expected));
    }

    #[test]
    fn a_finished_graph_goes_on_where_it_was() {
        let (mut walked, edges, loops) = walked();
        let Ok(found) = walked.settle() else { panic!("not solved") };
        let nodes = found.iter().zip(0..).map(|(pose, index)| Node {
            id: KeyframeId(index),
            stamp: Stamp::EPOCH,
            map_from_keyframe: *pose,
        });
        let nodes: Vec<Node> = nodes.collect();
        let Ok(mut resumed) = Optimiser::resume(&nodes, &edges, &loops) else { panic!("not resumed") };
        let Ok(same) = resumed.solve() else { panic!("not solved") };
        assert!(apart(&same, &found) < 1e-5, "{} m", apart(&same, &found));
        // On from a keyframe in the middle, with a loop to the end.
        let way = edge(30, 80, at(0.0, 1.0, 0.3));
        let next = Node { id: KeyframeId(80), ..nodes[30] };
        assert!(
            resumed.add_keyframe(&next, Some(&way)).is_ok() && resumed.has((KeyframeId(0), KeyframeId(40)))
        );
        assert!(resumed.remove_loop((KeyframeId(0), KeyframeId(40))));
        let Ok(poses) = resumed.solve() else { panic!("not solved") };
        let expected = poses[30] * at(0.0, 1.0, 0.3);
        assert_eq!(poses.len(), 81);
        assert!((poses[80].translation.vector - expected.translation.vector).norm() < 1e-6);
    }

    #[test]
    fn garbage_is_refused_and_changes_nothing() {
        let (mut optimiser, edges, loops) = walked();
        assert!(optimiser.add_loop(&edge(3, 4_000, Isometry::identity())).is_err());
        assert!(optimiser.add_loop(&edge(3, 30, at(f64::NAN, 0.0, 0.0))).is_err());
        let Ok(found) = optimiser.settle() else { panic!("not solved") };
        assert!(apart(&found, &batch(&edges, &loops)) < 1e-5);
    }
}
