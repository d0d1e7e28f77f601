//! Compares LiDAR, legs, battery and people with the ground truth.

use super::{drive, ideal_blind, imu, quiet, run, scans, site_from_base};
use crate::{RINGS, SWEEP_HZ, ScheduledFault, SimConfig, SimEvent, Simulator, SiteName};
use geometry::{Isometry, Vector3, isometry_from_pose, se3, vec_from_plain};
use messages::{BatteryState, LegOdometry, Sensor};
use vocab::{Span, Vec3};

/// Distance of every point of a walk from the site's surfaces. Each point is moved by the true pose at its own instant.
fn distances(config: SimConfig) -> Vec<f64> {
    let mut simulator = Simulator::new(config);
    let base_from_lidar = isometry_from_pose(&simulator.boot().mounting.base_from_lidar.unwrap()).unwrap();
    let events = run(&mut simulator, drive(0.7, 0.1, 0.5), 25);
    let truths = simulator.take_ground_truth();
    let begin = truths[0].stamp;
    let site_from_base = |seconds: f64| -> Isometry {
        let place = (seconds * 100.0).min(truths.len() as f64 - 1.001);
        let [a, b] = [0, 1].map(|i| site_from_base(&truths[place as usize + i]));
        se3::interpolate(&a, &b, place.fract())
    };
    let mut out = Vec::new();
    for scan in scans(&events).iter().skip(15) {
        for (xyz, offset) in scan.xyz.iter().zip(&scan.offset_ns) {
            let seconds = (scan.stamp - begin).secs_f64() + f64::from(*offset) * 1e-9;
            let point =
                site_from_base(seconds) * base_from_lidar * nalgebra::Point3::from(xyz.map(f64::from));
            out.push(simulator.site().distance(&point.coords, 0.5).map_or(0.5, f64::abs));
        }
    }
    out
}

#[test]
fn points_lie_on_surfaces_when_moved_by_the_true_pose() {
    let mut config = quiet(SiteName::B1);
    config.ideal = true;
    let exact = distances(config);
    // The truth has 100 Hz. Between its records the jolts of the gait are missing, so 2 % may be off.
    let off = exact.iter().filter(|d| **d > 5e-3).count();
    assert!(exact.len() > 10_000 && off * 50 < exact.len(), "{off} of {} points off", exact.len());

    let noisy = distances(quiet(SiteName::B1));
    let rms = (noisy.iter().map(|d| d * d).sum::<f64>() / noisy.len() as f64).sqrt();
    assert!((0.004..0.011).contains(&rms), "{rms} m of 0.01 m range noise");
    assert!(
        noisy.len() < exact.len() && noisy.len() * 10 > exact.len() * 8,
        "{} of {}",
        noisy.len(),
        exact.len()
    );
}

#[test]
fn a_scan_has_the_timing_and_the_rings_of_the_real_sensor() {
    let mut config = quiet(SiteName::B1);
    config.ideal = true;
    config.lidar_columns = 100;
    let mut simulator = Simulator::new(config);
    let begin = simulator.now();
    let events = run(&mut simulator, drive(0.0, 0.0, 0.0), 10);
    let sweep = Span::from_millis(1000 / i64::from(SWEEP_HZ));
    let delivered: Vec<_> =
        events.iter().filter(|e| matches!(e.sensor, Sensor::Scan(_))).map(|e| e.at).collect();
    for (i, (scan, at)) in scans(&events).iter().zip(delivered).enumerate() {
        assert_eq!(scan.stamp, begin + sweep * i as i64);
        assert_eq!(at, scan.stamp + sweep);
        assert!(scan.offset_ns.is_sorted() && scan.offset_ns.iter().all(|o| i64::from(*o) < sweep.nanos()));
        let columns = [scan.intensity.len(), scan.offset_ns.len(), scan.ring.len()];
        assert_eq!(columns, [scan.xyz.len(); 3]);
        for ((xyz, ring), offset) in scan.xyz.iter().zip(&scan.ring).zip(&scan.offset_ns) {
            let point = Vector3::from(xyz.map(f64::from));
            let elevation = (point.z / point.norm()).asin().to_degrees();
            assert!((elevation - (15.0 - f64::from(*ring))).abs() < 1e-3, "{elevation} in ring {ring}");
            assert_eq!(i64::from(*offset) % 1_000_000, 1512 * i64::from(*ring));
            // The head faces backwards at the start and then turns clockwise.
            let turned = std::f64::consts::TAU * f64::from(*offset) * 1e-9 * f64::from(SWEEP_HZ);
            let azimuth = std::f64::consts::PI - turned;
            let across = point.y * azimuth.cos() - point.x * azimuth.sin();
            assert!(across.abs() < 1e-3 * point.norm() && (0.3..120.0).contains(&point.norm()));
        }
        assert!(scan.xyz.len() * 10 > 100 * RINGS * 9, "{} points", scan.xyz.len());
    }
}

#[test]
fn full_resolution_is_640_000_rays_a_second() {
    let mut config = SimConfig::new(SiteName::Torus, 3);
    config.ideal = true;
    let events = run(&mut Simulator::new(config), drive(0.0, 0.0, 0.0), 1);
    assert_eq!(scans(&events)[0].xyz.len(), 64_000);
}

#[test]
fn people_walk_and_are_seen() {
    let mut config = quiet(SiteName::B1);
    config.people = 5;
    let mut simulator = Simulator::new(config);
    let before = simulator.people();
    let events = run(&mut simulator, drive(0.0, 0.0, 0.0), 150);
    let moved = |(a, b): (&Vec3, &Vec3)| (vec_from_plain(*a) - vec_from_plain(*b)).norm() > 1.0;
    assert!(before.iter().zip(&simulator.people()).filter(|pair| moved(*pair)).count() >= 3);
    // The robot stands still, so points away from all surfaces are people.
    let base_from_lidar = isometry_from_pose(&simulator.boot().mounting.base_from_lidar.unwrap()).unwrap();
    let site_from_lidar = site_from_base(&simulator.truth()) * base_from_lidar;
    let points = scans(&events).iter().flat_map(|scan| scan.xyz.clone()).collect::<Vec<_>>();
    let floating = points.iter().filter(|xyz| {
        let point = site_from_lidar * nalgebra::Point3::from(xyz.map(f64::from));
        simulator.site().distance(&point.coords, 0.08).is_none()
    });
    assert!(floating.count() > 100);
}

fn legs(events: &[SimEvent]) -> Vec<LegOdometry> {
    let legs = |event: &SimEvent| match event.sensor {
        Sensor::Legs(legs) => Some(legs),
        _ => None,
    };
    events.iter().filter_map(legs).collect()
}

#[test]
fn legs_without_errors_integrate_to_the_path_and_with_errors_drift() {
    let travel = |config| {
        let mut simulator = Simulator::new(config);
        let start = site_from_base(&simulator.truth());
        let odometry = legs(&run(&mut simulator, drive(1.0, 0.0, 0.1), 150));
        assert_eq!(odometry.len(), 1500);
        let last = odometry[odometry.len() - 1].odom_from_base;
        let first = isometry_from_pose(&odometry[0].odom_from_base).unwrap();
        let walked = first.inverse() * isometry_from_pose(&last).unwrap();
        let truth = start.inverse() * site_from_base(&simulator.truth());
        (walked.translation.vector - truth.translation.vector).norm() / truth.translation.vector.norm()
    };
    let (exact, real) = (travel(ideal_blind(SiteName::B1)), travel(quiet(SiteName::B1)));
    assert!(exact < 0.005, "{exact} without errors");
    assert!((0.003..0.08).contains(&real), "{real} with errors");
}

#[test]
fn imu_noise_has_the_density_of_the_datasheet() {
    let mut config = ideal_blind(SiteName::B1);
    config.ideal = false;
    let samples = imu(&run(&mut Simulator::new(config), drive(0.0, 0.0, 0.0), 200));
    let spread = |pick: &dyn Fn(&messages::ImuSample) -> f64| {
        let mean = samples.iter().map(pick).sum::<f64>() / samples.len() as f64;
        (samples.iter().map(|s| (pick(s) - mean).powi(2)).sum::<f64>() / samples.len() as f64).sqrt()
    };
    let band = f64::from(crate::IMU_HZ / 2).sqrt();
    let gyro = spread(&|s| s.angular_velocity.y) / (0.014_f64.to_radians() * band);
    let accel = spread(&|s| s.specific_force.z) / (160e-6 * geometry::STANDARD_GRAVITY_M_S2 * band);
    assert!((gyro - 1.0).abs() < 0.05 && (accel - 1.0).abs() < 0.08, "{gyro} {accel} times the datasheet");
}

#[test]
fn the_battery_charges_at_the_dock_and_drains_elsewhere() {
    let battery = |events: &[SimEvent]| -> BatteryState {
        let state = |event: &SimEvent| match event.sensor {
            Sensor::Battery(battery) => Some(battery),
            _ => None,
        };
        events.iter().rev().find_map(state).unwrap()
    };
    let mut simulator = Simulator::new(ideal_blind(SiteName::B1));
    let docked = battery(&run(&mut simulator, drive(0.0, 0.0, 0.0), 30));
    assert!(docked.charging && docked.current_a > 0.0);
    let walking = battery(&run(&mut simulator, drive(1.0, 0.0, 0.0), 50));
    let later = battery(&run(&mut simulator, drive(1.0, 0.0, 0.0), 100));
    assert!(!later.charging && later.current_a < 0.0 && later.charge < walking.charge);
    assert!((40.0..60.0).contains(&later.voltage_v));
}

#[test]
fn faults_begin_and_end_at_their_times() {
    let mut config = quiet(SiteName::B1);
    let span = |from, until| (Span::from_millis(from), Span::from_millis(until));
    let (from, until) = span(1000, 2000);
    config.faults.push(ScheduledFault::BlindLidar { from, until });
    let (from, until) = span(3000, 3500);
    config.faults.push(ScheduledFault::SilentImu { from, until });
    let mut simulator = Simulator::new(config);
    let events = run(&mut simulator, drive(0.0, 0.0, 0.0), 40);
    let points: Vec<usize> = scans(&events).iter().map(|scan| scan.xyz.len()).collect();
    assert_eq!(points.len(), 40);
    assert!((0..40).all(|i| (points[i] == 0) == (10..20).contains(&i)), "{points:?}");
    assert_eq!(imu(&events).len(), 400 * 4 - 1 - 200);

    let now = simulator.elapsed();
    let velocity = Vec3::new(0.3, 0.0, 0.0);
    simulator.inject_fault(ScheduledFault::LegSlip {
        from: now,
        until: now + Span::from_millis(500),
        velocity,
    });
    simulator.inject_fault(ScheduledFault::SilentLidar { from: now, until: now + Span::from_secs_f64(1e6) });
    let events = run(&mut simulator, drive(0.0, 0.0, 0.0), 10);
    assert!(scans(&events).is_empty());
    let fast = legs(&events).iter().filter(|legs| legs.base_velocity.linear.x > 0.2).count();
    assert_eq!(fast, 50);
    simulator.clear_faults();
    assert_eq!(scans(&run(&mut simulator, drive(0.0, 0.0, 0.0), 2)).len(), 2);
}
