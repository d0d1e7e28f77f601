//! The simulator: one world, advanced in blocks of 10 ms, whose sensors speak in the order of their arrival.

use crate::battery::Battery;
use crate::body::{Body, STANDING_HEIGHT};
use crate::faults::{Fault, Faults};
use crate::gait::Wobble;
use crate::imu::Imu;
use crate::legs::Legs;
use crate::lidar::{FULL_COLUMNS, Lidar};
use crate::people::People;
use crate::route::Start;
use crate::site::{Site, SiteName};
use crate::{
    BLOCK_NANOS, BLOCK_SECONDS, BLOCKS_PER_SWEEP, IMU_HZ, TICK_NANOS, TICK_SECONDS, TICKS_PER_BLOCK,
    TICKS_PER_IMU,
};
use geometry::{Isometry, RngTree, Rotation, Vector3, vec_from_plain};
use messages::{BootRecord, Drive, Mounting, RobotProfile, Sensor, Sources};
use nalgebra::Translation3;
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::sync::Arc;
use vocab::{Pose, Span, Stamp, Twist, Vec3};

/// Commands cease to hold after this long.
const COMMAND_LIFE: Span = Span::from_millis(500);
/// Blocks between two messages of the battery.
const BLOCKS_PER_BATTERY: i64 = 100;
/// Truths kept for whoever asks: one minute.
const TRUTHS_KEPT: usize = 6000;

/// Places that somebody who carries the robot away looks at.
const PLACES: i64 = 96;
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// What to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct SimConfig {
    /// Where.
    pub site: SiteName,
    /// Of every random number; the site itself does not depend on it.
    pub seed: u64,
    /// Columns of a LiDAR sweep; [`FULL_COLUMNS`] is full resolution (640,000 rays a second). Rounded up to a multiple
    /// of 10.
    pub lidar_columns: u32,
    /// People walking about.
    pub people: u32,
    /// Where the robot stands at first; at the site's first dock if not said.
    pub start: Option<Start>,
    /// What goes wrong, and when.
    pub faults: Vec<Fault>,
    /// The instant at which the simulation begins.
    pub epoch: Stamp,
    /// Sensors without noise, bias, drift or dropouts, for tests.
    pub ideal: bool,
}

impl SimConfig {
    /// Full resolution, three people, no faults, 2026-01-01 00:00 UTC.
    pub fn new(site: SiteName, seed: u64) -> Self {
        Self {
            site,
            seed,
            lidar_columns: FULL_COLUMNS,
            people: 3,
            start: None,
            faults: Vec::new(),
            epoch: Stamp::from_parts(1_767_225_600, 0),
            ideal: false,
        }
    }
}

/// A message of a sensor with the moment at which it reaches the computer.
#[derive(Clone, Debug, PartialEq)]
pub struct SimEvent {
    /// Arrival.
    pub at: Stamp,
    /// The message.
    pub sensor: Sensor,
}

/// Where the robot really is. For scorers and recordings only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// The instant.
    pub stamp: Stamp,
    /// Base in the site.
    pub site_from_base: Pose,
    /// Velocity of the base in its own frame.
    pub velocity: Twist,
}

/// Somebody lifts the robot so high, metres, in so long, seconds, and walks at so many steps a second.
const LIFTED: f64 = 0.35;
const LIFTING: f64 = 1.5;
const STEPS_HZ: f64 = 1.8;

/// A robot in somebody's arms: x, y (metres) and yaw (radians) at both ends, and the blocks of 10 ms that it takes.
#[derive(Clone, Copy, Debug)]
struct Carried {
    from: [f64; 3],
    to: [f64; 3],
    done: i64,
    blocks: i64,
}

impl Carried {
    /// Smoothly from rest to rest.
    fn at(&self) -> [f64; 3] {
        let share = (self.done as f64 / self.blocks as f64).min(1.0);
        let eased = share - (TAU * share).sin() / TAU;
        [0, 1, 2].map(|axis| self.from[axis] + (self.to[axis] - self.from[axis]) * eased)
    }

    /// Lifted, and swaying with the steps of who carries it, so long after it was taken up, seconds.
    fn sway(&self, seconds: f64) -> Wobble {
        let whole = self.blocks as f64 * BLOCK_SECONDS;
        let share = (seconds.min(whole - seconds) / LIFTING.min(whole / 2.0)).clamp(0.0, 1.0);
        // Continuous in acceleration.
        let ease = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
        let swing = |steps: f64, phase: f64| ease * (TAU * STEPS_HZ * steps * seconds + phase).sin();
        Wobble {
            shift: [0.0, 0.02 * swing(0.5, 0.0), LIFTED * ease + 0.02 * swing(1.0, 0.5)],
            lean: [0.04 * swing(0.5, 1.0), 0.03 * swing(1.0, 2.0), 0.0],
        }
    }
}

/// An angle between -π and π.
fn wrapped(angle: f64) -> f64 {
    let (sin, cos) = angle.sin_cos();
    sin.atan2(cos)
}

/// The world with its robot.
#[derive(Clone, Debug)]
pub struct Simulator {
    epoch: Stamp,
    carried: Option<Carried>,
    site: Arc<Site>,
    body: Body,
    people: People,
    lidar: Lidar,
    imu: Imu,
    legs: Legs,
    battery: Battery,
    faults: Faults,
    /// Finished blocks.
    blocks: i64,
    command: Option<(Stamp, Drive)>,
    truths: VecDeque<Truth>,
}

/// The LiDAR in the base: on a mast, not quite straight, as such things are.
fn base_from_lidar() -> Isometry {
    let rotation = Rotation::from_euler_angles(0.012, -0.018, 0.035);
    Isometry::from_parts(Translation3::new(0.07, 0.005, 0.31), rotation)
}

/// The IMU in the base.
fn base_from_imu() -> Isometry {
    let rotation = Rotation::from_euler_angles(-0.009, 0.006, -0.015);
    Isometry::from_parts(Translation3::new(-0.035, 0.018, 0.055), rotation)
}

impl Simulator {
    /// Builds the site and puts the robot on it.
    pub fn new(config: SimConfig) -> Self {
        Self::on(Arc::new(Site::new(config.site)), config)
    }

    /// On a site that is already built (which `config.site` then does not choose), so that many runs share one.
    pub fn on(site: Arc<Site>, config: SimConfig) -> Self {
        let tree = RngTree::new(config.seed);
        let errors = |name: &str| (!config.ideal).then(|| tree.child(name).rng());
        let start = config.start.unwrap_or_else(|| site.start());
        let Vec3 { x, y, z } = start.position;
        Self {
            epoch: config.epoch,
            body: Body::new(&site, x, y, z, start.yaw, tree.child("gait").rng()),
            people: People::new(&site, config.people, tree.child("people")),
            lidar: Lidar::new(base_from_lidar(), config.lidar_columns, errors("lidar")),
            imu: Imu::new(base_from_imu(), errors("imu")),
            legs: Legs::new(errors("legs")),
            battery: Battery::new(tree.child("battery").rng().range(0.8, 1.0)),
            faults: Faults::new(config.faults),
            blocks: 0,
            command: None,
            truths: VecDeque::new(),
            carried: None,
            site,
        }
    }

    /// What the configuration of a real robot would say.
    pub fn boot(&self) -> BootRecord {
        BootRecord {
            profile: RobotProfile {
                name: format!("Simulated walker ({})", self.site.name()),
                standing_height_m: STANDING_HEIGHT,
                ..RobotProfile::default()
            },
            mounting: Mounting {
                base_from_lidar: Some(geometry::pose_from_isometry(&base_from_lidar())),
                base_from_imu: Some(geometry::pose_from_isometry(&base_from_imu())),
                base_from_external: None,
                standing_height: Some(STANDING_HEIGHT),
            },
            sources: Sources::default(),
            start_mapping: None,
            leave_loops_open: false,
            last_place: None,
            docks: Arc::default(),
        }
    }

    /// The site.
    pub fn site(&self) -> &Arc<Site> {
        &self.site
    }

    /// Moves like this from now on, for half a second or until the next command.
    pub fn command(&mut self, drive: Drive) {
        self.command = Some((self.now(), drive));
    }

    /// Somebody takes the robot up and carries it away, with its LiDAR covered and its legs limp, and puts it down there, on the same
    /// floor, after so long.
    pub fn carry(&mut self, to: Start, takes: Span) {
        let from = self.body.place();
        let to = [to.position.x, to.position.y, from[2] + wrapped(to.yaw - from[2])];
        let blocks = (takes.nanos() / BLOCK_NANOS).max(1);
        self.carried = Some(Carried { from, to, done: 0, blocks });
    }

    /// As [`Self::carry`], to wherever on the same floor there is room, 20 m away if there is and 6 m at least; nothing happens where there
    /// is none.
    pub fn carry_away(&mut self, takes: Span) {
        let [x, y, yaw] = self.body.place();
        let feet = vec_from_plain(self.truth().site_from_base.position).z - STANDING_HEIGHT;
        let places = (0..PLACES).map(|number| {
            // Round and round by the golden angle, ever nearer, from another direction each time.
            let (sin, cos) = (GOLDEN_ANGLE * (self.blocks + number) as f64).sin_cos();
            let away = 20.0 - 14.0 * number as f64 / PLACES as f64;
            Vector3::new(x + away * cos, y + away * sin, feet)
        });
        if let Some(place) = { places }.find(|place| self.site.has_room(place)) {
            let position = Vec3::new(place.x, place.y, place.z);
            self.carry(Start { position, yaw: yaw + 2.0 }, takes);
        }
    }

    /// Adds a fault; its times count from the start of the simulation, see [`Simulator::elapsed`].
    pub fn inject(&mut self, fault: Fault) {
        self.faults.add(fault);
    }

    /// Ends all faults, also those to come.
    pub fn clear_faults(&mut self) {
        self.faults.clear();
    }

    /// The end of the last finished block of 10 ms.
    pub fn now(&self) -> Stamp {
        self.epoch + self.elapsed()
    }

    /// Since the start.
    pub fn elapsed(&self) -> Span {
        Span::from_nanos(BLOCK_NANOS * self.blocks)
    }

    /// Simulates all blocks that end by `until` and appends what the sensors say, in order of arrival.
    pub fn advance(&mut self, until: Stamp, out: &mut Vec<SimEvent>) {
        while self.now() + Span::from_nanos(BLOCK_NANOS) <= until {
            self.block(out);
        }
    }

    /// Where the robot is now.
    pub fn truth(&self) -> Truth {
        self.truth_at(TICKS_PER_BLOCK as isize, self.now())
    }

    /// Where people are, at their feet, site frame.
    pub fn people(&self) -> Vec<Vec3> {
        self.people.places().iter().map(geometry::vec_to_plain).collect()
    }

    /// Hands over the truth of every 10 ms since the last call, oldest first; what is older than a minute is gone.
    pub fn take_truths(&mut self) -> Vec<Truth> {
        self.truths.drain(..).collect()
    }

    fn truth_at(&self, tick: isize, stamp: Stamp) -> Truth {
        let motion = self.body.motion();
        Truth {
            stamp,
            site_from_base: geometry::pose_from_isometry(motion.at(tick)),
            velocity: motion.velocity(tick),
        }
    }

    fn block(&mut self, out: &mut Vec<SimEvent>) {
        let (start, elapsed) = (self.now(), self.elapsed());
        let carried = self.advance_body();
        let place = self.body.motion().at(0).translation.vector;
        self.people.advance(BLOCK_SECONDS, &place);
        let (speed, turning) = self.body.pace();
        self.battery.advance(BLOCK_SECONDS, speed, self.site.docked(&place));
        let truth = self.truth_at(0, start);
        self.truths.push_back(truth);
        if self.truths.len() > TRUTHS_KEPT {
            self.truths.pop_front();
        }

        let first = out.len();
        self.sense_imu(start, elapsed, out);
        let walking = speed + turning.abs() > 0.02;
        let felt = if carried { Twist::default() } else { truth.velocity };
        let legs = self.legs.sample(start, &felt, walking, self.faults.leg_slip(elapsed));
        out.push(SimEvent { at: start + Span::from_millis(1), sensor: Sensor::Legs(legs) });
        if self.blocks % BLOCKS_PER_BATTERY == 0 {
            out.push(SimEvent { at: start, sensor: Sensor::Battery(self.battery.state(start)) });
        }
        self.sense_lidar(start, elapsed, carried, out);
        out[first..].sort_by_key(|event| event.at);
        self.blocks += 1;
    }

    /// One block of motion; says whether the robot is carried.
    fn advance_body(&mut self) -> bool {
        let wanted = self.wanted();
        let Some(carried) = &mut self.carried else {
            self.body.advance(&self.site, &wanted);
            return false;
        };
        let before = carried.done as f64 * BLOCK_SECONDS;
        carried.done += 1;
        let (carried, put_down) = (*carried, carried.done >= carried.blocks);
        let sway = |tick: usize| carried.sway(before + tick as f64 * TICK_SECONDS);
        self.body.carry(&self.site, carried.at(), sway, put_down);
        if put_down {
            self.carried = None;
        }
        true
    }

    /// What the legs should do now.
    fn wanted(&self) -> Twist {
        match self.command {
            Some((given, drive)) if self.now() - given < COMMAND_LIFE => drive.velocity,
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
            if (elapsed + offset).nanos() >= 0 && !self.faults.imu_silent(elapsed + offset) {
                out.push(SimEvent { at: start + offset + latency, sensor: Sensor::Imu(sample) });
            }
        }
    }

    fn sense_lidar(&mut self, start: Stamp, elapsed: Span, carried: bool, out: &mut Vec<SimEvent>) {
        let block = (self.blocks % BLOCKS_PER_SWEEP) as u32;
        let sweep_start = start - Span::from_nanos(BLOCK_NANOS * i64::from(block));
        let silent = self.faults.lidar_silent(elapsed);
        let blind = silent || carried || self.faults.lidar_blind(elapsed);
        let motion = self.body.motion();
        let poses = |seconds| motion.between(seconds);
        let scan = self.lidar.advance(&self.site, &self.people, block, sweep_start, blind, poses);
        if let Some(scan) = scan
            && !silent
        {
            let at = start + Span::from_nanos(BLOCK_NANOS);
            out.push(SimEvent { at, sensor: Sensor::Scan(Arc::new(scan)) });
        }
    }
}

const _: () = assert!(IMU_HZ as i64 * TICK_NANOS * TICKS_PER_IMU as i64 == 1_000_000_000);
