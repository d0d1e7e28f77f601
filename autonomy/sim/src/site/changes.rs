//! What changes in a site from one day to another.

use super::Plan;
use crate::shape::{Shape, Solid};
use geometry::{Isometry, Rng, Rotation, Vector3};
use nalgebra::Translation3;
use std::f64::consts::TAU;

/// Of what is moved, such a share is gone.
const GONE: f64 = 0.25;
/// The rest is moved so far, metres, and turned by as much as this, radians.
const MOVED: (f64, f64) = (0.4, 1.6);
const TURNED: f64 = 0.5;
/// Doors swing by so much, either way, radians; such a share of them.
const SWUNG: (f64, f64) = (0.3, 1.4);
const SWINGING: f64 = 0.5;
/// Routes stay free for so much on either side, metres, and are looked at so often.
const FREE: f64 = 0.75;
const LOOKED_AT: f64 = 0.2;

/// Moves such a share of the furniture, takes some of it away, and swings doors.
pub(super) fn change(plan: &mut Plan, rng: &mut Rng, share: f64) {
    let ways = ways(plan);
    let mut gone = vec![false; plan.solids.len()];
    for piece in plan.furniture.clone() {
        let (chosen, away, toward) =
            (rng.uniform() < share, rng.range(MOVED.0, MOVED.1), rng.range(0.0, TAU));
        let (turn, stays) = (rng.range(-TURNED, TURNED), rng.uniform() >= GONE);
        if !chosen {
            continue;
        }
        let shift = Vector3::new(away * toward.cos(), away * toward.sin(), 0.0);
        let moved = moved(&plan.solids[piece.clone()], &shift, turn);
        if stays && moved.iter().all(|solid| is_free(&solid.shape, &ways)) {
            plan.solids[piece].copy_from_slice(&moved);
        } else {
            gone[piece].fill(true);
        }
    }
    for (leaf, hinge) in plan.leaves.clone() {
        let (swings, way) = (rng.uniform() < SWINGING, if rng.uniform() < 0.5 { 1.0 } else { -1.0 });
        let swing = about(&hinge, way * rng.range(SWUNG.0, SWUNG.1));
        let shape = plan.solids[leaf].shape.moved(&swing);
        if swings && is_free(&shape, &ways) {
            plan.solids[leaf].shape = shape;
        }
    }
    let mut index = 0;
    plan.solids.retain(|_| {
        index += 1;
        !gone[index - 1]
    });
    // They number solids that are no more.
    plan.furniture.clear();
    plan.leaves.clear();
}

/// A piece shifted, and turned about its own middle.
fn moved(piece: &[Solid], shift: &Vector3, turn: f64) -> Vec<Solid> {
    let bounds = piece.iter().map(|solid| solid.shape.bounds());
    let Some((least, most)) = bounds.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1))) else { return Vec::new() };
    let motion = Translation3::from(*shift) * about(&((least + most) / 2.0), turn);
    piece.iter().map(|solid| Solid { shape: solid.shape.moved(&motion), ..*solid }).collect()
}

/// A turn about an upright axis.
fn about(axis: &Vector3, turn: f64) -> Isometry {
    let turn = Rotation::from_euler_angles(0.0, 0.0, turn);
    Isometry::from_parts(Translation3::from(axis - turn * axis), turn)
}

/// Places along all routes.
fn ways(plan: &Plan) -> Vec<[f64; 2]> {
    let mut ways = Vec::new();
    for route in &plan.routes {
        let mut from = [route.start.position.x, route.start.position.y];
        for to in &route.waypoints {
            let apart = (to[0] - from[0]).hypot(to[1] - from[1]);
            let steps = (apart / LOOKED_AT).ceil().max(1.0) as usize;
            ways.extend((0..=steps).map(|step| {
                let along = step as f64 / steps as f64;
                [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * along)
            }));
            from = *to;
        }
    }
    ways
}

/// Whether a shape stands in nobody's way, on whatever floor.
fn is_free(shape: &Shape, ways: &[[f64; 2]]) -> bool {
    let (least, most) = shape.bounds();
    let within =
        |at: &[f64; 2]| (0..2).all(|axis| at[axis] >= least[axis] - FREE && at[axis] <= most[axis] + FREE);
    !ways.iter().any(within)
}

#[cfg(test)]
mod tests {
    use super::super::{Site, SiteName};

    #[test]
    fn another_day_differs_and_is_the_same_for_the_same_seed() {
        let usual = Site::new(SiteName::B1);
        let (one, again, other) = (
            Site::on_another_day(SiteName::B1, 5, 0.25),
            Site::on_another_day(SiteName::B1, 5, 0.25),
            Site::on_another_day(SiteName::B1, 6, 0.25),
        );
        assert_eq!(one.solids(), again.solids());
        assert!(one.solids() != usual.solids() && one.solids() != other.solids());
        let kept = one.solids().iter().filter(|solid| usual.solids().contains(solid)).count();
        let share = kept as f64 / usual.solids().len() as f64;
        assert!((0.6..0.99).contains(&share), "{share} of all solids are where they were");
    }
}
