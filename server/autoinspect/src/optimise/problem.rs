//! Converts a g2o file to a factor graph, and back.

use crate::texts;
use factors::{
    Between, FactorError, FactorGraph, FactorId, Key, Planar, PlanarBetween, PlanarPrior, Prior, SolveError,
    Value, Values,
};
use formats::g2o;
use geometry::{Isometry, Matrix3, Matrix6, isometry_from_pose, pose_from_isometry};
use nalgebra::Vector2;
use std::collections::BTreeMap;
use std::fmt::Display;

/// Fixed parameters of a [`GraphProblem`].
#[derive(Clone, Copy, Debug)]
struct ProblemConfig {
    /// Information of the prior that holds a fixed pose, 1/m² and 1/rad²: 1 µm and 1 µrad, far less than any measurement's deviation. Chosen: larger values make the
    /// equations badly conditioned.
    fixed_pose_information: f64,
}

const CONFIG: ProblemConfig = ProblemConfig { fixed_pose_information: 1e12 };

/// A graph to optimise. Factors come in the file's order of edges (SE(3) first), then the priors.
pub struct GraphProblem {
    /// The factors.
    pub graph: FactorGraph,
    /// The file's poses, or the origin for all.
    pub values: Values,
    /// Whether the file had vertices.
    pub has_start: bool,
    /// The file's number of each variable, ascending.
    pub ids: Vec<u64>,
    file: g2o::G2oGraph,
}

impl GraphProblem {
    /// Checks the file and makes the factors. The error is a sentence.
    pub fn new(file: g2o::G2oGraph) -> Result<Self, String> {
        let has_start = !(file.vertices.is_empty() && file.planar_vertices.is_empty());
        let mut poses: BTreeMap<u64, Value> = BTreeMap::new();
        for vertex in &file.vertices {
            let pose = isometry_from_pose(&vertex.pose).ok_or_else(|| texts::vertex_no_pose(vertex.id))?;
            insert(&mut poses, vertex.id, Value::Pose(pose))?;
        }
        for vertex in &file.planar_vertices {
            insert(&mut poses, vertex.id, Value::Planar(planar(vertex.pose)))?;
        }
        if !has_start {
            for edge in &file.edges {
                poses.extend([edge.from, edge.to].map(|id| (id, Value::Pose(Isometry::identity()))));
            }
            for edge in &file.planar_edges {
                poses.extend([edge.from, edge.to].map(|id| (id, Value::Planar(Planar::identity()))));
            }
        }
        if poses.is_empty() {
            return Err(texts::GRAPH_EMPTY.to_owned());
        }
        let mut values = Values::default();
        let mut keys: BTreeMap<u64, Key> = BTreeMap::new();
        for (&id, &value) in &poses {
            keys.insert(id, values.insert(value));
        }
        let mut problem =
            Self { graph: FactorGraph::default(), values, has_start, ids: poses.into_keys().collect(), file };
        problem.add_edges(&keys)?;
        problem.hold(&keys)?;
        Ok(problem)
    }

    fn add_edges(&mut self, keys: &BTreeMap<u64, Key>) -> Result<(), String> {
        let key = |id: u64| keys.get(&id).copied().ok_or_else(|| texts::vertex_missing(id));
        for edge in &self.file.edges {
            let (from, to) = (key(edge.from)?, key(edge.to)?);
            let refused = refused(edge.from, edge.to);
            let measured =
                isometry_from_pose(&edge.from_from_to).ok_or_else(|| refused(&texts::EDGE_NO_POSE))?;
            let information = Matrix6::from_fn(|row, column| edge.information[row][column]);
            let factor = Between::new(from, to, &measured, &information).map_err(|error| refused(&error))?;
            self.graph.add(factor, &self.values).map_err(|error| refused(&error))?;
        }
        for edge in &self.file.planar_edges {
            let (from, to) = (key(edge.from)?, key(edge.to)?);
            let refused = refused(edge.from, edge.to);
            let information = Matrix3::from_fn(|row, column| edge.information[row][column]);
            let factor = PlanarBetween::new(from, to, &planar(edge.from_from_to), &information)
                .map_err(|error| refused(&error))?;
            self.graph.add(factor, &self.values).map_err(|error| refused(&error))?;
        }
        Ok(())
    }

    /// Adds priors on the fixed poses, or on the first one.
    fn hold(&mut self, keys: &BTreeMap<u64, Key>) -> Result<(), String> {
        let mut held: Vec<Key> = self.file.fixed.iter().filter_map(|id| keys.get(id).copied()).collect();
        held.sort_unstable();
        held.dedup();
        if held.is_empty() {
            held.push(Key(0));
        }
        for key in held {
            self.prior(key).map_err(|error| texts::vertex_refused(self.ids[key.index()], &error))?;
        }
        Ok(())
    }

    fn prior(&mut self, key: Key) -> Result<(), FactorError> {
        match self.values.get(key).copied() {
            Some(Value::Pose(pose)) => {
                self.graph.add(
                    Prior::new(key, &pose, &(Matrix6::identity() * CONFIG.fixed_pose_information))?,
                    &self.values,
                )?;
            }
            Some(Value::Planar(pose)) => {
                self.graph.add(
                    PlanarPrior::new(key, &pose, &(Matrix3::identity() * CONFIG.fixed_pose_information))?,
                    &self.values,
                )?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Number of edges in the file.
    pub fn edges(&self) -> usize {
        self.file.edges.len() + self.file.planar_edges.len()
    }

    /// Numbers of the vertices of an edge.
    pub fn ends(&self, edge: usize) -> Option<[u64; 2]> {
        let planar = edge.checked_sub(self.file.edges.len());
        match planar {
            None => self.file.edges.get(edge).map(|edge| [edge.from, edge.to]),
            Some(edge) => self.file.planar_edges.get(edge).map(|edge| [edge.from, edge.to]),
        }
    }

    /// Whether a factor is an edge between poses with non-consecutive numbers.
    pub fn is_loop(&self, id: FactorId) -> bool {
        self.ends(id.index()).is_some_and(|[from, to]| from.abs_diff(to) != 1)
    }

    /// The graph without loops.
    pub fn without_loops(&self) -> FactorGraph {
        let mut graph = self.graph.clone();
        for edge in 0..self.edges() {
            let id = FactorId(edge as u32);
            if self.is_loop(id) {
                // It exists, because edges are the first factors.
                let _ = graph.remove(id);
            }
        }
        graph
    }

    /// The file with the given poses and without the rejected edges.
    pub fn result(&self, values: &Values, rejected: &[usize]) -> g2o::G2oGraph {
        let mut out = g2o::G2oGraph { fixed: self.file.fixed.clone(), ..g2o::G2oGraph::default() };
        for (&id, (_, value)) in self.ids.iter().zip(values.iter()) {
            match value {
                Value::Pose(pose) => out.vertices.push(g2o::G2oVertex { id, pose: pose_from_isometry(pose) }),
                Value::Planar(pose) => {
                    let (x, y, yaw) = (pose.translation.x, pose.translation.y, pose.rotation.angle());
                    out.planar_vertices.push(g2o::G2oVertex { id, pose: g2o::PlanarPose { x, y, yaw } });
                }
                _ => {}
            }
        }
        let kept = |edge: &usize| !rejected.contains(edge);
        let space = self.file.edges.len();
        out.edges = (0..space).filter(kept).map(|edge| self.file.edges[edge]).collect();
        out.planar_edges =
            (space..self.edges()).filter(kept).map(|edge| self.file.planar_edges[edge - space]).collect();
        out
    }

    /// The error message with the file's numbers.
    pub fn explain(&self, error: &SolveError) -> String {
        let vertex = |key: &Key| self.ids.get(key.index()).copied().unwrap_or_default();
        match error {
            SolveError::Undetermined { key } => texts::vertex_undetermined(vertex(key)),
            SolveError::Disconnected { key } => texts::vertex_disconnected(vertex(key)),
            SolveError::NotFinite { key, .. } => texts::vertex_edge_not_finite(vertex(key)),
            other => other.to_string(),
        }
    }
}

fn planar(pose: g2o::PlanarPose) -> Planar {
    Planar::new(Vector2::new(pose.x, pose.y), pose.yaw)
}

fn insert(poses: &mut BTreeMap<u64, Value>, id: u64, value: Value) -> Result<(), String> {
    if !value.is_finite() {
        return Err(texts::vertex_not_finite(id));
    }
    poses.insert(id, value).map_or(Ok(()), |_| Err(texts::vertex_twice(id)))
}

fn refused(from: u64, to: u64) -> impl Fn(&dyn Display) -> String {
    move |reason| texts::edge_refused(from, to, reason)
}
