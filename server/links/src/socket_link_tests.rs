use super::*;
use messages::ImuSample;
use std::os::unix::net::UnixListener;
use std::sync::mpsc;
use std::thread;

const PATIENCE: Duration = Duration::from_secs(30);

/// A robot that sends these messages after the core's greeting. It ends when the sender in the answer is dropped.
fn robot(path: &Path, messages: Vec<RobotMessage>) -> mpsc::Sender<()> {
    let listener = UnixListener::bind(path).expect("listens");
    let (end, ended) = mpsc::channel::<()>();
    thread::spawn(move || {
        let (mut core, _) = listener.accept().expect("a core");
        let hello: Option<RobotRequest> = read_frame(&mut core, 100).expect("a greeting");
        assert_eq!(hello, Some(RobotRequest::Hello { version: PROTOCOL_VERSION }));
        for message in messages {
            core.write_all(&encode_frame(&message)).expect("written");
        }
        let _ = ended.recv();
    });
    end
}

fn identity(simulated_faults: bool) -> RobotMessage {
    RobotMessage::Identity(Box::new(RobotIdentity {
        run: 7,
        now: Stamp::from_parts(100, 0),
        boot: BootRecord::default(),
        site: None,
        capabilities: crate::RobotCapabilities { simulated_faults },
        actions: Vec::new(),
    }))
}

const HELLO: RobotMessage = RobotMessage::Hello { version: PROTOCOL_VERSION };

#[test]
fn robots_of_another_version_and_other_programs_are_not_connected() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("robot.sock");
    let config =
        SocketLinkConfig { hello_timeout: Duration::from_millis(200), ..SocketLinkConfig::default() };
    let error = |messages: Vec<RobotMessage>| {
        let _robot = robot(&path, messages);
        let error = SocketLink::connect(&path, config).err().expect("not connected");
        std::fs::remove_file(&path).expect("removed");
        error
    };
    assert!(matches!(SocketLink::connect(&path, config), Err(ConnectError::Io(_))));
    let later = PROTOCOL_VERSION + 1;
    assert!(
        matches!(error(vec![RobotMessage::Hello { version: later }]), ConnectError::Version(v) if v == later)
    );
    assert!(matches!(error(vec![identity(true)]), ConnectError::NoGreeting));
    assert!(matches!(error(vec![HELLO, HELLO]), ConnectError::NoGreeting));
    assert!(matches!(error(vec![HELLO]), ConnectError::Io(_)));
}

#[test]
fn the_clock_never_goes_back_and_invalid_measurements_are_left_out() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("robot.sock");
    let at = |millis: i64| Stamp::from_parts(100, 0) + vocab::Span::from_millis(millis);
    let imu = Sensor::Imu(ImuSample::default());
    let scan = |xyz: Vec<[f32; 3]>, ring| Sensor::Scan(Arc::new(Scan { xyz, ring, ..Scan::default() }));
    let sensors = [
        (20, scan(vec![[1.0; 3]], vec![3])),
        (30, scan(vec![[f32::NAN; 3]], Vec::new())),
        (40, scan(vec![[1.0; 3]], vec![3, 4])),
        (10, imu.clone()),
    ];
    let messages = sensors
        .iter()
        .map(|(millis, sensor)| RobotMessage::Sensor { at: at(*millis), sensor: sensor.clone() });
    let robot = robot(&path, [HELLO, identity(false)].into_iter().chain(messages).collect());
    let link = SocketLink::connect(&path, SocketLinkConfig::default()).expect("connects");
    let next = || link.arrivals().recv_timeout(PATIENCE).expect("an arrival");
    let scan = next();
    assert!(scan.at == at(20) && matches!(scan.event, RobotEvent::Sensor(Sensor::Scan(_))), "{scan:?}");
    assert_eq!(next(), Arrival { at: at(30), event: RobotEvent::Clock });
    assert_eq!(next(), Arrival { at: at(40), event: RobotEvent::Clock });
    assert_eq!(next(), Arrival { at: at(40), event: RobotEvent::Sensor(imu) });

    let fault = SimulatedFault::CarryAway;
    let number = CommandId(uuid::Uuid::from_u128(1));
    assert_eq!(link.inject_fault(number, fault), Err(REAL_ROBOT_HAS_NO_FAULTS.to_owned()));
    drop(robot);
    let lost = next();
    assert!(lost.at == at(40) && matches!(lost.event, RobotEvent::Disconnected(_)), "{lost:?}");
    // Without a connection it does nothing.
    link.drive(Drive::default());
}

#[test]
fn a_robot_that_does_not_read_is_disconnected_and_never_blocks_the_core() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("robot.sock");
    let _robot = robot(&path, vec![HELLO, identity(true)]);
    let link = SocketLink::connect(&path, SocketLinkConfig::default()).expect("connects");
    let start = std::time::Instant::now();
    while link.connection.is_connected() {
        link.drive(Drive::default());
        assert!(start.elapsed() < PATIENCE, "still connected");
    }
    let fault = link.inject_fault(CommandId(uuid::Uuid::from_u128(1)), SimulatedFault::CarryAway);
    assert!(fault.is_err());
}
