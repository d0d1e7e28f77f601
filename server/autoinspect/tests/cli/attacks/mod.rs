//! Attacks on a whole platform with a robot: a robot that is driven stops within 200 ms of a press on Stop motion throughout, an operator can sign in, and the processes
//! stay small. Times are taken where the robot gets its commands. `cargo xtask test security` runs the short form; all of it, with a table:
//! `cargo nextest run -p autoinspect --no-capture -E 'test(attacks::nightly)'`.
#![allow(clippy::print_stdout, reason = "the table is for people")]

mod client;
mod floods;
mod guarded;
mod load;
mod tap;

use api::{Command, CommandOutcome};
use client::Client;
use floods::{Attack, Flood};
use guarded::{ANSWER_LIMIT, GuardedPlatform, PASSWORD, ask, bearer, connect_from, request_bytes};
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use vocab::{Twist, Vec3};

/// Longest time from a press on Stop motion until the robot is told to stand.
const STOP_LIMIT: Duration = Duration::from_millis(200);

/// Most that a process may grow under an attack, bytes.
const GROWTH_LIMIT: u64 = 64 << 20;

/// The address of the people of the tests.
const OWN_ADDRESS: u8 = 2;

/// Somebody who drives the robot by hand, and allows motion after each stop.
struct Driver {
    is_over: Arc<AtomicBool>,
    /// Commands to drive that were refused because motion is stopped.
    refused: Arc<AtomicU64>,
    may_go_on: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Driver {
    fn start(address: SocketAddr, token: &str) -> Self {
        let mut client = Client::connect(OWN_ADDRESS, address, token, 1).expect("a socket");
        let taken = client.outcome(Command::TakeControl { name: "Driver".to_owned() });
        assert_eq!(taken.expect("answered"), CommandOutcome::Accepted);
        let (is_over, refused, may_go_on) =
            (Arc::<AtomicBool>::default(), Arc::<AtomicU64>::default(), Arc::<AtomicBool>::default());
        let (ends, refusals, goes_on) = (Arc::clone(&is_over), Arc::clone(&refused), Arc::clone(&may_go_on));
        let thread = thread::spawn(move || {
            let turn = Twist { linear: Vec3::new(0.0, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, 0.3) };
            while !ends.load(Ordering::Relaxed) {
                if goes_on.swap(false, Ordering::Relaxed) {
                    let allowed = client.outcome(Command::AllowMotion);
                    assert_eq!(allowed.expect("answered"), CommandOutcome::Accepted);
                }
                match client.outcome(Command::Teleoperate(turn)).expect("answered") {
                    CommandOutcome::Accepted => {}
                    CommandOutcome::Refused(_) => drop(refusals.fetch_add(1, Ordering::Relaxed)),
                }
                thread::sleep(Duration::from_millis(50));
            }
        });
        Self { is_over, refused, may_go_on, thread: Some(thread) }
    }

    /// Waits until one more command to drive is refused: motion is stopped.
    fn wait_until_refused(&self, mut meanwhile: impl FnMut()) {
        let before = self.refused.load(Ordering::Relaxed);
        crate::fake_gateway::until("driving is refused", || {
            meanwhile();
            (self.refused.load(Ordering::Relaxed) > before).then_some(())
        });
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take()
            && let Err(panic) = thread.join()
            && !thread::panicking()
        {
            std::panic::resume_unwind(panic);
        }
    }
}

/// What a process holds in memory, bytes.
fn resident_bytes(process: u32) -> u64 {
    let statm = std::fs::read_to_string(format!("/proc/{process}/statm")).unwrap_or_default();
    let pages: u64 = statm.split(' ').nth(1).and_then(|pages| pages.parse().ok()).unwrap_or_default();
    pages * 4096
}

/// Watches how much two processes grow.
struct Growth {
    is_over: Arc<AtomicBool>,
    thread: JoinHandle<[u64; 2]>,
}

impl Growth {
    fn watch(processes: [u32; 2]) -> Self {
        let is_over = Arc::<AtomicBool>::default();
        let ends = Arc::clone(&is_over);
        let before = processes.map(resident_bytes);
        let thread = thread::spawn(move || {
            let mut most = [0; 2];
            while !ends.load(Ordering::Relaxed) {
                for (index, process) in processes.into_iter().enumerate() {
                    most[index] = most[index].max(resident_bytes(process).saturating_sub(before[index]));
                }
                thread::sleep(Duration::from_millis(20));
            }
            most
        });
        Self { is_over, thread }
    }

    /// The most that each has grown.
    fn end(self) -> [u64; 2] {
        self.is_over.store(true, Ordering::Relaxed);
        self.thread.join().expect("no panic")
    }
}

/// What came of an attack.
struct Row {
    attack: Attack,
    attempts: u64,
    /// Times until the robot was told to stand: over an open socket, and over a new connection.
    stops: [Vec<Duration>; 2],
    sign_in: Duration,
    /// Growth of gateway and core, bytes.
    growth: [u64; 2],
}

impl Row {
    fn print(&self) {
        let slowest = |times: &[Duration]| times.iter().max().copied().unwrap_or_default().as_millis();
        println!(
            "{:22} {:9} attempts; {} stops at the robot after at most {} ms (socket) and {} ms (new connection); sign-in {} ms; gateway +{} MB, core +{} MB",
            format!("{:?}", self.attack),
            self.attempts,
            self.stops[0].len() + self.stops[1].len(),
            slowest(&self.stops[0]),
            slowest(&self.stops[1]),
            self.sign_in.as_millis(),
            self.growth[0] >> 20,
            self.growth[1] >> 20,
        );
    }

    fn check(&self) {
        for time in self.stops.iter().flatten() {
            assert!(*time < STOP_LIMIT, "{:?}: the robot was told to stand after {time:?}", self.attack);
        }
        for (process, growth) in ["gateway", "core"].iter().zip(self.growth) {
            assert!(growth < GROWTH_LIMIT, "{:?}: the {process} grew by {} MB", self.attack, growth >> 20);
        }
    }
}

/// Signs in over a new connection, again if it is told to. Returns the time that it took.
fn sign_in(address: SocketAddr) -> Duration {
    let body = format!("{{\"account\": \"ada\", \"password\": \"{PASSWORD}\"}}");
    let request = request_bytes("POST", api::paths::SESSION_PATH, "", body.as_bytes());
    let start = Instant::now();
    loop {
        let asked = connect_from(OWN_ADDRESS, address).and_then(|stream| ask(stream, &request));
        match asked {
            Ok((200, _)) => return start.elapsed(),
            other => assert!(start.elapsed() < ANSWER_LIMIT, "no sign-in: {other:?}"),
        }
    }
}

/// Presses Stop this many times under an attack, by turns over the open socket of a viewer and over a new connection.
fn attack(attack: Attack, stops: usize, platform: &GuardedPlatform) -> Row {
    let address = platform.address();
    let processes = ["gateway", "core"].map(|role| platform.process(role));
    let driver = Driver::start(address, &platform.tokens.operator);
    let mut viewer = Client::connect(OWN_ADDRESS, address, &platform.tokens.viewer, 2).expect("a socket");
    let growth = Growth::watch(processes);
    let flood = Flood::begin(attack, platform);
    let attempts = match attack {
        Attack::HalfOpenConnections | Attack::SlowReaders => 1_000,
        Attack::CommandsOfOneAccount => 2_000,
        _ => 8,
    };
    flood.wait_for_attempts(attempts, || viewer.keep_alive());
    let mut times = [Vec::new(), Vec::new()];
    for number in 0..stops {
        platform.tap.wait_until_driven(Instant::now(), || viewer.keep_alive());
        let pressed = Instant::now();
        let took = if number % 2 == 0 {
            viewer.command(Command::StopMotion).expect("sent");
            platform.tap.wait_until_stopped(pressed)
        } else {
            let request = request_bytes("POST", api::paths::STOP_PATH, &bearer(&platform.tokens.viewer), b"");
            let answer = thread::spawn(move || {
                let stream = connect_from(OWN_ADDRESS, address)?;
                ask(stream, &request)
            });
            let took = platform.tap.wait_until_stopped(pressed);
            let (status, text) = answer.join().expect("no panic").expect("answered");
            assert_eq!(status, 204, "{text}");
            took
        };
        times[number % 2].push(took);
        // The commands to the robot could have ceased for another reason.
        driver.wait_until_refused(|| viewer.keep_alive());
        driver.may_go_on.store(true, Ordering::Relaxed);
    }
    let sign_in = sign_in(address);
    assert_eq!(
        ["gateway", "core"].map(|role| platform.process(role)),
        processes,
        "neither was started again"
    );
    let attempts = flood.attempts();
    drop(flood);
    let row = Row { attack, attempts, stops: times, sign_in, growth: growth.end() };
    row.print();
    row
}

fn attack_all(attacks: &[Attack], stops: usize) {
    let platform = GuardedPlatform::start(&[]);
    // From now on the address is known.
    sign_in(platform.address());
    let rows: Vec<_> = attacks.iter().map(|kind| attack(*kind, stops, &platform)).collect();
    rows.iter().for_each(Row::check);
}

#[test]
fn the_robot_stops_in_time_when_all_connections_are_taken_and_an_account_floods_it() {
    attack_all(&[Attack::HalfOpenConnections, Attack::CommandsOfOneAccount], 4);
}

mod nightly {
    use super::*;

    #[test]
    fn the_robot_stops_in_time_under_every_attack() {
        // One alone, to look into it: by its name.
        let only = std::env::var("AUTOINSPECT_ATTACK").ok();
        let is_wanted = |attack: &Attack| only.as_ref().is_none_or(|name| *name == format!("{attack:?}"));
        let attacks: Vec<_> = Attack::ALL.into_iter().filter(is_wanted).collect();
        attack_all(&attacks, 20);
    }
}
