//! Tests of the core's process with a fake gateway.

use crate::fake_gateway::{CommandSender, FakeGateway, until};
use crate::program::{json, program, text};
use api::{Command, CommandOutcome, CoreMessage, Event, GatewayMessage, Mapping, Motion};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use uuid::Uuid;
use vocab::{ClientId, MapId, SessionId, Twist, Vec3};

/// The process of a simulated robot; killed when dropped.
pub struct RobotProcess {
    child: Child,
    pub socket: PathBuf,
}

impl RobotProcess {
    /// Starts a robot that listens in this directory.
    pub fn start(dir: &Path, more: &[&str]) -> Self {
        // Of a core that is the first to use this directory.
        fs::create_dir_all(dir).expect("made");
        let socket = dir.join("robot.sock");
        let child = program()
            .args(["simulated-robot", "--socket", text(&socket), "--robot", "sim:b1"])
            .args(more)
            .stdin(Stdio::piped())
            .spawn()
            .expect("starts");
        Self { child, socket }
    }

    /// Its name as an argument.
    pub fn name(&self) -> String {
        format!("socket:{}", self.socket.display())
    }
}

impl Drop for RobotProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A core; killed when dropped.
pub struct CoreProcess {
    child: Child,
    /// Its robot, unless another one has it.
    robot: Option<RobotProcess>,
    pub socket: PathBuf,
}

impl CoreProcess {
    /// Starts a core with a robot of its own: coarse scans and fast simulation, so that a walk takes seconds.
    pub fn start(data: &Path) -> Self {
        Self::start_with_log(data, Stdio::inherit())
    }

    /// As [`Self::start`], with its log written elsewhere.
    pub fn start_with_log(data: &Path, log: Stdio) -> Self {
        Self::with(data, &["--lidar-columns", "200", "--people", "0", "--speed", "4"], log)
    }

    /// Starts a core with the scans of a real sensor.
    pub fn at_full_resolution(data: &Path) -> Self {
        Self::with(data, &[], Stdio::inherit())
    }

    fn with(data: &Path, robot: &[&str], log: Stdio) -> Self {
        let robot = RobotProcess::start(data, robot);
        let mut core = Self::spawn(data, &robot, log, &[]);
        core.robot = Some(robot);
        core
    }

    /// As [`Self::start`], with further arguments of the core.
    pub fn start_with_arguments(data: &Path, arguments: &[&str]) -> Self {
        let robot = RobotProcess::start(data, &["--lidar-columns", "200", "--people", "0"]);
        let mut core = Self::spawn(data, &robot, Stdio::inherit(), arguments);
        core.robot = Some(robot);
        core
    }

    /// Starts a core of this robot.
    pub fn start_with(data: &Path, robot: &RobotProcess) -> Self {
        Self::spawn(data, robot, Stdio::inherit(), &[])
    }

    fn spawn(data: &Path, robot: &RobotProcess, log: Stdio, more: &[&str]) -> Self {
        let socket = data.join("core.sock");
        let child = program()
            .args([
                "core",
                "--demo",
                "--data",
                text(data),
                "--socket",
                text(&socket),
                "--robot",
                &robot.name(),
            ])
            .args(more)
            .stdin(Stdio::piped())
            .stderr(log)
            .spawn()
            .expect("starts");
        Self { child, robot: None, socket }
    }

    pub fn signal(&self, signal: rustix::process::Signal) {
        let process = rustix::process::Pid::from_raw(self.child.id() as i32).expect("not zero");
        rustix::process::kill_process(process, signal).expect("a running process");
    }

    /// Whether it has ended by itself.
    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().is_ok_and(|status| status.is_some())
    }

    /// Kills it, as `kill -9` does.
    pub fn kill(mut self) {
        self.child.kill().expect("killed");
        self.child.wait().expect("reaped");
    }

    /// Closes its standard input, like the supervisor, and waits for an orderly end.
    pub fn stop(&mut self) {
        drop(self.child.stdin.take());
        assert!(self.child.wait().expect("ends").success());
    }
}

impl Drop for CoreProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Maps during a slow walk until there are some keyframes.
pub fn map_a_little(gateway: &mut impl CommandSender, session: u128) {
    gateway.command(Command::TakeControl { name: "Test".to_owned() });
    gateway.command(Command::StartMapping(SessionId(Uuid::from_u128(session))));
    let velocity = Twist { linear: Vec3::new(0.6, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, 0.3) };
    let mut keyframes = 0;
    while keyframes < 3 {
        gateway.command(Command::Teleoperate(velocity));
        keyframes = gateway.event(|event| match event {
            Event::Mapping(Mapping::Running { keyframes, .. }) => Some(*keyframes),
            Event::Estimate(_) => Some(keyframes),
            _ => None,
        });
    }
}

pub fn finish(map: u128) -> Command {
    Command::FinishMapping { map: MapId(Uuid::from_u128(map)), name: "Hall".to_owned() }
}

pub fn map_names(data: &Path) -> Vec<String> {
    let entries = fs::read_dir(data.join("maps")).into_iter().flatten();
    entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect()
}

#[test]
fn a_mapping_session_is_published_saved_recorded_and_replayed_bit_for_bit() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let mut core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    gateway.send(&GatewayMessage::Listeners { clients: 1, streams: 1 });
    map_a_little(&mut gateway, 1);

    let scan = loop {
        if let CoreMessage::Scan { points, .. } = gateway.message() {
            break points;
        }
    };
    assert!(map_codec::decode(&scan).expect("decodes").points.len() > 1000);

    // A gateway that connects again gets every tile and keyframe of the session.
    let mut gateway = FakeGateway::connect(&core.socket);
    let graph = gateway.event(|event| match event {
        Event::Graph(graph) => Some(graph.clone()),
        _ => None,
    });
    let tiles = gateway.event(|event| match event {
        Event::Tiles(tiles) if tiles.reset => Some(tiles.added.clone()),
        _ => None,
    });
    assert!(graph.nodes.len() >= 2, "{graph:?}");
    for tile in &tiles {
        let name = tile.hash.to_string();
        let bytes = fs::read(dir.path().join("tiles").join(&name[..2]).join(&name)).expect("tile");
        assert_eq!(map_codec::decode(&bytes).expect("decodes").points.len(), tile.points as usize);
    }
    assert!(tiles.iter().map(|tile| tile.points).sum::<u32>() > 1000);

    gateway.command(finish(9));
    let maps = gateway.event(|event| match event {
        Event::Maps(maps) if !maps.is_empty() => Some(maps.clone()),
        _ => None,
    });
    assert_eq!((maps.len(), maps[0].name.as_str()), (1, "Hall"));
    gateway.event(|event| matches!(event, Event::Mapping(Mapping::Idle)).then_some(()));
    core.stop();

    let recordings: Vec<_> = fs::read_dir(dir.path().join("recordings"))
        .expect("the folder of recordings exists")
        .map(|entry| entry.expect("readable").path())
        .collect();
    let [recording] = &recordings[..] else { panic!("{recordings:?}") };
    let replayed = json(&["replay", text(recording)]);
    assert!(replayed["inputs"].as_u64() > Some(100), "{replayed}");
    assert_eq!(json(&["replay", text(recording)]), replayed);
}

#[test]
fn a_core_that_is_killed_while_saving_leaves_no_incomplete_map() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let mut core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    map_a_little(&mut gateway, 1);
    gateway.command(finish(7));
    // At this moment the files of the map are being written, or have just been written.
    let hidden = format!(".{}", Uuid::from_u128(7));
    let whole = Uuid::from_u128(7).to_string();
    until("saving begins", || {
        map_names(dir.path()).iter().find(|name| **name == hidden || **name == whole).cloned()
    });
    core.child.kill().expect("killed");
    core.child.wait().expect("reaped");

    let store = store::Store::open(dir.path()).expect("opens after the crash");
    assert!(!map_names(dir.path()).contains(&hidden));
    for map in store.maps().expect("listed") {
        let list = fs::read(store.dir().map_tiles(map.id)).expect("tiles of a listed map");
        let list: api::TileList = serde_json::from_slice(&list).expect("valid JSON");
        assert!(list.tiles.iter().all(|tile| store.dir().tile(tile.hash).exists()));
        for name in ["graph.json", "graph.g2o", "trajectory.tum"] {
            assert!(store.dir().map(map.id).join(name).exists(), "{name}");
        }
    }
}

fn motion(event: &Event) -> Option<Motion> {
    match event {
        Event::Motion(motion) => Some(motion.clone()),
        _ => None,
    }
}

#[test]
fn a_stop_of_motion_outlives_a_killed_core_and_is_lifted_by_command_only() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let stopped = Motion::Stopped { by: Some(ClientId(Uuid::from_u128(1))) };
    let core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    gateway.command(Command::StopMotion);
    // The stop is on the disk once it is acknowledged.
    core.kill();

    let core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    assert_eq!(gateway.event(motion), stopped);
    let velocity = Twist { linear: Vec3::new(0.6, 0.0, 0.0), ..Twist::default() };
    assert!(gateway.outcome(Command::Teleoperate(velocity)) != CommandOutcome::Accepted);
    core.kill();

    let core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    assert_eq!(gateway.event(motion), stopped);
    gateway.command(Command::AllowMotion);
    core.kill();

    let core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    assert_eq!(gateway.event(motion), Motion::Idle);
    core.kill();

    // A damaged file counts as a stop, is kept, and is named.
    fs::write(dir.path().join("stop.json"), "{").expect("written");
    let core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    assert_eq!(gateway.event(motion), Motion::Stopped { by: None });
    gateway.notice("stop.json.damaged");
    assert_eq!(fs::read(dir.path().join("stop.json.damaged")).expect("kept"), b"{");
    drop(core);
}
