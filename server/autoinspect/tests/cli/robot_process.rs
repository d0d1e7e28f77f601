//! The simulated robot outlives its core: scored by the truth that its process writes, which no core sees.

use crate::core_process::{CoreProcess, RobotProcess};
use crate::fake_gateway::{FakeGateway, until};
use api::{Battery, Command, Event};
use rustix::process::Signal;
use rustix::time::{ClockId, clock_gettime};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use vocab::{Twist, Vec3};

/// A line of the truth.
#[derive(Clone, Copy, Debug)]
struct TruthRow {
    robot_s: f64,
    /// On this computer's monotonic clock.
    monotonic_ns: i64,
    position: [f64; 3],
    /// Horizontal speed of the base, m/s, with the sway of the gait.
    speed_m_s: f64,
    walking: bool,
}

/// The truth file of a robot.
struct Truth {
    path: PathBuf,
}

impl Truth {
    /// Complete lines, oldest first.
    fn rows(&self) -> Vec<TruthRow> {
        let text = fs::read_to_string(&self.path).unwrap_or_default();
        let complete = text.rsplit_once('\n').map_or("", |(complete, _)| complete);
        let parse = |line: &str| {
            let fields: Vec<f64> = line.split(',').map(|field| field.parse().expect("a number")).collect();
            TruthRow {
                robot_s: fields[0] * 1e-9,
                monotonic_ns: line.split(',').nth(1).and_then(|text| text.parse().ok()).expect("a number"),
                position: [fields[2], fields[3], fields[4]],
                speed_m_s: fields[9].hypot(fields[10]),
                walking: fields[15] > 0.5,
            }
        };
        complete.lines().skip(1).map(parse).collect()
    }

    /// The present state.
    fn now(&self) -> TruthRow {
        until("the truth is written", || self.rows().last().copied())
    }

    /// Waits for robot time, while the robot stands or walks.
    fn wait(&self, robot_s: f64) {
        let from = self.now().robot_s;
        until("the robot's clock goes on", || (self.now().robot_s >= from + robot_s).then_some(()));
    }

    /// Empties the file, which keeps reading it quick.
    fn clear(&self) {
        let file = fs::OpenOptions::new().write(true).open(&self.path).expect("writable");
        file.set_len(0).expect("emptied");
    }
}

fn distance(a: &TruthRow, b: &TruthRow) -> f64 {
    let [x, y] = [0, 1].map(|axis| a.position[axis] - b.position[axis]);
    x.hypot(y)
}

fn monotonic_ns() -> i64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec * 1_000_000_000 + now.tv_nsec
}

fn robot_with_truth(dir: &Path, speed: &str) -> (RobotProcess, Truth) {
    let path = dir.join("truth.csv");
    let coarse = ["--lidar-columns", "200", "--people", "0"];
    let more = ["--speed", speed, "--truth", path.to_str().expect("UTF-8")];
    let robot = RobotProcess::start(dir, &[&coarse[..], &more[..]].concat());
    (robot, Truth { path })
}

/// Walking speed of these tests, m/s.
const SPEED_M_S: f64 = 0.6;

/// Drives by hand in arcs until the robot has walked for this time, however often something is in its way.
fn walk(gateway: &mut FakeGateway, truth: &Truth, robot_s: f64) {
    let velocity = |forward: f64, turn: f64| {
        Command::Teleoperate(Twist {
            linear: Vec3::new(forward, 0.0, 0.0),
            angular: Vec3::new(0.0, 0.0, turn),
        })
    };
    let start = Instant::now();
    let mut since: Option<f64> = None;
    let mut last_walk = truth.now().robot_s;
    loop {
        assert!(start.elapsed() < Duration::from_secs(120), "the robot does not walk");
        let now = truth.now();
        if now.speed_m_s > 0.8 * SPEED_M_S {
            last_walk = now.robot_s;
            if now.robot_s >= *since.get_or_insert(now.robot_s) + robot_s {
                return;
            }
        } else {
            since = None;
        }
        // In front of an obstacle it turns in place for a while.
        let is_blocked = (now.robot_s - last_walk) % 6.0 > 3.0;
        gateway.command(if is_blocked { velocity(0.0, 0.8) } else { velocity(SPEED_M_S, 0.4) });
    }
}

/// How the robot stopped after its core was killed or stopped.
struct Stopping {
    /// Robot time from then until its legs stand.
    time_s: f64,
    distance_m: f64,
}

/// Sends the signal to the core while the robot walks, and waits until the robot stands.
fn stopping(core: &CoreProcess, truth: &Truth, signal: Signal) -> Stopping {
    let at = monotonic_ns();
    core.signal(signal);
    // It stands when it has not walked for a second.
    let rows = until("the legs stand", || {
        let rows = truth.rows();
        let last_step = rows.iter().rfind(|row| row.walking)?;
        let last = rows.last()?;
        (last.monotonic_ns > at && last.robot_s > last_step.robot_s + 1.0).then_some(rows)
    });
    let before = rows.iter().rfind(|row| row.monotonic_ns <= at).expect("it walked before");
    assert!(before.walking, "the robot walked when the core was killed");
    let last_step = rows.iter().rfind(|row| row.walking).expect("it walked");
    let last = rows.last().expect("some rows");
    Stopping { time_s: last_step.robot_s - before.robot_s, distance_m: distance(before, last) }
}

/// How a core fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CoreFailure {
    Killed,
    Hung,
}

impl CoreFailure {
    fn signal(self) -> Signal {
        match self {
            Self::Killed => Signal::KILL,
            Self::Hung => Signal::STOP,
        }
    }

    /// Longest time from the failure until the legs stand. When the core is killed, the connection ends, and the legs stand 0.5 s later. When it
    /// hangs, its last command is valid for 0.5 s of robot time; then the legs brake from 0.6 m/s within 0.45 s.
    fn limit_s(self) -> f64 {
        match self {
            Self::Killed => 0.5,
            Self::Hung => messages::DRIVE_LIFETIME.secs_f64() + 0.45,
        }
    }
}

/// Lets the core fail again and again while the robot walks, prints a table of how it stopped, and checks it.
fn fail_while_walking(failures: &[CoreFailure]) {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (robot, truth) = robot_with_truth(dir.path(), "1");
    let mut stoppings: Vec<(CoreFailure, Stopping)> = Vec::new();
    let mut stood: Option<TruthRow> = None;
    for (number, failure) in failures.iter().enumerate() {
        let core = CoreProcess::start_with(dir.path(), &robot);
        let mut gateway = FakeGateway::connect(&core.socket);
        gateway.command(Command::TakeControl { name: "Test".to_owned() });
        let now = truth.now();
        if let Some(stood) = &stood {
            assert!(now.robot_s > stood.robot_s, "the robot's clock went back");
            let moved = distance(&now, stood);
            assert!(moved < 1e-3, "the robot moved by {moved} m without a core");
        }
        truth.clear();
        // Each failure falls into another moment between two commands and two steps of the legs.
        walk(&mut gateway, &truth, 0.5 + 0.037 * (number % 17) as f64);
        stoppings.push((*failure, stopping(&core, &truth, failure.signal())));
        stood = Some(truth.now());
        core.kill();
    }
    eprintln!(
        "| core at {SPEED_M_S} m/s | times | stopping time: median, s | worst, s | stopping distance: median, m | worst, m |"
    );
    eprintln!("| --- | ---: | ---: | ---: | ---: | ---: |");
    for (failure, name) in [(CoreFailure::Killed, "killed"), (CoreFailure::Hung, "hangs")] {
        let sorted = |value: fn(&Stopping) -> f64| {
            let of_failure = stoppings.iter().filter(|(kind, _)| *kind == failure);
            let mut values: Vec<f64> = of_failure.map(|(_, stopping)| value(stopping)).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let (times_s, distances_m) = (sorted(|stop| stop.time_s), sorted(|stop| stop.distance_m));
        if let ([.., worst_s], [.., worst_m]) = (&times_s[..], &distances_m[..]) {
            let (median_s, median_m) = (times_s[times_s.len() / 2], distances_m[distances_m.len() / 2]);
            eprintln!(
                "| {name} | {} | {median_s:.2} | {worst_s:.2} | {median_m:.2} | {worst_m:.2} |",
                times_s.len()
            );
        }
    }
    for (failure, Stopping { time_s, .. }) in &stoppings {
        assert!(*time_s <= failure.limit_s(), "{failure:?}: the legs moved for {time_s} s");
    }
}

#[test]
fn the_legs_stop_when_the_core_is_killed_or_hangs() {
    fail_while_walking(&[CoreFailure::Killed, CoreFailure::Killed, CoreFailure::Hung]);
}

mod nightly {
    use super::{CoreFailure, fail_while_walking};

    /// How often the core fails: the number in `AUTOINSPECT_KILLS`.
    fn times() -> usize {
        std::env::var("AUTOINSPECT_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(100)
    }

    #[test]
    fn the_legs_stop_every_time_when_the_core_is_killed() {
        fail_while_walking(&vec![CoreFailure::Killed; times()]);
    }

    #[test]
    fn the_legs_stop_every_time_when_the_core_hangs() {
        fail_while_walking(&vec![CoreFailure::Hung; times()]);
    }
}

#[test]
fn a_core_that_hung_is_connected_again_and_the_robot_obeys_it() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (robot, truth) = robot_with_truth(dir.path(), "2");
    let core = CoreProcess::start_with(dir.path(), &robot);
    let mut gateway = FakeGateway::connect(&core.socket);
    gateway.command(Command::TakeControl { name: "Test".to_owned() });
    walk(&mut gateway, &truth, 0.5);
    core.signal(Signal::STOP);
    // Longer than what the queues hold: the robot goes on without the core, and stands.
    truth.wait(10.0);
    assert!(!truth.now().walking);
    core.signal(Signal::CONT);
    gateway.notice("The connection to the robot was lost");
    gateway.notice("The robot is connected again");
    walk(&mut gateway, &truth, 0.5);
}

fn battery(gateway: &mut FakeGateway) -> Battery {
    gateway.event(|event| match event {
        Event::Battery(battery) => Some(*battery),
        _ => None,
    })
}

#[test]
fn the_battery_is_charged_on_the_dock_while_no_core_runs() {
    let dir = tempfile::tempdir().expect("temporary directory");
    // The robot starts on its dock.
    let (robot, truth) = robot_with_truth(dir.path(), "10");
    let core = CoreProcess::start_with(dir.path(), &robot);
    let before = battery(&mut FakeGateway::connect(&core.socket));
    assert!(before.charging, "{before:?}");
    core.kill();
    truth.wait(30.0);
    let core = CoreProcess::start_with(dir.path(), &robot);
    let after = battery(&mut FakeGateway::connect(&core.socket));
    let elapsed_s = (after.stamp - before.stamp).secs_f64();
    assert!(elapsed_s >= 30.0 && after.charging, "{after:?}");
    // 700 W into 930 Wh.
    let expected = 700.0 * elapsed_s / (930.0 * 3600.0);
    let gained = f64::from(after.charge - before.charge);
    assert!((gained - expected).abs() < 0.1 * expected, "{gained} instead of {expected} in {elapsed_s} s");
    drop(core);
}
