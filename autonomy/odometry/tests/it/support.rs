//! Simulated walks in memory, and the error of an estimate against the truth.

use geometry::{Isometry, Vector3, se3, vec_from_plain};
use messages::Sensor;
use odometry::{Mounting, Odometry, OdometryConfig, OdometryEvent, PoseEvent, ScanView, Sources};
use sim::{RouteFollower, SimConfig, SimulatedSite, Simulator, SiteName, SiteRoute, Start};
use std::sync::{Arc, OnceLock};
use vocab::{Span, Stamp};

/// The sensor messages of a walk in order of arrival, and the true poses of the robot.
pub struct Walk {
    pub mounting: Mounting,
    pub messages: Vec<Sensor>,
    truth: Vec<(Stamp, Isometry)>,
}

/// The first half minute of the route "round" through b1 at a quarter of the LiDAR's resolution. Simulated once.
pub fn b1() -> &'static Walk {
    static WALK: OnceLock<Walk> = OnceLock::new();
    WALK.get_or_init(|| walk(SiteName::B1, 30.0))
}

/// Through a narrow door into a room of b1 and out again, with turns in the door. Simulated once.
pub fn narrow_doors() -> &'static Walk {
    static WALK: OnceLock<Walk> = OnceLock::new();
    WALK.get_or_init(|| {
        let site = Arc::new(SimulatedSite::new(SiteName::B1));
        let start = Start { position: vocab::Vec3 { x: 18.0, y: 37.0, z: 0.0 }, yaw: -2.0 };
        let waypoints =
            vec![[17.0, 35.0], [12.5, 35.0], [12.5, 36.0], [8.0, 36.0], [12.5, 36.0], [12.5, 28.0]];
        walk_route(&site, SiteRoute { start, waypoints, ..site.routes()[0].clone() }, 60.0)
    })
}

/// Ten seconds of walking in b1, ten of being carried to a room with the LiDAR covered, and fifteen of standing there. The stamp is the time at
/// which the robot is put down. Simulated once.
pub fn carried() -> &'static (Walk, Stamp) {
    static WALK: OnceLock<(Walk, Stamp)> = OnceLock::new();
    WALK.get_or_init(|| {
        let mut walking = Walking::on(&Arc::new(SimulatedSite::new(SiteName::B1)), None);
        walking.simulate_until(10.0);
        walking.walker = None;
        let away = Start { position: vocab::Vec3 { x: 8.0, y: 36.0, z: 0.0 }, yaw: 1.0 };
        walking.sim.carry(away, Span::from_millis(10_000));
        walking.simulate_until(20.0);
        let put_down = walking.sim.now();
        walking.simulate_until(35.0);
        (walking.end(), put_down)
    })
}

fn walk(name: SiteName, seconds: f64) -> Walk {
    let mut walking = Walking::on(&Arc::new(SimulatedSite::new(name)), None);
    walking.simulate_until(seconds);
    walking.end()
}

fn walk_route(site: &Arc<SimulatedSite>, route: SiteRoute, seconds: f64) -> Walk {
    let mut walking = Walking::on(site, Some(route));
    walking.simulate_until(seconds);
    walking.end()
}

/// A walk that is being simulated.
struct Walking {
    sim: Simulator,
    /// `None` while the robot stands still.
    walker: Option<RouteFollower>,
    mounting: Mounting,
    events: Vec<sim::SimEvent>,
    truth: Vec<(Stamp, Isometry)>,
}

impl Walking {
    /// Begins a route, by default the first one of the site.
    fn on(site: &Arc<SimulatedSite>, route: Option<SiteRoute>) -> Self {
        let route = route.unwrap_or_else(|| site.routes()[0].clone());
        let mut config = SimConfig { lidar_columns: 500, ..SimConfig::new(Arc::clone(site), 3) };
        config.start = Some(route.start);
        let sim = Simulator::new(config);
        let boot = sim.boot().mounting;
        let mounting = Mounting::from_poses(boot.base_from_lidar.as_ref(), boot.base_from_imu.as_ref(), None);
        let walker = Some(RouteFollower::new(route));
        Self { sim, walker, mounting, events: Vec::new(), truth: Vec::new() }
    }

    /// Simulates up to a number of seconds after the start, or to the end of the route.
    fn simulate_until(&mut self, seconds: f64) {
        while self.sim.elapsed().secs_f64() < seconds {
            if let Some(walker) = &mut self.walker {
                let Some(drive) = walker.drive(&self.sim.truth()) else { break };
                self.sim.command(drive);
            }
            let until = self.sim.now() + Span::from_millis(10);
            self.sim.advance(until, &mut self.events);
            let now = self.sim.truth();
            self.truth.push((now.stamp, geometry::isometry_from_pose(&now.site_from_base).unwrap()));
        }
    }

    fn end(self) -> Walk {
        let messages = self.events.into_iter().map(|event| event.sensor).collect();
        Walk { mounting: self.mounting, messages, truth: self.truth }
    }
}

/// A configuration with the named sources, or all if none is named.
pub fn config(walk: &Walk, sources: &[&str]) -> OdometryConfig {
    let has = |name| sources.is_empty() || sources.contains(&name);
    let sources =
        Sources { lidar: has("lidar"), imu: has("imu"), legs: has("legs"), external: has("external") };
    OdometryConfig { sources, mounting: walk.mounting, ..OdometryConfig::default() }
}

/// Inserts one message into the odometry.
pub fn feed(odometry: &mut Odometry, message: &Sensor, out: &mut Vec<OdometryEvent>) {
    match message {
        Sensor::Imu(imu) => odometry.insert_imu(
            imu.stamp,
            vec_from_plain(imu.angular_velocity),
            vec_from_plain(imu.specific_force),
            out,
        ),
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

/// The events of an odometry that is fed with messages.
pub fn run(config: OdometryConfig, messages: impl Iterator<Item = Sensor>) -> Vec<OdometryEvent> {
    let mut odometry = Odometry::new(config);
    let mut out = Vec::new();
    for message in messages {
        feed(&mut odometry, &message, &mut out);
    }
    odometry.flush(&mut out);
    out
}

/// The poses among events.
pub fn poses(events: &[OdometryEvent]) -> Vec<PoseEvent> {
    let pose = |event: &OdometryEvent| match event {
        OdometryEvent::Pose(pose) => Some(**pose),
        _ => None,
    };
    events.iter().filter_map(pose).collect()
}

impl Walk {
    /// True pose of the base in the site, interpolated.
    pub fn truth_at(&self, stamp: Stamp) -> Isometry {
        let after = self.truth.partition_point(|entry| entry.0 < stamp).clamp(1, self.truth.len() - 1);
        let (a, b) = (&self.truth[after - 1], &self.truth[after]);
        se3::interpolate(&a.1, &b.1, (stamp - a.0).secs_f64() / (b.0 - a.0).secs_f64())
    }

    /// Root mean square error of positions after rigid alignment, metres.
    pub fn error(&self, poses: &[PoseEvent]) -> f64 {
        let found: Vec<Vector3> =
            poses.iter().map(|p| p.estimate.odom_from_base.translation.vector).collect();
        let truth: Vec<Vector3> =
            poses.iter().map(|p| self.truth_at(p.estimate.stamp).translation.vector).collect();
        aligned_error(&found, &truth)
    }
}

/// Root mean square distance after the best rigid alignment, metres.
pub fn aligned_error(found: &[Vector3], truth: &[Vector3]) -> f64 {
    let pairs: Vec<_> = truth.iter().copied().zip(found.iter().copied()).collect();
    geometry::aligned_rmse(&pairs).unwrap()
}
