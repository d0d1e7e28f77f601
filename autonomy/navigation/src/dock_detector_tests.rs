//! The detector of docks on scans of scenes in the plane: docks in all poses, partly hidden ones, and what only resembles one.

use crate::{DockDetection, DockDetector, DockMarker, DockNotFound};
use geometry::{Isometry, Rng, RngTree, Rotation, Vector3};
use proptest::prelude::*;
use std::f64::consts::TAU;

/// A wall seen from above.
type Segment = [[f64; 2]; 2];

fn pose(x: f64, y: f64, heading: f64) -> Isometry {
    let rotation = Rotation::from_euler_angles(0.0, 0.0, heading);
    Isometry::from_parts(Vector3::new(x, y, 0.0).into(), rotation)
}

fn at(pose: &Isometry, x: f64, y: f64) -> [f64; 2] {
    let point = pose * nalgebra::Point3::new(x, y, 0.0);
    [point.x, point.y]
}

/// The plates of a dock for a base docked in `pose`.
fn marker(pose: &Isometry) -> Vec<Segment> {
    let DockMarker { ridge_m, half_width_m, depth_m, .. } = DockMarker::default();
    let end = |side: f64| at(pose, -ridge_m - depth_m, side * half_width_m);
    [1.0, -1.0].map(|side| [at(pose, -ridge_m, 0.0), end(side)]).to_vec()
}

/// The body of a person.
fn body(x: f64, y: f64, radius_m: f64) -> Vec<Segment> {
    let corner = |index: i32| {
        let (sin, cos) = (TAU * f64::from(index) / 16.0).sin_cos();
        [x + radius_m * cos, y + radius_m * sin]
    };
    (0..16).map(|index| [corner(index), corner(index + 1)]).collect()
}

/// Distance along a ray to a segment.
fn hit(eye: [f64; 2], direction: [f64; 2], [a, b]: &Segment) -> Option<f64> {
    let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
    let denominator = direction[0] * ey - direction[1] * ex;
    let (ax, ay) = (a[0] - eye[0], a[1] - eye[1]);
    let range = (ax * ey - ay * ex) / denominator;
    let share = (ax * direction[1] - ay * direction[0]) / denominator;
    (denominator.abs() > 1e-12 && range > 0.0 && (0.0..=1.0).contains(&share)).then_some(range)
}

/// What a LiDAR sees: 200 columns, as many rings on the plates as a sensor of 1 degree has at its distance from the origin, and five sweeps.
fn scan(eye: [f64; 2], scene: &[Segment], seed: u64) -> Vec<[f64; 2]> {
    let mut rng: Rng = RngTree::new(seed).rng();
    let rings = (0.27 / (0.0175 * (eye[0] + 0.6).hypot(eye[1]))).clamp(3.0, 20.0) as usize;
    let mut points = Vec::new();
    for sweep in 0..5 {
        for column in 0..200 {
            // The standing robot sways a little.
            let bearing = TAU * f64::from(column) / 200.0 + 0.004 * (f64::from(sweep) - 2.0);
            let direction = [bearing.cos(), bearing.sin()];
            let ranges = scene.iter().filter_map(|segment| hit(eye, direction, segment));
            let Some(range) = ranges.min_by(f64::total_cmp) else { continue };
            for _ in 0..rings {
                let range = range + 0.01 * rng.normal();
                points.push([eye[0] + range * direction[0], eye[1] + range * direction[1]]);
            }
        }
    }
    points
}

/// Looks from 1.2 m ahead of the origin for a dock at the origin.
fn look(scene: &[Segment]) -> Result<DockDetection, DockNotFound> {
    DockDetector::default().detect(&scan([1.2, 0.1], scene, 1), &pose(0.0, 0.0, 0.0))
}

/// A wall behind the dock.
fn wall() -> Segment {
    [[-1.4, -4.0], [-1.4, 4.0]]
}

#[track_caller]
fn assert_found(
    found: Result<DockDetection, DockNotFound>,
    truth: &Isometry,
    position_m: f64,
    heading_rad: f64,
) {
    let found = found.unwrap_or_else(|reason| panic!("{reason:?} at {truth}"));
    let error = truth.inverse() * found.frame_from_dock;
    let (off_m, off_rad) = (error.translation.vector.norm(), error.rotation.angle());
    assert!(off_m < position_m && off_rad < heading_rad, "{off_m} m, {off_rad} rad, {found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn a_dock_is_found_wherever_it_was_pushed_to(
        x in -0.4..0.4, y in -0.4..0.4, heading in -0.22..0.22,
        ahead in 1.0..1.9, left in -0.25..0.25, seed in 0_u64..1_000,
        // The frame of the points may be any.
        fx in -50.0..50.0, fy in -50.0..50.0, turned in -3.0..3.0,
    ) {
        let (frame, truth) = (pose(fx, fy, turned), pose(x, y, heading));
        let mut scene = marker(&truth);
        scene.push(wall());
        let eye = at(&truth, ahead, left);
        let points: Vec<_> = scan(eye, &scene, seed).into_iter().map(|[x, y]| at(&frame, x, y)).collect();
        let found = DockDetector::default().detect(&points, &frame);
        // From afar few columns are on the plates, and their heading moves the place of the base with a lever of 0.7 m.
        let far = if ahead < 1.4 { 1.0 } else { 2.0 };
        assert_found(found, &(frame * truth), 0.018 * far, 0.02 * far);
        let deviation_m = found.map_or(0.0, |found| found.covariance[(1, 1)].sqrt());
        prop_assert!((0.0001..0.01).contains(&deviation_m));
    }
}

/// Walls, cabinets and people, but no dock. Some of these scenes do look like one: two walls may meet as the plates do.
#[test]
fn hardly_anything_else_looks_like_a_dock() {
    let found = (0..400).filter(|seed| {
        let mut rng = RngTree::new(*seed).rng();
        let mut scene = vec![wall()];
        for _ in 0..4 {
            let (x, y, heading) = (rng.range(-1.1, 0.2), rng.range(-0.8, 0.8), rng.range(0.0, TAU));
            let length_m = rng.range(0.1, 1.2);
            scene.push([[x, y], [x + length_m * heading.cos(), y + length_m * heading.sin()]]);
        }
        scene.extend(body(rng.range(-1.0, 0.2), rng.range(-0.6, 0.6), rng.range(0.08, 0.25)));
        look(&scene).is_ok()
    });
    let found: Vec<u64> = found.collect();
    assert!(found.len() <= 1, "{found:?}");
}

#[test]
fn a_dock_is_found_past_a_leg_and_not_if_half_of_it_is_hidden() {
    let truth = pose(0.1, -0.05, 0.1);
    let mut scene = marker(&truth);
    scene.extend(body(0.3, 0.25, 0.06));
    assert_found(look(&scene), &truth, 0.012, 0.03);
    let mut hidden = marker(&truth);
    hidden.push([[0.2, 0.06], [0.2, 0.8]]);
    assert_eq!(look(&hidden).err(), Some(DockNotFound::PartlyHidden));
}

#[test]
fn walls_corners_and_people_are_no_docks() {
    let corner = |angle_rad: f64, length_m: f64| -> Vec<Segment> {
        let ridge = [-0.6, 0.05];
        let end =
            |side: f64| [ridge[0] - length_m * angle_rad.sin(), ridge[1] + side * length_m * angle_rad.cos()];
        vec![[ridge, end(1.0)], [ridge, end(-1.0)]]
    };
    for (name, scene) in [
        ("a wall", vec![[[-0.65, -4.0], [-0.65, 4.0]]]),
        ("a board", vec![[[-0.65, -0.35], [-0.65, 0.35]]]),
        ("a corner", corner(0.79, 2.0)),
        ("a small corner", corner(0.79, 0.4)),
        ("a blunt corner of long walls", corner(0.52, 2.0)),
        ("a corner of a room", corner(-0.52, 1.0)),
        ("a person", body(-0.8, 0.0, 0.2)),
        ("two people", [body(-0.8, 0.22, 0.2), body(-0.8, -0.22, 0.2)].concat()),
        ("a tank", body(-1.0, 0.0, 0.4)),
    ] {
        assert_eq!(look(&scene).err(), Some(DockNotFound::NoMatch), "{name}");
    }
    assert_eq!(look(&[]).err(), Some(DockNotFound::FewPoints));
    assert_eq!(look(&[[[-9.0, -4.0], [-9.0, 4.0]]]).err(), Some(DockNotFound::FewPoints));
}

#[test]
fn two_docks_within_the_window_are_ambiguous_and_the_same_points_give_the_same_result() {
    let scene = [marker(&pose(0.0, 0.38, 0.0)), marker(&pose(0.0, -0.38, 0.0))].concat();
    assert_eq!(look(&scene).err(), Some(DockNotFound::Ambiguous));
    let scene = marker(&pose(0.2, 0.1, -0.1));
    assert_eq!(look(&scene), look(&scene));
    assert!(look(&marker(&pose(0.0, 0.9, 0.0))).is_err(), "outside the window");
}
