//! A synthetic site for tests: vertical walls, given from above, and keyframes of a LiDAR with 21 beams that stands among them.

use geometry::{Isometry, Rotation, Vector3, so3};
use mapping::KeyframeDescriptor;

/// Walls seen from above, each from one corner to another, metres.
pub(crate) type Walls = Vec<[[f64; 2]; 2]>;

/// A corridor along x with a room on its left at 4 m and at 24 m, each with a door 1 m wide. Both rooms are alike, so that no scan from inside
/// tells which one it is. A box stands in the corridor 8 m beyond the second door, and more of them farther on, so that every scan there is
/// unique.
pub(crate) fn rooms() -> Walls {
    let mut walls =
        vec![[[-10.0, -1.5], [44.0, -1.5]], [[-10.0, -1.5], [-10.0, 1.5]], [[44.0, -1.5], [44.0, 1.5]]];
    let doors = [4.0, 24.0];
    let mut from = -10.0;
    for door in doors {
        walls.push([[from, 1.5], [door - 0.5, 1.5]]);
        from = door + 0.5;
        let [west, east, north] = [door - 3.0, door + 5.0, 8.5];
        walls.extend([
            [[west, 1.7], [west, north]],
            [[east, 1.7], [east, north]],
            [[west, north], [east, north]],
        ]);
        walls.extend([[[west, 1.7], [door - 0.5, 1.7]], [[door + 0.5, 1.7], [east, 1.7]]]);
        for side in [-0.5, 0.5] {
            walls.push([[door + side, 1.5], [door + side, 1.7]]);
        }
        walls.push([[east - 2.0, north - 1.0], [east - 1.0, north - 1.0]]);
    }
    walls.push([[from, 1.5], [44.0, 1.5]]);
    // West side, east side, front, and the wall behind of each box.
    let boxes = [
        (31.0, 32.0, 0.3, -1.5),
        (34.0, 34.5, -0.4, -1.5),
        (36.0, 36.8, 1.1, 1.5),
        (38.0, 39.0, -0.2, -1.5),
        (40.2, 40.8, 1.0, 1.5),
        (42.0, 42.6, -0.5, -1.5),
    ];
    for (west, east, front, wall) in boxes {
        walls.extend([
            [[west, wall], [west, front]],
            [[east, wall], [east, front]],
            [[west, front], [east, front]],
        ]);
    }
    walls
}

/// Distance from a point to the nearest wall along a ray, metres.
fn range(walls: &Walls, from: [f64; 2], along: [f64; 2]) -> Option<f64> {
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let intersect = |[a, b]: &[[f64; 2]; 2]| {
        let (wall, offset) = ([b[0] - a[0], b[1] - a[1]], [a[0] - from[0], a[1] - from[1]]);
        let determinant = cross(along, wall);
        let (range, share) = (cross(offset, wall) / determinant, cross(offset, along) / determinant);
        (range > 0.0 && (0.0..=1.0).contains(&share)).then_some(range)
    };
    walls.iter().filter_map(intersect).min_by(f64::total_cmp)
}

/// A keyframe among walls: they reach 2 m above the LiDAR, and the floor lies half a metre below the base.
pub(crate) fn room_keyframe(walls: &Walls, x: f64, y: f64, yaw: f64) -> (Isometry, KeyframeDescriptor) {
    let pose = at(x, y, yaw);
    let mut points = Vec::new();
    for column in 0..720 {
        let (sin, cos) = (f64::from(column) * 0.5).to_radians().sin_cos();
        let ray = pose.rotation * Vector3::new(cos, sin, 0.0);
        let Some(range) = range(walls, [x, y], [ray.x, ray.y]) else { continue };
        for row in -10..=10 {
            let up = (f64::from(row) * 2.0).to_radians().tan();
            let range = if up * range < -0.5 { -0.5 / up } else { range };
            points.push([range * cos, range * sin, range * up].map(|c| c as f32));
        }
    }
    (pose, KeyframeDescriptor::of_cloud(&points, &Rotation::identity(), [0.0; 3]))
}

/// A map of both rooms and the corridor.
pub(crate) fn rooms_keyframes() -> Vec<(Isometry, KeyframeDescriptor)> {
    let walls = rooms();
    let mut keyframes = Vec::new();
    for step in 0..34 {
        keyframes.push(room_keyframe(&walls, -8.0 + 1.5 * f64::from(step), 0.6, 0.0));
    }
    for door in [4.0, 24.0] {
        for step in 0..5 {
            keyframes.push(room_keyframe(&walls, door, 1.0 + 1.3 * f64::from(step), 1.57));
        }
    }
    keyframes
}

/// A pose on the floor of the site.
pub(crate) fn at(x: f64, y: f64, yaw: f64) -> Isometry {
    Isometry::from_parts(Vector3::new(x, y, 0.0).into(), so3::exp(&(Vector3::z() * yaw)))
}
