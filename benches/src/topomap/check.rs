//! Checks of a topological map: its edges against the solids of a site, and the walked path against its edges.

#![allow(clippy::print_stdout, reason = "with --verbose it lists what it finds")]

use geometry::{Isometry, Vector3, vec_from_plain};
use nalgebra::Point3;
use sim::SimulatedSite;
use site_model::Traversal;
use std::collections::{BTreeMap, BTreeSet};
use topomap::GeneratedMap;

/// Distance between the places of an edge that are checked, metres.
const STEP_M: f64 = 0.1;
/// A sphere by which the simulated robot collides with solids.
struct HullSphere {
    /// Height of its centre above the ground, metres.
    height_m: f64,
    radius_m: f64,
}

/// The body and the mast of the simulated robot.
const HULL: [HullSphere; 2] =
    [HullSphere { height_m: 0.60, radius_m: 0.36 }, HullSphere { height_m: 0.85, radius_m: 0.28 }];
/// Surfaces whose normal is steeper than this stop the robot; floors and ceilings do not.
const WALL_LEVEL: f64 = 0.3;
/// Distance around the hull in which solids are searched, metres.
const REACH_M: f64 = 0.7;
/// Highest ledge that the simulated robot steps over, metres.
const MAX_LEDGE_M: f64 = 0.27;
/// Height above the expected ground at which the ground is looked for, metres.
const PROBE_ABOVE_M: f64 = 0.5;
/// Depth below the expected ground down to which it is looked for, metres.
const PROBE_BELOW_M: f64 = 0.6;
/// The ground over this distance says whether an edge has stairs, metres, ...
const STAIRS_WINDOW_STEPS: usize = 8;
/// ... which are steeper than this: 20 degrees.
const STAIRS_SLOPE: f64 = 0.36;

/// An edge of one direction, at the feet, map frame, metres.
pub struct CheckedEdge {
    pub from: Vector3,
    pub to: Vector3,
    pub is_stairs: bool,
    /// Names of its nodes.
    pub name: String,
}

/// Every edge once, whatever its directions; positions are those of the base.
pub fn edges(made: &GeneratedMap) -> impl Iterator<Item = CheckedEdge> + '_ {
    let nodes: BTreeMap<_, _> = made.nodes.iter().map(|node| (node.id, node)).collect();
    let mut seen = BTreeSet::new();
    made.edges.iter().filter_map(move |edge| {
        let pair = (edge.from.min(edge.to), edge.from.max(edge.to));
        let (from, to) = (*nodes.get(&edge.from)?, *nodes.get(&edge.to)?);
        seen.insert(pair).then(|| CheckedEdge {
            from: vec_from_plain(from.map_from_node.position),
            to: vec_from_plain(to.map_from_node.position),
            is_stairs: edge.traversal == Traversal::Stairs,
            name: format!("{} - {}", from.name, to.name),
        })
    })
}

/// The solids of a site in the frame of a map.
pub struct SolidCheck<'a> {
    pub site: &'a SimulatedSite,
    pub site_from_map: Isometry,
}

/// What the solids say of the edges.
#[derive(Debug, Default)]
pub struct SolidScore {
    /// Edges on which the body would overlap a solid by more than [`MAX_OVERLAP_M`], or on which the ground is missing or too high.
    pub through: usize,
    /// Room between the body and the nearest solid along each edge, metres; negative where they overlap.
    pub rooms_m: Vec<f64>,
    pub stairs_true: usize,
    pub stairs_found: usize,
    pub stairs_wrong: usize,
}

/// Overlap that counts as a touch in passing, metres: the errors of map (1 cm) and LiDAR (2 cm). The robot keeps its own distance while it walks.
const MAX_OVERLAP_M: f64 = 0.03;

impl SolidCheck<'_> {
    /// Checks every edge.
    pub fn edges(&self, made: &GeneratedMap, standing_height_m: f64, verbose: bool) -> SolidScore {
        let mut score = SolidScore::default();
        for edge in edges(made) {
            let feet = |base: &Vector3| {
                let at = self.site_from_map * Point3::from(*base);
                at.coords - Vector3::z() * standing_height_m
            };
            let (room_m, heights) = self.walk(&feet(&edge.from), &feet(&edge.to));
            let is_true = heights.windows(STAIRS_WINDOW_STEPS + 1).any(|window| {
                let rise = window[STAIRS_WINDOW_STEPS] - window[0];
                rise.abs() > STAIRS_SLOPE * STEP_M * STAIRS_WINDOW_STEPS as f64
            });
            score.stairs_true += usize::from(is_true);
            score.stairs_found += usize::from(is_true && edge.is_stairs);
            score.stairs_wrong += usize::from(!is_true && edge.is_stairs);
            let is_through = room_m < -MAX_OVERLAP_M;
            score.through += usize::from(is_through);
            score.rooms_m.push(room_m);
            if verbose && room_m < 0.0 {
                let (a, b) = (feet(&edge.from), feet(&edge.to));
                println!(
                    "{}: room {room_m:.3} m, from {:.2},{:.2},{:.2} to {:.2},{:.2},{:.2}",
                    edge.name, a.x, a.y, a.z, b.x, b.y, b.z
                );
            }
        }
        score
    }

    /// Least room of the body along a straight line between two places of the feet in the site, and the heights of the ground. Minus infinity where the ground
    /// is missing or too high.
    fn walk(&self, from: &Vector3, to: &Vector3) -> (f64, Vec<f64>) {
        let steps = ((to - from).xy().norm() / STEP_M).ceil().max(1.0) as usize;
        let (mut room_m, mut heights) = (f64::INFINITY, Vec::new());
        let mut height = from.z;
        for step in 0..=steps {
            let mut at = from.lerp(to, step as f64 / steps as f64);
            let top = Vector3::new(at.x, at.y, height + PROBE_ABOVE_M);
            let Some((down, _)) = self.site.cast_ray(&top, &-Vector3::z(), PROBE_ABOVE_M + PROBE_BELOW_M)
            else {
                return (f64::NEG_INFINITY, heights);
            };
            let ground = top.z - down;
            if step > 0 && (ground - height).abs() > MAX_LEDGE_M {
                return (f64::NEG_INFINITY, heights);
            }
            (height, at.z) = (ground, ground);
            heights.push(height);
            for sphere in &HULL {
                room_m = room_m.min(self.room(&(at + Vector3::z() * sphere.height_m)) - sphere.radius_m);
            }
        }
        (room_m, heights)
    }

    /// Distance from a point to the nearest wall; [`REACH_M`] if none is near.
    fn room(&self, centre: &Vector3) -> f64 {
        let mut least = REACH_M;
        self.site.bvh().near(centre, REACH_M, |solid| {
            let clearance = solid.shape.clearance(centre);
            if clearance.outward.xy().norm() >= WALL_LEVEL {
                least = least.min(clearance.distance);
            }
        });
        least
    }
}

/// How near the edges are to the walked path.
pub struct PathCover {
    pub walked_m: f64,
    pub mean_m: f64,
    pub worst_m: f64,
    /// Share of the path farther away than the limit.
    pub far_share: f64,
}

impl PathCover {
    /// Measures the distance from each pose of the base to the nearest edge that can be reached from the first node.
    pub fn new(
        path: &[Isometry],
        made: &GeneratedMap,
        limit_m: f64,
        _standing_height_m: f64,
        verbose: bool,
    ) -> Self {
        let reachable = reachable(made);
        let distance_m = |at: &Vector3| {
            let nearest = reachable.iter().map(|edge| {
                let span = edge.to - edge.from;
                let share = ((at - edge.from).dot(&span) / span.norm_squared().max(1e-9)).clamp(0.0, 1.0);
                (at - edge.from - span * share).norm()
            });
            nearest.fold(f64::INFINITY, f64::min)
        };
        let mut places: Vec<Vector3> = Vec::new();
        let mut walked_m = 0.0;
        for pose in path {
            let at = pose.translation.vector;
            let step_m = places.last().map_or(f64::INFINITY, |last| (at - last).norm());
            if step_m >= 0.1 {
                walked_m += if step_m < 1.5 { step_m } else { 0.0 };
                places.push(at);
            }
        }
        let distances: Vec<f64> = places.iter().map(distance_m).collect();
        let far = distances.iter().filter(|distance| **distance > limit_m).count();
        if verbose {
            let far = places.iter().zip(&distances).filter(|(_, d)| **d > limit_m);
            for (place, distance) in far.step_by(20) {
                println!(
                    "path at {:.2},{:.2},{:.2}: {distance:.2} m from all edges",
                    place.x, place.y, place.z
                );
            }
        }
        Self {
            walked_m,
            mean_m: distances.iter().sum::<f64>() / distances.len().max(1) as f64,
            worst_m: distances.iter().copied().fold(0.0, f64::max),
            far_share: far as f64 / distances.len().max(1) as f64,
        }
    }
}

/// The edges of the piece with the most nodes.
fn reachable(made: &GeneratedMap) -> Vec<CheckedEdge> {
    let mut piece_of: BTreeMap<_, usize> = made.nodes.iter().map(|node| node.id).zip(0..).collect();
    loop {
        let mut is_changed = false;
        for edge in &made.edges {
            let (Some(from), Some(to)) = (piece_of.get(&edge.from), piece_of.get(&edge.to)) else { continue };
            let least = *from.min(to);
            is_changed |= from != to;
            piece_of.extend([(edge.from, least), (edge.to, least)]);
        }
        if !is_changed {
            break;
        }
    }
    let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
    for piece in piece_of.values() {
        *sizes.entry(*piece).or_default() += 1;
    }
    let largest = sizes.iter().max_by_key(|(_, size)| **size).map(|(piece, _)| *piece);
    let inside: BTreeSet<_> =
        piece_of.iter().filter(|(_, piece)| Some(**piece) == largest).map(|(node, _)| *node).collect();
    let part = GeneratedMap {
        nodes: made.nodes.iter().filter(|node| inside.contains(&node.id)).cloned().collect(),
        edges: made.edges.clone(),
        ..GeneratedMap::default()
    };
    edges(&part).collect()
}
