//! What is under a pixel, found on the processor.
//!
//! Signs (robot, nodes, markers) and loops are compared on the screen, so that a finger hits them. Points are compared with a
//! cone around the ray; of those inside, the nearest to the eye wins, provided that it is drawn at all.

use crate::eye::{Eye, Ray};
use crate::loops::LoopEdge;
use crate::tiles::{BLOCK_POINTS, Cloud, lattice};
use glam::{DAffine3, DVec2, DVec3};

/// How far from the pointer things still count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickOptions {
    /// Signs, physical pixels; 22 logical ones make a target of 44.
    pub sign_px: f64,
    /// How far a sign reaches past every line, physical pixels: as large as it is drawn.
    pub disc_px: f64,
    /// Lines of loops, physical pixels.
    pub line_px: f64,
    /// Points, physical pixels.
    pub point_px: f64,
}

/// What is under a pixel.
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

/// A sign that can be picked.
pub(crate) struct Sign {
    pub(crate) hit: Hit,
    /// Metres, map frame.
    pub(crate) position: DVec3,
}

/// The sign nearest to a pixel on the screen, within `radius_px`, and its distance; the nearer to the eye when two are
/// equally near.
pub(crate) fn nearest_sign(signs: &[Sign], eye: &Eye, pixel: DVec2, radius_px: f64) -> Option<(f64, Hit)> {
    let mut best: Option<(f64, f64, Hit)> = None;
    for sign in signs {
        let Some((at, depth)) = eye.project(sign.position) else {
            continue;
        };
        let apart = at.distance(pixel);
        if apart <= radius_px && best.is_none_or(|(a, d, _)| (apart, depth) < (a, d)) {
            best = Some((apart, depth, sign.hit));
        }
    }
    best.map(|(apart, _, hit)| (apart, hit))
}

/// The loop whose line on the screen is nearest to a pixel, within `radius_px`; the one that matters more, then the later
/// one, when two are equally near, as they are drawn. Cost: linear in the loops.
pub(crate) fn nearest_loop(loops: &[LoopEdge], eye: &Eye, pixel: DVec2, radius_px: f64) -> Option<Hit> {
    let apart = |edge: &LoopEdge| {
        let [a, b] = eye.project_line(edge.ends)?;
        let (line, to_pixel) = (b - a, pixel - a);
        let along = (to_pixel.dot(line) / line.length_squared().max(1e-12)).clamp(0.0, 1.0);
        Some((to_pixel - line * along).length())
    };
    let near = loops.iter().filter_map(|edge| Some((apart(edge).filter(|px| *px <= radius_px)?, edge)));
    let best = near.reduce(|best, new| {
        let order = new.0.total_cmp(&best.0).then(best.1.state.cmp(&new.1.state));
        if order.is_le() { new } else { best }
    });
    best.map(|(_, edge)| Hit::Loop(edge.nodes))
}

/// Of a sign (with its distance) and a line near a pixel, the one that is meant: a sign where it is drawn, else the line,
/// which is much narrower than a finger, else the sign.
pub(crate) fn meant(sign: Option<(f64, Hit)>, line: Option<Hit>, disc_px: f64) -> Option<Hit> {
    match (sign, line) {
        (Some((apart, sign)), Some(line)) => Some(if apart <= disc_px { sign } else { line }),
        (sign, line) => line.or(sign.map(|(_, sign)| sign)),
    }
}

/// A narrow cone with its tip in the eye, and the heights between which points are drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cone {
    pub(crate) ray: Ray,
    /// Tangent of the half angle.
    pub(crate) slope: f64,
    /// Metres, map frame.
    pub(crate) heights: [f64; 2],
}

impl Cone {
    /// Distance along the ray of a point inside the cone and between the heights.
    pub(crate) fn along(&self, point_in_map: DVec3) -> Option<f64> {
        let relative = point_in_map - self.ray.origin;
        let along = relative.dot(self.ray.direction);
        let aside = (relative - self.ray.direction * along).length();
        let [floor, ceiling] = self.heights;
        let drawn = (floor..=ceiling).contains(&point_in_map.z) && along >= Eye::NEAR;
        (drawn && aside <= along * self.slope).then_some(along)
    }

    /// Whether the cone may touch a ball nearer than `limit` along the ray.
    fn may_touch(&self, centre_in_map: DVec3, radius: f64, limit: f64) -> bool {
        let relative = centre_in_map - self.ray.origin;
        let along = relative.dot(self.ray.direction);
        let aside = (relative - self.ray.direction * along).length();
        along + radius >= Eye::NEAR
            && along - radius <= limit
            && aside - radius <= (along + radius).max(0.0) * self.slope
    }
}

/// Distance along the ray and position (metres, map frame) of the nearest point of a cloud in the cone, nearer than
/// `limit`.
pub(crate) fn nearest_point(
    cloud: &Cloud,
    map_from_anchor: &DAffine3,
    cone: &Cone,
    limit: f64,
) -> Option<(f64, DVec3)> {
    let mut best: Option<(f64, DVec3)> = None;
    let centre = map_from_anchor.transform_point3(cloud.centre);
    if !cone.may_touch(centre, cloud.radius, limit) {
        return None;
    }
    for (block, points) in cloud.blocks.iter().zip(cloud.points.chunks(BLOCK_POINTS)) {
        let (min, max) = (lattice(block.min), lattice(block.max));
        let middle = map_from_anchor.transform_point3(cloud.origin + (min + max) * (0.5 * cloud.step));
        let reach = (max - min).length() * 0.5 * cloud.step;
        let nearest = best.map_or(limit, |(along, _)| along);
        if !cone.may_touch(middle, reach, nearest) {
            continue;
        }
        for point in points {
            let in_map = map_from_anchor.transform_point3(cloud.position(point));
            if let Some(along) = cone.along(in_map)
                && along < best.map_or(limit, |(along, _)| along)
            {
                best = Some((along, in_map));
            }
        }
    }
    best
}
