//! The actions of the simulated robot, called through the socket.

use super::*;
use crate::protocol::{PROTOCOL_VERSION, RobotCapabilities};
use crate::{SimulatedRobot, SimulatedRobotConfig, SocketLink, SocketLinkConfig};
use messages::BootRecord;
use ports::RobotLink;
use sim::{SimConfig, SiteName};
use site_model::{ActionReport, GammaSpectrum};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use uuid::Uuid;
use vocab::Stamp;

/// Limit of all waits, far longer than any of them takes.
const PATIENCE: Duration = Duration::from_secs(60);

struct Bench {
    robot: Option<SimulatedRobot>,
    dir: tempfile::TempDir,
}

impl Bench {
    fn start(speed: f64) -> (Self, SocketLink) {
        let mut bench = Self { robot: None, dir: tempfile::tempdir().expect("temporary directory") };
        let sim = SimConfig { lidar_columns: 10, people: 0, ..SimConfig::new(SiteName::B1, 1) };
        let config = SimulatedRobotConfig::new(sim, speed, bench.socket());
        bench.robot = Some(SimulatedRobot::start(config).expect("starts"));
        let link = SocketLink::connect(&bench.socket(), SocketLinkConfig::default()).expect("connects");
        (bench, link)
    }

    fn socket(&self) -> PathBuf {
        self.dir.path().join("robot.sock")
    }
}

fn id(number: u128) -> ActionCallId {
    ActionCallId(Uuid::from_u128(number))
}

fn call(number: u128, action: &str, parameters: &str) -> ActionCall {
    ActionCall { id: id(number), action: action.to_owned(), parameters: parameters.to_owned() }
}

/// The next end of a call, and the feedback before it. The robot's measurements are read meanwhile, so that it goes on.
fn next_end(link: &SocketLink) -> (ActionCallId, ActionEnd, Vec<Option<f32>>) {
    let (arrivals, events) = (link.arrivals(), link.action_server().expect("has actions").events());
    let (begun, mut feedback) = (Instant::now(), Vec::new());
    loop {
        assert!(begun.elapsed() < PATIENCE, "the action does not end");
        crossbeam_channel::select! {
            recv(arrivals) -> _ => {}
            recv(events) -> event => match event.expect("the link lives") {
                ActionEvent::Feedback { progress, .. } => feedback.push(progress),
                ActionEvent::Ended { call, end } => return (call, end, feedback),
            },
            default(Duration::from_millis(50)) => {}
        }
    }
}

/// Report and files of an action that is expected to succeed.
fn succeed(link: &SocketLink, call: ActionCall) -> (ActionReport, Vec<ports::ActionFile>) {
    let id = call.id;
    link.action_server().expect("has actions").start(call).expect("begun");
    match next_end(link) {
        (ended, ActionEnd::Succeeded { report, files }, _) if ended == id => {
            (serde_json::from_str(&report).expect("a report"), files)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_photo_is_a_jpeg_and_its_report_says_how_the_camera_stood() {
    let (_bench, link) = Bench::start(1.0);
    let server = link.action_server().expect("has actions");
    let names: Vec<String> = server.actions().into_iter().map(|action| action.name).collect();
    assert_eq!(names, ["photo", "thermal_photo", "temperature_humidity", "gamma_spectrum"]);
    assert_eq!(link.boot().profile.camera_head.zoom_max, 20.0);
    let (report, files) =
        succeed(&link, call(1, "photo", r#"{"pan_rad": 0.5, "tilt_rad": -0.1, "zoom": 2}"#));
    let camera = report.camera.expect("a picture has one");
    assert_eq!((camera.aim.pan_rad, camera.aim.zoom, camera.size_px), (0.5, 2.0, [640, 480]));
    assert!((camera.focal_px - 2.0 * 554.256).abs() < 0.1, "{}", camera.focal_px);
    assert!(report.at.robot_time > Stamp::EPOCH);
    assert_eq!((files[0].media_type.as_str(), &files[0].bytes[..3]), ("image/jpeg", &[0xff, 0xd8, 0xff][..]));
    let mut decoder = zune_jpeg::JpegDecoder::new(std::io::Cursor::new(&files[0].bytes));
    let pixels = decoder.decode().expect("decodes");
    let mean = pixels.iter().map(|byte| f64::from(*byte)).sum::<f64>() / pixels.len() as f64;
    assert!(pixels.len() == 640 * 480 * 3 && (40.0..220.0).contains(&mean), "mean {mean}");
    let (report, files) = succeed(&link, call(2, "thermal_photo", r#"{"pan_rad": 0.5, "tilt_rad": 0}"#));
    assert_eq!((files.len(), report.readings.len(), &files[1].bytes[1..4]), (2, 3, &b"PNG"[..]));
}

#[test]
fn measurements_take_their_time_on_the_robots_clock_and_tell_how_far_they_are() {
    let (_bench, link) = Bench::start(100.0);
    let server = link.action_server().expect("has actions");
    let before = link.arrivals().recv_timeout(PATIENCE).expect("the robot lives").at;
    server.start(call(1, "gamma_spectrum", r#"{"duration_s": 20}"#)).expect("begun");
    let (_, end, feedback) = next_end(&link);
    let ActionEnd::Succeeded { report, files } = end else { panic!("{end:?}") };
    let report: ActionReport = serde_json::from_str(&report).expect("a report");
    assert!((report.at.robot_time - before).secs_f64() >= 20.0);
    let spectrum: GammaSpectrum = serde_json::from_slice(&files[0].bytes).expect("a spectrum");
    assert!((spectrum.live_time_s - 20.0).abs() < 1e-6 && spectrum.counts.len() == 1024);
    let events = spectrum.counts_between(0.0, 1e9) as f64;
    assert!((1_000.0..8_000.0).contains(&events), "{events} events of background");
    assert!((report.readings[0].value - events / 20.0).abs() < 1e-6);
    let shares: Vec<f32> = feedback.into_iter().flatten().collect();
    assert!(shares.len() >= 10 && shares.is_sorted() && shares.last() == Some(&1.0), "{shares:?}");
    let (report, _) = succeed(&link, call(2, "temperature_humidity", "{}"));
    assert_eq!(report.readings[0].unit, "°C");
    assert!((10.0..35.0).contains(&report.readings[0].value), "{:?}", report.readings);
}

#[test]
fn what_cannot_be_done_fails_with_a_reason() {
    let (_bench, link) = Bench::start(10.0);
    let server = link.action_server().expect("has actions");
    let cases = [
        ("photo", r#"{"pan_rad": 3.1, "tilt_rad": 0}"#, "cannot point there"),
        ("photo", r#"{"pan_rad": 0, "tilt_rad": 0, "zoom": 50}"#, "cannot point there"),
        ("photo", r#"{"pan_rad": "left"}"#, "schema"),
        ("gamma_spectrum", "[", "schema"),
        ("dance", "{}", "no action \"dance\""),
    ];
    for (number, (action, parameters, expected)) in cases.into_iter().enumerate() {
        server.start(call(number as u128, action, parameters)).expect("begun");
        match next_end(&link) {
            (ended, ActionEnd::Failed { reason }, _) if ended == id(number as u128) => {
                assert!(reason.contains(expected), "{reason}");
            }
            other => panic!("{other:?}"),
        }
    }
    let long = "x".repeat(MAX_ACTION_PARAMETER_BYTES + 1);
    assert!(server.start(call(9, "photo", &long)).expect_err("refused").contains("too long"));
}

#[test]
fn a_cancelled_action_ends_at_once_and_only_once() {
    let (_bench, link) = Bench::start(1.0);
    let server = link.action_server().expect("has actions");
    server.start(call(1, "gamma_spectrum", r#"{"duration_s": 3600}"#)).expect("begun");
    // A call that is repeated is the same one.
    server.start(call(1, "gamma_spectrum", r#"{"duration_s": 3600}"#)).expect("begun");
    server.start(call(2, "photo", r#"{"pan_rad": 0, "tilt_rad": 0}"#)).expect("begun");
    server.cancel(id(2));
    server.cancel(id(1));
    // Nobody has called this.
    server.cancel(id(3));
    let mut ends = [next_end(&link), next_end(&link)].map(|(call, end, _)| (call, end));
    ends.sort_by_key(|(call, _)| *call);
    assert_eq!(ends, [(id(1), ActionEnd::Cancelled), (id(2), ActionEnd::Cancelled)]);
    // The picture that is still rendered is left out, and the robot takes others.
    succeed(&link, call(4, "photo", r#"{"pan_rad": 0, "tilt_rad": 0}"#));
}

#[test]
fn an_action_of_a_robot_that_dies_fails_because_nobody_knows_what_became_of_it() {
    let (mut bench, link) = Bench::start(1.0);
    let server = link.action_server().expect("has actions");
    server.start(call(1, "gamma_spectrum", r#"{"duration_s": 3600}"#)).expect("begun");
    bench.robot = None;
    let (ended, end, _) = next_end(&link);
    let ActionEnd::Failed { reason } = end else { panic!("{end:?}") };
    assert!(ended == id(1) && reason.contains("nobody knows"), "{reason}");
    let refused =
        server.start(call(2, "photo", r#"{"pan_rad": 0, "tilt_rad": 0}"#)).expect_err("not connected");
    assert!(refused.contains("not connected"), "{refused}");
}

#[test]
fn a_robot_that_floods_with_feedback_leaves_room_for_the_ends() {
    let identity = RobotIdentity {
        run: 1,
        now: Stamp::EPOCH,
        boot: BootRecord::default(),
        site: None,
        capabilities: RobotCapabilities::default(),
        actions: Vec::new(),
    };
    assert_eq!(PROTOCOL_VERSION, 4);
    let (ours, theirs) = std::os::unix::net::UnixStream::pair().expect("a pair");
    let connection = Arc::<CurrentConnection>::default();
    connection.install(&ours).expect("installed");
    let actions = RobotActions::new(&identity, connection);
    for number in 0..MAX_OPEN_ACTIONS as u128 {
        actions.start(call(number, "photo", "{}")).expect("begun");
    }
    assert!(actions.start(call(99, "photo", "{}")).expect_err("refused").contains("too many"));
    for number in 0..10_000 {
        let feedback = ActionEvent::Feedback { call: id(number % 20), progress: None, text: String::new() };
        actions.receive(feedback);
    }
    let large = ports::ActionFile {
        name: String::new(),
        media_type: String::new(),
        bytes: vec![0; MAX_ACTION_RESULT_BYTES + 1],
    };
    let end = ActionEnd::Succeeded { report: String::new(), files: vec![large] };
    actions.receive(ActionEvent::Ended { call: id(0), end });
    actions.receive(ActionEvent::Ended { call: id(0), end: ActionEnd::Cancelled });
    actions.fail_all();
    let ends: Vec<ActionEvent> = actions.events().try_iter().skip(CONFIG.max_waiting_feedback).collect();
    assert_eq!(ends.len(), MAX_OPEN_ACTIONS);
    let is_failure =
        |event: &ActionEvent| matches!(event, ActionEvent::Ended { end: ActionEnd::Failed { .. }, .. });
    assert!(ends.iter().all(is_failure), "{ends:?}");
    drop(theirs);
}
