//! Tests of the simulator.

mod cameras;
mod conditions;
mod generated;
mod instruments;
mod models;
mod motion;
mod rays;
mod sensors;
mod whole;

use crate::{GroundTruth, ScheduledFault, SimConfig, SimEvent, SimulatedSite, Simulator};
use geometry::{Isometry, isometry_from_pose};
use messages::{Drive, ImuSample, Scan, Sensor};
use std::sync::Arc;
use vocab::{Span, Twist, Vec3};

/// Few columns and no people.
fn quiet(site: impl Into<Arc<SimulatedSite>>) -> SimConfig {
    let mut config = SimConfig::new(site, 7);
    config.lidar_columns = 50;
    config.people = 0;
    config
}

/// As [`quiet`], without rays and without sensor errors.
fn ideal_blind(site: impl Into<Arc<SimulatedSite>>) -> SimConfig {
    let mut config = quiet(site);
    config.ideal = true;
    config.faults = vec![ScheduledFault::BlindLidar { from: Span::ZERO, until: Span::from_secs_f64(1e6) }];
    config
}

fn drive(forward: f64, left: f64, turn: f64) -> Drive {
    let velocity = Twist { linear: Vec3::new(forward, left, 0.0), angular: Vec3::new(0.0, 0.0, turn) };
    Drive { velocity }
}

/// Runs for `tenths` of a second and repeats the command at every step.
fn run(simulator: &mut Simulator, command: Drive, tenths: usize) -> Vec<SimEvent> {
    let mut events = Vec::new();
    for _ in 0..tenths {
        simulator.command(command);
        simulator.advance(simulator.now() + Span::from_millis(100), &mut events);
    }
    events
}

fn scans(events: &[SimEvent]) -> Vec<Arc<Scan>> {
    let scan = |event: &SimEvent| match &event.sensor {
        Sensor::Scan(scan) => Some(scan.clone()),
        _ => None,
    };
    events.iter().filter_map(scan).collect()
}

fn imu(events: &[SimEvent]) -> Vec<ImuSample> {
    let sample = |event: &SimEvent| match &event.sensor {
        Sensor::Imu(sample) => Some(*sample),
        _ => None,
    };
    events.iter().filter_map(sample).collect()
}

fn site_from_base(truth: &GroundTruth) -> Isometry {
    isometry_from_pose(&truth.site_from_base).unwrap()
}
