//! The path of every sensor message from a link to the control loop.

use crate::standstill::{StandstillConfig, StandstillDetector};
use crate::{quantise, thin};
use messages::{Scan, Sensor};
use std::sync::Arc;
use vocab::Stamp;

/// Parameters of [`ScanPreparation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreparationConfig {
    /// When the robot counts as standing.
    pub standstill: StandstillConfig,
    /// Points of a sweep while the robot stands. A sweep with more keeps some of its columns only, and its successors the others. 8,000 are every eighth
    /// column of an XT-32, 1.4° apart. The stack needs fewer: its closed-loop tests have sweeps of 6,400. Chosen: more fill the disk, fewer show people to
    /// clients less well.
    pub max_standing_points: usize,
}

impl Default for PreparationConfig {
    fn default() -> Self {
        Self { standstill: StandstillConfig::default(), max_standing_points: 8_000 }
    }
}

/// Prepares sweeps for the stack: moves them onto the grid, and thins them while the robot stands.
///
/// Thinning cannot hide that a standing robot is moved or covered: every sweep of the sensor arrives, over the whole field of view, so that odometry sees
/// what IMU and legs did not notice, and the sensors that say that the robot stands are not thinned.
#[derive(Clone, Debug, Default)]
pub struct ScanPreparation {
    config: PreparationConfig,
    standstill: StandstillDetector,
    /// Sweeps that were thinned.
    thinned: usize,
}

impl ScanPreparation {
    /// A preparation that has seen nothing.
    pub fn new(config: PreparationConfig) -> Self {
        Self { config, standstill: StandstillDetector::new(config.standstill), thinned: 0 }
    }

    /// Prepares a message that arrives at `at`. Messages other than sweeps stay as they are.
    pub fn prepare(&mut self, at: Stamp, sensor: Sensor) -> Sensor {
        match sensor {
            Sensor::Scan(scan) => Sensor::Scan(Arc::new(self.prepare_scan(at, Arc::unwrap_or_clone(scan)))),
            other => {
                self.standstill.update(at, &other);
                other
            }
        }
    }

    fn prepare_scan(&mut self, at: Stamp, mut scan: Scan) -> Scan {
        let step = scan.xyz.len().div_ceil(self.config.max_standing_points.max(1));
        if step > 1 && self.standstill.is_standing(at) {
            thin(&mut scan, step, self.thinned);
            self.thinned = self.thinned.wrapping_add(1);
        }
        quantise(&mut scan);
        scan
    }
}
