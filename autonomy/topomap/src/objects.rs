//! The objects of a site that a topological map consists of.

use crate::corridor::Passage;
use crate::path_graph::{LinkKind, PathGraph, PlaceKind};
use crate::simplify::StraightEdges;
use crate::texts;
use crate::{GeneratedMap, NodeToleranceConfig, TopomapConfig, TopomapInput};
use geometry::{Isometry, Rotation, Vector3};
use site_model::{
    Anchor, Corridor, Dock, DockId, Edge, EdgeFailStep, EdgeId, Node, NodeId, NodeKind, PoseTolerance,
    TravelDirection, Traversal,
};
use std::collections::{BTreeMap, BTreeSet};
use uuid::Uuid;
use vocab::{KeyframeId, MapId};

/// Makes nodes, edges and docks.
pub(crate) fn objects(
    input: &TopomapInput<'_>,
    graph: &PathGraph,
    straight: &StraightEdges,
    passage: &Passage<'_>,
) -> GeneratedMap {
    let used: BTreeSet<usize> = straight.keys().flat_map(|(a, b)| [*a, *b]).collect();
    let floors = floors(graph, straight, &used, &passage.floor.config);
    let corridors: BTreeMap<(usize, usize), Corridor> = straight
        .keys()
        .map(|&(a, b)| ((a, b), passage.floor.corridor(&graph.feet(a), &graph.feet(b))))
        .collect();
    let mut made = GeneratedMap::default();
    let mut ids = BTreeMap::new();
    let mut anchored: BTreeMap<Option<KeyframeId>, u32> = BTreeMap::new();
    let mut counts = NameCounts::default();
    for &place in &used {
        let at = &graph.places[place];
        let map_from_node =
            pose_at(&(at.sample.feet + Vector3::z() * input.robot.standing_height_m), at.sample.yaw);
        let anchor = anchor(input, &map_from_node, passage.floor.config.floor_separation_m);
        let keyframe = anchor.map(|anchor| anchor.keyframe);
        let ordinal = anchored.entry(keyframe).or_default();
        let id = NodeId(named_id(input.map, "node", &[keyframe.map_or(u32::MAX, |id| id.0), *ordinal]));
        *ordinal += 1;
        ids.insert(place, id);
        let room_m = corridors
            .iter()
            .filter(|((a, b), _)| *a == place || *b == place)
            .map(|(_, corridor)| corridor.left_m.min(corridor.right_m))
            .fold(f64::INFINITY, f64::min);
        made.nodes.push(Node {
            id,
            name: counts.name(at.kind, straight, place),
            kind: match at.kind {
                PlaceKind::Plain => NodeKind::Waypoint,
                PlaceKind::Portal => NodeKind::Portal,
                PlaceKind::Dock(_) => NodeKind::Dock,
                PlaceKind::DockApproach(_) => NodeKind::DockApproach,
            },
            map_from_node: geometry::pose_from_isometry(&map_from_node),
            anchor,
            tolerance: tolerance(at.kind, room_m, &passage.floor.config.tolerances),
            influence_area_m: Vec::new(),
            floor: floors.get(&place).copied().unwrap_or_default(),
            tags: BTreeSet::new(),
            properties: BTreeMap::new(),
        });
    }
    for (&(a, b), kind) in straight {
        let corridor = corridors[&(a, b)];
        let back = Corridor { left_m: corridor.right_m, right_m: corridor.left_m };
        for (number, (from, to, corridor)) in [(a, b, corridor), (b, a, back)].into_iter().enumerate() {
            let leads_onto_dock = matches!(graph.places[to].kind, PlaceKind::Dock(_));
            let (from_id, to_id) = (ids[&from], ids[&to]);
            let id = EdgeId(joined_id(input.map, "edge", &[from_id.0, to_id.0]));
            made.edges.push(Edge {
                traversal: match kind {
                    LinkKind::Stairs(_) => Traversal::Stairs,
                    LinkKind::Dock if leads_onto_dock => Traversal::Dock,
                    LinkKind::Walk | LinkKind::Dock => Traversal::Walk,
                },
                corridor,
                direction: direction(graph, *kind, number, from, to),
                fail_policy: vec![EdgeFailStep::Retry(1), EdgeFailStep::Replan, EdgeFailStep::Fail],
                ..Edge::walk(id, from_id, to_id)
            });
        }
    }
    made.docks = docks(input, graph, &ids);
    made.pieces = pieces(straight);
    made
}

/// The docks whose two nodes were made.
fn docks(input: &TopomapInput<'_>, graph: &PathGraph, ids: &BTreeMap<usize, NodeId>) -> Vec<Dock> {
    let find =
        |kind: PlaceKind| ids.iter().find(|(place, _)| graph.places[**place].kind == kind).map(|(_, id)| *id);
    let made = (0..input.docks.len()).filter_map(|number| {
        let (node, approach) = (find(PlaceKind::Dock(number))?, find(PlaceKind::DockApproach(number))?);
        let id = DockId(joined_id(input.map, "dock", &[node.0]));
        Some(Dock { id, name: texts::dock(number + 1), node, approach })
    });
    made.collect()
}

/// Which way the robot faces on an edge.
fn direction(graph: &PathGraph, kind: LinkKind, number: usize, from: usize, to: usize) -> TravelDirection {
    let is_backward = match kind {
        LinkKind::Walk => false,
        LinkKind::Stairs(backward) => backward[number],
        // The heading on the dock is that before it.
        LinkKind::Dock => {
            let (from, to) = (graph.places[from].sample, graph.places[to].sample);
            let span = (to.feet - from.feet).xy();
            span.x * from.yaw.cos() + span.y * from.yaw.sin() < 0.0
        }
    };
    if is_backward { TravelDirection::Backward } else { TravelDirection::Forward }
}

fn tolerance(kind: PlaceKind, room_m: f64, config: &NodeToleranceConfig) -> PoseTolerance {
    let default = PoseTolerance::default();
    let circle =
        |radius_m: f64, yaw_rad: f64| PoseTolerance { along_m: radius_m, across_m: radius_m, yaw_rad };
    match kind {
        PlaceKind::Plain => {
            let radius_m = room_m.clamp(config.min_waypoint_m, config.waypoint_m);
            circle(radius_m, std::f64::consts::PI)
        }
        PlaceKind::Portal => circle(config.portal_m, config.portal_rad),
        PlaceKind::Dock(_) => circle(config.dock_m, default.yaw_rad),
        PlaceKind::DockApproach(_) => default,
    }
}

/// Counts the nodes of each kind for their names.
#[derive(Default)]
struct NameCounts {
    waypoints: usize,
    junctions: usize,
    portals: usize,
}

impl NameCounts {
    fn name(&mut self, kind: PlaceKind, straight: &StraightEdges, place: usize) -> String {
        match kind {
            PlaceKind::Plain if straight.keys().filter(|(a, b)| *a == place || *b == place).count() > 2 => {
                self.junctions += 1;
                texts::junction(self.junctions)
            }
            PlaceKind::Plain => {
                self.waypoints += 1;
                texts::waypoint(self.waypoints)
            }
            PlaceKind::Portal => {
                self.portals += 1;
                texts::portal(self.portals)
            }
            PlaceKind::Dock(number) => texts::on_dock(number + 1),
            PlaceKind::DockApproach(number) => texts::before_dock(number + 1),
        }
    }
}

/// The floor of each place: pieces of the graph without its stairs, numbered from the lowest, 0 where the map began.
fn floors(
    graph: &PathGraph,
    straight: &StraightEdges,
    used: &BTreeSet<usize>,
    config: &TopomapConfig,
) -> BTreeMap<usize, i32> {
    let level: Vec<(usize, usize)> = straight
        .iter()
        .filter(|(_, kind)| !matches!(kind, LinkKind::Stairs(_)))
        .map(|(pair, _)| *pair)
        .collect();
    let mut pieces = connected(&level);
    let single: Vec<usize> =
        used.iter().copied().filter(|place| !pieces.iter().any(|piece| piece.contains(place))).collect();
    pieces.extend(single.into_iter().map(|place| BTreeSet::from([place])));
    let mean_z = |piece: &BTreeSet<usize>| {
        piece.iter().map(|place| graph.feet(*place).z).sum::<f64>() / piece.len() as f64
    };
    // Landings belong to stairs: short ground between two flights. They get the floor below.
    let is_landing = |piece: &BTreeSet<usize>| {
        let portals = piece.iter().filter(|place| graph.places[**place].kind == PlaceKind::Portal).count();
        let first = piece.first().map(|place| graph.feet(*place)).unwrap_or_default();
        portals > 1 && piece.iter().all(|place| (graph.feet(*place) - first).norm() <= config.max_landing_m)
    };
    let mut storeys: Vec<f64> = pieces.iter().filter(|piece| !is_landing(piece)).map(mean_z).collect();
    storeys.sort_by(f64::total_cmp);
    let separation_m = config.floor_separation_m;
    storeys.dedup_by(|next, last| *next - *last < separation_m);
    let storey =
        |z: f64| storeys.iter().rposition(|height| *height - separation_m / 2.0 <= z).unwrap_or(0) as i32;
    let first = used.first().map_or(0, |place| storey(graph.feet(*place).z));
    pieces
        .iter()
        .flat_map(|piece| {
            piece.iter().map(|place| (*place, storey(mean_z(piece)) - first)).collect::<Vec<_>>()
        })
        .collect()
}

/// Connected pieces of pairs.
fn connected(pairs: &[(usize, usize)]) -> Vec<BTreeSet<usize>> {
    let mut pieces: Vec<BTreeSet<usize>> = Vec::new();
    for (a, b) in pairs {
        let (touched, mut rest): (Vec<_>, Vec<_>) =
            pieces.into_iter().partition(|piece| piece.contains(a) || piece.contains(b));
        let mut joined: BTreeSet<usize> = touched.into_iter().flatten().collect();
        joined.extend([*a, *b]);
        rest.push(joined);
        pieces = rest;
    }
    pieces
}

fn pieces(straight: &StraightEdges) -> usize {
    connected(&straight.keys().copied().collect::<Vec<_>>()).len()
}

/// A level pose.
fn pose_at(position: &Vector3, yaw: f64) -> Isometry {
    Isometry::from_parts((*position).into(), Rotation::from_euler_angles(0.0, 0.0, yaw))
}

/// The nearest keyframe, one of the same floor if there is one.
fn anchor(input: &TopomapInput<'_>, map_from_node: &Isometry, separation_m: f64) -> Option<Anchor> {
    let rank = |pose: &Isometry| {
        let offset = pose.translation.vector - map_from_node.translation.vector;
        (offset.z.abs() > separation_m, offset.norm())
    };
    let nearest = input.keyframes.iter().min_by(|(a, a_pose), (b, b_pose)| {
        let (a_rank, b_rank) = (rank(a_pose), rank(b_pose));
        a_rank.0.cmp(&b_rank.0).then(a_rank.1.total_cmp(&b_rank.1)).then(a.cmp(b))
    })?;
    let keyframe_from_node = geometry::pose_from_isometry(&(nearest.1.inverse() * map_from_node));
    Some(Anchor { keyframe: nearest.0, keyframe_from_node })
}

/// The id of an object of a map, named by numbers. The same numbers give the same id.
fn named_id(map: MapId, kind: &str, numbers: &[u32]) -> Uuid {
    hashed_id(map, kind, numbers.iter().flat_map(|number| number.to_le_bytes()))
}

/// The id of an object of a map that joins others.
fn joined_id(map: MapId, kind: &str, others: &[Uuid]) -> Uuid {
    hashed_id(map, kind, others.iter().flat_map(|id| *id.as_bytes()))
}

/// A UUID of version 8 (RFC 9562) from the BLAKE3 of a name, as version 5 has it from the SHA-1.
fn hashed_id(map: MapId, kind: &str, name: impl Iterator<Item = u8>) -> Uuid {
    let bytes: Vec<u8> = map.0.as_bytes().iter().copied().chain(kind.bytes()).chain(name).collect();
    let hash = blake3::hash(&bytes);
    let mut first = [0; 16];
    first.copy_from_slice(&hash.as_bytes()[..16]);
    uuid::Builder::from_custom_bytes(first).into_uuid()
}
