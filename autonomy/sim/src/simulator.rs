//! The simulator: one world, advanced in blocks of 10 ms. The messages of its sensors come in the order of their arrival.

use crate::battery::SimulatedBattery;
use crate::body::{STANDING_HEIGHT, SimulatedBody};
use crate::camera::{CameraConfig, CameraImage, CameraScene, CameraSnapshot, ThermalImage};
use crate::contacts::{Contact, Contacts, TouchingBody};
use crate::dock_contact::DockContact;
use crate::faults::{FaultSchedule, ScheduledFault};
use crate::gait::PoseOffset;
use crate::ground_truth::GroundTruth;
use crate::imu::SimulatedImu;
use crate::instruments::{InstrumentEnvironment, InstrumentSnapshot};
use crate::legs::Legs;
use crate::lidar::{FULL_COLUMNS, Lidar};
use crate::people::People;
use crate::route::Start;
use crate::site::SimulatedSite;
use crate::timing::{
    BLOCK_NANOS, BLOCK_SECONDS, BLOCKS_PER_SWEEP, TICK_NANOS, TICK_SECONDS, TICKS_PER_BLOCK, TICKS_PER_IMU,
};
use geometry::{Isometry, Rng, RngTree, Rotation, Vector3, vec_from_plain};
use messages::{BootRecord, DRIVE_LIFETIME, Drive, Mounting, RobotProfile, Sensor, Sources};
use nalgebra::Translation3;
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::sync::Arc;
use vocab::{CameraAim, Span, Stamp, Twist, Vec3};

/// Blocks between two messages of the battery.
const BLOCKS_PER_BATTERY: i64 = 100;
/// Ground-truth states that are kept until they are taken: one minute.
const GROUND_TRUTH_KEPT: usize = 6000;

/// Places that are tried when the robot is carried away.
const CARRY_CANDIDATES: i64 = 96;
/// Greatest distance of such a place, metres.
const MAX_CARRY_DISTANCE_M: f64 = 20.0;
/// Least distance of such a place, metres.
const MIN_CARRY_DISTANCE_M: f64 = 6.0;
/// Rotation of the robot while it is carried away, radians.
const CARRY_ROTATION_RAD: f64 = 2.0;
/// Sum of planar speed (m/s) and turning rate (rad/s) above which the legs walk.
const MIN_WALKING_SPEED: f64 = 0.02;
/// The golden angle, radians: successive multiples of it cover all directions evenly.
const GOLDEN_ANGLE_RAD: f64 = 2.399_963_229_728_653;

/// What to simulate.
#[derive(Clone, Debug)]
pub struct SimConfig {
    /// The site. Many runs may share one. Given by the caller.
    pub site: Arc<SimulatedSite>,
    /// Seed of all random numbers. The site itself does not depend on it. Any number; the same one gives the same run.
    pub seed: u64,
    /// Columns of a LiDAR sweep, rounded up to a multiple of 10. [`FULL_COLUMNS`] is full resolution (640,000 rays a second). The default is that of the sensor; fewer
    /// make the simulation faster.
    pub lidar_columns: u32,
    /// Number of people who walk on the site. Chosen: a site at which people work but do not crowd.
    pub people: u32,
    /// Start of the robot. `None` is the first dock of the site. Given by the caller.
    pub start: Option<Start>,
    /// Faults, and when they happen. Given by the caller.
    pub faults: Vec<ScheduledFault>,
    /// Share of the attempts to dock at which no current flows although the contacts touch, 0 to 1. Chosen: often enough for missions of a day to meet it.
    pub dock_contact_failure_share: f64,
    /// Most such attempts in a row at one dock. The next one works. Chosen: two of the three attempts of a robot then remain.
    pub max_dock_contact_failures: u32,
    /// The instant at which the simulation begins. Chosen: the beginning of 2026, UTC.
    pub epoch: Stamp,
    /// Whether sensors are without noise, bias, drift and dropouts, for tests. The default is no, as real sensors are.
    pub ideal: bool,
}

impl SimConfig {
    /// Full resolution, three people, no faults but 3 % of dockings whose contacts fail, 2026-01-01 00:00 UTC.
    pub fn new(site: impl Into<Arc<SimulatedSite>>, seed: u64) -> Self {
        Self {
            site: site.into(),
            seed,
            lidar_columns: FULL_COLUMNS,
            people: 3,
            start: None,
            faults: Vec::new(),
            dock_contact_failure_share: 0.03,
            max_dock_contact_failures: 1,
            epoch: Stamp::from_parts(1_767_225_600, 0),
            ideal: false,
        }
    }
}

/// A message of a sensor with the instant at which it reaches the computer.
#[derive(Clone, Debug, PartialEq)]
pub struct SimEvent {
    /// Instant of arrival.
    pub at: Stamp,
    /// The message.
    pub sensor: Sensor,
}

/// Height to which a person lifts the robot, metres.
const LIFT_HEIGHT_M: f64 = 0.35;
/// Time that lifting takes, and putting down, seconds.
const LIFT_DURATION_S: f64 = 1.5;
/// Steps per second of the person who carries the robot, Hz.
const STEP_FREQUENCY_HZ: f64 = 1.8;
/// Amplitude of the vertical and the sideways motion with these steps, metres.
const SWAY_AMPLITUDE_M: f64 = 0.02;
/// Amplitude of the roll with these steps, radians.
const SWAY_ROLL_RAD: f64 = 0.04;
/// Amplitude of the pitch with these steps, radians.
const SWAY_PITCH_RAD: f64 = 0.03;

/// The motion of a robot that a person carries.
#[derive(Clone, Copy, Debug)]
struct CarriedMotion {
    /// Planar pose at the beginning: x, y (metres), yaw (radians), site frame.
    from: [f64; 3],
    /// Planar pose at the end.
    to: [f64; 3],
    /// Blocks that have passed.
    elapsed_blocks: i64,
    /// Blocks that the whole motion takes.
    blocks: i64,
}

impl CarriedMotion {
    /// The present planar pose, on a path that is smooth from rest to rest.
    fn planar_pose(&self) -> [f64; 3] {
        let share = (self.elapsed_blocks as f64 / self.blocks as f64).min(1.0);
        let eased = share - (TAU * share).sin() / TAU;
        [0, 1, 2].map(|axis| self.from[axis] + (self.to[axis] - self.from[axis]) * eased)
    }

    /// The lift and the sway with the steps of the person, `seconds` after the robot was taken up.
    fn sway(&self, seconds: f64) -> PoseOffset {
        let whole = self.blocks as f64 * BLOCK_SECONDS;
        let share = (seconds.min(whole - seconds) / LIFT_DURATION_S.min(whole / 2.0)).clamp(0.0, 1.0);
        // The acceleration is continuous.
        let ease = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
        let swing = |steps: f64, phase: f64| ease * (TAU * STEP_FREQUENCY_HZ * steps * seconds + phase).sin();
        PoseOffset {
            translation_m: [
                0.0,
                SWAY_AMPLITUDE_M * swing(0.5, 0.0),
                LIFT_HEIGHT_M * ease + SWAY_AMPLITUDE_M * swing(1.0, 0.5),
            ],
            rotation_rad: [SWAY_ROLL_RAD * swing(0.5, 1.0), SWAY_PITCH_RAD * swing(1.0, 2.0), 0.0],
        }
    }
}

/// The angle between -π and π.
fn wrap_angle(angle: f64) -> f64 {
    let (sin, cos) = angle.sin_cos();
    sin.atan2(cos)
}

/// A site with its robot and its people.
#[derive(Clone, Debug)]
pub struct Simulator {
    epoch: Stamp,
    carried: Option<CarriedMotion>,
    site: Arc<SimulatedSite>,
    body: SimulatedBody,
    people: People,
    lidar: Lidar,
    imu: SimulatedImu,
    legs: Legs,
    battery: SimulatedBattery,
    dock_contact: DockContact,
    contacts: Contacts,
    cameras: CameraConfig,
    /// What the cameras see, prepared with the first picture.
    camera_scene: Option<Arc<CameraScene>>,
    camera_rng: Rng,
    /// What the instruments sense of the site, prepared with the first reading.
    surroundings: Option<Arc<InstrumentEnvironment>>,
    instrument_rng: Rng,
    faults: FaultSchedule,
    /// Number of finished blocks.
    blocks: i64,
    /// The last drive command, with the time at which it was given.
    command: Option<(Stamp, Drive)>,
    /// Ground truth since it was last taken, oldest first.
    ground_truth: VecDeque<GroundTruth>,
}

/// Pose of the LiDAR in the base: on a mast, with small mounting angles.
fn base_from_lidar() -> Isometry {
    let rotation = Rotation::from_euler_angles(0.012, -0.018, 0.035);
    Isometry::from_parts(Translation3::new(0.07, 0.005, 0.31), rotation)
}

/// Pose of the IMU in the base.
fn base_from_imu() -> Isometry {
    let rotation = Rotation::from_euler_angles(-0.009, 0.006, -0.015);
    Isometry::from_parts(Translation3::new(-0.035, 0.018, 0.055), rotation)
}

impl Simulator {
    /// Places the robot and the people on the site.
    pub fn new(config: SimConfig) -> Self {
        let site = config.site;
        let tree = RngTree::new(config.seed);
        let errors = |name: &str| (!config.ideal).then(|| tree.child(name).rng());
        let start = config.start.unwrap_or_else(|| site.start());
        let Vec3 { x, y, z } = start.position;
        let body = SimulatedBody::new(&site, x, y, z, start.yaw, tree.child("gait").rng());
        let contact_rng = tree.child("dock contact").rng();
        let place = body.motion().at(0);
        Self {
            dock_contact: DockContact::new(
                config.dock_contact_failure_share,
                config.max_dock_contact_failures,
                contact_rng,
                &site,
                place,
            ),
            epoch: config.epoch,
            body,
            people: People::new(&site, config.people, tree.child("people")),
            lidar: Lidar::new(base_from_lidar(), config.lidar_columns, errors("lidar")),
            imu: SimulatedImu::new(base_from_imu(), errors("imu")),
            legs: Legs::new(errors("legs")),
            battery: SimulatedBattery::new(tree.child("battery").rng().range(0.8, 1.0)),
            contacts: Contacts::default(),
            cameras: CameraConfig::default(),
            camera_scene: None,
            camera_rng: tree.child("camera").rng(),
            surroundings: None,
            instrument_rng: tree.child("instruments").rng(),
            faults: FaultSchedule::new(config.faults),
            blocks: 0,
            command: None,
            ground_truth: VecDeque::new(),
            carried: None,
            site,
        }
    }

    /// The boot record that the configuration of a real robot would hold.
    pub fn boot(&self) -> BootRecord {
        BootRecord {
            profile: RobotProfile {
                name: format!("Simulated walker ({})", self.site.name()),
                standing_height_m: STANDING_HEIGHT,
                camera_head: self.cameras.head(),
                ..RobotProfile::default()
            },
            mounting: Mounting {
                base_from_lidar: Some(geometry::pose_from_isometry(&base_from_lidar())),
                base_from_imu: Some(geometry::pose_from_isometry(&base_from_imu())),
                base_from_external: None,
                standing_height_m: Some(STANDING_HEIGHT),
            },
            sources: Sources::default(),
            start_mapping: None,
            leave_loops_open: false,
            last_pose: None,
            docks: Arc::default(),
            stop_latch: None,
        }
    }

    /// The site.
    pub fn site(&self) -> &Arc<SimulatedSite> {
        &self.site
    }

    /// Sets the drive command. It holds for half a second or until the next one.
    pub fn command(&mut self, drive: Drive) {
        self.command = Some((self.now(), drive));
    }

    /// A person lifts the robot, with its LiDAR covered and its legs hanging, and puts it down at `to`, on the same floor, after `duration`.
    pub fn carry(&mut self, to: Start, duration: Span) {
        let from = self.body.planar_pose();
        let to = [to.position.x, to.position.y, from[2] + wrap_angle(to.yaw - from[2])];
        let blocks = (duration.nanos() / BLOCK_NANOS).max(1);
        self.carried = Some(CarriedMotion { from, to, elapsed_blocks: 0, blocks });
    }

    /// As [`Self::carry`], to a free place on the same floor, 20 m away if there is one and at least 6 m. Without a free place nothing happens;
    /// returns whether there is one.
    pub fn carry_away(&mut self, duration: Span) -> bool {
        let [x, y, yaw] = self.body.planar_pose();
        let feet = vec_from_plain(self.truth().site_from_base.position).z - STANDING_HEIGHT;
        let places = (0..CARRY_CANDIDATES).map(|number| {
            // The candidates form a spiral inwards, each in another direction.
            let (sin, cos) = (GOLDEN_ANGLE_RAD * (self.blocks + number) as f64).sin_cos();
            let away = MAX_CARRY_DISTANCE_M
                - (MAX_CARRY_DISTANCE_M - MIN_CARRY_DISTANCE_M) * number as f64 / CARRY_CANDIDATES as f64;
            Vector3::new(x + away * cos, y + away * sin, feet)
        });
        let Some(place) = { places }.find(|place| self.site.has_room(place)) else {
            return false;
        };
        let position = Vec3::new(place.x, place.y, place.z);
        self.carry(Start { position, yaw: yaw + CARRY_ROTATION_RAD }, duration);
        true
    }

    /// Adds a fault; its times count from the start of the simulation, see [`Simulator::elapsed`].
    pub fn inject_fault(&mut self, fault: ScheduledFault) {
        self.faults.add(fault);
    }

    /// Removes all faults, present and future.
    pub fn clear_faults(&mut self) {
        self.faults.clear();
    }

    /// The cameras on the robot's head.
    pub fn cameras(&self) -> &CameraConfig {
        &self.cameras
    }

    /// What the cameras can see of the site.
    pub fn camera_scene(&mut self) -> Arc<CameraScene> {
        let site = &self.site;
        Arc::clone(self.camera_scene.get_or_insert_with(|| Arc::new(CameraScene::new(Arc::clone(site)))))
    }

    /// What the robot's instruments sense of its surroundings besides light: prepared with the first reading.
    pub fn surroundings(&mut self) -> Arc<InstrumentEnvironment> {
        let scene = self.camera_scene();
        Arc::clone(self.surroundings.get_or_insert_with(|| Arc::new(InstrumentEnvironment::new(&scene))))
    }

    /// This instant, for a picture.
    pub fn camera_snapshot(&mut self) -> CameraSnapshot {
        CameraSnapshot {
            cameras: self.cameras,
            people: self.people.clone(),
            site_from_base: self.site_from_base(),
            seconds: self.elapsed().secs_f64(),
            rng: RngTree::new(self.camera_rng.bits()).rng(),
        }
    }

    /// This instant, for a reading of instruments.
    pub fn instrument_snapshot(&mut self) -> InstrumentSnapshot {
        InstrumentSnapshot {
            site_from_base: self.site_from_base(),
            seconds: self.elapsed().secs_f64(),
            rng: RngTree::new(self.instrument_rng.bits()).rng(),
        }
    }

    /// Takes a picture now. The head goes to the nearest aim that it can take.
    pub fn picture(&mut self, aim: &CameraAim) -> CameraImage {
        let scene = self.camera_scene();
        self.camera_snapshot().picture(&scene, aim)
    }

    /// Takes a picture of temperatures now, as [`Self::picture`]. It has no zoom.
    pub fn thermal_picture(&mut self, aim: &CameraAim) -> ThermalImage {
        let scene = self.camera_scene();
        self.camera_snapshot().thermal_picture(&scene, aim)
    }

    /// True pose of the base now.
    fn site_from_base(&self) -> Isometry {
        *self.body.motion().at(TICKS_PER_BLOCK as isize)
    }

    /// The time at the end of the last finished block of 10 ms.
    pub fn now(&self) -> Stamp {
        self.epoch + self.elapsed()
    }

    /// The time since the start of the simulation.
    pub fn elapsed(&self) -> Span {
        Span::from_nanos(BLOCK_NANOS * self.blocks)
    }

    /// Simulates all blocks that end by `until` and appends the sensors' messages in the order of their arrival.
    pub fn advance(&mut self, until: Stamp, out: &mut Vec<SimEvent>) {
        while self.now() + Span::from_nanos(BLOCK_NANOS) <= until {
            self.advance_block(out);
        }
    }

    /// The ground truth now.
    pub fn truth(&self) -> GroundTruth {
        self.truth_at(TICKS_PER_BLOCK as isize, self.now())
    }

    /// Whether the legs move the robot, by more than 0.02 m/s or rad/s.
    pub fn is_walking(&self) -> bool {
        let (speed, turning) = self.body.planar_speed();
        speed + turning.abs() > MIN_WALKING_SPEED
    }

    /// Positions of the people, at their feet, site frame, metres.
    pub fn people(&self) -> Vec<Vec3> {
        self.people.positions().iter().map(geometry::vec_to_plain).collect()
    }

    /// Returns the contacts that have begun since the last call. The robot is not scored while it is carried.
    pub fn take_contacts(&mut self) -> Vec<Contact> {
        self.contacts.take()
    }

    /// Returns the ground truth of every 10 ms since the last call, oldest first. States older than a minute are dropped.
    pub fn take_ground_truth(&mut self) -> Vec<GroundTruth> {
        self.ground_truth.drain(..).collect()
    }

    fn truth_at(&self, tick: isize, stamp: Stamp) -> GroundTruth {
        let motion = self.body.motion();
        GroundTruth {
            stamp,
            site_from_base: geometry::pose_from_isometry(motion.at(tick)),
            velocity: motion.velocity(tick),
        }
    }

    fn advance_block(&mut self, out: &mut Vec<SimEvent>) {
        let (start, elapsed) = (self.now(), self.elapsed());
        let carried = self.advance_body();
        let site_from_base = *self.body.motion().at(0);
        self.people.advance(BLOCK_SECONDS, &site_from_base.translation.vector);
        let (speed, _) = self.body.planar_speed();
        let is_docked = self.dock_contact.update(&self.site, &site_from_base);
        self.battery.advance(BLOCK_SECONDS, speed, is_docked);
        let truth = self.truth_at(0, start);
        self.ground_truth.push_back(truth);
        if self.ground_truth.len() > GROUND_TRUTH_KEPT {
            self.ground_truth.pop_front();
        }

        if !carried {
            self.update_contacts(start, &site_from_base, &truth);
        }

        let first = out.len();
        self.sense_imu(start, elapsed, out);
        let walking = self.is_walking();
        // The legs of a carried robot hang, so they measure no motion.
        let leg_velocity = if carried { Twist::default() } else { truth.velocity };
        let legs = self.legs.sample(start, &leg_velocity, walking, self.faults.leg_slip_velocity(elapsed));
        out.push(SimEvent { at: start + Span::from_millis(1), sensor: Sensor::Legs(legs) });
        if self.blocks % BLOCKS_PER_BATTERY == 0 {
            out.push(SimEvent { at: start, sensor: Sensor::Battery(self.battery.state(start)) });
        }
        self.sense_lidar(start, elapsed, carried, out);
        out[first..].sort_by_key(|event| event.at);
        self.blocks += 1;
    }

    fn update_contacts(&mut self, at: Stamp, site_from_base: &Isometry, truth: &GroundTruth) {
        let body = TouchingBody {
            position: site_from_base.translation.vector,
            velocity: site_from_base.rotation * vec_from_plain(truth.velocity.linear),
            spheres: self.body.spheres(),
            touches_solid: self.body.touches_solid(),
        };
        self.contacts.update(at, &body, &self.people);
    }

    /// Advances the body by one block; returns whether the robot is carried.
    fn advance_body(&mut self) -> bool {
        let commanded = self.commanded_velocity();
        let Some(carried) = &mut self.carried else {
            self.body.advance(&self.site, &commanded);
            return false;
        };
        let before = carried.elapsed_blocks as f64 * BLOCK_SECONDS;
        carried.elapsed_blocks += 1;
        let (carried, put_down) = (*carried, carried.elapsed_blocks >= carried.blocks);
        let sway = |tick: usize| carried.sway(before + tick as f64 * TICK_SECONDS);
        self.body.carry(&self.site, carried.planar_pose(), sway, put_down);
        if put_down {
            self.carried = None;
        }
        true
    }

    /// The velocity that is commanded now.
    fn commanded_velocity(&self) -> Twist {
        match self.command {
            Some((given, drive)) if self.now() - given < DRIVE_LIFETIME => drive.velocity,
            _ => Twist::default(),
        }
    }

    fn sense_imu(&mut self, start: Stamp, elapsed: Span, out: &mut Vec<SimEvent>) {
        // A sample looks three ticks ahead, so the samples of a block begin one period before it.
        let latency = Span::from_nanos(TICK_NANOS * TICKS_PER_IMU as i64);
        for tick in
            (0..TICKS_PER_BLOCK as isize).step_by(TICKS_PER_IMU as usize).map(|tick| tick - TICKS_PER_IMU)
        {
            let offset = Span::from_nanos(TICK_NANOS * tick as i64);
            let sample = self.imu.sample(self.body.motion(), tick, start + offset);
            if (elapsed + offset).nanos() >= 0 && !self.faults.is_imu_silent(elapsed + offset) {
                out.push(SimEvent { at: start + offset + latency, sensor: Sensor::Imu(sample) });
            }
        }
    }

    fn sense_lidar(&mut self, start: Stamp, elapsed: Span, carried: bool, out: &mut Vec<SimEvent>) {
        let block = (self.blocks % BLOCKS_PER_SWEEP) as u32;
        let sweep_start = start - Span::from_nanos(BLOCK_NANOS * i64::from(block));
        let silent = self.faults.is_lidar_silent(elapsed);
        let blind = silent || carried || self.faults.is_lidar_blind(elapsed);
        let motion = self.body.motion();
        let poses = |seconds| motion.interpolate_at(seconds);
        let scan = self.lidar.advance(&self.site, &self.people, block, sweep_start, blind, poses);
        if let Some(scan) = scan
            && !silent
        {
            let at = start + Span::from_nanos(BLOCK_NANOS);
            out.push(SimEvent { at, sensor: Sensor::Scan(Arc::new(scan)) });
        }
    }
}
