//! For tests: small worlds made of boxes with a LiDAR in them, and odometry steps.

use crate::submap::{KeyframeCloud, Submap};
use crate::{KeyframePolicy, PoseGraphEdge, UncertainPose};
use geometry::{Isometry, Matrix6, RngTree, Vector3, Vector6};
use points::Downsampler;
use std::sync::Arc;
use vocab::KeyframeId;

/// Axis-aligned boxes: least and greatest corners.
pub type World = Vec<[[f64; 3]; 2]>;

/// Keyframes of a robot for tests.
pub const KEYFRAMES: KeyframePolicy = KeyframePolicy { distance_m: 1.0, rotation_rad: 0.7 };

/// Where the sensor is on the base.
pub const SENSOR: [f32; 3] = [0.0, 0.0, 0.3];

/// Four walls, floor and ceiling round `[x0, y0]..[x1, y1]`; the base walks 0.5 m over the floor, at z = 0.
pub fn room(low: [f64; 2], high: [f64; 2]) -> World {
    let ([x0, y0], [x1, y1]) = (low, high);
    vec![
        [[x0 - 1.0, y0 - 1.0, -0.7], [x1 + 1.0, y1 + 1.0, -0.5]],
        [[x0 - 1.0, y0 - 1.0, 2.5], [x1 + 1.0, y1 + 1.0, 2.7]],
        [[x0 - 0.2, y0, -0.5], [x0, y1, 2.5]],
        [[x1, y0, -0.5], [x1 + 0.2, y1, 2.5]],
        [[x0, y0 - 0.2, -0.5], [x1, y0, 2.5]],
        [[x0, y1, -0.5], [x1, y1 + 0.2, 2.5]],
    ]
}

/// A room of 10 m by 8 m about the origin with a column, a cupboard and a bench, by which its corners differ.
pub fn furnished() -> World {
    let mut world = room([-5.0, -4.0], [5.0, 4.0]);
    world.push([[1.8, -2.2, -0.5], [2.3, -1.7, 2.5]]);
    world.push([[-4.9, 2.0, -0.5], [-2.6, 2.7, 1.5]]);
    world.push([[3.6, 1.0, -0.5], [4.2, 3.4, 0.3]]);
    world
}

/// A corridor along x with nothing in it, longer than the LiDAR sees.
pub fn corridor() -> World {
    room([-80.0, -1.2], [80.0, 1.2])
}

/// A ring of corridors, 2.4 m wide, round a block of 12 m by 8 m, with cupboards at irregular places.
pub fn ring() -> World {
    let mut world = room([-8.4, -6.4], [8.4, 6.4]);
    world.push([[-6.0, -4.0, -0.5], [6.0, 4.0, 2.5]]);
    for (x, y) in [(-8.4, -3.0), (-8.4, 1.2), (7.9, 2.5), (7.9, -1.0)] {
        world.push([[x, y, -0.5], [x + 0.5, y + 0.9, 1.8]]);
    }
    for (x, y) in [(-4.0, 5.9), (0.7, 5.9), (3.1, -6.4), (-2.2, -6.4), (5.0, 5.9)] {
        world.push([[x, y, -0.5], [x + 1.1, y + 0.5, 1.4]]);
    }
    world
}

/// One pose each metre once round the ring, `aside` metres to the left of the middle of the corridors.
pub fn ring_poses(aside: f64) -> Vec<Isometry> {
    let corners = [[-7.2, -5.2], [7.2, -5.2], [7.2, 5.2], [-7.2, 5.2]];
    let mut poses = Vec::new();
    for leg in 0..4 {
        let ([x0, y0], [x1, y1]): ([f64; 2], [f64; 2]) = (corners[leg], corners[(leg + 1) % 4]);
        let length = (x1 - x0).hypot(y1 - y0);
        let yaw = (y1 - y0).atan2(x1 - x0);
        for step in 0..length.round() as usize {
            let share = step as f64 / length.round();
            let (x, y) = (x0 + share * (x1 - x0), y0 + share * (y1 - y0));
            poses.push(at(x - aside * yaw.sin(), y + aside * yaw.cos(), yaw));
        }
    }
    poses
}

/// What a LiDAR of 32 rings and 360 columns sees, base frame, with a centimetre of noise.
pub fn scan(world: &World, world_from_base: &Isometry, seed: u64) -> Vec<[f32; 3]> {
    let mut rng = RngTree::new(seed).child("scan").rng();
    let sensor = Vector3::from(SENSOR.map(f64::from));
    let eye = world_from_base * nalgebra::Point3::from(sensor);
    let mut points = Vec::new();
    for ring in -16..16 {
        for column in 0..360 {
            let (sin, cos) = (f64::from(column) + 0.5).to_radians().sin_cos();
            let tangent = (f64::from(ring) + 0.5).to_radians().tan();
            let ray = Vector3::new(cos, sin, tangent).normalize();
            let Some(range) = cast(world, &eye.coords, &(world_from_base.rotation * ray)) else { continue };
            let point = sensor + ray * (range + 0.01 * rng.normal());
            points.push([point.x as f32, point.y as f32, point.z as f32]);
        }
    }
    points
}

/// Range to the first box within 60 m.
fn cast(world: &World, from: &Vector3, along: &Vector3) -> Option<f64> {
    let hit = |[low, high]: &[[f64; 3]; 2]| {
        let (mut enter, mut leave) = (0.0_f64, 60.0_f64);
        for axis in 0..3 {
            let [a, b] = [low[axis], high[axis]].map(|bound| (bound - from[axis]) / along[axis]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        (enter > 0.0 && enter < leave).then_some(enter)
    };
    world.iter().filter_map(hit).min_by(f64::total_cmp)
}

/// The submap of the first of some poses, seen from all of them.
pub fn submap(world: &World, poses: &[Isometry], seed: u64) -> Submap {
    let mut downsampler = Downsampler::default();
    let members = (seed..).zip(poses).map(|(seed, pose)| {
        let cloud = KeyframeCloud::new(&scan(world, pose, seed), SENSOR, &mut downsampler);
        let relative = UncertainPose { pose: poses[0].inverse() * pose, covariance: Matrix6::zeros() };
        (relative, Arc::new(cloud))
    });
    Submap::new(members.collect(), 0)
}

/// A level pose.
pub fn at(x: f64, y: f64, yaw: f64) -> Isometry {
    Isometry::new(Vector3::new(x, y, 0.0), Vector3::z() * yaw)
}

/// An edge of those deviations, radians and metres.
pub fn edge(from: u32, to: u32, pose: Isometry, (turn, place): (f64, f64)) -> PoseGraphEdge {
    let [turn, place] = [turn, place].map(|deviation: f64| deviation.powi(-2));
    let information = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, place, place, place));
    PoseGraphEdge { from: KeyframeId(from), to: KeyframeId(to), from_from_to: pose, information }
}

/// One metre ahead, turned by `yaw` radians, with a translation deviation of `deviation_m` and a larger one about the vertical.
pub fn step(yaw: f64, deviation_m: f64) -> UncertainPose {
    let pose = Isometry::new(Vector3::new(1.0, 0.0, 0.0), Vector3::z() * yaw);
    let variances = Vector6::new(1e-6, 1e-6, 4e-6, 1.0, 1.0, 1.0);
    let scale = Vector6::new(1.0, 1.0, 1.0, deviation_m, deviation_m, deviation_m).map(|v| v * v);
    UncertainPose { pose, covariance: Matrix6::from_diagonal(&variances.component_mul(&scale)) }
}

/// Whether two uncertain poses are the same but for rounding.
pub fn near(a: &UncertainPose, b: &UncertainPose) -> bool {
    geometry::se3::local(&a.pose, &b.pose).norm() < 1e-9 && (a.covariance - b.covariance).norm() < 1e-9
}
