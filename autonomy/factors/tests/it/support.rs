//! Loads published graphs as factor graphs.

use factors::{Between, PlanarBetween, PlanarPrior, Prior, Residual};
use factors::{FactorGraph, FactorId, Key, Planar, Value, Values};
use formats::g2o;
use geometry::{Isometry, Matrix3, Matrix6, isometry_from_pose};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Path of a published file. `None`, with a printed line, if it is not there.
pub fn data(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("AUTOINSPECT_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let path = root.join(name);
    if !path.exists() {
        println!("skipped: {} is not there; set AUTOINSPECT_DATA", path.display());
        return None;
    }
    Some(path)
}

/// A published graph.
pub struct Published {
    pub values: Values,
    pub graph: FactorGraph,
    /// Edges in the file's order, with their factors.
    pub edges: Vec<(Key, Key, FactorId)>,
    /// Whether the file had vertices; otherwise all estimates are the origin.
    pub has_start: bool,
}

pub fn planar(pose: g2o::PlanarPose) -> Planar {
    Planar::new(nalgebra::Vector2::new(pose.x, pose.y), pose.yaw)
}

/// Reads a graph with the residual that keeps rotation and translation apart.
pub fn load(name: &str) -> Option<Published> {
    load_with(name, Residual::Split)
}

/// Reads a graph. The first pose gets a prior of 1 µm and 1 µrad.
pub fn load_with(name: &str, residual: Residual) -> Option<Published> {
    let text = std::fs::read_to_string(data(name)?).unwrap();
    let file = g2o::read(&text).unwrap();
    let mut ids: Vec<u64> = file.edges.iter().flat_map(|edge| [edge.from, edge.to]).collect();
    ids.extend(file.planar_edges.iter().flat_map(|edge| [edge.from, edge.to]));
    ids.sort_unstable();
    ids.dedup();
    let is_planar = !file.planar_edges.is_empty();
    let mut poses: BTreeMap<u64, Value> = BTreeMap::new();
    for vertex in &file.vertices {
        poses.insert(vertex.id, Value::Pose(isometry_from_pose(&vertex.pose).unwrap()));
    }
    for vertex in &file.planar_vertices {
        poses.insert(vertex.id, Value::Planar(planar(vertex.pose)));
    }
    let origin =
        if is_planar { Value::Planar(Planar::identity()) } else { Value::Pose(Isometry::identity()) };
    let mut values = Values::default();
    let keys: BTreeMap<u64, Key> =
        ids.iter().map(|id| (*id, values.insert(poses.get(id).copied().unwrap_or(origin)))).collect();
    let mut graph = FactorGraph::default();
    let mut edges = Vec::new();
    for edge in &file.edges {
        let (from, to) = (keys[&edge.from], keys[&edge.to]);
        let information = Matrix6::from_fn(|row, column| edge.information[row][column]);
        let measured = isometry_from_pose(&edge.from_from_to).unwrap();
        let factor = Between::new(from, to, &measured, &information).unwrap().with_residual(residual);
        edges.push((from, to, graph.add(factor, &values).unwrap()));
    }
    for edge in &file.planar_edges {
        let (from, to) = (keys[&edge.from], keys[&edge.to]);
        let information = Matrix3::from_fn(|row, column| edge.information[row][column]);
        let factor = PlanarBetween::new(from, to, &planar(edge.from_from_to), &information).unwrap();
        let factor = factor.with_residual(residual);
        edges.push((from, to, graph.add(factor, &values).unwrap()));
    }
    match values.get(Key(0)).copied().unwrap() {
        Value::Planar(pose) => {
            let factor = PlanarPrior::new(Key(0), &pose, &(Matrix3::identity() * 1e12)).unwrap();
            graph.add(factor, &values).unwrap();
        }
        Value::Pose(pose) => {
            graph.add(Prior::new(Key(0), &pose, &(Matrix6::identity() * 1e12)).unwrap(), &values).unwrap();
        }
        _ => unreachable!("a published graph has poses only"),
    }
    Some(Published { values, graph, edges, has_start: !poses.is_empty() })
}
