use super::wait_budget::WaitBudgetConfig;
use super::*;
use crate::protocol::{MAX_ROBOT_MESSAGE_BYTES, PROTOCOL_VERSION, RobotMessage, RobotRequest};
use crate::{SocketLink, SocketLinkConfig};
use messages::{DRIVE_LIFETIME, Drive, Sensor};
use ports::{Arrival, RobotEvent, RobotLink, SimulatedFault, encode_frame, read_frame};
use sim::{SimConfig, SiteName};
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};
use uuid::Uuid;
use vocab::{CommandId, Span, Stamp, Twist, Vec3};

/// Limit of all waits, far longer than any of them takes.
const PATIENCE: Duration = Duration::from_secs(30);

/// A robot that runs as fast as possible, with few LiDAR columns: these tests use no details of the scans.
struct Bench {
    robot: Option<SimulatedRobot>,
    dir: tempfile::TempDir,
}

impl Bench {
    /// A robot that waits for its core as long as these tests do, on a machine however slow.
    fn start() -> Self {
        Self::start_with(PATIENCE)
    }

    fn start_with(max_wait: Duration) -> Self {
        let mut bench = Self { robot: None, dir: tempfile::tempdir().expect("temporary directory") };
        bench.robot = Some(SimulatedRobot::start(bench.config(max_wait)).expect("starts"));
        bench
    }

    fn config(&self, max_wait: Duration) -> SimulatedRobotConfig {
        let sim = SimConfig { lidar_columns: 10, people: 0, ..SimConfig::new(SiteName::B1, 1) };
        SimulatedRobotConfig {
            truth: Some(self.dir.path().join("truth.csv")),
            wait: WaitBudgetConfig { max_wait, wait_per_robot_second: 1e4 },
            ..SimulatedRobotConfig::new(sim, 1000.0, self.socket())
        }
    }

    fn socket(&self) -> PathBuf {
        self.dir.path().join("robot.sock")
    }

    fn link(&self) -> SocketLink {
        SocketLink::connect(&self.socket(), SocketLinkConfig::default()).expect("connects")
    }

    /// A core that has greeted.
    fn core(&self) -> UnixStream {
        let mut core = UnixStream::connect(self.socket()).expect("connects");
        core.set_read_timeout(Some(PATIENCE)).expect("settable");
        send(&mut core, &RobotRequest::Hello { version: PROTOCOL_VERSION });
        assert_eq!(receive(&mut core), Some(RobotMessage::Hello { version: PROTOCOL_VERSION }));
        assert!(matches!(receive(&mut core), Some(RobotMessage::Identity(_))));
        core
    }

    /// The last line of the truth: robot time in seconds, and whether the robot walks.
    fn truth(&self) -> (f64, bool) {
        let text = std::fs::read_to_string(self.dir.path().join("truth.csv")).expect("readable");
        // The last line may be incomplete.
        let line = text.lines().rev().nth(1).expect("some lines");
        let time: f64 = line.split(',').next().expect("a column").parse().expect("a number");
        (time * 1e-9, line.ends_with(",1"))
    }
}

fn send(core: &mut UnixStream, request: &RobotRequest) {
    core.write_all(&encode_frame(request)).expect("written");
}

/// The next message; `None` at the end of the connection.
fn receive(core: &mut UnixStream) -> Option<RobotMessage> {
    read_frame(core, MAX_ROBOT_MESSAGE_BYTES).unwrap_or_default()
}

fn until<T>(what: &str, mut condition: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = condition() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "did not happen within the limit: {what}");
        std::thread::yield_now();
    }
}

fn next(arrivals: &Receiver<Arrival>) -> Arrival {
    arrivals.recv_timeout(PATIENCE).expect("the simulation goes on")
}

fn id(number: u128) -> CommandId {
    CommandId(Uuid::from_u128(number))
}

const FORWARD: Drive =
    Drive { velocity: Twist { linear: Vec3::new(0.5, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, 0.0) } };

/// Reads arrivals, and drives if a command is given, until the legs report a wanted speed; false after some robot seconds.
fn reaches(link: &SocketLink, drive: Option<Drive>, seconds: i64, is_wanted: fn(f64) -> bool) -> bool {
    let arrivals = link.arrivals();
    let mut until = None;
    loop {
        let arrival = next(&arrivals);
        if arrival.at > *until.get_or_insert(arrival.at + Span::from_millis(1000 * seconds)) {
            return false;
        }
        if let Some(drive) = drive {
            link.drive(drive);
        }
        if let RobotEvent::Sensor(Sensor::Legs(legs)) = arrival.event
            && is_wanted(legs.base_velocity.linear.x)
        {
            return true;
        }
    }
}

#[test]
fn arrivals_come_in_order_and_a_slow_core_misses_none() {
    let bench = Bench::start();
    let link = bench.link();
    assert_eq!(link.site().as_deref(), Some("b1"));
    let arrivals = link.arrivals();
    let (mut last, mut clock): (Option<Stamp>, Option<Stamp>) = (None, None);
    let mut kinds = [0; 4];
    for number in 0..10_000 {
        // The queues fill up in the meantime: the simulation runs a hundred times faster than this.
        if number % 100 == 0 {
            std::thread::sleep(Duration::from_millis(2));
        }
        let arrival = next(&arrivals);
        assert!(last.is_none_or(|last| arrival.at >= last), "{arrival:?} after {last:?}");
        last = Some(arrival.at);
        match arrival.event {
            RobotEvent::Sensor(Sensor::Imu(_)) => kinds[0] += 1,
            RobotEvent::Sensor(Sensor::Scan(_)) => kinds[1] += 1,
            RobotEvent::Sensor(Sensor::Legs(_)) => kinds[2] += 1,
            RobotEvent::Clock => {
                kinds[3] += 1;
                assert!(clock.is_none_or(|clock| arrival.at - clock == Span::from_millis(10)));
                clock = Some(arrival.at);
            }
            _ => {}
        }
    }
    assert!(kinds.iter().all(|count| *count > 10), "{kinds:?}");
}

#[test]
fn the_robot_walks_on_commands_and_stops_when_they_cease() {
    let bench = Bench::start();
    let link = bench.link();
    // While this thread sleeps, the simulation may fill its queue. That takes longer than a command is valid, so the robot may stop
    // in between. The test therefore waits until a speed is reached.
    assert!(reaches(&link, Some(FORWARD), 60, |speed| speed > 0.4), "never walks at the commanded speed");
    // The arrivals in the queue are from walking. After them the last command is valid for its time, and the legs come to rest.
    let rest = 5 + DRIVE_LIFETIME.nanos() / 1_000_000_000;
    assert!(!reaches(&link, None, rest, |_| false), "always false, so this only lets {rest} s pass");
    assert!(
        !reaches(&link, None, 3, |speed| speed.abs() > 0.1),
        "still moves {rest} s after the last command"
    );
}

#[test]
fn the_robot_stands_without_a_core_and_its_clock_goes_on() {
    let bench = Bench::start();
    let link = bench.link();
    assert!(reaches(&link, Some(FORWARD), 60, |speed| speed > 0.4), "never walks at the commanded speed");
    let last = link.arrivals().recv_timeout(PATIENCE).expect("the simulation goes on").at;
    drop(link);
    until("it stands", || (!bench.truth().1).then_some(()));
    let (stands, _) = bench.truth();
    until("its clock goes on", || (bench.truth().0 > stands + 5.0).then_some(()));
    assert!(!bench.truth().1);
    let link = bench.link();
    let first = next(&link.arrivals()).at;
    assert!(first - last > Span::from_millis(5_000), "{first:?} after {last:?}");
    assert!(!reaches(&link, None, 3, |speed| speed.abs() > 0.1), "walks without a command");
    assert!(
        reaches(&link, Some(FORWARD), 60, |speed| speed > 0.4),
        "does not drive as the second core commands"
    );
}

#[test]
fn a_core_that_does_not_read_is_disconnected_and_can_connect_again() {
    let bench = Bench::start_with(Duration::from_millis(300));
    let link = bench.link();
    let arrivals = link.arrivals();
    let first = next(&arrivals).at;
    // The robot waits for a moment; then its clock goes on, far beyond what the queues hold.
    until("the clock goes on", || (bench.truth().0 > first.nanos() as f64 * 1e-9 + 30.0).then_some(()));
    let (mut last, mut events) = (first, Vec::new());
    while events.len() < 2 {
        let arrival = next(&arrivals);
        assert!(arrival.at >= last, "{arrival:?} after {last:?}");
        last = arrival.at;
        match arrival.event {
            RobotEvent::Sensor(_) | RobotEvent::Clock => {}
            other => events.push(other),
        }
    }
    assert!(matches!(events[..], [RobotEvent::Disconnected(_), RobotEvent::Reconnected]), "{events:?}");
    let gap = next(&arrivals).at - last;
    assert!(gap > Span::from_millis(10_000), "{gap:?}");
}

#[test]
fn malformed_frames_end_the_connection_and_not_the_robot() {
    let bench = Bench::start();
    for bytes in [&[255; 64][..], &[1, 0, 0, 0, 99], &encode_frame(&RobotRequest::Hello { version: 1 })] {
        let mut core = bench.core();
        core.write_all(bytes).expect("written");
        until("the connection ends", || receive(&mut core).is_none().then_some(()));
    }
    // Before the greeting too, and a core that says nothing is not waited for for ever.
    for bytes in [&b"GET / HTTP/1.1\r\n\r\n"[..], &encode_frame(&RobotRequest::Drive(FORWARD)), &[]] {
        let mut core = UnixStream::connect(bench.socket()).expect("connects");
        core.set_read_timeout(Some(PATIENCE)).expect("settable");
        core.write_all(bytes).expect("written");
        assert_eq!(core.read(&mut [0; 8]).unwrap_or(0), 0);
    }
    // A core of another version learns the robot's.
    let mut core = UnixStream::connect(bench.socket()).expect("connects");
    core.set_read_timeout(Some(PATIENCE)).expect("settable");
    send(&mut core, &RobotRequest::Hello { version: PROTOCOL_VERSION + 1 });
    assert_eq!(receive(&mut core), Some(RobotMessage::Hello { version: PROTOCOL_VERSION }));
    assert_eq!(receive(&mut core), None);
    // Requests that no core makes, but that are well formed.
    let mut core = bench.core();
    let nan = Twist { linear: Vec3::new(f64::NAN, f64::INFINITY, 0.0), ..Twist::default() };
    send(&mut core, &RobotRequest::Drive(Drive { velocity: nan }));
    let fault = SimulatedFault::CoverLidar(Span::from_nanos(i64::MAX));
    send(&mut core, &RobotRequest::InjectFault { id: id(1), fault });
    until("the fault is answered", || {
        matches!(receive(&mut core), Some(RobotMessage::FaultAnswer { refused: None, .. })).then_some(())
    });
    drop(core);
    next(&bench.link().arrivals());
}

#[test]
fn a_new_core_replaces_the_old_one() {
    let bench = Bench::start();
    let (mut old, mut new) = (bench.core(), bench.core());
    until("the old one is disconnected", || receive(&mut old).is_none().then_some(()));
    assert!(receive(&mut new).is_some());
}

#[test]
fn a_robot_that_is_started_again_is_another_robot() {
    let mut bench = Bench::start();
    let link = bench.link();
    let second = SimulatedRobot::start(bench.config(PATIENCE)).err().expect("the socket is in use");
    assert!(matches!(second, RobotStartError::InUse { .. }), "{second}");
    bench.robot = None;
    assert!(!bench.socket().exists());
    bench.robot = Some(SimulatedRobot::start(bench.config(PATIENCE)).expect("starts again"));
    // The queue is read, so that the link's thread does not wait.
    let arrivals = link.arrivals();
    until("the link notices", || {
        let _ = arrivals.try_recv();
        link.robot_restarted().try_recv().ok()
    });
}

#[test]
fn links_and_robots_with_full_queues_can_be_dropped() {
    let bench = Bench::start();
    let link = bench.link();
    let arrivals = link.arrivals();
    until("the queue fills", || arrivals.is_full().then_some(()));
    drop(bench);
    drop(link);
    assert_eq!(arrivals.iter().count(), SocketLinkConfig::default().max_queued_arrivals);
}

#[test]
fn injected_faults_blind_the_lidar_until_they_are_cleared() {
    let bench = Bench::start();
    let link = bench.link();
    let arrivals = link.arrivals();
    let sees = |expected: bool, seconds: i64| {
        let mut until = None;
        loop {
            let arrival = next(&arrivals);
            if arrival.at > *until.get_or_insert(arrival.at + Span::from_millis(1000 * seconds)) {
                return false;
            }
            if let RobotEvent::Sensor(Sensor::Scan(scan)) = arrival.event
                && scan.xyz.is_empty() != expected
            {
                return true;
            }
        }
    };
    let inject = |number: u128, fault: SimulatedFault| {
        link.inject_fault(id(number), fault).expect("connected");
        until("the fault is answered", || match next(&arrivals).event {
            RobotEvent::FaultAnswered { id: answered, refused } => {
                assert_eq!((answered, refused), (id(number), None));
                Some(())
            }
            _ => None,
        });
    };
    assert!(sees(true, 10));
    inject(1, SimulatedFault::CoverLidar(Span::from_millis(3_600_000)));
    assert!(sees(false, 60), "the LiDAR is covered");
    inject(2, SimulatedFault::End);
    assert!(sees(true, 60), "the LiDAR is clear again");
    inject(3, SimulatedFault::CarryAway);
    assert!(sees(false, 60) && sees(true, 60), "the LiDAR is covered again and clear again");
}
