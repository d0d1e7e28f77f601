//! Calls of actions, from the control loop's end to the stored result.

use super::*;
use crate::clock::RobotClock;
use crate::mailbox::Mailbox;
use messages::{Cloud, Estimate, LocalisationState};
use ports::{ActionCall, ActionEnd, ActionEvent, ActionFile, ActionRegistration, ActionServer};
use site_model::{ActionReport, LocalisationQuality};
use std::sync::Mutex;
use std::thread::JoinHandle;
use std::time::Instant;
use store::{BlobsConfig, Store};
use uuid::Uuid;
use vocab::{CameraAim, CameraHead, MapId, Pose, Quat, Stamp, Vec3};
use watchdog::Heartbeat;

/// Far longer than any step of these tests.
const PATIENCE: Duration = Duration::from_secs(30);
const MAP: MapId = MapId(Uuid::from_u128(77));
const HEAD: CameraHead = CameraHead {
    base_from_head_m: [0.0; 3],
    pan_max_rad: 2.9,
    tilt_min_rad: -0.7,
    tilt_max_rad: 1.4,
    zoom_max: 20.0,
    field_of_view_rad: 1.0,
};

/// A robot whose answers the test gives.
struct FakeRobot {
    calls: Mutex<Vec<ActionCall>>,
    cancelled: Mutex<Vec<ActionCallId>>,
    answers: Sender<ActionEvent>,
    events: Receiver<ActionEvent>,
    refuses: bool,
}

impl ActionServer for FakeRobot {
    fn actions(&self) -> Vec<ActionRegistration> {
        let action = |name: &str| ActionRegistration {
            name: name.to_owned(),
            title: name.to_owned(),
            parameter_schema: "{}".to_owned(),
            expected: Span::from_millis(1_000),
            expected_energy_j: 60,
            is_idempotent: true,
        };
        vec![action("photo"), action("gamma_spectrum")]
    }
    fn start(&self, call: ActionCall) -> Result<(), String> {
        if self.refuses {
            return Err("The robot is not connected.".to_owned());
        }
        self.calls.lock().expect("not poisoned").push(call);
        Ok(())
    }
    fn cancel(&self, call: ActionCallId) {
        self.cancelled.lock().expect("not poisoned").push(call);
    }
    fn events(&self) -> Receiver<ActionEvent> {
        self.events.clone()
    }
}

struct Bench {
    queue: Option<ActionQueue>,
    results: Receiver<Input>,
    robot: Arc<FakeRobot>,
    store: Arc<Store>,
    clock: Arc<RobotClock>,
    mailbox: Arc<Mailbox>,
    thread: Option<JoinHandle<()>>,
    begun: Instant,
    _dir: tempfile::TempDir,
}

impl Bench {
    fn start(blobs: BlobsConfig, refuses: bool) -> Self {
        let (answers, events) = crossbeam_channel::unbounded();
        let robot =
            FakeRobot { calls: Mutex::default(), cancelled: Mutex::default(), answers, events, refuses };
        let robot = Arc::new(robot);
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Arc::new(Store::open(dir.path()).expect("opens"));
        let (clock, mailbox) = (Arc::<RobotClock>::default(), Arc::<Mailbox>::default());
        let config = ActionConfig { max_cloud_points: 5, ..ActionConfig::default() };
        let (queue, inbox) = ActionQueue::new(&config);
        let (sender, results) = crossbeam_channel::bounded(config.max_results);
        let worker = ActionWorker {
            config,
            blobs,
            store: Arc::clone(&store),
            robot: Some(Arc::clone(&robot) as Arc<dyn ActionServer>),
            camera_head: HEAD,
            base_from_lidar_m: Vec3::new(0.0, 0.0, 0.25),
            inbox,
            results: sender,
            mailbox: Arc::clone(&mailbox),
            state_publisher: Arc::default(),
            clock: Arc::clone(&clock),
            open: OpenActions::default(),
            sight: SightChecker::new(Arc::clone(&store)),
            gauges: None,
        };
        let thread = Some(std::thread::spawn(move || worker.run(&Heartbeat::unwatched())));
        let bench = Self {
            queue: Some(queue),
            results,
            robot,
            store,
            clock,
            mailbox,
            thread,
            begun: Instant::now(),
            _dir: dir,
        };
        bench.clock.set(at(0));
        let registered = bench.results.recv_timeout(PATIENCE).expect("the thread lives");
        let Input::ActionsRegistered(actions) = registered else { panic!("{registered:?}") };
        let names: Vec<&str> = actions.iter().map(|action| action.name.as_str()).collect();
        assert_eq!(names, ["photo", "gamma_spectrum", "point_cloud", "wait", "message", "dock", "undock"]);
        assert!(actions[0].is_idempotent && !actions[4].is_idempotent);
        assert_eq!(actions[3].expected, Span::from_millis(10_000));
        bench
    }

    fn queue(&self) -> &ActionQueue {
        self.queue.as_ref().expect("not closed")
    }

    fn call(&self, number: u128, action: &str, parameters: &str) {
        assert_eq!(self.queue().call(id(number), action.to_owned(), parameters.to_owned()), None);
    }

    /// The robot is localised at (1, 0, 0), turned half round.
    fn localise(&self) {
        let orientation = Quat { w: 0.0, x: 0.0, y: 0.0, z: 1.0 };
        let map_from_base = Pose { position: Vec3::new(1.0, 0.0, 0.0), orientation };
        let estimate = Estimate { stamp: at(0), map_from_base, ..Estimate::default() };
        let localised = LocalisationState::Localised { map: MAP, degradation: None };
        self.queue().watch(&Publication::Localisation(localised));
        self.queue().watch(&Publication::Estimate(estimate));
    }

    fn robot_says(&self, event: ActionEvent) {
        self.robot.answers.send(event).expect("the test holds the other end");
    }

    /// The next end of a call; feedback is left out.
    fn end(&self) -> (u128, ActionOutcome) {
        loop {
            match self.results.recv_timeout(PATIENCE).expect("the thread lives") {
                Input::ActionDone { call, outcome } => return (call.0.as_u128(), outcome),
                Input::ActionFeedback { .. } => {}
                other => panic!("{other:?}"),
            }
        }
    }

    fn failure(&self) -> (u128, String) {
        match self.end() {
            (call, ActionOutcome::Failed { reason }) => (call, reason),
            other => panic!("{other:?}"),
        }
    }

    fn report(&self) -> (u128, ActionReport) {
        match self.end() {
            (call, ActionOutcome::Succeeded { result }) => {
                (call, serde_json::from_str(&result).expect("a report"))
            }
            other => panic!("{other:?}"),
        }
    }

    fn until<T>(&self, what: &str, mut condition: impl FnMut() -> Option<T>) -> T {
        let begun = Instant::now();
        loop {
            if let Some(found) = condition() {
                return found;
            }
            assert!(begun.elapsed() < PATIENCE, "did not happen within the limit: {what}");
            std::thread::yield_now();
        }
    }

    /// Lets the robot's clock run twenty times faster than this computer's.
    fn pass_time(&self) {
        let nanos = i64::try_from(self.begun.elapsed().as_nanos()).expect("a short time");
        self.clock.set(at(0) + Span::from_nanos(20 * nanos));
    }

    fn called(&self) -> ActionCall {
        self.until("the robot is called", || self.robot.calls.lock().expect("not poisoned").pop())
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        drop(self.queue.take());
        if let Some(thread) = self.thread.take() {
            thread.join().expect("it ends without a panic");
        }
    }
}

fn at(millis: i64) -> Stamp {
    Stamp::from_parts(1_000, 0) + Span::from_millis(millis)
}

fn id(number: u128) -> ActionCallId {
    ActionCallId(Uuid::from_u128(number))
}

fn photo(bytes: &[u8]) -> ActionEnd {
    let camera = r#""camera": {"aim": {"pan_rad": 0.1, "tilt_rad": 0, "zoom": 1}, "size_px": [4, 3], "focal_px": 3.5,
        "centre_px": [2, 1.5], "base_from_camera": {"position": {"x": 0, "y": 0, "z": 0}, "orientation": {"w": 1, "x": 0, "y": 0, "z": 0}}}"#;
    let robot_time = at(0).nanos();
    let report = format!(
        r#"{{"at": {{"robot_time": {robot_time}, "utc_ns": 0, "is_synchronised": false}}, {camera}}}"#
    );
    let media_type = "image/jpeg".to_owned();
    let file = ActionFile { name: "photo.jpg".to_owned(), media_type, bytes: bytes.to_vec() };
    ActionEnd::Succeeded { report, files: vec![file] }
}

#[test]
fn a_photo_is_aimed_by_the_estimate_and_stored_before_the_stack_hears_of_it() {
    let bench = Bench::start(BlobsConfig::default(), false);
    bench.localise();
    // Two metres to the left of the robot, which looks along -x.
    bench.call(1, "photo", r#"{"target_m": [1, -2, 0], "zoom": 3}"#);
    let called = bench.called();
    let aim: CameraAim = serde_json::from_str(&called.parameters).expect("an aim");
    assert!((aim.pan_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12 && aim.zoom == 3.0, "{aim:?}");
    bench.robot_says(ActionEvent::Ended { call: id(1), end: photo(b"picture") });
    let (call, report) = bench.report();
    let [file] = &report.files[..] else { panic!("{:?}", report.files) };
    assert_eq!((call, file.media_type.as_str(), file.bytes), (1, "image/jpeg", 7));
    assert_eq!(std::fs::read(bench.store.dir().blob(file.blob)).expect("stored"), b"picture");
    let place = report.place.expect("localised");
    assert_eq!((place.map, place.quality), (Some(MAP), LocalisationQuality::Good));
    assert_eq!(place.map_from_base.position.x, 1.0);
    assert_eq!(report.camera.expect("a camera").target_m, Some(Vec3::new(1.0, -2.0, 0.0)));
    assert!(report.at.utc_ns > 1_700_000_000_000_000_000);
}

#[test]
fn calls_that_cannot_be_done_end_with_a_reason_and_never_twice() {
    let bench = Bench::start(BlobsConfig::default(), false);
    bench.call(1, "photo", r#"{"target_m": [1, -2, 0]}"#);
    assert!(bench.failure().1.contains("not known"), "no place yet");
    bench.localise();
    // Straight behind the robot.
    bench.call(2, "photo", r#"{"target_m": [4, 0.01, 0]}"#);
    assert!(matches!(bench.end(), (2, ActionOutcome::NeedsTurn { turn_rad }) if turn_rad.abs() > 0.1));
    bench.call(2, "photo", r#"{"pan_rad": 3.1}"#);
    assert!(bench.failure().1.contains("turn at least"), "no target tells where to");
    bench.call(3, "photo", r#"{"target_m": "there"}"#);
    assert!(bench.failure().1.contains("schema"));
    bench.call(4, "dance", "{}");
    assert!(bench.failure().1.contains("No action server offers \"dance\""));
    bench.call(5, "message", r#"{"text": " "}"#);
    assert!(bench.failure().1.contains("empty"));
    bench.queue().cancel(id(6));
    assert_eq!(bench.failure().0, 6);
    // The robot ends a call twice, and one that nobody called.
    bench.call(7, "gamma_spectrum", "{}");
    bench.called();
    let failed = ActionEnd::Failed { reason: "It rains.".to_owned() };
    for call in [7, 7, 8] {
        bench.robot_says(ActionEvent::Ended { call: id(call), end: failed.clone() });
    }
    assert_eq!(bench.failure(), (7, "It rains.".to_owned()));
    bench.call(9, "gamma_spectrum", "{}");
    bench.called();
    let report = "no JSON".to_owned();
    bench.robot_says(ActionEvent::Ended { call: id(9), end: ActionEnd::Succeeded { report, files: vec![] } });
    assert!(bench.failure().1.contains("cannot be read"));
    let refusing = Bench::start(BlobsConfig::default(), true);
    refusing.call(1, "gamma_spectrum", "{}");
    assert!(refusing.failure().1.contains("not connected"));
}

#[test]
fn a_result_that_cannot_be_stored_is_a_failure() {
    let blobs = BlobsConfig { max_bytes: 3, min_free_bytes: 0 };
    let bench = Bench::start(blobs, false);
    bench.call(1, "photo", "{}");
    bench.called();
    bench.robot_says(ActionEvent::Ended { call: id(1), end: photo(b"picture") });
    let reason = bench.failure().1;
    assert!(reason.contains("could not be stored") && reason.contains("7 bytes"), "{reason}");
}

#[test]
fn waiting_follows_the_robots_clock_and_can_be_cancelled() {
    let bench = Bench::start(BlobsConfig::default(), false);
    bench.call(1, "wait", r#"{"duration_s": 60}"#);
    bench.call(2, "wait", r#"{"duration_s": 60}"#);
    let feedback = bench.until("progress", || {
        bench.pass_time();
        bench.results.try_recv().ok()
    });
    assert!(
        matches!(feedback, Input::ActionFeedback { progress: Some(share), .. } if share < 1.0),
        "{feedback:?}"
    );
    bench.queue().cancel(id(1));
    assert_eq!(bench.end(), (1, ActionOutcome::Cancelled));
    bench.clock.set(bench.clock.now() + Span::from_millis(60_000));
    let (call, report) = bench.report();
    assert!(call == 2 && report.files.is_empty() && report.at.robot_time >= at(60_000));
    // The next end is that of another call: those two ended once.
    bench.call(3, "message", r#"{"text": "At the pump"}"#);
    assert_eq!(bench.report().0, 3);
    let mail = bench.mailbox.wait(Instant::now() + PATIENCE);
    let notice = |publication: &Publication| matches!(publication, Publication::Notice(notice) if notice.text == "At the pump");
    assert!(mail.ordered.iter().any(notice));
}

#[test]
fn a_cancelled_action_of_the_robot_ends_when_the_robot_says_so() {
    let bench = Bench::start(BlobsConfig::default(), false);
    bench.call(1, "gamma_spectrum", r#"{"duration_s": 60}"#);
    // A call that is repeated is the same one.
    bench.call(1, "gamma_spectrum", r#"{"duration_s": 60}"#);
    bench.called();
    bench.queue().cancel(id(1));
    bench.until("the robot is told", || bench.robot.cancelled.lock().expect("not poisoned").pop());
    assert!(bench.results.is_empty() && bench.robot.calls.lock().expect("not poisoned").is_empty());
    bench.robot_says(ActionEvent::Ended { call: id(1), end: ActionEnd::Cancelled });
    assert_eq!(bench.end(), (1, ActionOutcome::Cancelled));
}

#[test]
fn a_point_cloud_puts_scans_together_in_the_frame_of_the_first() {
    let bench = Bench::start(BlobsConfig::default(), false);
    bench.localise();
    let scan = |millis: i64, x: f64, points: &[[f32; 3]]| {
        let map_from_base = Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::IDENTITY };
        let cloud = Cloud { xyz: points.to_vec(), intensity: vec![9.0; points.len()] };
        let cloud = Arc::new(cloud);
        bench.queue().watch(&Publication::Scan(CorrectedScan { stamp: at(millis), map_from_base, cloud }));
    };
    // Nobody gathers scans yet.
    scan(0, 0.0, &[[5.0; 3]]);
    bench.call(1, "point_cloud", r#"{"duration_s": 1}"#);
    bench.until("it gathers", || (bench.queue().open_captures.load(Ordering::Relaxed) > 0).then_some(()));
    scan(100, 1.0, &[[1.0, 2.0, 3.0], [0.0, 0.0, 1.0]]);
    scan(200, 1.5, &[[1.0, 2.0, 3.0]; 9]);
    bench.until("they are taken", || bench.queue().scans.is_empty().then_some(()));
    bench.clock.set(at(2_000));
    let (_, report) = bench.report();
    let [file] = &report.files[..] else { panic!("{:?}", report.files) };
    let bytes = std::fs::read(bench.store.dir().blob(file.blob)).expect("stored");
    let text = String::from_utf8_lossy(&bytes);
    // As many points of the second scan as the limit leaves.
    assert!(text.contains("POINTS 5") && text.contains("VIEWPOINT 0 0 0.25"), "{text}");
    let last: Vec<f32> = bytes[bytes.len() - 16..]
        .chunks_exact(4)
        .map(|number| f32::from_le_bytes(number.try_into().expect("four bytes")))
        .collect();
    assert_eq!((last, report.at.robot_time), (vec![1.5, 2.0, 3.0, 9.0], at(100)));
    assert_eq!(report.place.expect("localised").map_from_base.position.x, 1.0);
    bench.call(2, "point_cloud", r#"{"duration_s": 1}"#);
    bench.until("it gathers", || (bench.queue().open_captures.load(Ordering::Relaxed) > 0).then_some(()));
    bench.clock.set(at(5_000));
    assert!(bench.failure().1.contains("saw nothing"));
    assert_eq!(bench.queue().open_captures.load(Ordering::Relaxed), 0);
}

#[test]
fn more_calls_than_are_performed_fail_and_none_is_lost() {
    let bench = Bench::start(BlobsConfig::default(), false);
    let mut accepted = 0;
    for number in 0..100 {
        let refused = bench.queue().call(id(number), "wait".to_owned(), r#"{"duration_s": 20}"#.to_owned());
        let Some(Input::ActionDone { outcome: ActionOutcome::Failed { .. }, .. }) = refused else {
            assert_eq!(refused, None);
            accepted += 1;
            continue;
        };
        // It has failed at once. The thread is given time to take the others.
        bench.until("room", || (!bench.queue().requests.is_full()).then_some(()));
    }
    let mut ends = Vec::new();
    bench.until("all end", || {
        // The last of them may have begun a moment ago.
        bench.pass_time();
        ends.extend(bench.results.try_iter().filter_map(|input| match input {
            Input::ActionDone { outcome, .. } => Some(outcome),
            _ => None,
        }));
        (ends.len() == accepted).then_some(())
    });
    let succeeded = ends.iter().filter(|end| matches!(end, ActionOutcome::Succeeded { .. })).count();
    // Those that did not fit had failed before the clock was set.
    assert_eq!(succeeded, ActionConfig::default().max_open);
}

#[test]
fn what_the_map_shows_before_the_target_is_told_and_the_picture_is_taken_all_the_same() {
    let bench = Bench::start(BlobsConfig::default(), false);
    // With a wall along y = -2 m.
    crate::testing::save_corridor(&bench.store, MAP, 0.0);
    bench.localise();
    let sight = |target: &str, call: u128| {
        bench.call(call, "photo", &format!(r#"{{"target_m": {target}}}"#));
        bench.called();
        bench.robot_says(ActionEvent::Ended { call: id(call), end: photo(b"picture") });
        let (_, report) = bench.report();
        report.camera.and_then(|camera| camera.line_of_sight).expect("the map was looked at")
    };
    let free = sight("[1, -1.5, 0.8]", 1);
    assert!(free.obstacle_at_m.is_none() && free.distance_m > 1.0, "{free:?}");
    let on_the_wall = sight("[1, -1.97, 0.8]", 2);
    assert_eq!(on_the_wall.obstacle_at_m, None);
    let behind = sight("[1, -4, 1.9]", 3);
    assert!(behind.obstacle_at_m.is_some_and(|at_m| (1.5..2.3).contains(&at_m)), "{behind:?}");
    let mail = bench.mailbox.wait(Instant::now() + PATIENCE);
    let is_reported = |publication: &&Publication| matches!(publication, Publication::Notice(notice) if notice.text.contains("map shows something"));
    assert_eq!(mail.ordered.iter().filter(is_reported).count(), 1);
}

#[test]
fn the_longest_times_are_those_of_the_catalogue() {
    let maximum_s = |action: &str| {
        let known = site_model::describe_action(action).expect("in the catalogue");
        let schema: serde_json::Value = serde_json::from_str(&known.parameter_schema(&HEAD)).expect("JSON");
        schema["properties"]["duration_s"]["maximum"].as_f64().expect("a number")
    };
    let config = ActionConfig::default();
    assert_eq!([config.max_wait_s, config.max_capture_s], ["wait", "point_cloud"].map(maximum_s));
}
