//! Body, collisions, ground, gait and IMU.

use super::{drive, ideal_blind, imu, quiet, run, scans, site_from_base};
use crate::{
    ContactWith, RouteFollower, STANDING_HEIGHT, SimConfig, SimulatedSite, Simulator, SiteName, Start,
};
use geometry::{Isometry, RngTree, STANDARD_GRAVITY_M_S2, Vector3, isometry_from_pose, so3, vec_from_plain};
use messages::Sensor;
use std::sync::Arc;
use vocab::{Span, Vec3};

#[test]
fn the_body_never_enters_walls_under_any_command() {
    for name in SiteName::ALL {
        let site = Arc::new(SimulatedSite::new(name));
        for seed in 0..4 {
            let mut rng = RngTree::new(seed).child("commands").rng();
            let mut simulator = Simulator::new(ideal_blind(site.clone()));
            let mut walked = 0.0;
            for _ in 0..25 {
                let command = drive(rng.range(-0.8, 2.0), rng.range(-0.6, 0.6), rng.range(-1.5, 1.5));
                for _ in 0..10 {
                    let before = simulator.truth().site_from_base.position;
                    run(&mut simulator, command, 1);
                    let truth = simulator.truth();
                    let base = vec_from_plain(truth.site_from_base.position);
                    walked += (base - vec_from_plain(before)).xy().norm();
                    let hull = base + Vector3::z() * 0.08;
                    let gap = site.distance(&hull, 0.28);
                    assert!(gap.is_none(), "{name} seed {seed}: {gap:?} m from something at {base:?}");
                }
            }
            assert!(walked > 3.0, "{name} seed {seed}: walked {walked} m only");
        }
    }
}

#[test]
fn a_robot_that_walks_against_a_wall_touches_it_once() {
    let mut simulator = Simulator::new(ideal_blind(SiteName::B1));
    assert!(simulator.take_contacts().is_empty());
    // The hall is 60 m long.
    for _ in 0..600 {
        run(&mut simulator, drive(1.2, 0.0, 0.0), 1);
        if simulator.truth().velocity.linear.x.abs() < 0.01 && simulator.elapsed() > Span::from_millis(1_000)
        {
            break;
        }
    }
    let contacts = simulator.take_contacts();
    assert!(
        !contacts.is_empty() && contacts.iter().all(|it| it.with == ContactWith::Solid && it.is_by_robot)
    );
    run(&mut simulator, drive(1.2, 0.0, 0.0), 5);
    assert!(simulator.take_contacts().is_empty(), "it is the same contact");
}

#[test]
fn speed_is_limited_and_ends_when_commands_cease() {
    let mut simulator = Simulator::new(ideal_blind(SiteName::B1));
    run(&mut simulator, drive(5.0, 0.0, 0.0), 30);
    let x = simulator.truth().site_from_base.position.x;
    run(&mut simulator, drive(5.0, 0.0, 0.0), 20);
    let speed = (simulator.truth().site_from_base.position.x - x) / 2.0;
    assert!((speed - 1.2).abs() < 0.02, "{speed} m/s");
    let mut events = Vec::new();
    simulator.advance(simulator.now() + Span::from_millis(2500), &mut events);
    let stopped = simulator.truth();
    simulator.advance(simulator.now() + Span::from_millis(500), &mut events);
    let moved = vec_from_plain(simulator.truth().site_from_base.position)
        - vec_from_plain(stopped.site_from_base.position);
    assert!(moved.norm() < 1e-6, "still moving: {moved}");
}

#[test]
fn the_imu_of_a_standing_robot_measures_gravity_only() {
    let mut simulator = Simulator::new(ideal_blind(SiteName::B1));
    let base_from_imu = isometry_from_pose(&simulator.boot().mounting.base_from_imu.unwrap()).unwrap();
    let samples = imu(&run(&mut simulator, drive(0.0, 0.0, 0.0), 10));
    assert_eq!(samples.len(), 399);
    let site_from_imu = site_from_base(&simulator.truth()) * base_from_imu;
    for sample in samples {
        let up = site_from_imu.rotation * vec_from_plain(sample.specific_force);
        assert!((up - Vector3::z() * STANDARD_GRAVITY_M_S2).norm() < 1e-6, "{up}");
        assert!(vec_from_plain(sample.angular_velocity).norm() < 1e-9);
    }
}

#[test]
fn the_imu_integrates_back_to_the_true_path() {
    let mut simulator = Simulator::new(ideal_blind(SiteName::B1));
    let base_from_imu = isometry_from_pose(&simulator.boot().mounting.base_from_imu.unwrap()).unwrap();
    run(&mut simulator, drive(0.0, 0.0, 0.0), 10);
    let start = site_from_base(&simulator.truth()) * base_from_imu;
    let (mut place, mut velocity, mut attitude) =
        (start.translation.vector, Vector3::zeros(), start.rotation);
    let from = simulator.now();
    let events = run(&mut simulator, drive(1.0, 0.1, 0.25), 60);
    let dt = 1.0 / f64::from(crate::IMU_HZ);
    let truth = simulator.take_ground_truth().pop().unwrap();
    let (mut jerky, mut half_turn) = (0.0_f64, so3::exp(&Vector3::zeros()));
    for sample in imu(&events).into_iter().filter(|sample| (from..truth.stamp).contains(&sample.stamp)) {
        // A sample is the mean over a period around its stamp. So half of the rotation comes before the acceleration and half after it.
        half_turn = so3::exp(&(vec_from_plain(sample.angular_velocity) * (dt / 2.0)));
        attitude *= half_turn;
        let push = attitude * vec_from_plain(sample.specific_force) - Vector3::z() * STANDARD_GRAVITY_M_S2;
        jerky = jerky.max(push.norm());
        place += velocity * dt + push * (dt * dt / 2.0);
        velocity += push * dt;
        attitude *= half_turn;
    }
    // The last period ends half a period before the truth's stamp.
    place += velocity * (dt / 2.0);
    attitude *= half_turn;
    let site_from_imu: Isometry = site_from_base(&truth) * base_from_imu;
    let error = (place - site_from_imu.translation.vector).norm();
    let turned = so3::log(&(site_from_imu.rotation.inverse() * attitude)).norm();
    assert!(error < 0.004, "{error} m after six seconds");
    assert!(turned < 0.001, "{turned} rad after six seconds");
    assert!(jerky > 3.0, "footfalls must jolt the IMU: {jerky} m/s²");
}

#[test]
fn stairs_lift_the_robot_to_the_upper_floor() {
    let site = Arc::new(SimulatedSite::new(SiteName::Plant));
    let mut config = ideal_blind(SiteName::Plant);
    let route = site.route("short").cloned().unwrap();
    config.start = Some(route.start);
    let mut simulator = Simulator::new(config);
    let mut walker = RouteFollower::new(route);
    let (mut steepest, mut highest) = (0.0_f64, 0.0_f64);
    while let Some(command) = walker.drive(&simulator.truth()) {
        run(&mut simulator, command, 1);
        let pose = site_from_base(&simulator.truth());
        steepest = steepest.max((pose.rotation * Vector3::x()).z);
        highest = highest.max(pose.translation.vector.z);
    }
    let z = simulator.truth().site_from_base.position.z;
    assert!((z - 4.08 - STANDING_HEIGHT).abs() < 0.02, "ended at {z} m");
    assert!(highest < z + 0.05, "jumped to {highest} m");
    // 17 cm over 28 cm is 31 degrees.
    assert!((0.45..0.62).contains(&steepest), "sine of the steepest pitch: {steepest}");
}

#[test]
fn a_carried_robot_measures_motion_with_its_imu_alone() {
    let mut simulator = Simulator::new(SimConfig { ideal: true, lidar_columns: 50, ..quiet(SiteName::B1) });
    run(&mut simulator, drive(0.0, 0.0, 0.0), 5);
    let to = Start { position: Vec3::new(29.0, 17.2, 0.0), yaw: 1.0 };
    simulator.carry(to, Span::from_millis(8_000));
    let mut events = run(&mut simulator, drive(0.5, 0.0, 0.0), 40);
    let lifted = site_from_base(&simulator.truth()).translation.z;
    assert!((lifted - STANDING_HEIGHT - 0.35).abs() < 0.05, "{lifted} m");
    events.extend(run(&mut simulator, drive(0.5, 0.0, 0.0), 40));
    let place = site_from_base(&simulator.truth()).translation.vector;
    assert!((place - Vector3::new(29.0, 17.2, place.z)).norm() < 0.05, "{place}");
    assert!(scans(&events).iter().all(|scan| scan.xyz.is_empty()));
    let fastest = imu(&events)
        .iter()
        .map(|sample| sample.specific_force.x.hypot(sample.specific_force.y))
        .fold(0.0, f64::max);
    assert!((0.5..8.0).contains(&fastest), "{fastest} m/s²");
    for event in &events {
        if let Sensor::Legs(legs) = &event.sensor {
            let v = legs.base_velocity.linear;
            assert!(v.x.hypot(v.y) < 0.01, "hanging legs must measure no motion: {v:?}");
        }
    }
    run(&mut simulator, drive(0.5, 0.0, 0.0), 20);
    let after = site_from_base(&simulator.truth()).translation.vector;
    assert!((after - place).norm() > 0.4, "the robot must walk again");
}

#[test]
fn a_robot_that_is_carried_away_is_put_down_where_there_is_room() {
    for site in [SiteName::B1, SiteName::Torus, SiteName::Plant, SiteName::Twins] {
        let mut simulator = Simulator::new(SimConfig { ideal: true, lidar_columns: 50, ..quiet(site) });
        for _ in 0..3 {
            run(&mut simulator, drive(0.0, 0.0, 0.0), 5);
            let before = site_from_base(&simulator.truth()).translation.vector;
            simulator.carry_away(Span::from_millis(3_000));
            run(&mut simulator, drive(0.0, 0.0, 0.0), 40);
            let after = site_from_base(&simulator.truth()).translation.vector;
            let moved = (after - before).norm();
            assert!((5.9..20.1).contains(&moved) && (after.z - before.z).abs() < 0.1, "{site}: {moved} m");
            let feet = after - Vector3::z() * STANDING_HEIGHT;
            assert!(simulator.site().has_room(&feet), "{site}: {after}");
        }
    }
}
