//! What sensors see of a site whose condition has changed.

use super::cameras::{in_front_of, needle_value};
use super::{quiet, run, scans, site_from_base};
use crate::camera::CameraScene;
use crate::people::People;
use crate::{
    CameraConfig, CameraSnapshot, ConditionChange, Face, Fixture, Leak, Liquid, SimConfig, SimulatedSite,
    Simulator, SiteName, Start,
};
use geometry::{Isometry, RngTree, Vector3, isometry_from_pose, vec_from_plain};
use nalgebra::{Matrix3, Point3, Rotation3, Translation3, UnitQuaternion};
use std::f64::consts::FRAC_PI_8;
use std::sync::Arc;
use vocab::Vec3;

/// The pose of a camera at `eye` that looks at `target`.
fn looking(eye: &Vector3, target: &Vector3) -> Isometry {
    let ahead = (target - eye).normalize();
    let right = ahead.cross(&Vector3::z()).normalize();
    let axes = Matrix3::from_columns(&[right, ahead.cross(&right), ahead]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    Isometry::from_parts(Translation3::from(*eye), rotation)
}

fn scene(site: &SimulatedSite) -> CameraScene {
    CameraScene::new(Arc::new(site.clone()))
}

fn changed(site: &SimulatedSite, change: ConditionChange) -> SimulatedSite {
    site.with_condition_changes(&[change]).expect("a change of what is there")
}

#[test]
fn a_room_is_darker_with_its_lamp_out_and_another_room_is_not() {
    let site = SimulatedSite::new(SiteName::Twins);
    let usual = scene(&site);
    let lamps = usual.lamps();
    let lamp = lamps[lamps.len() / 2];
    let dark = scene(&changed(&site, ConditionChange::LampOut { lamp }));
    assert_eq!(dark.lamps().len(), lamps.len() - 1);
    let intrinsics = CameraConfig::default().thermal_intrinsics();
    let mean_below = |scene: &CameraScene, lamp: &Vec3| {
        let below = vec_from_plain(*lamp) - Vector3::z() * 2.0;
        let view = looking(&(below + Vector3::new(0.3, 0.2, 1.5)), &below);
        let light = scene.light(&view, &intrinsics);
        light.iter().flatten().map(|c| f64::from(*c)).sum::<f64>() / (3 * light.len()) as f64
    };
    let (before, after) = (mean_below(&usual, &lamp), mean_below(&dark, &lamp));
    assert!(after < 0.8 * before, "{before} {after}");
    let away = |other: &Vec3| (vec_from_plain(*other) - vec_from_plain(lamp)).norm();
    let far = lamps.iter().max_by(|a, b| away(a).total_cmp(&away(b))).expect("lamps");
    assert!(away(far) > 10.0, "{}", away(far));
    assert!((mean_below(&usual, far) - mean_below(&dark, far)).abs() < 1e-9);
}

/// A puddle on a free floor, and a camera that looks at it from the side.
fn puddle(site: &SimulatedSite, liquid: Option<Liquid>, warmer_k: f64) -> (Leak, Isometry) {
    let config = crate::ConditionChangesConfig::default();
    let random = site.random_condition_changes(1, 40, &config);
    let found = random.iter().find_map(|change| match change {
        ConditionChange::Leak(leak) => Some(*leak),
        _ => None,
    });
    let leak = Leak { radius_m: 0.4, liquid, warmer_k, ..found.expect("a leak") };
    let place = vec_from_plain(leak.place);
    let eye = (0..16)
        .map(|step| {
            let (sin, cos) = (FRAC_PI_8 * f64::from(step)).sin_cos();
            place + Vector3::new(1.2 * cos, 1.2 * sin, 0.9)
        })
        .find(|eye| {
            let offset = place - eye;
            let is_seen = site.cast_ray(eye, &offset.normalize(), offset.norm() - 0.02).is_none();
            is_seen && site.distance(eye, 0.2).is_none()
        });
    (leak, looking(&eye.expect("a free place beside the puddle"), &place))
}

#[test]
fn a_puddle_is_seen_where_it_is_and_nowhere_else() {
    let site = SimulatedSite::new(SiteName::B1);
    let usual = scene(&site);
    let intrinsics = CameraConfig::default().intrinsics(1.0);
    for liquid in [Liquid::Water, Liquid::Oil] {
        let (leak, view) = puddle(&site, Some(liquid), 0.0);
        let wet = scene(&changed(&site, ConditionChange::Leak(leak)));
        let (before, after) = (usual.light(&view, &intrinsics), wet.light(&view, &intrinsics));
        let camera_from_site = view.inverse();
        let pixel_m = 2.0 / intrinsics.focal_px;
        let mut inside = 0;
        for (pixel, (a, b)) in before.iter().zip(&after).enumerate() {
            if a == b {
                continue;
            }
            inside += 1;
            // Where the ray of the pixel meets the level of the floor.
            let [x, y] =
                [pixel as u32 % intrinsics.width_px, pixel as u32 / intrinsics.width_px].map(f64::from);
            let ray = Vector3::new(
                (x + 0.5 - intrinsics.centre_px[0]) / intrinsics.focal_px,
                (y + 0.5 - intrinsics.centre_px[1]) / intrinsics.focal_px,
                1.0,
            );
            let ray = view.rotation * ray;
            let eye = view.translation.vector;
            let point = eye + ray * ((leak.place.z - eye.z) / ray.z);
            let away_m = (point - vec_from_plain(leak.place)).norm();
            assert!(away_m < leak.radius_m + 4.0 * pixel_m, "{away_m} m from the middle");
        }
        assert!(inside > 2000, "{inside} pixels");
        let middle = (camera_from_site * Point3::from(vec_from_plain(leak.place))).coords;
        let [x, y] = intrinsics.project(&middle).expect("in front").map(|c| c as usize);
        let at = y * intrinsics.width_px as usize + x;
        assert!(after[at][1] < 0.8 * before[at][1], "{liquid:?} {:?} {:?}", before[at], after[at]);
    }
}

#[test]
fn a_thermal_picture_is_warmer_at_a_leak_by_what_was_asked() {
    let site = SimulatedSite::new(SiteName::B1);
    let usual = scene(&site);
    let intrinsics = CameraConfig::default().thermal_intrinsics();
    let take = |scene: &CameraScene, view: &Isometry| {
        let mut rng = RngTree::new(3).rng();
        scene.thermal_picture(&People::default(), view, &intrinsics, 0.0, &mut rng).celsius
    };
    for (liquid, warmer_k) in [(Some(Liquid::Water), 12.0), (Some(Liquid::Oil), -6.0), (None, 9.0)] {
        let (leak, view) = puddle(&site, liquid, warmer_k);
        let leaking = scene(&changed(&site, ConditionChange::Leak(leak)));
        let (before, after) = (take(&usual, &view), take(&leaking, &view));
        let [x, y] = intrinsics.centre_px.map(|c| c as usize);
        let at = y * intrinsics.width_px as usize + x;
        let rise_k = f64::from(after[at] - before[at]);
        assert!((rise_k - warmer_k).abs() < 0.1, "{liquid:?}: {rise_k} K for {warmer_k} K");
        // In a corner of the picture nothing has changed.
        assert_eq!(before[0], after[0]);
        let same = before.iter().zip(&after).filter(|(a, b)| a == b).count();
        assert!(same > before.len() / 3 && same < before.len() - 200, "{same} of {}", before.len());
        if liquid.is_none() {
            let colour = CameraConfig::default().thermal_intrinsics();
            assert!(usual.light(&view, &colour) == leaking.light(&view, &colour), "only warmth is seen");
        }
    }
}

/// What the needle of `tag` shows in pictures of a site, at these times.
fn needle_of(site: &Arc<SimulatedSite>, tag: &str, seconds: [f64; 2]) -> [f64; 2] {
    let is_it = |fixture: &Fixture| fixture.tag == tag;
    let (mut simulator, aim, fixture) = in_front_of(Arc::clone(site), is_it, 1.6, 8.0, 0.3);
    let (scene, truth) = (simulator.camera_scene(), site_from_base(&simulator.truth()));
    seconds.map(|seconds| {
        let image = CameraSnapshot::alone(truth, seconds, 5).picture(&scene, &aim);
        needle_value(&image, &fixture, &truth, simulator.cameras(), &aim)
    })
}

#[test]
fn a_drifting_gauge_shows_the_drifted_value_and_a_stuck_one_does_not_move() {
    let site = SimulatedSite::new(SiteName::B1);
    let tag = "PI-101".to_owned();
    let fixtures = scene(&site).fixtures().to_vec();
    let usual = fixtures.iter().find(|fixture| fixture.tag == tag).expect("the first gauge");
    let Face::Gauge { reading, .. } = usual.face else { panic!() };
    let true_value = |seconds: f64| reading.at(seconds);
    // A swing later, and a day later, in the middle of a swing.
    let times = [0.0, 86_400.0];
    let drifts = ConditionChange::GaugeDrifts { tag: tag.clone(), per_day: 1.0, begun_days_ago: 2.0 };
    let shown = needle_of(&Arc::new(changed(&site, drifts)), &tag, times);
    for (seconds, value) in times.into_iter().zip(shown) {
        let expected = true_value(seconds) + 2.0 + seconds / 86_400.0;
        assert!((value - expected).abs() < 0.2, "after {seconds} s: {value:.2} for {expected:.2}");
    }
    // A quarter and three quarters of a swing: the true value goes from one end of its range to the other.
    let times = [0.25 * reading.period_s, 0.75 * reading.period_s];
    let moving = needle_of(&Arc::new(site.clone()), &tag, times);
    assert!((moving[0] - moving[1]).abs() > reading.amplitude, "{moving:?}");
    let stuck = ConditionChange::GaugeStuck { tag: tag.clone(), value: 7.5 };
    let shown = needle_of(&Arc::new(changed(&site, stuck)), &tag, times);
    assert!(shown.iter().all(|value| (value - 7.5).abs() < 0.2), "{shown:?}");
}

#[test]
fn the_lidar_sees_a_door_at_its_other_angle() {
    let site = SimulatedSite::new(SiteName::B1);
    let hinge = Vec3::new(50.1, 6.7, 0.0);
    let swung = changed(&site, ConditionChange::DoorTurned { hinge, turn_rad: 1.0 });
    let (leaf, motion) = swung.turned_leaves().into_iter().next().expect("a turned leaf");
    let [usual_leaf, turned_leaf] =
        [Isometry::identity(), motion].map(|motion| leaf[0].shape.transformed(&motion));
    let middle = |shape: &crate::Shape| {
        let (least, most) = shape.bounds();
        (least + most) / 2.0
    };
    // A place from which both angles are seen.
    let place = (0..64)
        .map(|step| {
            let (sin, cos) = (FRAC_PI_8 * f64::from(step % 16)).sin_cos();
            let away = 1.6 + 0.5 * f64::from(step / 16);
            vec_from_plain(hinge) + Vector3::new(away * cos, away * sin, 0.0)
        })
        .find(|feet| {
            let eye = feet + Vector3::z() * 0.7;
            let sees = |site: &SimulatedSite, shape: &crate::Shape| {
                let offset = middle(shape) - eye;
                site.cast_ray(&eye, &offset.normalize(), offset.norm() - 0.1).is_none()
            };
            swung.has_room(feet)
                && site.has_room(feet)
                && sees(&swung, &turned_leaf)
                && sees(&site, &usual_leaf)
        })
        .expect("a place beside the door");
    let counts = |site: &SimulatedSite| {
        let start = Start { position: Vec3::new(place.x, place.y, place.z), yaw: 0.0 };
        let config = SimConfig { start: Some(start), ideal: true, lidar_columns: 500, ..quiet(site.clone()) };
        let mut simulator = Simulator::new(config);
        let base_from_lidar = simulator.boot().mounting.base_from_lidar.expect("mounted");
        let events = run(&mut simulator, super::drive(0.0, 0.0, 0.0), 3);
        let site_from_lidar =
            site_from_base(&simulator.truth()) * isometry_from_pose(&base_from_lidar).expect("a rigid pose");
        let scan = scans(&events).pop().expect("a sweep");
        [&usual_leaf, &turned_leaf].map(|leaf| {
            let on_leaf = |point: &[f32; 3]| {
                let point = site_from_lidar * Point3::from(point.map(f64::from));
                let distance = leaf.clearance(&point.coords).distance;
                distance.abs() < 0.03 && point.z > place.z + 0.3
            };
            scan.xyz.iter().filter(|point| on_leaf(point)).count()
        })
    };
    let (before, after) = (counts(&site), counts(&swung));
    assert!(before[0] > 100 && before[1] < before[0] / 4, "{before:?}");
    assert!(after[1] > 100 && after[0] < after[1] / 4, "{after:?}");
}

#[test]
fn plates_stay_where_they_are_and_those_on_doors_turn_with_them() {
    for name in [SiteName::B1, SiteName::Plant, SiteName::Generated(4)] {
        let site = SimulatedSite::new(name);
        let turn = |hinge| ConditionChange::DoorTurned { hinge, turn_rad: 0.6 };
        let changes: Vec<_> = site.door_hinges().into_iter().map(turn).collect();
        assert!(!changes.is_empty(), "{name}");
        let swung = site.with_condition_changes(&changes).expect("doors");
        let (before, after) = (scene(&site), scene(&swung));
        assert_eq!(before.lamps(), after.lamps(), "{name}");
        assert_eq!(before.fixtures().len(), after.fixtures().len(), "{name}");
        for (a, b) in before.fixtures().iter().zip(after.fixtures()) {
            assert_eq!((&a.tag, &a.face), (&b.tag, &b.face), "{name}");
            let distance = swung.distance(&b.site_from_plate.translation.vector, 0.05);
            assert!(distance.is_some_and(|far| far < 0.01), "{name} {}: {distance:?}", a.tag);
        }
    }
}

#[test]
fn changes_of_objects_and_another_day_keep_the_condition() {
    let site = SimulatedSite::new(SiteName::B1);
    let hinge = site.door_hinges()[0];
    let leak = Leak { place: Vec3::new(5.0, 5.0, 0.0), radius_m: 0.4, liquid: None, warmer_k: 3.0 };
    let turn = ConditionChange::DoorTurned { hinge, turn_rad: 0.5 };
    let changed = site.with_condition_changes(&[turn.clone(), ConditionChange::Leak(leak)]).expect("changes");
    assert_ne!(changed.solids(), site.solids());
    assert_eq!(changed.usual().solids(), site.solids());
    let later = changed.on_another_day(4, 0.25);
    assert_eq!(later.condition_changes(), changed.condition_changes());
    assert_eq!(later.usual().solids(), site.on_another_day(4, 0.25).solids());
    assert_eq!(later.door_hinges(), site.door_hinges());
    // Each thing changes once.
    assert!(changed.with_condition_changes(&[turn]).is_err());
}
