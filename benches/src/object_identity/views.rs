//! What a LiDAR sees of an object that stands free, from a few places along a straight walk past it.

use super::objects::ShapedObject;
use changes::{BoxFitConfig, UprightBox};
use geometry::{Isometry, Rng, RngTree, Rotation, Vector3, so3};
use nalgebra::Point3;
use sim::{Bvh, Solid};
use std::f64::consts::TAU;

/// The LiDAR of the simulated robot: height, elevations of the channels, noise of ranges.
const SENSOR_HEIGHT_M: f64 = 0.7;
const ELEVATIONS_DEG: std::ops::RangeInclusive<i32> = -16..=15;
const RANGE_NOISE_M: f64 = 0.01;
/// Columns of a sweep.
const COLUMNS: [u32; 4] = [250, 400, 1_000, 2_000];
/// Distance at which the walk passes, metres, and distance between two sweeps.
const PASSES_M: [f64; 2] = [1.2, 6.0];
const STEP_M: f64 = 2.0;
/// Errors of the poses of a sweep, metres and radians, as in the visits of the benchmark of changes.
const POSE_ERROR_M: f64 = 0.01;
const POSE_ERROR_RAD: f64 = 0.001;
/// Points lower than this above the ground do not belong to an object (`changes::ChangesConfig::ground_clearance_m`), metres.
const GROUND_M: f64 = 0.08;
/// Numbers of points of a view.
const POINTS: [usize; 2] = [30, 5_000];
/// Share of the views in which something hides a part of the object, and of those in which it lies on a side.
const HIDDEN_SHARE: f64 = 0.2;
const TIPPED_SHARE: f64 = 0.25;
/// Walks that are tried for a view.
const TRIES: usize = 20;

/// What one visit has of an object.
#[derive(Clone, Debug)]
pub struct ObjectView {
    /// Turned in any direction, as descriptors have to allow.
    pub points: Vec<[f32; 3]>,
    /// The sides of the box that stands upright, metres.
    pub size_m: [f64; 3],
}

/// Views of an object, as many as have enough points.
pub fn views(object: &ShapedObject, count: usize, tree: &RngTree) -> Vec<ObjectView> {
    let mut rng = tree.rng();
    (0..count).filter_map(|_| (0..TRIES).find_map(|_| view(object, &mut rng))).collect()
}

fn view(object: &ShapedObject, rng: &mut Rng) -> Option<ObjectView> {
    let side = (rng.uniform() * 4.0) as usize;
    let is_tipped = rng.uniform() < TIPPED_SHARE;
    let object = if is_tipped { object.tipped(side) } else { object.clone() };
    let heading = Isometry::from_parts(
        Vector3::zeros().into(),
        Rotation::from_euler_angles(0.0, 0.0, rng.uniform() * TAU),
    );
    let turned = |solid: &Solid| Solid { shape: solid.shape.transformed(&heading), ..*solid };
    let bvh = Bvh::new(&object.solids.iter().map(turned).collect::<Vec<_>>());
    let reach_m = object.size_m[0].hypot(object.size_m[1]) / 2.0 + 0.1;
    let passes_m = reach_m + rng.range(PASSES_M[0], PASSES_M[1]);
    let (columns, sweeps) = (COLUMNS[(rng.uniform() * 4.0) as usize % 4], 1 + (rng.uniform() * 4.0) as usize);
    let first_m = rng.range(-4.0, 2.0);
    let mut points = Vec::new();
    for sweep in 0..sweeps {
        let at = Vector3::new(first_m + STEP_M * sweep as f64, -passes_m, SENSOR_HEIGHT_M);
        cast(&bvh, &at, reach_m, columns, rng, &mut points);
    }
    points.retain(|point: &Vector3| point.z > GROUND_M);
    if rng.uniform() < HIDDEN_SHARE {
        hide(&mut points, rng);
    }
    let step = points.len().div_ceil(POINTS[1]).max(1);
    let upright: Vec<[f32; 3]> = points.iter().step_by(step).map(|at| at.map(|x| x as f32).into()).collect();
    if upright.len() < POINTS[0] {
        return None;
    }
    let size_m = UprightBox::around(&upright, &BoxFitConfig::default())?.down_to(0.0).size_m;
    let turn = so3::exp(&(Vector3::new(rng.normal(), rng.normal(), rng.normal()) * 2.0));
    let anywhere = |point: &[f32; 3]| (turn * Vector3::from(point.map(f64::from))).map(|x| x as f32).into();
    Some(ObjectView { points: upright.iter().map(anywhere).collect(), size_m })
}

/// The returns of a sweep from the object.
fn cast(bvh: &Bvh, at: &Vector3, reach_m: f64, columns: u32, rng: &mut Rng, points: &mut Vec<Vector3>) {
    let mut random = |sigma: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * sigma;
    let error = Isometry::from_parts(random(POSE_ERROR_M).into(), so3::exp(&random(POSE_ERROR_RAD)));
    let (toward, phase) = ((-at.y).atan2(-at.x), rng.uniform());
    let half_rad = (reach_m / at.xy().norm()).min(1.0).asin();
    let step_rad = TAU / f64::from(columns);
    let steps = (half_rad / step_rad).ceil() as i64;
    for column in -steps..=steps {
        let azimuth = toward + (column as f64 + phase) * step_rad;
        for elevation_deg in ELEVATIONS_DEG {
            let (up, flat) = f64::from(elevation_deg).to_radians().sin_cos();
            let along = Vector3::new(flat * azimuth.cos(), flat * azimuth.sin(), up);
            if let Some((range_m, _)) = bvh.first_hit(at, &along, 30.0) {
                let offset = along * (range_m + RANGE_NOISE_M * rng.normal());
                points.push(at + (error * Point3::from(offset)).coords);
            }
        }
    }
}

/// Takes away what is on one side of an upright plane: at most a third of the width.
fn hide(points: &mut Vec<Vector3>, rng: &mut Rng) {
    let toward = rng.uniform() * TAU;
    let along = |point: &Vector3| point.x * toward.cos() + point.y * toward.sin();
    let ends = points
        .iter()
        .map(along)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
    let limit = ends[0] + (ends[1] - ends[0]) * rng.range(0.67, 1.0);
    points.retain(|point| along(point) <= limit);
}
