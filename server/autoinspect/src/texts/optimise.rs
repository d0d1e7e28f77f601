//! Errors of `autoinspect optimise`, and reasons for [`cannot_optimise`].

use std::fmt::Display;
use std::path::Path;

/// A pose graph that the solver rejects.
pub fn cannot_optimise(graph: &Path, reason: &dyn Display) -> String {
    format!("{} cannot be optimised: {reason}", graph.display())
}

/// A graph without vertices and edges.
pub const GRAPH_EMPTY: &str = "it holds no poses";

/// An edge of a map whose measured pose is invalid.
pub const MAP_EDGE_NO_POSE: &str = "an edge of its graph is no pose";

/// The measured pose of an edge is invalid: a reason for [`edge_refused`].
pub const EDGE_NO_POSE: &str = "its pose is none";

/// A vertex whose pose is no rotation and translation.
pub fn vertex_no_pose(vertex: u64) -> String {
    format!("the pose of vertex {vertex} is none")
}

/// A vertex with numbers that are not finite.
pub fn vertex_not_finite(vertex: u64) -> String {
    format!("the pose of vertex {vertex} is not finite")
}

/// Two vertices of one number.
pub fn vertex_twice(vertex: u64) -> String {
    format!("vertex {vertex} is there twice")
}

/// An edge to a vertex that is not in the file.
pub fn vertex_missing(vertex: u64) -> String {
    format!("an edge names vertex {vertex}, which is missing")
}

/// A vertex that cannot be held fixed.
pub fn vertex_refused(vertex: u64, reason: &dyn Display) -> String {
    format!("vertex {vertex}: {reason}")
}

/// An edge that is no measurement.
pub fn edge_refused(from: u64, to: u64, reason: &dyn Display) -> String {
    format!("edge {from} to {to}: {reason}")
}

/// A vertex with too few edges.
pub fn vertex_undetermined(vertex: u64) -> String {
    format!("its edges do not determine vertex {vertex}; connect it to the others")
}

/// A vertex in a part of the graph without a fixed pose.
pub fn vertex_disconnected(vertex: u64) -> String {
    format!("no chain of edges connects vertex {vertex} to the first or a fixed one")
}

/// A vertex whose edges give no finite residual.
pub fn vertex_edge_not_finite(vertex: u64) -> String {
    format!("an edge of vertex {vertex} is not finite")
}
