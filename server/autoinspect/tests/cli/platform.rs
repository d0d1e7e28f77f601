//! Tests of `autoinspect up`: its processes and their supervision.

use crate::fake_gateway::until;
use crate::program::{program, refused, text};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};

/// Arguments of a platform where nobody has to sign in, with a simulated robot.
const DEMO: [&str; 5] = ["--demo", "--robot", "sim:b1", "--people", "0"];

/// A platform with a robot, which is stopped in order when dropped.
pub struct RunningPlatform {
    child: Child,
    address: SocketAddr,
    complaints: PathBuf,
}

impl RunningPlatform {
    fn start(dir: &Path) -> Self {
        Self::start_with(dir, &[])
    }

    /// Starts it with environment variables.
    pub fn start_with(dir: &Path, variables: &[(&str, &Path)]) -> Self {
        Self::launch(dir, &[&DEMO, &["--lidar-columns", "50"][..]].concat(), variables)
    }

    /// Starts it with further arguments of its robot. Returns when browsers can use it.
    pub fn start_with_robot(dir: &Path, robot: &[&str]) -> Self {
        Self::launch(dir, &[&DEMO, robot].concat(), &[])
    }

    /// Where its standard error is written.
    pub fn log(dir: &Path) -> PathBuf {
        dir.join("stderr.txt")
    }

    /// Starts it with these arguments: how people sign in, and which robot it has. Its data are in `data` of this directory.
    pub fn launch(dir: &Path, arguments: &[&str], variables: &[(&str, &Path)]) -> Self {
        let complaints = Self::log(dir);
        let client = dir.join("static");
        fs::create_dir_all(&client).expect("made");
        fs::write(client.join("index.html"), "<title>AutoInspect</title>").expect("writable");
        let mut child = program()
            .args([
                "up",
                "--data",
                text(&dir.join("data")),
                "--static",
                text(&client),
                "--listen",
                "127.0.0.1:0",
            ])
            .args(arguments)
            .envs(variables.iter().copied())
            .stdout(Stdio::piped())
            .stderr(fs::File::create(&complaints).expect("writable"))
            // A group of its own, so that all its processes can be killed at once.
            .process_group(0)
            .spawn()
            .expect("starts");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("piped")).read_line(&mut line).expect("a line");
        let (_, address) = line.trim().split_once("://").expect("its address");
        Self { address: address.parse().expect("an address"), child, complaints }
    }

    /// Id of its child process with this role.
    pub fn process(&self, role: &str) -> Option<u32> {
        let id = self.child.id();
        let children = fs::read_to_string(format!("/proc/{id}/task/{id}/children")).ok()?;
        children.split_whitespace().filter_map(|child| child.parse().ok()).find(|child: &u32| {
            let command = fs::read(format!("/proc/{child}/cmdline")).unwrap_or_default();
            command.split(|byte| *byte == 0).nth(1) == Some(role.as_bytes())
        })
    }

    /// Stops the gateway and the supervisor, which would start it again: a core has one gateway at a time, and a test may take its place.
    pub fn freeze_gateway(&self) {
        signal(self.child.id(), rustix::process::Signal::STOP);
        signal(self.process("gateway").expect("runs"), rustix::process::Signal::STOP);
    }

    /// Kills all its processes at once, as a power cut does, and waits until they are gone.
    pub fn kill_all(mut self) {
        let group = rustix::process::Pid::from_raw(self.child.id() as i32).expect("not zero");
        let processes = ["gateway", "core", "simulated-robot"].map(|role| self.process(role));
        rustix::process::kill_process_group(group, rustix::process::Signal::KILL).expect("running processes");
        self.child.wait().expect("reaped");
        for process in processes.into_iter().flatten() {
            until("it ends", || has_ended(process).then_some(()));
        }
    }

    /// Its address for clients.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    pub fn get(&self, path: &str) -> Option<String> {
        let mut stream = TcpStream::connect(self.address).ok()?;
        write!(stream, "GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").ok()?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).ok()?;
        Some(answer)
    }

    /// What was printed on standard error.
    pub fn complaints(&self) -> String {
        fs::read_to_string(&self.complaints).expect("readable")
    }

    fn is_healthy(&self) -> bool {
        self.get("/api/v1/health").is_some_and(|answer| answer.starts_with("HTTP/1.1 200"))
    }
}

impl Drop for RunningPlatform {
    fn drop(&mut self) {
        if self.child.try_wait().is_ok_and(|ended| ended.is_none()) {
            signal(self.child.id(), rustix::process::Signal::TERM);
            // It may be stopped, see [`Self::freeze_gateway`].
            signal(self.child.id(), rustix::process::Signal::CONT);
        }
        let _ = self.child.wait();
    }
}

/// Whether a process has ended. In a container it may remain as a zombie.
pub fn has_ended(process: u32) -> bool {
    fs::read_to_string(format!("/proc/{process}/stat")).map_or(true, |stat| stat.contains(") Z"))
}

/// Sends a signal to a process.
pub fn signal(process: u32, signal: rustix::process::Signal) {
    let process = rustix::process::Pid::from_raw(process as i32).expect("not zero");
    rustix::process::kill_process(process, signal).expect("a running process");
}

#[test]
fn every_process_is_restarted_after_a_crash_and_all_end_together() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let mut platform = RunningPlatform::start(dir.path());
    assert!(platform.is_healthy());
    assert!(platform.get("/").expect("answers").contains("AutoInspect"));
    // After the robot the core is started again too, because the clock and the place of a new robot are others.
    for role in ["gateway", "core", "simulated-robot"] {
        let core = platform.process("core");
        let crashed = platform.process(role).expect("runs");
        signal(crashed, rustix::process::Signal::KILL);
        until("another takes its place", || platform.process(role).filter(|id| *id != crashed));
        if role == "simulated-robot" {
            until("the core begins anew", || platform.process("core").filter(|id| Some(*id) != core));
        }
        until("core and gateway are connected again", || platform.is_healthy().then_some(()));
    }

    let processes = ["gateway", "core", "simulated-robot"].map(|role| platform.process(role).expect("runs"));
    signal(platform.child.id(), rustix::process::Signal::TERM);
    assert!(platform.child.wait().expect("ends").success());
    for process in processes {
        assert!(!Path::new(&format!("/proc/{process}")).exists(), "process {process} still runs");
    }
}

#[test]
fn no_process_outlives_a_supervisor_that_was_killed() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let mut platform = RunningPlatform::start(dir.path());
    let processes = ["gateway", "core", "simulated-robot"].map(|role| platform.process(role).expect("runs"));
    platform.child.kill().expect("killed");
    platform.child.wait().expect("reaped");
    for process in processes {
        until("it ends", || has_ended(process).then_some(()));
    }
}

#[test]
fn an_address_in_use_ends_the_platform_with_an_error_message() {
    let dir = tempfile::tempdir().expect("temporary directory");
    fs::write(dir.path().join("index.html"), "").expect("writable");
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("an address").to_string();
    let data = dir.path().join("data");
    let complaint = refused(&[
        "up",
        "--listen",
        &address,
        "--data",
        text(&data),
        "--static",
        text(dir.path()),
        "--lidar-columns",
        "50",
    ]);
    assert!(complaint.contains(&address), "{complaint}");
}
