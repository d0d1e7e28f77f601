//! Cost of each stage of a scan at full resolution (64,000 points of an XT-32 in the test hall) on one core, and of a whole scan:
//! `cargo bench -p odometry`. Estimates on paper: motion correction 1 ms, downsampling 1.5 ms, eight Gauss-Newton iterations 1 to
//! 2.5 ms, insertion into the map 0.3 ms.

use divan::{Bencher, black_box};
use geometry::{Isometry, vec_from_plain};
use messages::Sensor;
use odometry::{Mounting, Odometry, OdometryConfig, OdometryEvent, ScanView, deskew};
use points::{Centroid, Downsampler, GaussianMap, GaussianMapConfig};
use registration::{MatchingConfig, linearise};
use sim::{RouteFollower, SimConfig, SimulatedSite, Simulator, SiteName};
use std::sync::{Arc, OnceLock};
use vocab::Span;

fn main() {
    divan::main();
}

/// Five seconds: standing, then walking.
struct Walk {
    mounting: Mounting,
    messages: Vec<Sensor>,
}

fn walk() -> &'static Walk {
    static WALK: OnceLock<Walk> = OnceLock::new();
    WALK.get_or_init(|| {
        let site = Arc::new(SimulatedSite::new(SiteName::B1));
        let route = site.routes()[0].clone();
        let start = Some(route.start);
        let mut sim = Simulator::new(SimConfig { start, ..SimConfig::new(site, 1) });
        let boot = sim.boot().mounting;
        let mounting = Mounting::from_poses(boot.base_from_lidar.as_ref(), boot.base_from_imu.as_ref(), None);
        let (mut walker, mut events) = (RouteFollower::new(route), Vec::new());
        while sim.elapsed() < Span::from_millis(5_000) {
            if let Some(drive) = walker.drive(&sim.truth()) {
                sim.command(drive);
            }
            let until = sim.now() + Span::from_millis(10);
            sim.advance(until, &mut events);
        }
        Walk { mounting, messages: events.into_iter().map(|event| event.sensor).collect() }
    })
}

fn last_scan() -> Arc<messages::Scan> {
    let scan = |message: &Sensor| match message {
        Sensor::Scan(scan) => Some(scan.clone()),
        _ => None,
    };
    walk().messages.iter().rev().find_map(scan).unwrap_or_default()
}

fn downsampled(voxel: f32) -> Vec<[f32; 3]> {
    let mut out: Vec<Centroid> = Vec::new();
    Downsampler::default().downsample(&last_scan().xyz, &[], voxel, &mut out);
    out.iter().map(|centroid| centroid.xyz).collect()
}

fn insert(map: &mut GaussianMap, points: &[[f32; 3]]) {
    for point in points {
        map.insert(&point.map(f64::from));
    }
}

#[divan::bench]
fn copy_and_deskew(bencher: Bencher) {
    let scan = last_scan();
    let view = ScanView {
        stamp: scan.stamp,
        xyz: &scan.xyz,
        intensity: &scan.intensity,
        offset_ns: &scan.offset_ns,
    };
    let pose = |step: i64| Isometry::translation(step as f64 * 0.003, 0.0, 0.0);
    let poses: Vec<_> =
        (-1..42).map(|step| (scan.stamp + Span::from_nanos(2_500_000 * step), pose(step))).collect();
    bencher.bench_local(|| deskew(black_box(&view), &poses, &Isometry::identity()));
}

#[divan::bench]
fn downsample_to_13_cm_and_to_26_cm(bencher: Bencher) {
    let scan = last_scan();
    let mut downsampler = Downsampler::default();
    let (mut fine, mut coarse, mut xyz) = (Vec::new(), Vec::new(), Vec::new());
    bencher.bench_local(|| {
        fine.clear();
        downsampler.downsample(black_box(&scan.xyz), &[], 0.13, &mut fine);
        xyz.clear();
        xyz.extend(fine.iter().map(|centroid: &Centroid| centroid.xyz));
        coarse.clear();
        downsampler.downsample(&xyz, &[], 0.26, &mut coarse);
        coarse.len()
    });
}

#[divan::bench]
fn one_linearisation(bencher: Bencher) {
    let mut map = GaussianMap::new(GaussianMapConfig::default());
    insert(&mut map, &downsampled(0.1));
    insert(&mut map, &downsampled(0.12));
    let coarse = downsampled(0.26);
    let pose = Isometry::translation(0.002, 0.001, 0.0);
    bencher.bench_local(|| linearise(&map, black_box(&coarse), &pose, &MatchingConfig::default()));
}

#[divan::bench]
fn insert_a_scan(bencher: Bencher) {
    let fine = downsampled(0.13);
    let mut map = GaussianMap::new(GaussianMapConfig::default());
    for _ in 0..5 {
        insert(&mut map, &fine);
    }
    bencher.bench_local(|| insert(&mut map, black_box(&fine)));
}

/// All sources for five seconds. One scan costs a fiftieth.
#[divan::bench(sample_count = 5)]
fn fifty_scans_with_imu_and_legs() -> usize {
    let walk = walk();
    let mut odometry = Odometry::new(OdometryConfig { mounting: walk.mounting, ..OdometryConfig::default() });
    let mut out: Vec<OdometryEvent> = Vec::new();
    let mut events = 0;
    for message in &walk.messages {
        match message {
            Sensor::Scan(scan) => {
                let (xyz, intensity) = (scan.xyz.as_slice(), scan.intensity.as_slice());
                let view = ScanView { stamp: scan.stamp, xyz, intensity, offset_ns: &scan.offset_ns };
                odometry.insert_scan(view, &mut out);
            }
            Sensor::Imu(imu) => {
                let (gyro, force) =
                    (vec_from_plain(imu.angular_velocity), vec_from_plain(imu.specific_force));
                odometry.insert_imu(imu.stamp, gyro, force, &mut out);
            }
            Sensor::Legs(legs) => odometry.insert_leg_velocity(
                legs.stamp,
                [legs.base_velocity.linear, legs.base_velocity.angular].map(vec_from_plain),
                &mut out,
            ),
            Sensor::Odometry(_) | Sensor::Battery(_) => {}
        }
        events += out.drain(..).count();
    }
    events
}
