//! Scans of a standing robot, for tests of several parts.

use crate::odometry_adapter::{LocatedScan, OdometryAdapter, OdometryEvent};
use messages::{BootRecord, Scan, Sensor, Sources};
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Time of a sweep.
pub(crate) const SWEEP: Span = Span::from_millis(100);

/// A scan of a closed room of 8 m by 6 m by 3 m, taken in its middle.
pub(crate) fn room_scan(number: i64) -> Sensor {
    let mut xyz = Vec::new();
    for row in -30..=30_i16 {
        for column in -30..=30_i16 {
            let (a, b) = (f32::from(row) / 30.0, f32::from(column) / 30.0);
            xyz.extend([[4.0, 3.0 * a, 1.5 * b], [-4.0, 3.0 * a, 1.5 * b]]);
            xyz.extend([[4.0 * a, 3.0, 1.5 * b], [4.0 * a, -3.0, 1.5 * b]]);
            xyz.extend([[4.0 * a, 3.0 * b, 1.5], [4.0 * a, 3.0 * b, -1.5]]);
        }
    }
    let stamp = Stamp::from_parts(10, 0) + Span::from_nanos(SWEEP.nanos() * number);
    let intensity = vec![7.0; xyz.len()];
    let last = xyz.len() as i64 - 1;
    let offset_ns = (0..=last).map(|index| (SWEEP.nanos() * index / last) as i32).collect();
    Sensor::Scan(Arc::new(Scan { stamp, xyz, intensity, offset_ns, ring: Vec::new() }))
}

/// The boot record of a robot with nothing but a LiDAR.
pub(crate) fn lidar_only() -> BootRecord {
    let sources = Sources { lidar: true, imu: false, legs: false, external: false };
    BootRecord { sources, ..BootRecord::default() }
}

/// The first scans of the room, located.
pub(crate) fn located_scans() -> Vec<LocatedScan> {
    let mut adapter = OdometryAdapter::new(&lidar_only());
    let mut events = Vec::new();
    for number in 0..5 {
        adapter.update(&room_scan(number), &mut events);
    }
    adapter.flush(&mut events);
    let located = events.into_iter().filter_map(|event| match event {
        OdometryEvent::Scan(located) => Some(*located),
        _ => None,
    });
    located.collect()
}
