//! Adapter of crate `odometry`: converts sensor messages to its inputs, and its events to located scans and findings.

use crate::texts;
use geometry::{Isometry, Matrix6, Vector3, isometry_from_pose, vec_from_plain, vec_to_plain};
use messages::{BootRecord, Cloud, Finding, Sensor, Severity};
use odometry::{Mounting, Odometry, OdometryConfig, PoseEvent, ScanView, Sources};
use std::sync::Arc;
use vocab::{Stamp, Twist};

/// A motion-corrected scan with its pose by odometry.
#[derive(Clone, Debug)]
pub(crate) struct LocatedScan {
    /// Instant of the pose: the end of the sweep.
    pub stamp: Stamp,
    /// Pose of the base at that instant.
    pub odom_from_base: Isometry,
    /// The scan's own stamp, usually the start of the sweep.
    pub scan_stamp: Stamp,
    /// Pose of the base at the scan's own stamp.
    pub odom_from_base_at_scan: Isometry,
    /// Velocity of the base in its own frame, m/s and rad/s.
    pub velocity: Twist,
    /// Covariance of `odom_from_base`, `[rotation; translation]`.
    pub covariance: Matrix6,
    /// The part of the covariance that was added for unknown motion, see [`odometry::Estimate::covariance_inflation`].
    pub covariance_inflation: Matrix6,
    /// Degenerate directions of the scan's registration, as unit vectors in the base frame.
    pub degenerate: [Option<Vector3>; 3],
    /// Points that entered registration.
    pub points_used: u32,
    /// Whether an IMU measures gravity.
    pub is_gravity_measured: bool,
    /// Whether the pose is predicted by other sensors, because the LiDAR saw nothing or nothing that fits the local map.
    pub is_dead_reckoned: bool,
    /// Motion-corrected points, base frame, metres.
    pub cloud: Arc<Cloud>,
}

/// Event of the odometry.
pub(crate) enum OdometryEvent {
    /// Odometry has started or restarted. Its frame has no known relation to the one before.
    FrameReset,
    /// A scan was located.
    Scan(Box<LocatedScan>),
    /// A sensor works badly.
    Finding(Finding),
}

/// Feeds sensor messages to odometry and joins its poses and scans.
#[derive(Debug)]
pub(crate) struct OdometryAdapter {
    odometry: Odometry,
    /// The last pose without its scan. The odometry emits a pose before its scan.
    pending: Option<Box<PoseEvent>>,
    events: Vec<odometry::OdometryEvent>,
}

impl OdometryAdapter {
    /// Configures odometry with the sensors and the mounting of a boot record.
    pub fn new(record: &BootRecord) -> Self {
        let mounting = &record.mounting;
        let config = OdometryConfig {
            sources: Sources {
                lidar: record.sources.lidar,
                imu: record.sources.imu,
                legs: record.sources.legs,
                external: record.sources.external,
            },
            mounting: Mounting::from_poses(
                mounting.base_from_lidar.as_ref(),
                mounting.base_from_imu.as_ref(),
                mounting.base_from_external.as_ref(),
            ),
            self_filter: record.profile.self_filter,
            ..OdometryConfig::default()
        };
        Self { odometry: Odometry::new(config), pending: None, events: Vec::new() }
    }

    /// Findings about invalid poses in the mounting.
    pub fn mounting_findings(record: &BootRecord) -> Vec<Finding> {
        let mounting = &record.mounting;
        [("LiDAR", mounting.base_from_lidar), ("IMU", mounting.base_from_imu)]
            .into_iter()
            .filter(|(_, pose)| pose.is_some_and(|pose| isometry_from_pose(&pose).is_none()))
            .map(|(name, _)| Finding {
                severity: Severity::Error,
                what: texts::mounting_not_finite(name),
                remedy: texts::MOUNTING_REMEDY.to_owned(),
            })
            .collect()
    }

    /// Handles a sensor message and appends the odometry's events.
    pub fn update(&mut self, sensor: &Sensor, output: &mut Vec<OdometryEvent>) {
        let mut events = std::mem::take(&mut self.events);
        match sensor {
            Sensor::Imu(imu) => {
                let (gyro, force) =
                    (vec_from_plain(imu.angular_velocity), vec_from_plain(imu.specific_force));
                self.odometry.insert_imu(imu.stamp, gyro, force, &mut events);
            }
            Sensor::Legs(legs) => {
                self.odometry.insert_leg_velocity(
                    legs.stamp,
                    [legs.base_velocity.linear, legs.base_velocity.angular].map(vec_from_plain),
                    &mut events,
                );
            }
            Sensor::Odometry(external) => {
                if let Some(pose) = isometry_from_pose(&external.odom_from_external) {
                    self.odometry.insert_external_pose(external.stamp, pose, &mut events);
                }
            }
            Sensor::Scan(scan) => {
                let view = ScanView {
                    stamp: scan.stamp,
                    xyz: &scan.xyz,
                    intensity: &scan.intensity,
                    offset_ns: &scan.offset_ns,
                };
                self.odometry.insert_scan(view, &mut events);
            }
            Sensor::Battery(_) => {}
        }
        self.events = events;
        self.collect(output);
    }

    /// Processes the messages that still wait for other sensors, as at the end of a recording.
    pub fn flush(&mut self, output: &mut Vec<OdometryEvent>) {
        let mut events = std::mem::take(&mut self.events);
        self.odometry.flush(&mut events);
        self.events = events;
        self.collect(output);
    }

    /// Whether odometry tracks the robot. It does not before it has started, and while it restarts.
    pub fn is_tracking(&self) -> bool {
        self.odometry.is_tracking()
    }

    /// The latest located scan with its pose, velocity and covariance predicted for `at`.
    pub fn predict(&self, at: Stamp, last: &LocatedScan) -> Box<LocatedScan> {
        let estimate = self.odometry.predict(at);
        Box::new(LocatedScan {
            stamp: estimate.stamp,
            odom_from_base: estimate.odom_from_base,
            velocity: twist(&estimate.velocity, &estimate.turn_rate),
            covariance: estimate.covariance,
            covariance_inflation: estimate.covariance_inflation,
            ..last.clone()
        })
    }

    fn collect(&mut self, output: &mut Vec<OdometryEvent>) {
        for event in self.events.drain(..) {
            match event {
                odometry::OdometryEvent::Started(_) => output.push(OdometryEvent::FrameReset),
                odometry::OdometryEvent::Pose(pose) => self.pending = Some(pose),
                odometry::OdometryEvent::Scan(scan) => {
                    let Some(pose) = self.pending.take() else { continue };
                    let cloud = Cloud {
                        xyz: Arc::unwrap_or_clone(scan.xyz),
                        intensity: Arc::unwrap_or_clone(scan.intensity),
                    };
                    output.push(OdometryEvent::Scan(Box::new(LocatedScan {
                        stamp: pose.estimate.stamp,
                        odom_from_base: pose.estimate.odom_from_base,
                        scan_stamp: pose.scan_stamp,
                        odom_from_base_at_scan: pose.odom_from_base_at_scan,
                        velocity: twist(&pose.estimate.velocity, &pose.estimate.turn_rate),
                        covariance: pose.estimate.covariance,
                        covariance_inflation: pose.estimate.covariance_inflation,
                        degenerate: pose.degenerate_directions,
                        points_used: u32::try_from(pose.registration.points_used).unwrap_or(u32::MAX),
                        is_gravity_measured: pose.is_gravity_measured,
                        is_dead_reckoned: pose.is_dead_reckoned,
                        cloud: Arc::new(cloud),
                    })));
                }
                odometry::OdometryEvent::Finding(finding) => output.push(OdometryEvent::Finding(Finding {
                    severity: match finding.severity {
                        odometry::Severity::Info => Severity::Info,
                        odometry::Severity::Warning => Severity::Warning,
                        odometry::Severity::Error => Severity::Error,
                    },
                    what: finding.what,
                    remedy: finding.remedy,
                })),
            }
        }
    }
}

fn twist(linear: &Vector3, angular: &Vector3) -> Twist {
    Twist { linear: vec_to_plain(linear), angular: vec_to_plain(angular) }
}

#[cfg(test)]
#[path = "odometry_adapter_tests.rs"]
mod tests;
