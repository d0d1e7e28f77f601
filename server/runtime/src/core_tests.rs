//! The whole core. The test plays the robot and the gateway.

#[path = "core_tests/imports.rs"]
mod imports;
#[path = "core_tests/simulated_faults.rs"]
mod simulated_faults;

use super::*;
use crate::RecordingTarget;
use api::{CommandOutcome, CoreMessage, Event, GatewayMessage, Import, ImportStage};
use crossbeam_channel::Receiver;
use messages::{
    BootRecord, Command, CommandKind, Drive, GraphDelta, ImuSample, Input, PoseGraph, Principal, Publication,
    RobotProfile, Sensor, SpeedLimits,
};
use ports::{Arrival, Journal, JournalError, RobotEvent, Segment, SegmentWriter, SimulatedFault};
use std::io::{Read, Write};
use std::ops::ControlFlow;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::Mutex;
use std::thread;
use std::time::Duration;
use uuid::Uuid;
use vocab::{ClientId, CommandId, MapId, SessionId, Span, Stamp, UploadId, Vec3};

/// Far longer than any step of these tests.
const PATIENCE: Duration = Duration::from_secs(30);
const CLIENT: ClientId = ClientId(Uuid::from_u128(5));

/// A robot whose messages the test sends.
struct FakeLink {
    arrivals: Receiver<Arrival>,
    drives: Arc<Mutex<Vec<Drive>>>,
    /// Receives injected faults; `None` for a real robot.
    faults: Option<Sender<(CommandId, SimulatedFault)>>,
}

impl RobotLink for FakeLink {
    fn boot(&self) -> BootRecord {
        BootRecord {
            profile: RobotProfile {
                name: "Fake".to_owned(),
                manual_limits: SpeedLimits { forward_m_s: 0.7, sideways_m_s: 0.0, turn_rad_s: 0.6 },
                ..RobotProfile::default()
            },
            ..BootRecord::default()
        }
    }
    fn arrivals(&self) -> Receiver<Arrival> {
        self.arrivals.clone()
    }
    fn drive(&self, drive: Drive) {
        self.drives.lock().expect("not poisoned").push(drive);
    }
    fn inject_fault(&self, id: CommandId, fault: SimulatedFault) -> Result<(), String> {
        let faults = self.faults.as_ref().ok_or("This robot is a real one.")?;
        faults.send((id, fault)).map_err(|error| error.to_string())
    }
}

/// Passes every input to the test, and fails after the given number of inputs.
struct FakeJournal {
    written: Sender<(Stamp, Input)>,
    until: usize,
}

impl Journal for FakeJournal {
    fn append(&mut self, at: Stamp, input: &Input) -> Result<(), JournalError> {
        if self.until == 0 {
            return Err(JournalError("the disk is full".into()));
        }
        self.until -= 1;
        self.written.send((at, input.clone())).map_err(|error| JournalError(Box::new(error)))
    }
    fn finish(self: Box<Self>) -> Result<(), JournalError> {
        Ok(())
    }
}

struct FakeSegments {
    written: Sender<(Stamp, Input)>,
    until: usize,
}

impl SegmentWriter for FakeSegments {
    fn create(&mut self, _path: &Path, _segment: &Segment) -> Result<Box<dyn Journal>, JournalError> {
        // A disk that has failed stays so.
        let until = if self.until == usize::MAX { usize::MAX } else { std::mem::take(&mut self.until) };
        Ok(Box::new(FakeJournal { written: self.written.clone(), until }))
    }
}

/// A core with the test's ends of its connections.
struct Bench {
    core: Option<Core>,
    robot: Sender<Arrival>,
    written: Receiver<(Stamp, Input)>,
    socket: PathBuf,
    failures: Receiver<watchdog::ThreadFailure>,
    _dir: tempfile::TempDir,
}

fn bench(journal_until: usize) -> Bench {
    bench_of(journal_until, None, None)
}

fn bench_of(
    journal_until: usize,
    faults: Option<Sender<(CommandId, SimulatedFault)>>,
    importer: Option<Box<dyn MapImporter>>,
) -> Bench {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Arc::new(Store::open(dir.path()).expect("store"));
    let (robot, arrivals) = crossbeam_channel::bounded(100);
    let (write, written) = crossbeam_channel::unbounded();
    let socket = store.dir().core_socket();
    let recording = RecordingTarget {
        writer: Box::new(FakeSegments { written: write, until: journal_until }),
        run: store.recordings().begin_run(Stamp::EPOCH).expect("begins"),
    };
    let link = Box::new(FakeLink { arrivals, drives: Arc::default(), faults });
    let restart = |process, cause: &str| ProcessRestart { process, cause: cause.to_owned(), count: 1 };
    let of_robot = restart(api::ProcessRole::SimulatedRobot, "was stuck");
    let restart = restart(api::ProcessRole::Core, "was ill");
    let watchdog = Watchdog::default();
    let failures = watchdog.failures();
    let config = CoreConfig {
        link,
        store,
        recording: Some(recording),
        socket: socket.clone(),
        importer,
        example_maker: None,
        change_finder: None,
        gauge_reader: None,
        picture_comparer: None,
        watchdog,
        restart: Some(restart),
        robot_restart: Some(RobotRestart { restart: of_robot, is_new: true }),
        access: AccessMode::Demo,
        audit_entries: None,
    };
    Bench { core: Some(Core::start(config).expect("starts")), robot, written, socket, failures, _dir: dir }
}

impl Bench {
    fn at(millis: i64) -> Stamp {
        Stamp::from_parts(1_000, 0) + Span::from_millis(millis)
    }

    fn clock(&self, millis: i64) {
        let arrival = Arrival { at: Self::at(millis), event: RobotEvent::Clock };
        self.robot.send_timeout(arrival, PATIENCE).expect("the core listens");
    }

    fn event(&self, millis: i64, event: RobotEvent) {
        self.robot.send_timeout(Arrival { at: Self::at(millis), event }, PATIENCE).expect("the core listens");
    }

    fn imu(&self, millis: i64) {
        let stamp = Self::at(millis);
        let sample = ImuSample { stamp, ..ImuSample::default() };
        let arrival = Arrival { at: stamp, event: RobotEvent::Sensor(Sensor::Imu(sample)) };
        self.robot.send_timeout(arrival, PATIENCE).expect("the core listens");
    }

    /// The next input that was recorded.
    fn written(&self) -> (i64, Input) {
        let (at, input) = self.written.recv_timeout(PATIENCE).expect("something is recorded");
        ((at - Self::at(0)).nanos() / 1_000_000, input)
    }

    fn gateway(&self) -> FakeGateway {
        let stream = UnixStream::connect(&self.socket).expect("connects");
        stream.set_read_timeout(Some(PATIENCE)).expect("settable");
        let mut gateway = FakeGateway { stream };
        gateway.send(&GatewayMessage::Hello { version: api::VERSION });
        gateway
    }
}

struct FakeGateway {
    stream: UnixStream,
}

impl FakeGateway {
    fn send(&mut self, message: &GatewayMessage) {
        let body = api::encode(message);
        self.stream.write_all(&(body.len() as u32).to_le_bytes()).expect("written");
        self.stream.write_all(&body).expect("written");
    }

    /// The next message; none at the end.
    fn next(&mut self) -> Option<CoreMessage> {
        let mut length = [0; 4];
        self.stream.read_exact(&mut length).ok()?;
        let mut body = vec![0; u32::from_le_bytes(length) as usize];
        self.stream.read_exact(&mut body).ok()?;
        Some(api::decode(&body).expect("a message"))
    }

    /// Reads until an event is what the test waits for.
    fn event<T>(&mut self, mut wanted: impl FnMut(&Option<ClientId>, &Event) -> Option<T>) -> T {
        loop {
            if let CoreMessage::Event { to, event } = self.next().expect("the core goes on")
                && let Some(found) = wanted(&to, &event)
            {
                return found;
            }
        }
    }

    fn command(&mut self, id: u128, command: api::Command) {
        self.send(&GatewayMessage::Command {
            id: CommandId(Uuid::from_u128(id)),
            by: CLIENT.into(),
            command,
        });
    }
}

fn take_control() -> api::Command {
    api::Command::TakeControl { name: "Ada".to_owned() }
}

#[test]
fn every_input_is_recorded_once_in_the_order_of_the_robots_clock() {
    let bench = bench(usize::MAX);
    for millis in [0, 20, 130, 120] {
        bench.imu(millis);
    }
    bench.clock(160);
    let mut heard = Vec::new();
    while heard.len() < 9 {
        let (millis, input) = bench.written();
        heard.push(match input {
            Input::Boot(boot) => {
                assert_eq!(boot.profile.name, "Fake");
                (millis, "boot")
            }
            Input::Tick => (millis, "tick"),
            Input::Sensor(_) => (millis, "imu"),
            Input::WallClock { .. }
            | Input::MissionsRestored(_)
            | Input::Site(_)
            | Input::ActionsRegistered(_) => continue,
            other => panic!("{other:?}"),
        });
    }
    let expected = [
        (0, "boot"),
        (0, "tick"),
        (0, "imu"),
        (20, "imu"),
        (50, "tick"),
        (100, "tick"),
        (130, "imu"),
        // An input that comes late is stepped at the present time.
        (130, "imu"),
        (150, "tick"),
    ];
    assert_eq!(heard, expected);
}

#[test]
fn a_command_is_recorded_with_its_maker_and_answered_to_it() {
    let bench = bench(usize::MAX);
    bench.clock(0);
    let mut gateway = bench.gateway();
    gateway.command(1, take_control());
    // Answer and state come from different threads, in either order.
    let (mut answer, mut owner) = (None, None);
    while answer.is_none() || owner.is_none() {
        gateway.event(|to, event| {
            match event {
                Event::CommandDone { id, outcome } if id.0.as_u128() == 1 => {
                    answer = Some((*to, outcome.clone()))
                }
                Event::Control(control) => owner = control.owner,
                _ => return None,
            }
            Some(())
        });
    }
    assert_eq!(answer, Some((Some(CLIENT), CommandOutcome::Accepted)));
    assert_eq!(owner, Some(CLIENT));
    let recorded = loop {
        if let (_, Input::Command(command)) = bench.written() {
            break command;
        }
    };
    let kind = CommandKind::TakeControl { name: "Ada".to_owned() };
    // In a demonstration everybody is an admin.
    let by = Principal { role: api::Role::Admin, ..Principal::operator(CLIENT) };
    assert_eq!(recorded, Command { id: CommandId(Uuid::from_u128(1)), by, kind });
}

#[test]
fn each_gateway_gets_a_greeting_and_a_snapshot_and_the_newest_one_is_served() {
    let bench = bench(usize::MAX);
    bench.clock(0);
    let mut first = bench.gateway();
    first.command(1, take_control());
    first.event(|_, event| matches!(event, Event::Control(control) if control.owner.is_some()).then_some(()));

    let mut second = bench.gateway();
    assert_eq!(second.next(), Some(CoreMessage::Hello { version: api::VERSION }));
    let wanted: [fn(&Event) -> bool; 5] = [
        |event| matches!(event, Event::Maps(maps) if maps.is_empty()),
        |event| matches!(event, Event::DamagedMaps(maps) if maps.is_empty()),
        |event| matches!(event, Event::Graph(graph) if graph.nodes.is_empty()),
        |event| matches!(event, Event::Control(control) if control.owner == Some(CLIENT)),
        |event| matches!(event, Event::Tiles(tiles) if tiles.reset),
    ];
    let mut seen = Vec::new();
    while !wanted.iter().all(|wanted| seen.iter().any(wanted)) {
        seen.push(second.event(|_, event| Some(event.clone())));
    }
    while first.next().is_some() {}
    second.command(2, api::Command::ReleaseControl);
    second.event(|_, event| matches!(event, Event::CommandDone { .. }).then_some(()));
}

#[test]
fn clients_get_damaged_maps_with_the_file_and_what_to_do() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Store::open(dir.path()).expect("store");
    let publisher = StatePublisher::default();
    let folder = store.dir().map(MapId(Uuid::from_u128(9)));
    std::fs::create_dir_all(&folder).expect("made");
    let publish = |content: &str| {
        std::fs::write(folder.join("map.json"), content).expect("written");
        publish_map_list(&store, &publisher, CalendarTime::read()).expect("listed");
        let connection = publisher.connect();
        loop {
            if let Some(CoreMessage::Event { event: Event::DamagedMaps(maps), .. }) =
                publisher.next(connection)
            {
                return maps;
            }
        }
    };
    let [damaged] = publish("{ cut").try_into().expect("one map");
    assert_eq!(damaged.folder, folder.file_name().expect("a name").to_string_lossy());
    assert!(damaged.problem.contains("map.json"), "{damaged:?}");
    assert!(damaged.remedy.contains(&folder.display().to_string()), "{damaged:?}");
    let later = r#"{"format_version": 1000, "id": "00000000-0000-0000-0000-000000000009", "name": "Hall", "created": 1,
        "distance_m": 1.0, "keyframes": 1, "points": 1, "bytes": 1}"#;
    let [later] = publish(later).try_into().expect("one map");
    assert!(later.problem.contains("version 1000") && later.remedy.starts_with("Update"), "{later:?}");
}

#[test]
fn a_gateway_that_speaks_nonsense_or_another_version_is_dropped_and_the_core_goes_on() {
    let bench = bench(usize::MAX);
    bench.clock(0);
    for bytes in [&b"\xff\xff\xff\xffnonsense"[..], &b"\x02\x00\x00\x00\xff\xff"[..]] {
        let mut gateway = bench.gateway();
        gateway.stream.write_all(bytes).expect("written");
        while gateway.next().is_some() {}
    }
    let mut gateway = bench.gateway();
    gateway.send(&GatewayMessage::Hello { version: api::VERSION + 1 });
    while gateway.next().is_some() {}

    let mut gateway = bench.gateway();
    gateway.command(1, take_control());
    gateway.event(|_, event| matches!(event, Event::CommandDone { .. }).then_some(()));
}

#[test]
fn a_gateway_that_never_reads_delays_nothing() {
    let bench = bench(usize::MAX);
    let _deaf = bench.gateway();
    // 1,000 seconds of robot time, with about 20,000 ticks and everything that is published meanwhile.
    for second in 0..1_000 {
        bench.clock(1_000 * second);
    }
    let last = loop {
        let (millis, _) = bench.written();
        if millis >= 999_000 {
            break millis;
        }
    };
    // The last tick itself may be missing: a recorder that falls behind leaves inputs out and does not delay the loop.
    assert!((999_000..1_002_000).contains(&last), "{last}");
}

#[test]
fn a_disk_that_fails_is_announced_and_the_robot_goes_on() {
    let bench = bench(3);
    let mut gateway = bench.gateway();
    for millis in 0..100 {
        bench.clock(100 * millis);
    }
    let text = gateway.event(|_, event| match event {
        Event::Notice(notice) if notice.text.contains("disk is full") => Some(notice.text.clone()),
        _ => None,
    });
    assert!(text.contains("Recording has paused"), "{text}");
    gateway.command(1, take_control());
    gateway.event(|_, event| matches!(event, Event::CommandDone { .. }).then_some(()));
}

#[test]
fn time_goes_on_for_the_stack_when_the_robot_falls_silent() {
    let bench = bench(usize::MAX);
    bench.imu(0);
    let mut last = i64::MIN;
    let mut ticks = 0;
    while ticks < 10 {
        let (millis, input) = bench.written();
        assert!(millis >= last);
        last = millis;
        ticks += i32::from(matches!(input, Input::Tick));
    }
    assert!(last >= 450, "{last}");
}

#[test]
fn a_core_ends_with_everything_recorded_and_its_socket_gone() {
    let mut bench = bench(usize::MAX);
    for millis in 0..50 {
        bench.imu(millis);
    }
    // Every input that the core has taken must be recorded when it has ended.
    drop(bench.core.take());
    let taken = 50 - bench.robot.len();
    let recorded = bench.written.try_iter().filter(|(_, input)| matches!(input, Input::Sensor(_))).count();
    assert_eq!(recorded, taken);
    assert!(!bench.socket.exists());
}

#[test]
fn a_core_ends_also_when_its_data_directory_has_been_removed() {
    let mut bench = bench(usize::MAX);
    let gateway = bench.gateway();
    std::fs::remove_dir_all(bench.socket.parent().expect("it is in a directory")).expect("removed");
    let core = bench.core.take();
    let (ended, end) = crossbeam_channel::bounded(1);
    thread::spawn(move || {
        drop(core);
        let _ = ended.send(());
    });
    end.recv_timeout(PATIENCE).expect("the core ends");
    drop(gateway);
}

#[test]
fn changes_of_the_graph_that_do_not_apply_are_dropped_and_the_stack_is_asked_for_the_whole_graph_once() {
    let bench = bench(usize::MAX);
    bench.clock(0);
    let session = SessionId(Uuid::from_u128(3));
    let delta = |base_revision| {
        let (nodes, edges, removed_loops) = Default::default();
        let revision = base_revision + 1;
        let delta = GraphDelta { session, base_revision, revision, nodes, removed_loops, edges };
        Publication::GraphDelta(Arc::new(delta))
    };
    let whole = PoseGraph { revision: 7, ..PoseGraph::default() };
    let publications = [
        // Asks.
        delta(5),
        // Does not ask again.
        delta(6),
        Publication::Graph { session, graph: Arc::new(whole) },
        // Applies.
        delta(7),
        // Asks.
        delta(9),
    ];
    for publication in publications {
        bench.core.as_ref().expect("it runs").mailbox.post(publication);
    }
    let mut requests = 0;
    while requests < 2 {
        requests += i32::from(bench.written().1 == Input::GraphRequested);
    }
    let mut gateway = bench.gateway();
    let revision = gateway.event(|_, event| match event {
        Event::Graph(graph) => Some(graph.revision),
        _ => None,
    });
    assert_eq!(revision, 8, "what applies was published");
    gateway.command(1, take_control());
    loop {
        match bench.written().1 {
            Input::Command(_) => break,
            other => assert_ne!(other, Input::GraphRequested),
        }
    }
    // The gateway gets the whole graph as often as it asks.
    gateway.send(&GatewayMessage::RequestGraph);
    let graph = gateway.event(|_, event| match event {
        Event::Graph(graph) => Some(graph.clone()),
        _ => None,
    });
    assert_eq!((graph.session, graph.revision), (Some(session), 8));
}

#[test]
fn clients_are_told_why_robot_and_core_were_started_again() {
    let bench = bench(usize::MAX);
    bench.clock(0);
    let mut gateway = bench.gateway();
    for cause in ["was stuck", "was ill"] {
        let text = gateway.event(|_, event| match event {
            Event::Notice(notice) => Some(notice.text.clone()),
            _ => None,
        });
        assert!(text.contains(cause), "{text}");
    }
    let restarts = gateway.event(|_, event| match event {
        Event::Platform(platform) => Some(platform.restarts.clone()),
        _ => None,
    });
    let roles: Vec<_> = restarts.iter().map(|restart| restart.process).collect();
    assert_eq!(roles, [api::ProcessRole::SimulatedRobot, api::ProcessRole::Core]);
}

#[test]
fn clients_are_told_the_limits_of_the_robots_profile() {
    let bench = bench(usize::MAX);
    bench.clock(0);
    let limits = bench.gateway().event(|_, event| match event {
        Event::Platform(platform) => platform.manual_limits,
        _ => None,
    });
    assert_eq!(limits, api::SpeedLimits { forward_m_s: 0.7, sideways_m_s: 0.0, turn_rad_s: 0.6 });
}

#[test]
fn a_link_that_ends_without_a_word_is_a_failure() {
    let Bench { core, robot, failures, _dir: _kept, .. } = bench(usize::MAX);
    drop(robot);
    let failure = failures.recv_timeout(PATIENCE).expect("reported");
    assert_eq!(failure.to_string(), "lost its thread robot-link");
    drop(core);

    let bench = bench(usize::MAX);
    bench.clock(0);
    let Bench { core, robot, failures, _dir: _kept, .. } = bench;
    drop(robot);
    let failure = failures.recv_timeout(PATIENCE).expect("reported");
    assert_eq!(failure.to_string(), "lost its thread robot-link");
    drop(core);
}
