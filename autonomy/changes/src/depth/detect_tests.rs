//! A table with boxes that a simulated depth camera sees twice, with the noise of such cameras.

use super::*;
use crate::Change;
use geometry::RngTree;
use nalgebra::{Point3, UnitQuaternion};

const SIZE_PX: [usize; 2] = [320, 240];
const FOCAL_PX: f64 = 262.5;

/// A box on the table with its colour.
type Thing = (UprightBox, [u8; 3]);

const RED: [u8; 3] = [180, 30, 30];
const WHITE: [u8; 3] = [220, 220, 220];
const WOOD: [u8; 3] = [170, 140, 110];

fn thing(x: f64, y: f64, bottom_m: f64, size_m: [f64; 3], yaw_rad: f64, colour: [u8; 3]) -> Thing {
    (UprightBox { centre_m: Vector3::new(x, y, bottom_m + size_m[2] / 2.0), size_m, yaw_rad }, colour)
}

/// The camera 0.6 m above the table, which looks down at it by 35 degrees. The table's second axis points away from the camera.
fn table_from_camera() -> Isometry {
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -(90.0_f64 + 35.0).to_radians());
    Isometry::from_parts(Vector3::new(0.0, 0.0, 0.6).into(), down)
}

fn image(things: &[Thing], seed: u64) -> DepthImage {
    let table_from_camera = table_from_camera();
    let mut rng = RngTree::new(seed).child("camera").rng();
    let (mut points, mut colours) = (Vec::new(), Vec::new());
    for pixel in 0..SIZE_PX[0] * SIZE_PX[1] {
        let at = |axis: usize, pixel: usize| (pixel as f64 - (SIZE_PX[axis] as f64 - 1.0) / 2.0) / FOCAL_PX;
        let ray = Vector3::new(at(0, pixel % SIZE_PX[0]), at(1, pixel / SIZE_PX[0]), 1.0);
        let start = table_from_camera.translation.vector;
        let along = table_from_camera.rotation * ray;
        let table_m = if along.z < -1e-6 { -start.z / along.z } else { f64::INFINITY };
        let met = things
            .iter()
            .filter_map(|(place, colour)| {
                let [enters, _] = place.crossed_by(&start, &along)?;
                Some((enters, *colour))
            })
            .fold((table_m, WOOD), |nearest, met| if met.0 < nearest.0 { met } else { nearest });
        let depth_m = met.0 + 0.001425 * met.0 * met.0 * rng.normal();
        let is_seen = met.0 < 3.0;
        points.push(if is_seen { (ray * depth_m).map(|at| at as f32).into() } else { [f32::NAN; 3] });
        colours.push(met.1);
    }
    DepthImage::new(SIZE_PX, points, colours).expect("a depth image")
}

fn compare(before: &[Thing], after: &[Thing]) -> Vec<(Change, UprightBox)> {
    let found = detect_depth_changes(&image(before, 1), &image(after, 2), &DepthChangesConfig::default())
        .expect("compared");
    // From the frame of the plane to that of the table: the camera sees both.
    let table_from_support = table_from_camera() * found.camera_from_support;
    assert!((table_from_support.translation.z).abs() < 0.003, "{table_from_support:?}");
    let on_table = |place: UprightBox| UprightBox {
        centre_m: (table_from_support * Point3::from(place.centre_m)).coords,
        ..place
    };
    let mut objects: Vec<(Change, UprightBox)> = found
        .changes
        .objects
        .iter()
        .map(|object| {
            let change = match object.change {
                Change::Moved { from } => Change::Moved { from: on_table(from) },
                other => other,
            };
            (change, on_table(object.place))
        })
        .collect();
    objects.sort_by(|a, b| a.1.centre_m.x.total_cmp(&b.1.centre_m.x));
    objects
}

/// Whether a found box is at a thing: the back of it is not seen, so that its size is not compared.
fn is_at(found: &UprightBox, (expected, _): &Thing) -> bool {
    (found.centre_m - expected.centre_m).norm() < 0.03
}

#[test]
fn things_that_appeared_were_removed_and_moved_on_a_table_are_found_and_nothing_else_is() {
    let stays = thing(0.25, 0.9, 0.0, [0.12, 0.1, 0.15], 0.3, RED);
    let gone = thing(-0.25, 0.8, 0.0, [0.08, 0.06, 0.1], 0.5, WHITE);
    let new = thing(0.0, 0.6, 0.0, [0.06, 0.05, 0.05], 0.2, RED);
    let (from, to) = (
        thing(-0.1, 1.1, 0.0, [0.1, 0.06, 0.12], 0.1, [40, 60, 160]),
        thing(0.15, 0.55, 0.0, [0.1, 0.06, 0.12], 0.1, [40, 60, 160]),
    );
    let found = compare(&[stays, gone, from], &[stays, new, to]);
    assert_eq!(found.len(), 3, "{found:#?}");
    assert!(matches!(found[0].0, Change::Removed) && is_at(&found[0].1, &gone), "{found:#?}");
    assert!(matches!(found[1].0, Change::Appeared) && is_at(&found[1].1, &new), "{found:#?}");
    assert!(matches!(found[2].0, Change::Moved { from: was } if is_at(&was, &from)), "{found:#?}");
    assert!(is_at(&found[2].1, &to), "{found:#?}");
    assert_eq!(compare(&[stays, gone], &[stays, gone]), [], "noise is no change");
}

#[test]
fn two_things_that_touch_are_two_if_their_colours_differ() {
    let below = thing(0.0, 0.7, 0.0, [0.24, 0.24, 0.08], 0.0, RED);
    let above = |colour| thing(0.0, 0.7, 0.08, [0.08, 0.08, 0.1], 0.0, colour);
    let found = compare(&[], &[below, above(WHITE)]);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert_eq!(compare(&[], &[below, above(RED)]).len(), 1, "one colour is one thing");
}

#[test]
fn what_is_no_image_of_a_table_or_of_another_camera_is_refused() {
    let config = DepthChangesConfig::default();
    let table = image(&[], 1);
    let nothing = vec![[f32::NAN; 3]; SIZE_PX[0] * SIZE_PX[1]];
    assert_eq!(
        DepthImage::new(SIZE_PX, nothing, Vec::new()),
        Err(DepthImageError::TooFewReturns { returns: 0 })
    );
    assert_eq!(DepthImage::new(SIZE_PX, Vec::new(), Vec::new()), Err(DepthImageError::SizeDiffers));
    let mut rng = RngTree::new(3).child("cloud").rng();
    let cloud: Vec<[f32; 3]> = (0..SIZE_PX[0] * SIZE_PX[1])
        .map(|_| [rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(0.5, 2.0)].map(|at| at as f32))
        .collect();
    assert_eq!(
        DepthImage::new(SIZE_PX, cloud, Vec::new()),
        Err(DepthImageError::NoPinholeCamera),
        "points in no order"
    );
    let shifted: Vec<[f32; 3]> = (0..table.len())
        .map(|pixel| {
            let [x, y, z] = table.raw_point(pixel);
            [x + 0.02 * z, y, z]
        })
        .collect();
    let other = DepthImage::new(SIZE_PX, shifted, Vec::new()).expect("a camera with another centre");
    assert_eq!(detect_depth_changes(&table, &other, &config), Err(DepthImageError::CamerasDiffer));
    let mut ball = Vec::new();
    for pixel in 0..table.len() {
        let [x, y, z] = table.raw_point(pixel);
        let (x, y) = (x / z, y / z);
        let range_m = 1.0 + 0.8 * (9.0 * x).sin() * (9.0 * y).cos();
        ball.push([x * range_m, y * range_m, range_m]);
    }
    let waves = DepthImage::new(SIZE_PX, ball, Vec::new()).expect("a depth image");
    assert_eq!(detect_depth_changes(&waves, &waves, &config), Err(DepthImageError::NoSupport));
}
