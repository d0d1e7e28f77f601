//! Simulated walks as input of mapping: the keyframes of the odometry, with the ground truth for the score.

use anyhow::{Context, Result, bail};
use benches::keyframe_policy;
use benches::stack_walk::WalkPlan;
use geometry::{Isometry, Matrix6, isometry_from_pose, se3, vec_from_plain};
use mapping::{PoseGraph, ScanPose, Session, SessionConfig};
use messages::Sensor;
use odometry::{Mounting, Odometry, OdometryConfig, OdometryEvent, PoseEvent, ScanView};
use points::Downsampler;
use sim::{RouteFollower, SimConfig, SimulatedSite, Simulator};
use std::io::{Read, Write};
use std::path::Path;
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Edge of the voxels in which clouds are averaged, metres; the robot's value.
const VOXEL_M: f32 = 0.04;
/// Interval between two drive commands.
const COMMAND_INTERVAL: Span = Span::from_millis(50);

/// A recorded keyframe.
#[derive(Clone, Debug)]
pub struct RecordedKeyframe {
    pub stamp: Stamp,
    pub odom_from_base: Isometry,
    pub covariance: Matrix6,
    pub degenerate: bool,
    /// True pose of the base.
    pub site_from_base: Isometry,
    /// Motion-corrected points, base frame, metres.
    pub cloud: Vec<[f32; 3]>,
}

/// The keyframes of a walk: read from `file` if it exists, otherwise simulated and written there.
pub fn keyframes(
    site: &Arc<SimulatedSite>,
    plan: &WalkPlan,
    seconds: f64,
    file: &Path,
) -> Result<Vec<RecordedKeyframe>> {
    if file.exists() {
        return load(file).with_context(|| format!("{} cannot be read; delete it", file.display()));
    }
    let walked = walk(site, plan, seconds)?;
    store(&walked, file).with_context(|| format!("{} cannot be written", file.display()))?;
    Ok(walked)
}

fn walk(site: &Arc<SimulatedSite>, plan: &WalkPlan, seconds: f64) -> Result<Vec<RecordedKeyframe>> {
    let Some(route) = site.route("round").cloned() else { bail!("{} has no round", site.name()) };
    let mut config = SimConfig {
        lidar_columns: plan.columns,
        people: plan.people,
        ..SimConfig::new(Arc::clone(site), plan.seed)
    };
    config.start = Some(route.start);
    let mut simulator = Simulator::new(config);
    let boot = simulator.boot().mounting;
    let mounting = Mounting::from_poses(boot.base_from_lidar.as_ref(), boot.base_from_imu.as_ref(), None);
    let mut recorder = KeyframeRecorder::new(OdometryConfig { mounting, ..OdometryConfig::default() });
    let mut walker = RouteFollower::new(route.clone());
    let mut events = Vec::new();
    while simulator.elapsed().secs_f64() < seconds {
        let Some(drive) = walker.drive(&simulator.truth()) else {
            // On longer walks the route begins again.
            walker = RouteFollower::new(route.clone());
            continue;
        };
        simulator.command(drive);
        let until = simulator.now() + COMMAND_INTERVAL;
        simulator.advance(until, &mut events);
        for truth in simulator.take_ground_truth() {
            let pose = isometry_from_pose(&truth.site_from_base).context("a true pose is no pose")?;
            recorder.truth.push((truth.stamp, pose));
        }
        for event in events.drain(..) {
            recorder.on_message(&event.sensor);
        }
    }
    Ok(recorder.keyframes)
}

/// Odometry with the keyframe policy of the stack.
struct KeyframeRecorder {
    odometry: Odometry,
    pending: Option<Box<PoseEvent>>,
    session: Option<Session>,
    downsampler: Downsampler,
    truth: Vec<(Stamp, Isometry)>,
    keyframes: Vec<RecordedKeyframe>,
    out: Vec<OdometryEvent>,
}

impl KeyframeRecorder {
    fn new(config: OdometryConfig) -> Self {
        Self {
            odometry: Odometry::new(config),
            pending: None,
            session: None,
            downsampler: Downsampler::default(),
            truth: Vec::new(),
            keyframes: Vec::new(),
            out: Vec::new(),
        }
    }

    fn on_message(&mut self, sensor: &Sensor) {
        let mut out = std::mem::take(&mut self.out);
        match sensor {
            Sensor::Imu(imu) => self.odometry.insert_imu(
                imu.stamp,
                vec_from_plain(imu.angular_velocity),
                vec_from_plain(imu.specific_force),
                &mut out,
            ),
            Sensor::Legs(legs) => {
                self.odometry.insert_leg_velocity(
                    legs.stamp,
                    [legs.base_velocity.linear, legs.base_velocity.angular].map(vec_from_plain),
                    &mut out,
                );
            }
            Sensor::Scan(scan) => {
                let (xyz, intensity) = (scan.xyz.as_slice(), scan.intensity.as_slice());
                let view = ScanView { stamp: scan.stamp, xyz, intensity, offset_ns: &scan.offset_ns };
                self.odometry.insert_scan(view, &mut out);
            }
            Sensor::Odometry(_) | Sensor::Battery(_) => {}
        }
        for event in out.drain(..) {
            match event {
                OdometryEvent::Pose(pose) => self.pending = Some(pose),
                OdometryEvent::Scan(scan) => {
                    if let Some(pose) = self.pending.take() {
                        self.scan(&pose, &scan.xyz);
                    }
                }
                OdometryEvent::Started(_) | OdometryEvent::Finding(_) => {}
            }
        }
        self.out = out;
    }

    fn scan(&mut self, pose: &PoseEvent, xyz: &[[f32; 3]]) {
        let estimate = &pose.estimate;
        let session = self.session.get_or_insert_with(|| {
            Session::begin(
                &estimate.odom_from_base,
                SessionConfig::new(keyframe_policy()),
                PoseGraph::default(),
            )
        });
        let degenerate = pose.degenerate_directions.iter().any(Option::is_some);
        let added = session.add_scan(&ScanPose {
            stamp: estimate.stamp,
            odom_from_base: estimate.odom_from_base,
            scan_stamp: pose.scan_stamp,
            odom_from_base_at_scan: pose.odom_from_base_at_scan,
            covariance: estimate.covariance,
            covariance_inflation: estimate.covariance_inflation,
            is_degenerate: degenerate,
            is_gravity_measured: pose.is_gravity_measured,
            is_dead_reckoned: pose.is_dead_reckoned,
        });
        if added.is_none() {
            return;
        }
        let mut centroids = Vec::new();
        self.downsampler.downsample(xyz, &[], VOXEL_M, &mut centroids);
        self.keyframes.push(RecordedKeyframe {
            stamp: estimate.stamp,
            odom_from_base: estimate.odom_from_base,
            covariance: estimate.covariance,
            degenerate,
            site_from_base: self.truth_at(estimate.stamp),
            cloud: centroids.iter().map(|centroid| centroid.xyz).collect(),
        });
    }

    fn truth_at(&self, stamp: Stamp) -> Isometry {
        let after = self.truth.partition_point(|entry| entry.0 < stamp).clamp(1, self.truth.len() - 1);
        let (before, after) = (&self.truth[after - 1], &self.truth[after]);
        let fraction = (stamp - before.0).secs_f64() / (after.0 - before.0).secs_f64();
        se3::interpolate(&before.1, &after.1, fraction.min(1.0))
    }
}

fn store(keyframes: &[RecordedKeyframe], file: &Path) -> Result<()> {
    let mut bytes = Vec::new();
    bytes.extend((keyframes.len() as u64).to_le_bytes());
    for keyframe in keyframes {
        bytes.extend(keyframe.stamp.nanos().to_le_bytes());
        let mut numbers = Vec::new();
        for pose in [&keyframe.odom_from_base, &keyframe.site_from_base] {
            numbers.extend(pose.translation.vector.iter());
            numbers.extend(pose.rotation.coords.iter());
        }
        numbers.extend(keyframe.covariance.iter());
        numbers.push(f64::from(u8::from(keyframe.degenerate)));
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        bytes.extend((keyframe.cloud.len() as u64).to_le_bytes());
        bytes.extend(keyframe.cloud.iter().flatten().flat_map(|c| c.to_le_bytes()));
    }
    // Written under another name first, so that an interrupted write is not taken for a complete walk.
    let partial = file.with_extension("partial");
    std::fs::File::create(&partial)?.write_all(&bytes)?;
    Ok(std::fs::rename(partial, file)?)
}

fn load(file: &Path) -> Result<Vec<RecordedKeyframe>> {
    let mut reader = std::io::BufReader::new(std::fs::File::open(file)?);
    let count = u64::from_le_bytes(read_word(&mut reader)?);
    (0..count)
        .map(|_| {
            let stamp = Stamp::from_nanos(i64::from_le_bytes(read_word(&mut reader)?));
            let mut number = || -> Result<f64> { Ok(f64::from_le_bytes(read_word(&mut reader)?)) };
            let mut pose = || -> Result<Isometry> {
                let [x, y, z] = [number()?, number()?, number()?];
                let [i, j, k, w] = [number()?, number()?, number()?, number()?];
                let rotation =
                    nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, i, j, k));
                Ok(Isometry::from_parts(nalgebra::Translation3::new(x, y, z), rotation))
            };
            let (odom_from_base, site_from_base) = (pose()?, pose()?);
            let mut covariance = Matrix6::zeros();
            for value in covariance.iter_mut() {
                *value = number()?;
            }
            let degenerate = number()? > 0.5;
            let points = u64::from_le_bytes(read_word(&mut reader)?) as usize;
            let mut bytes = vec![0; points * 12];
            reader.read_exact(&mut bytes)?;
            let coordinate = |c: &[u8]| f32::from_le_bytes([c[0], c[1], c[2], c[3]]);
            let cloud = bytes
                .chunks_exact(12)
                .map(|point| [coordinate(&point[..4]), coordinate(&point[4..8]), coordinate(&point[8..])])
                .collect();
            Ok(RecordedKeyframe { stamp, odom_from_base, covariance, degenerate, site_from_base, cloud })
        })
        .collect()
}

fn read_word(reader: &mut impl Read) -> Result<[u8; 8]> {
    let mut bytes = [0; 8];
    reader.read_exact(&mut bytes)?;
    Ok(bytes)
}
