//! Cost of a simulated second: LiDAR rays per site at full resolution, from a walking robot, and everything else.
//!
//! `cargo bench -p sim`. Divan's items are rays, so the time per item is nanoseconds per ray, including body, IMU and noise.

use divan::counter::ItemsCount;
use sim::{
    FULL_COLUMNS, RINGS, RouteFollower, SWEEP_HZ, ScheduledFault, SimConfig, SimEvent, SimulatedSite,
    Simulator, SiteName,
};
use std::sync::Arc;
use vocab::{CameraAim, Span};

fn main() {
    divan::main();
}

/// A robot eight seconds into the short route of the site.
fn walking(site: SiteName, columns: u32) -> (Simulator, RouteFollower) {
    let site = Arc::new(SimulatedSite::new(site));
    let Some(route) = site.route("short").cloned() else { panic!("every site has a short route") };
    let mut config = SimConfig::new(Arc::clone(&site), 1);
    config.lidar_columns = columns;
    config.start = Some(route.start);
    let mut simulator = Simulator::new(config);
    let mut walker = RouteFollower::new(route);
    for _ in 0..80 {
        tenth(&mut simulator, &mut walker);
    }
    (simulator, walker)
}

/// Simulates a tenth of a second: one sweep.
fn tenth(simulator: &mut Simulator, walker: &mut RouteFollower) -> Vec<SimEvent> {
    let mut events = Vec::new();
    simulator.command(walker.drive(&simulator.truth()).unwrap_or_default());
    simulator.advance(simulator.now() + Span::from_millis(100), &mut events);
    events
}

#[divan::bench(args = SiteName::ALL, sample_count = 30, sample_size = 1)]
fn sweep_at_full_resolution(bencher: divan::Bencher, site: SiteName) {
    let (mut simulator, mut walker) = walking(site, FULL_COLUMNS);
    bencher
        .counter(ItemsCount::new(FULL_COLUMNS as usize * RINGS))
        .bench_local(|| tenth(&mut simulator, &mut walker));
}

#[divan::bench(args = SiteName::ALL, sample_count = 30, sample_size = 1)]
fn tenth_of_a_second_without_rays(bencher: divan::Bencher, site: SiteName) {
    let (mut simulator, mut walker) = walking(site, SWEEP_HZ);
    simulator.inject_fault(ScheduledFault::BlindLidar { from: Span::ZERO, until: Span::from_secs_f64(1e6) });
    bencher.bench_local(|| tenth(&mut simulator, &mut walker));
}

#[divan::bench(args = SiteName::ALL, sample_count = 5, sample_size = 1)]
fn build_the_site(site: SiteName) -> SimulatedSite {
    SimulatedSite::new(site)
}

#[divan::bench(args = SiteName::ALL, sample_count = 10, sample_size = 1)]
fn picture_of_640_by_480(bencher: divan::Bencher, site: SiteName) {
    let (mut simulator, _) = walking(site, SWEEP_HZ);
    bencher.bench_local(|| simulator.picture(&CameraAim { pan_rad: 0.3, tilt_rad: 0.1, zoom: 1.0 }));
}

#[divan::bench(args = SiteName::ALL, sample_count = 10, sample_size = 1)]
fn thermal_picture_of_320_by_240(bencher: divan::Bencher, site: SiteName) {
    let (mut simulator, _) = walking(site, SWEEP_HZ);
    bencher.bench_local(|| simulator.thermal_picture(&CameraAim { pan_rad: 0.3, tilt_rad: 0.1, zoom: 1.0 }));
}
