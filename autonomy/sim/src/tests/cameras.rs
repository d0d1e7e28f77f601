//! Pictures of the simulated cameras.

use super::{quiet, site_from_base};
use crate::{CameraConfig, Face, Fixture, SimConfig, SimulatedSite, Simulator, SiteName, Start, off_centre};
use geometry::{Isometry, Vector3};
use nalgebra::Point3;
use std::sync::Arc;
use vocab::{CameraAim, Vec3};

/// A robot that stands `away_m` in front of a fixture, turned by `turn` to the left of it, and the aim at the middle of the plate by the true pose.
pub(super) fn in_front_of(
    site: impl Into<Arc<SimulatedSite>>,
    pick: impl Fn(&Fixture) -> bool,
    away_m: f64,
    zoom: f64,
    turn: f64,
) -> (Simulator, CameraAim, Fixture) {
    let site: Arc<SimulatedSite> = site.into();
    let scene = Simulator::new(quiet(Arc::clone(&site))).camera_scene();
    let fixture = scene.fixtures().iter().find(|fixture| pick(fixture)).unwrap().clone();
    let plate = fixture.site_from_plate.translation.vector;
    let outward = fixture.site_from_plate.rotation * Vector3::z();
    let feet = plate + outward * away_m;
    let start = Start {
        position: Vec3::new(feet.x, feet.y, feet.z - 1.0),
        yaw: (-outward.y).atan2(-outward.x) + turn,
    };
    let mut simulator = Simulator::new(SimConfig { start: Some(start), ..quiet(site) });
    simulator.advance(simulator.now() + vocab::Span::from_millis(50), &mut Vec::new());
    let aim = aim_at(&simulator, &plate, zoom);
    (simulator, aim, fixture)
}

fn aim_at(simulator: &Simulator, target: &Vector3, zoom: f64) -> CameraAim {
    let base_from_site = site_from_base(&simulator.truth()).inverse();
    simulator.cameras().aim_at(&(base_from_site * Point3::from(*target)).coords, zoom)
}

/// Mean of the three colours of a pixel.
fn brightness(image: &crate::CameraImage, [x, y]: [u32; 2]) -> f64 {
    let first = 3 * (y * image.width_px + x) as usize;
    image.rgb[first..first + 3].iter().map(|byte| f64::from(*byte)).sum::<f64>() / 3.0
}

#[test]
fn a_target_that_is_aimed_at_is_in_the_middle_of_the_picture() {
    let config = CameraConfig::default();
    for target in [Vector3::new(2.0, 0.7, 0.9), Vector3::new(1.0, -2.0, -0.2), Vector3::new(-1.5, 1.0, 1.2)] {
        let aim = config.aim_at(&target, 4.0);
        let camera_from_base: Isometry = config.base_from_camera(&aim).inverse();
        let point = (camera_from_base * Point3::from(target)).coords;
        let intrinsics = config.intrinsics(aim.zoom);
        let [x, y] = intrinsics.project(&point).unwrap();
        assert!((x - 320.0).abs() < 1e-6 && (y - 240.0).abs() < 1e-6, "{x} {y}");
        // What is above the target is above it in the picture, and what is to its left is to its left.
        let above = (camera_from_base * Point3::from(target + Vector3::z() * 0.1)).coords;
        assert!(intrinsics.project(&above).unwrap()[1] < 240.0);
        let left = (camera_from_base * Point3::from(target + Vector3::z().cross(&target) * 0.1)).coords;
        assert!(intrinsics.project(&left).unwrap()[0] < 320.0);
    }
}

#[test]
fn the_needle_of_a_gauge_can_be_read_from_its_picture() {
    let pressure = |fixture: &Fixture| matches!(fixture.face, Face::Gauge { unit: "bar", .. });
    let (mut simulator, aim, fixture) = in_front_of(SiteName::B1, pressure, 1.6, 8.0, 0.3);
    let image = simulator.picture(&aim);
    let site_from_base = site_from_base(&simulator.truth());
    let value = needle_value(&image, &fixture, &site_from_base, simulator.cameras(), &aim);
    let Face::Gauge { reading, .. } = fixture.face else { panic!() };
    let expected = reading.at(simulator.elapsed().secs_f64());
    assert!((value - expected).abs() < 0.2, "read {value:.2}, true {expected:.2}");
}

/// The value that the needle of a gauge shows in a picture.
pub(super) fn needle_value(
    image: &crate::CameraImage,
    fixture: &Fixture,
    site_from_base: &Isometry,
    cameras: &CameraConfig,
    aim: &CameraAim,
) -> f64 {
    let Face::Gauge { min, max, .. } = fixture.face else { panic!() };
    // The middle of the dial is above the middle of the plate; the needle is the only thing that is red.
    let reds: Vec<[f64; 2]> = (0..image.height_px)
        .flat_map(|y| (0..image.width_px).map(move |x| [x, y]))
        .filter(|[x, y]| {
            let first = 3 * (y * image.width_px + x) as usize;
            let [r, g, b] = [0, 1, 2].map(|i| f64::from(image.rgb[first + i]));
            r > 70.0 && r > 1.8 * g && r > 1.8 * b
        })
        .map(|[x, y]| [f64::from(x), f64::from(y)])
        .collect();
    assert!(reds.len() > 100, "{} red pixels", reds.len());
    // Its tip is farthest from the middle of all red pixels, on the long side: the hub is the densest place.
    let truth = site_from_base * cameras.base_from_camera(aim);
    let dial = fixture.site_from_plate * Point3::new(0.0, 0.035, 0.0);
    let hub = cameras.intrinsics(aim.zoom).project(&(truth.inverse() * dial).coords).unwrap();
    let away = |px: &[f64; 2]| (px[0] - hub[0]).hypot(px[1] - hub[1]);
    let tip = reds.iter().max_by(|a, b| away(a).total_cmp(&away(b))).unwrap();
    let angle = (tip[0] - hub[0]).atan2(hub[1] - tip[1]);
    min + (max - min) * (angle / 4.712_389 + 0.5)
}

/// The letter that fits best to the picture of a place on a plate. `at`: number of the letter in its line; `up`: height of the line above the middle, metres.
fn read_letter(dark: &impl Fn([f32; 2]) -> f64, at: f32, count: f32, up: f32) -> char {
    let middle = (at + 0.5 - 0.5 * count) * 0.0212;
    let places: Vec<[f32; 2]> = (0..16)
        .flat_map(|x| (0..16).map(move |y| [(x as f32 - 7.5) * 0.001, (y as f32 - 7.5) * 0.0016]))
        .collect();
    let seen: Vec<f64> = places.iter().map(|[x, y]| dark([middle + x, up + y])).collect();
    let mean = seen.iter().sum::<f64>() / seen.len() as f64;
    let likeness = |letter: char| {
        let ink: Vec<f64> = places
            .iter()
            .map(|at| f64::from(crate::camera::faces::text(&letter.to_string(), *at, 1.0)))
            .collect();
        let ink_mean = ink.iter().sum::<f64>() / ink.len() as f64;
        let product: f64 = ink.iter().zip(&seen).map(|(a, b)| (a - ink_mean) * (b - mean)).sum();
        let norm: f64 = ink.iter().map(|a| (a - ink_mean).powi(2)).sum::<f64>().sqrt();
        product / norm
    };
    ('A'..='Z').chain('0'..='9').chain(['-']).max_by(|a, b| likeness(*a).total_cmp(&likeness(*b))).unwrap()
}

#[test]
fn letters_of_20_mm_can_be_read_from_a_picture_at_2_m() {
    let label = |fixture: &Fixture| matches!(fixture.face, Face::Label(_));
    // The camera is 0.32 m ahead of the middle of the robot.
    let (mut simulator, aim, fixture) = in_front_of(SiteName::B1, label, 2.32, 5.0, 0.0);
    let image = simulator.picture(&aim);
    let site_from_camera = site_from_base(&simulator.truth()) * simulator.cameras().base_from_camera(&aim);
    let camera_from_plate = site_from_camera.inverse() * fixture.site_from_plate;
    let intrinsics = simulator.cameras().intrinsics(5.0);
    let dark = |at: [f32; 2]| {
        let point = camera_from_plate * Point3::new(f64::from(at[0]), f64::from(at[1]), 0.0);
        let px = intrinsics.project(&point.coords).unwrap();
        255.0 - brightness(&image, px.map(|c| c as u32))
    };
    let Face::Label(lines) = &fixture.face else { panic!() };
    for (number, line) in lines.iter().enumerate() {
        let count = line.chars().count() as f32;
        let up = (0.5 * (lines.len() as f32 - 1.0) - number as f32) * 0.034;
        let read: String = line
            .chars()
            .enumerate()
            .map(|(at, letter)| if letter == ' ' { ' ' } else { read_letter(&dark, at as f32, count, up) })
            .collect();
        assert_eq!(&read, line);
    }
}

#[test]
fn a_warm_machine_is_the_warmest_spot_of_a_thermal_picture() {
    let warm = |fixture: &Fixture| matches!(fixture.face, Face::Warm { .. });
    let (mut simulator, aim, fixture) = in_front_of(SiteName::B1, warm, 1.6, 1.0, -0.2);
    let image = simulator.thermal_picture(&aim);
    let Face::Warm { celsius } = fixture.face else { panic!() };
    let (pixel, warmest) = image.celsius.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
    let [x, y] = [pixel as u32 % image.width_px, pixel as u32 / image.width_px];
    assert!((f64::from(*warmest) - celsius).abs() < 1.0, "{warmest} for {celsius}");
    assert!(x.abs_diff(160) < 12 && y.abs_diff(120) < 12, "at {x} {y}");
}

#[test]
fn pictures_of_equal_simulations_are_equal_and_the_lidar_does_not_see_the_plates() {
    let take = || {
        let mut simulator = Simulator::new(quiet(SiteName::Twins));
        let image = simulator.picture(&CameraAim { pan_rad: 0.4, tilt_rad: 0.1, zoom: 1.0 });
        let mut events = Vec::new();
        simulator.advance(simulator.now() + vocab::Span::from_millis(200), &mut events);
        (image, events)
    };
    let (image, events) = take();
    assert!(take() == (image, events.clone()));
    let mut without = Simulator::new(quiet(SiteName::Twins));
    let mut plain = Vec::new();
    without.advance(without.now() + vocab::Span::from_millis(200), &mut plain);
    assert!(plain == events, "a picture changes what the sensors measure");
}

#[test]
fn a_picture_is_neither_black_nor_white_on_any_site() {
    for name in [SiteName::B1, SiteName::Torus, SiteName::Plant, SiteName::Generated(2)] {
        let mut simulator = Simulator::new(quiet(Arc::new(SimulatedSite::new(name))));
        let image = simulator.picture(&CameraAim { pan_rad: 0.0, tilt_rad: 0.0, zoom: 1.0 });
        let mean = image.rgb.iter().map(|byte| f64::from(*byte)).sum::<f64>() / image.rgb.len() as f64;
        assert!((60.0..215.0).contains(&mean), "{name}: mean {mean}");
        let extreme = image.rgb.iter().filter(|byte| **byte < 2 || **byte > 253).count();
        assert!((extreme as f64) < 0.1 * image.rgb.len() as f64, "{name}: {extreme} bytes without detail");
    }
}

#[test]
fn a_target_is_off_the_centre_by_the_error_of_the_estimate() {
    let truth = Isometry::identity();
    let target = Vector3::new(4.32, 0.0, 0.2);
    let share = off_centre(&truth, &truth, &target, &target, 1.0);
    assert!(share.is_some_and(|share| share < 1e-9), "{share:?}");
    // 1 degree of heading, 4 m away: 0.017 of 0.577 half widths, twice.
    let rotation = geometry::Rotation::from_euler_angles(0.0, 0.0, 0.01745);
    let turned = Isometry::from_parts(nalgebra::Translation3::identity(), rotation);
    let share = off_centre(&truth, &turned, &target, &target, 1.0).unwrap_or(f64::NAN);
    assert!((share - 0.0163).abs() < 5e-4, "{share}");
    let zoomed = off_centre(&truth, &turned, &target, &target, 4.0).unwrap_or(f64::NAN);
    assert!((zoomed - 4.0 * share).abs() < 1e-3, "{zoomed}");
    // Behind: beyond the reach of the head.
    assert_eq!(off_centre(&truth, &truth, &Vector3::new(-4.0, 0.0, 0.2), &target, 1.0), None);
}

#[test]
fn a_scene_can_be_lit_otherwise_and_a_gauge_can_show_another_value() {
    let gauge = |fixture: &Fixture| matches!(fixture.face, Face::Gauge { .. });
    let (mut simulator, aim, fixture) = in_front_of(SiteName::B1, gauge, 1.6, 4.0, 0.0);
    let scene = simulator.camera_scene();
    let truth = site_from_base(&simulator.truth());
    let take = |scene: &crate::CameraScene| crate::CameraSnapshot::alone(truth, 0.0, 5).picture(scene, &aim);
    let plain = take(&scene);
    assert!(plain == take(&scene), "the same seed makes the same picture");
    let sun = (1.0, [0.0, 0.0, 1.0]);
    // Without lamps what is left is exposed longer, and noise grows.
    let dark = take(&scene.relit(|_| 0.0, sun));
    assert!(dark != plain && take(&scene.relit(|_| 1.0, sun)) == plain);
    let steady = crate::SimulatedQuantity { mean: 9.0, amplitude: 0.0, period_s: 1.0, rise_per_s: 0.0 };
    let turned = scene.with_reading(&fixture.tag, steady).expect("a gauge");
    let reds =
        |image: &crate::CameraImage| image.rgb.chunks(3).filter(|c| c[0] > 70 && c[0] / 2 > c[1]).count();
    let changed = take(&turned);
    assert!(changed != plain && reds(&changed).abs_diff(reds(&plain)) < reds(&plain) / 2);
    assert!(scene.with_reading("none", steady).is_none());
}
