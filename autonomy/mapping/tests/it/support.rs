//! Simulates a walk through a site and keeps the odometry's keyframes in memory.

use geometry::{Isometry, isometry_from_pose, vec_from_plain};
use mapping::{KeyframePolicy, PoseGraph, PoseGraphEdge, ScanPose, Session, SessionConfig};
use messages::Sensor;
use odometry::{Mounting, Odometry, OdometryConfig, OdometryEvent, PoseEvent, ScanView};
use sim::{RouteFollower, SimConfig, Simulator, SiteName, SiteRoute};
use vocab::{Span, Stamp};

/// A keyframe.
pub struct Keyframe {
    pub site_from_base: Isometry,
    pub odom_from_base: Isometry,
    pub cloud: Vec<[f32; 3]>,
}

/// Keyframes in order, and the odometry's edges between them.
pub struct Walk {
    pub keyframes: Vec<Keyframe>,
    pub edges: Vec<PoseGraphEdge>,
}

/// Walks a route with 200 LiDAR columns and one person on the site.
pub fn walk(site: SiteName, route: SiteRoute) -> Walk {
    let mut config = SimConfig { lidar_columns: 200, people: 1, ..SimConfig::new(site, 5) };
    config.start = Some(route.start);
    let mut simulator = Simulator::new(config);
    let boot = simulator.boot().mounting;
    let mounting = Mounting::from_poses(boot.base_from_lidar.as_ref(), boot.base_from_imu.as_ref(), None);
    let mut odometry = Odometry::new(OdometryConfig { mounting, ..OdometryConfig::default() });
    let mut walker = RouteFollower::new(route);
    let (mut events, mut out, mut truth) = (Vec::new(), Vec::new(), Vec::new());
    let mut recorder = Recorder::default();
    while let Some(drive) = walker.drive(&simulator.truth()) {
        simulator.command(drive);
        simulator.advance(simulator.now() + Span::from_millis(50), &mut events);
        truth.extend(simulator.take_ground_truth());
        for event in events.drain(..) {
            feed(&mut odometry, &event.sensor, &mut out);
        }
        for event in out.drain(..) {
            recorder.handle_event(event, |stamp: Stamp| {
                let after = truth.partition_point(|t| t.stamp < stamp).min(truth.len() - 1);
                isometry_from_pose(&truth[after].site_from_base).unwrap_or_default()
            });
        }
    }
    Walk {
        keyframes: recorder.keyframes,
        edges: recorder.session.map_or(Vec::new(), |s| s.graph().edges().to_vec()),
    }
}

fn feed(odometry: &mut Odometry, sensor: &Sensor, out: &mut Vec<OdometryEvent>) {
    match sensor {
        Sensor::Imu(imu) => {
            let (gyro, force) = (vec_from_plain(imu.angular_velocity), vec_from_plain(imu.specific_force));
            odometry.insert_imu(imu.stamp, gyro, force, out);
        }
        Sensor::Legs(legs) => odometry.insert_leg_velocity(
            legs.stamp,
            [legs.base_velocity.linear, legs.base_velocity.angular].map(vec_from_plain),
            out,
        ),
        Sensor::Scan(scan) => {
            let (xyz, intensity) = (scan.xyz.as_slice(), scan.intensity.as_slice());
            odometry
                .insert_scan(ScanView { stamp: scan.stamp, xyz, intensity, offset_ns: &scan.offset_ns }, out);
        }
        Sensor::Odometry(_) | Sensor::Battery(_) => {}
    }
}

#[derive(Default)]
struct Recorder {
    session: Option<Session>,
    pending: Option<Box<PoseEvent>>,
    keyframes: Vec<Keyframe>,
}

/// Keyframes of a robot for tests.
const KEYFRAMES: KeyframePolicy = KeyframePolicy { distance_m: 1.0, rotation_rad: 0.7 };

impl Recorder {
    fn handle_event(&mut self, event: OdometryEvent, truth: impl Fn(Stamp) -> Isometry) {
        match event {
            OdometryEvent::Pose(pose) => self.pending = Some(pose),
            OdometryEvent::Scan(scan) => {
                let Some(pose) = self.pending.take() else { return };
                let estimate = &pose.estimate;
                let begin = || {
                    Session::begin(
                        &estimate.odom_from_base,
                        SessionConfig::new(KEYFRAMES),
                        PoseGraph::default(),
                    )
                };
                let added = self.session.get_or_insert_with(begin).add_scan(&ScanPose {
                    stamp: estimate.stamp,
                    odom_from_base: estimate.odom_from_base,
                    scan_stamp: pose.scan_stamp,
                    odom_from_base_at_scan: pose.odom_from_base_at_scan,
                    covariance: estimate.covariance,
                    covariance_inflation: estimate.covariance_inflation,
                    is_degenerate: pose.degenerate_directions.iter().any(Option::is_some),
                    is_gravity_measured: pose.is_gravity_measured,
                    is_dead_reckoned: pose.is_dead_reckoned,
                });
                if added.is_some() {
                    self.keyframes.push(Keyframe {
                        site_from_base: truth(estimate.stamp),
                        odom_from_base: estimate.odom_from_base,
                        cloud: scan.xyz.to_vec(),
                    });
                }
            }
            OdometryEvent::Started(_) | OdometryEvent::Finding(_) => {}
        }
    }
}
