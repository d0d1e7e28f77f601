//! Picking: finds the thing under a pixel, on the CPU.
//!
//! Robot, nodes, markers and loops are picked by their distance on the screen, so that a finger hits them. Of the drawn points in a cone
//! around the ray, the nearest to the camera is picked.

use crate::pose_graph::LoopEdge;
use crate::projection::{CameraProjection, Ray};
use crate::tiles::{PICK_BLOCK_POINTS, TilePoints, lattice};
use glam::{DAffine3, DVec2, DVec3};

/// Distances from the pointer within which things are picked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickOptions {
    /// Robot, nodes and markers, physical px; 22 logical px make a touch target of 44.
    pub target_px: f64,
    /// Distance within which a node or marker precedes every line, physical px: its drawn radius.
    pub marker_px: f64,
    /// Lines of loops, physical px.
    pub line_px: f64,
    /// Points, physical px.
    pub point_px: f64,
}

/// The thing under a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hit {
    /// The robot.
    Robot,
    /// A node of the graph, by its number.
    Node(u32),
    /// A marker that has an id.
    Marker(u64),
    /// A loop, by the numbers of its nodes.
    Loop([u32; 2]),
    /// A point of the map or of the scan: metres, map frame.
    Point(DVec3),
}

/// A robot, node or marker that can be picked.
pub(crate) struct PickTarget {
    pub(crate) hit: Hit,
    /// Lowest and highest drawn height, m, map frame.
    pub(crate) position: DVec3,
}

/// The target nearest to a pixel on the screen, within `max_distance_px`, and its distance in px. Of two at the same distance,
/// the one nearer to the camera.
pub(crate) fn nearest_target(
    targets: &[PickTarget],
    projection: &CameraProjection,
    pixel: DVec2,
    max_distance_px: f64,
) -> Option<(f64, Hit)> {
    let mut best: Option<(f64, f64, Hit)> = None;
    for target in targets {
        let Some((at, depth)) = projection.project(target.position) else {
            continue;
        };
        let apart = at.distance(pixel);
        if apart <= max_distance_px && best.is_none_or(|(a, d, _)| (apart, depth) < (a, d)) {
            best = Some((apart, depth, target.hit));
        }
    }
    best.map(|(apart, _, hit)| (apart, hit))
}

/// The loop whose line on the screen is nearest to a pixel, within `max_distance_px`. Of two at the same distance the one that is drawn
/// on top: the higher state, then the later one. Cost: linear in the loops.
pub(crate) fn nearest_loop(
    loops: &[LoopEdge],
    projection: &CameraProjection,
    pixel: DVec2,
    max_distance_px: f64,
) -> Option<Hit> {
    let apart = |edge: &LoopEdge| {
        let [a, b] = projection.project_line(edge.ends)?;
        let (line, to_pixel) = (b - a, pixel - a);
        let fraction = (to_pixel.dot(line) / line.length_squared().max(1e-12)).clamp(0.0, 1.0);
        Some((to_pixel - line * fraction).length())
    };
    let near = loops.iter().filter_map(|edge| Some((apart(edge).filter(|px| *px <= max_distance_px)?, edge)));
    let best = near.reduce(|best, new| {
        let order = new.0.total_cmp(&best.0).then(best.1.state.cmp(&new.1.state));
        if order.is_le() { new } else { best }
    });
    best.map(|(_, edge)| Hit::Loop(edge.nodes))
}

/// Decides between a target (with its distance, px) and a line near a pixel. Within `marker_px` the target precedes the line; beyond it
/// the line precedes the target, because the line is much narrower than a finger.
pub(crate) fn resolve_pick(target: Option<(f64, Hit)>, line: Option<Hit>, marker_px: f64) -> Option<Hit> {
    match (target, line) {
        (Some((apart, target)), Some(line)) => Some(if apart <= marker_px { target } else { line }),
        (target, line) => line.or(target.map(|(_, target)| target)),
    }
}

/// A narrow cone with its tip in the camera, limited to the heights between which points are drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PickCone {
    pub(crate) ray: Ray,
    /// Tangent of half its opening angle.
    pub(crate) slope: f64,
    /// Lowest and highest drawn height, m, map frame.
    pub(crate) height_range: [f64; 2],
}

impl PickCone {
    /// Distance along the ray of a point inside the cone and between the heights.
    pub(crate) fn distance_to(&self, point_in_map: DVec3) -> Option<f64> {
        let relative = point_in_map - self.ray.origin;
        let distance = relative.dot(self.ray.direction);
        let off_axis = (relative - self.ray.direction * distance).length();
        let [floor, ceiling] = self.height_range;
        let drawn = (floor..=ceiling).contains(&point_in_map.z) && distance >= CameraProjection::NEAR_M;
        (drawn && off_axis <= distance * self.slope).then_some(distance)
    }

    /// Whether the cone may touch a sphere nearer than `limit` along the ray.
    fn may_touch(&self, centre_in_map: DVec3, radius: f64, limit: f64) -> bool {
        let relative = centre_in_map - self.ray.origin;
        let distance = relative.dot(self.ray.direction);
        let off_axis = (relative - self.ray.direction * distance).length();
        distance + radius >= CameraProjection::NEAR_M
            && distance - radius <= limit
            && off_axis - radius <= (distance + radius).max(0.0) * self.slope
    }
}

/// Distance along the ray (m) and position (m, map frame) of the nearest point of a tile in the cone, nearer than
/// `limit`.
pub(crate) fn nearest_point(
    points: &TilePoints,
    map_from_anchor: &DAffine3,
    cone: &PickCone,
    limit: f64,
) -> Option<(f64, DVec3)> {
    let mut best: Option<(f64, DVec3)> = None;
    let centre = map_from_anchor.transform_point3(points.centre);
    if !cone.may_touch(centre, points.radius, limit) {
        return None;
    }
    for (block, block_points) in points.blocks.iter().zip(points.points.chunks(PICK_BLOCK_POINTS)) {
        let (min, max) = (lattice(block.min), lattice(block.max));
        let middle = map_from_anchor.transform_point3(points.origin + (min + max) * (0.5 * points.step));
        let reach = (max - min).length() * 0.5 * points.step;
        let nearest = best.map_or(limit, |(distance, _)| distance);
        if !cone.may_touch(middle, reach, nearest) {
            continue;
        }
        for point in block_points {
            let in_map = map_from_anchor.transform_point3(points.position(point));
            if let Some(distance) = cone.distance_to(in_map)
                && distance < best.map_or(limit, |(distance, _)| distance)
            {
                best = Some((distance, in_map));
            }
        }
    }
    best
}
