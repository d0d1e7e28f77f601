//! Processes of the platform that fail in every way: each is noticed, started again, and clients are told why.

use crate::fake_gateway::until;
use crate::platform::{RunningPlatform, signal};
use rustix::process::Signal;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A platform whose threads can be made to fail.
struct FaultyPlatform {
    platform: RunningPlatform,
    faults: tempfile::TempDir,
    dir: tempfile::TempDir,
}

impl FaultyPlatform {
    fn start() -> Self {
        let dir = tempfile::tempdir().expect("temporary directory");
        let faults = tempfile::tempdir().expect("temporary directory");
        let platform = RunningPlatform::start_with(dir.path(), &[("AUTOINSPECT_TEST_FAULTS", faults.path())]);
        Self { platform, faults, dir }
    }

    /// Asks for a fault, and waits until it has struck: the thread removes the file first.
    fn inject(&self, fault: &str) {
        let file = self.faults.path().join(fault);
        fs::write(&file, "").expect("written");
        if fault.ends_with("gateway-accept") || fault.ends_with("gateway-read") {
            // Both threads wait for the gateway.
            signal(self.platform.process("gateway").expect("runs"), Signal::KILL);
        }
        until("the fault strikes", || (!file.exists()).then_some(()));
    }

    /// How often a process was started again, and why last, as clients are told.
    fn restarts(&self, process: &str) -> Option<(u64, String)> {
        let answer =
            self.platform.get("/api/v1/health").filter(|answer| answer.starts_with("HTTP/1.1 200"))?;
        let (_, body) = answer.split_once("\r\n\r\n")?;
        let health: Value = serde_json::from_str(body).ok()?;
        let restart = health["restarts"].as_array()?.iter().find(|restart| restart["process"] == process)?;
        Some((restart["count"].as_u64()?, restart["cause"].as_str()?.to_owned()))
    }

    /// Waits until a process runs again, with the gateway and the core connected, and checks why it was started again.
    fn restarted(&self, process: &str, count: u64, cause: &str) {
        let known = until(&format!("the {process} runs again, because it {cause}"), || {
            self.restarts(process).filter(|(known, _)| *known >= count)
        });
        assert!(known.0 == count && known.1.contains(cause), "the {process} was started again {known:?}");
    }
}

fn panics(threads: &[&str]) {
    let faulty = FaultyPlatform::start();
    assert!(faulty.restarts("core").is_none());
    for (count, thread) in (1..).zip(threads) {
        faulty.inject(&format!("panic-{thread}"));
        faulty.restarted("core", count, &format!("panicked in its thread {thread}: a test asked for it"));
    }
}

#[test]
fn a_core_whose_writer_panics_is_started_again() {
    panics(&["ledger", "sessions", "recorder"]);
}

#[test]
fn a_core_whose_control_loop_panics_is_started_again() {
    let faulty = FaultyPlatform::start();
    faulty.inject("panic-control");
    faulty.restarted("core", 1, "panicked in its thread control: a test asked for it");
}

#[test]
fn a_core_whose_lane_or_publisher_panics_is_started_again() {
    panics(&["disk", "compute", "publisher", "imports"]);
}

#[test]
fn a_core_whose_thread_to_the_gateway_panics_is_started_again() {
    panics(&["gateway-accept", "gateway-read", "gateway-write"]);
}

#[test]
fn a_process_that_hangs_is_killed_and_started_again() {
    let faulty = FaultyPlatform::start();
    faulty.inject("hang-control");
    faulty.restarted("core", 1, "did not answer for 5 s");
    faulty.inject("hang-gateway");
    faulty.restarted("gateway", 1, "did not answer for 5 s");
    // A process that is stopped as a whole gives no heartbeat either.
    signal(faulty.platform.process("core").expect("runs"), Signal::STOP);
    faulty.restarted("core", 2, "did not answer for 5 s");
}

#[test]
fn a_simulated_robot_that_hangs_is_killed_and_started_again() {
    let faulty = FaultyPlatform::start();
    assert!(faulty.restarts("simulated_robot").is_none());
    signal(faulty.platform.process("simulated-robot").expect("runs"), Signal::STOP);
    faulty.restarted("simulated_robot", 1, "did not answer for 5 s");
    // The place and the clock of the new robot are others.
    faulty.restarted("core", 1, "because the robot was started again");
    // A robot whose simulation hangs while its other threads live.
    faulty.inject("hang-simulation");
    faulty.restarted("simulated_robot", 2, "did not answer for 5 s");
    faulty.restarted("core", 2, "because the robot was started again");
}

#[test]
fn a_gateway_that_panics_and_a_core_that_is_killed_are_started_again() {
    let faulty = FaultyPlatform::start();
    faulty.inject("panic-gateway");
    faulty.restarted("gateway", 1, "panicked in its thread gateway: a test asked for it");
    signal(faulty.platform.process("core").expect("runs"), Signal::KILL);
    faulty.restarted("core", 1, "was killed (signal 9)");
    assert!(faulty.restarts("gateway").is_some(), "the gateway went on");
}

#[test]
fn a_core_that_cannot_start_any_more_is_tried_again_until_it_can() {
    let faulty = FaultyPlatform::start();
    let data = faulty.dir.path().join("data");
    let (maps, aside) = (data.join("maps"), data.join("maps-aside"));
    move_aside(&maps, &aside);
    signal(faulty.platform.process("core").expect("runs"), Signal::KILL);
    // It ends with exit code 2 at once, each time.
    let restarted = || faulty.platform.complaints().contains("exit code 2").then_some(());
    until("the core refuses to start", restarted);
    fs::remove_file(&maps).expect("removed");
    fs::rename(&aside, &maps).expect("moved back");
    until("the core runs again", || faulty.restarts("core").filter(|(_, why)| why.contains("exit code 2")));
}

/// Puts a file where the folder of maps was, so that the store cannot be opened.
fn move_aside(maps: &Path, aside: &Path) {
    fs::rename(maps, aside).expect("moved");
    fs::write(maps, "").expect("written");
}
