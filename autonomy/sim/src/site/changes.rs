//! Changes of a site from one day to another.

use super::plan::{DoorLeaf, SitePlan};
use crate::shape::{Shape, Solid};
use geometry::{Isometry, Rng, Rotation, Vector3};
use nalgebra::Translation3;
use std::f64::consts::TAU;

/// Share of the changed furniture that is removed.
const REMOVED_SHARE: f64 = 0.25;
/// Least distance by which the other changed furniture is moved, metres.
const MIN_SHIFT_M: f64 = 0.4;
/// Greatest distance by which it is moved, metres.
const MAX_SHIFT_M: f64 = 1.6;
/// Greatest angle by which it is turned, radians.
const MAX_TURN_RAD: f64 = 0.5;
/// Share of the doors that swing.
const SWUNG_SHARE: f64 = 0.5;
/// Least angle by which a door swings, in either direction, radians.
const MIN_SWING_RAD: f64 = 0.3;
/// Greatest angle by which a door swings, radians.
const MAX_SWING_RAD: f64 = 1.4;
/// Distance on both sides of a route that stays free, metres.
const ROUTE_CLEARANCE_M: f64 = 0.75;
/// Distance between the points of a route that are checked, metres.
const ROUTE_STEP_M: f64 = 0.2;

/// Moves or removes a share of the furniture, and swings doors.
pub(super) fn change(plan: &mut SitePlan, rng: &mut Rng, changed_share: f64) {
    let route_points = route_points(plan);
    let mut removed = vec![false; plan.solids.len()];
    for piece in plan.furniture.clone() {
        let (chosen, away, toward) =
            (rng.uniform() < changed_share, rng.range(MIN_SHIFT_M, MAX_SHIFT_M), rng.range(0.0, TAU));
        let (turn, stays) = (rng.range(-MAX_TURN_RAD, MAX_TURN_RAD), rng.uniform() >= REMOVED_SHARE);
        if !chosen {
            continue;
        }
        let shift = Vector3::new(away * toward.cos(), away * toward.sin(), 0.0);
        let moved = transform_piece(&plan.solids[piece.clone()], &shift, turn);
        if stays && moved.iter().all(|solid| is_free(&solid.shape, &route_points)) {
            plan.solids[piece].copy_from_slice(&moved);
        } else {
            removed[piece].fill(true);
        }
    }
    for leaf in plan.door_leaves.clone() {
        let (swings, sign) = (rng.uniform() < SWUNG_SHARE, if rng.uniform() < 0.5 { 1.0 } else { -1.0 });
        let swung = swung(plan, &leaf, sign * rng.range(MIN_SWING_RAD, MAX_SWING_RAD));
        if swings && swung.iter().all(|solid| is_free(&solid.shape, &route_points)) {
            plan.solids[leaf.solids].copy_from_slice(&swung);
        }
    }
    let kept_before = |end: usize| removed[..end].iter().filter(|gone| !**gone).count();
    for leaf in &mut plan.door_leaves {
        leaf.solids = kept_before(leaf.solids.start)..kept_before(leaf.solids.end);
    }
    let mut index = 0;
    plan.solids.retain(|_| {
        index += 1;
        !removed[index - 1]
    });
    // Their indices refer to the solids before the removal.
    plan.furniture.clear();
}

/// The solids of a door leaf that is turned about its hinge, radians.
pub(super) fn swung(plan: &SitePlan, leaf: &DoorLeaf, turn: f64) -> Vec<Solid> {
    let swing = rotation_about(&leaf.hinge, turn);
    let solids = plan.solids[leaf.solids.clone()].iter();
    solids.map(|solid| Solid { shape: solid.shape.transformed(&swing), ..*solid }).collect()
}

/// Whether a door leaf that is turned leaves all routes free.
pub(super) fn is_swing_free(plan: &SitePlan, leaf: &DoorLeaf, turn: f64) -> bool {
    let route_points = route_points(plan);
    swung(plan, leaf, turn).iter().all(|solid| is_free(&solid.shape, &route_points))
}

/// The solids of a piece, shifted, and turned about the middle of the piece.
fn transform_piece(piece: &[Solid], shift: &Vector3, turn: f64) -> Vec<Solid> {
    let bounds = piece.iter().map(|solid| solid.shape.bounds());
    let Some((least, most)) = bounds.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))) else { return Vec::new() };
    let motion = Translation3::from(*shift) * rotation_about(&((least + most) / 2.0), turn);
    piece.iter().map(|solid| Solid { shape: solid.shape.transformed(&motion), ..*solid }).collect()
}

/// A rotation about the vertical axis through a point.
pub(super) fn rotation_about(axis: &Vector3, turn: f64) -> Isometry {
    let turn = Rotation::from_euler_angles(0.0, 0.0, turn);
    Isometry::from_parts(Translation3::from(axis - turn * axis), turn)
}

/// Points along all routes, site frame x and y, metres.
fn route_points(plan: &SitePlan) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for route in &plan.routes {
        let mut from = [route.start.position.x, route.start.position.y];
        for to in &route.waypoints {
            let apart = (to[0] - from[0]).hypot(to[1] - from[1]);
            let steps = (apart / ROUTE_STEP_M).ceil().max(1.0) as usize;
            points.extend((0..=steps).map(|step| {
                let along = step as f64 / steps as f64;
                [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * along)
            }));
            from = *to;
        }
    }
    points
}

/// Whether a shape leaves all routes free, on every floor.
fn is_free(shape: &Shape, route_points: &[[f64; 2]]) -> bool {
    let (least, most) = shape.bounds();
    let within = |at: &[f64; 2]| {
        (0..2).all(|axis| {
            at[axis] >= least[axis] - ROUTE_CLEARANCE_M && at[axis] <= most[axis] + ROUTE_CLEARANCE_M
        })
    };
    !route_points.iter().any(within)
}
