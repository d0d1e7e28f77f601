//! Makes the graph of an imported map: virtual viewpoints as keyframes, and edges between neighbours.

use geometry::pose_from_isometry;
use mapping::virtual_viewpoint::{ViewpointConfig, VirtualViewpoints};
use messages::{EdgeKind, FinishedMap, GraphEdge, GraphNode, PoseGraph, RevisitCounts};
use std::sync::Arc;
use store::MapPoints;
use uuid::Uuid;
use vocab::{KeyframeId, MapId, SessionId, Stamp};

/// Standard deviations of the relative pose of two viewpoints, for each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeNoise {
    /// Rotation, radians.
    pub rotation_std_rad: f64,
    /// Translation, metres.
    pub translation_std_m: f64,
}

impl EdgeNoise {
    /// Diagonal information matrix, rotation first.
    fn information(self) -> [[f64; 6]; 6] {
        let mut information = [[0.0; 6]; 6];
        for (index, row) in information.iter_mut().enumerate() {
            row[index] = if index < 3 { self.rotation_std_rad } else { self.translation_std_m }.powi(-2);
        }
        information
    }
}

/// Parameters of the graph of an imported map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportedGraphConfig {
    /// Noise of edges between viewpoints on connected floor. Chosen: a survey is known to millimetres, so that its own poses are kept.
    pub neighbour_noise: EdgeNoise,
    /// Noise of edges between separate pieces of floor. Chosen: far looser than that of neighbours, because no floor joins them.
    pub bridge_noise: EdgeNoise,
}

impl Default for ImportedGraphConfig {
    fn default() -> Self {
        Self {
            neighbour_noise: EdgeNoise { rotation_std_rad: 1e-3, translation_std_m: 5e-3 },
            bridge_noise: EdgeNoise { rotation_std_rad: 1e-2, translation_std_m: 0.1 },
        }
    }
}

/// The map in the form of the store: viewpoints as keyframes, edges between neighbours on connected floor, and bridges between separate
/// pieces of floor.
pub fn imported_map(
    id: MapId,
    name: &str,
    created: Stamp,
    found: &VirtualViewpoints,
    config: &ImportedGraphConfig,
) -> FinishedMap {
    let nodes = (0..).zip(&found.viewpoints).map(|(number, place)| GraphNode {
        id: KeyframeId(number),
        stamp: Stamp::EPOCH,
        map_from_keyframe: pose_from_isometry(&place.map_from_base),
    });
    let edge = |[from, to]: [usize; 2], noise: EdgeNoise| {
        let [a, b] = [from, to].map(|index| found.viewpoints[index].map_from_base);
        GraphEdge {
            from: KeyframeId(from as u32),
            to: KeyframeId(to as u32),
            kind: EdgeKind::Odometry,
            from_from_to: pose_from_isometry(&(a.inverse() * b)),
            information: noise.information(),
        }
    };
    let neighbours = found.connections.iter().map(|pair| edge(*pair, config.neighbour_noise));
    let bridges = bridges(found).into_iter().map(|pair| edge(pair, config.bridge_noise));
    let edges: Vec<GraphEdge> = neighbours.chain(bridges).collect();
    FinishedMap {
        map: id,
        name: name.to_owned(),
        session: SessionId(Uuid::nil()),
        extends: None,
        at: created,
        distance_m: 0.0,
        graph: Arc::new(PoseGraph { revision: 1, nodes: nodes.collect(), edges }),
        trajectory: Vec::new(),
        degenerate: Vec::new(),
        decisions: Vec::new(),
        unverified: 0,
        revisits: RevisitCounts::default(),
    }
}

/// Pairs of viewpoints that join separate pieces of floor with the first one, because the graph must be connected.
fn bridges(found: &VirtualViewpoints) -> Vec<[usize; 2]> {
    let mut neighbours = vec![Vec::new(); found.viewpoints.len()];
    for &[a, b] in &found.connections {
        neighbours[a].push(b);
        neighbours[b].push(a);
    }
    let mut reached = vec![false; found.viewpoints.len()];
    let mut bridges = Vec::new();
    for first in 0..found.viewpoints.len() {
        if reached[first] {
            continue;
        }
        if first > 0 {
            bridges.push([0, first]);
        }
        let mut open = vec![first];
        while let Some(place) = open.pop() {
            if !std::mem::replace(&mut reached[place], true) {
                open.extend(&neighbours[place]);
            }
        }
    }
    bridges
}

/// The map's id: FNV-1a of the points and the viewpoints' parameters, so that the same import gives the same id.
pub fn map_id(cloud: &MapPoints, config: &ViewpointConfig) -> MapId {
    let [down, up] = config.elevations_rad;
    let parameters = [config.spacing_m, down, up];
    let bits = cloud.xyz.iter().flatten().chain(&parameters).map(|number| number.to_bits());
    let mix = |sum: u128, bits: u32| (sum ^ u128::from(bits)).wrapping_mul(0x0100_0000_0000_0000_0000_013b);
    MapId(Uuid::from_u128(bits.fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d, mix)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Isometry;
    use mapping::PackedIndices;
    use mapping::virtual_viewpoint::VirtualViewpoint;

    #[test]
    fn separate_pieces_of_floor_are_joined_by_bridges() {
        let place = |x: f64| VirtualViewpoint {
            map_from_base: Isometry::translation(x, 0.0, 0.0),
            visible: PackedIndices::default(),
        };
        let places = (0..5).map(|number| place(f64::from(number))).collect();
        let found = VirtualViewpoints { viewpoints: places, connections: vec![[0, 1], [2, 3]] };
        let id = map_id(&MapPoints::default(), &ViewpointConfig::default());
        let map = imported_map(id, "two rooms", Stamp::EPOCH, &found, &ImportedGraphConfig::default());
        let pairs: Vec<[u32; 2]> = map.graph.edges.iter().map(|edge| [edge.from.0, edge.to.0]).collect();
        assert_eq!(pairs, [[0, 1], [2, 3], [0, 2], [0, 4]]);
        let translation_information = |edge: usize| map.graph.edges[edge].information[3][3];
        assert!(translation_information(0) > 100.0 * translation_information(2));
    }
}
