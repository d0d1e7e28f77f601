//! Pictures of the simulated robot, called as the control loop calls them, through the robot's socket, to the stored file.

use super::*;
use crate::clock::RobotClock;
use crate::gauges::{GaugeQueue, GaugeWorker};
use crate::mailbox::Mailbox;
use links::{SimulatedRobot, SimulatedRobotConfig, SocketLink, SocketLinkConfig};
use messages::Estimate;
use ports::{GaugeReader, ReadGauge, RobotLink};
use sim::{Face, SimConfig, Simulator, SiteName, Start};
use site_model::{ActionReport, DialDirection, GaugeDial, GaugeReport, ReportFile};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::Instant;
use store::{BlobsConfig, Store};
use uuid::Uuid;
use vocab::{BlobHash, Pose, Vec3};
use watchdog::Heartbeat;

const PATIENCE: Duration = Duration::from_secs(60);
const CALL: ActionCallId = ActionCallId(Uuid::from_u128(1));

/// A simulated robot that stands in front of a warm machine of b1, and the thread of actions.
struct Bench {
    queue: Option<ActionQueue>,
    results: Receiver<Input>,
    robot: Option<SimulatedRobot>,
    link: SocketLink,
    store: Arc<Store>,
    /// Actions and gauges.
    threads: Vec<JoinHandle<()>>,
    stop_gauges: Option<Sender<()>>,
    /// The middle of the machine's plate, site frame, metres.
    target: Vec3,
    _dir: tempfile::TempDir,
}

/// Reads 4.2 bar in each picture.
struct FakeReader;

impl GaugeReader for FakeReader {
    fn read(
        &self,
        picture: &Path,
        described_in: &Path,
        dial: &GaugeDial,
        _is_cancelled: &mut dyn FnMut() -> bool,
    ) -> Result<ReadGauge, String> {
        if !described_in.exists() {
            return Err("The picture is gone.".to_owned());
        }
        assert!(picture.exists());
        let reading = site_model::Reading {
            name: site_model::GAUGE_READING.to_owned(),
            value: 4.2,
            standard_deviation: None,
            unit: dial.unit.clone(),
        };
        Ok(ReadGauge { reading: Some(reading), report: GaugeReport::default() })
    }
}

impl Bench {
    fn start() -> Self {
        let quiet = SimConfig { lidar_columns: 10, people: 0, ..SimConfig::new(SiteName::B1, 1) };
        let mut simulator = Simulator::new(quiet.clone());
        let scene = simulator.camera_scene();
        let warm = scene.fixtures().iter().find(|fixture| matches!(fixture.face, Face::Warm { .. }));
        let plate = warm.expect("b1 has warm machines").site_from_plate;
        let outward = plate.rotation * geometry::Vector3::z();
        let feet = plate.translation.vector + outward * 1.6;
        let position = Vec3::new(feet.x, feet.y, feet.z - 1.0);
        // It looks along the wall, and the estimate is wrong by a degree and three centimetres.
        let start = Start { position, yaw: (-outward.y).atan2(-outward.x) + 1.2 };
        let sim = SimConfig { start: Some(start), ..quiet };
        let mut settled = Simulator::new(sim.clone());
        settled.advance(settled.now() + Span::from_millis(500), &mut Vec::new());
        let map_from_base = nudge(settled.truth().site_from_base);
        let dir = tempfile::tempdir().expect("temporary directory");
        let socket: PathBuf = dir.path().join("robot.sock");
        let robot =
            SimulatedRobot::start(SimulatedRobotConfig::new(sim, 1.0, socket.clone())).expect("starts");
        let link = SocketLink::connect(&socket, SocketLinkConfig::default()).expect("connects");
        let store = Arc::new(Store::open(dir.path().join("data")).expect("opens"));
        // The clock of the bench stands still.
        let config = ActionConfig { feedback_period: Span::ZERO, ..ActionConfig::default() };
        let (queue, inbox) = ActionQueue::new(&config);
        let (sender, results) = crossbeam_channel::bounded(config.max_results);
        let clock = Arc::<RobotClock>::default();
        clock.set(settled.now());
        let (gauges, pictures, answers) = GaugeQueue::new();
        let (stop_gauges, stop) = crossbeam_channel::bounded(0);
        let reader = Box::new(FakeReader);
        let gauge_worker = GaugeWorker { reader, store: Arc::clone(&store), pictures, answers, stop };
        let gauge_thread = std::thread::spawn(move || gauge_worker.run(&Heartbeat::unwatched()));
        let worker = ActionWorker {
            config,
            blobs: BlobsConfig::default(),
            store: Arc::clone(&store),
            robot: link.action_server(),
            camera_head: link.boot().profile.camera_head,
            base_from_lidar_m: Vec3::default(),
            inbox,
            results: sender,
            mailbox: Arc::<Mailbox>::default(),
            state_publisher: Arc::default(),
            clock,
            open: OpenActions::default(),
            sight: SightChecker::new(Arc::clone(&store)),
            gauges: Some(gauges),
        };
        let thread = std::thread::spawn(move || worker.run(&Heartbeat::unwatched()));
        let estimate = Estimate { stamp: settled.now(), map_from_base, ..Estimate::default() };
        queue.watch(&Publication::Estimate(estimate));
        let target = geometry::vec_to_plain(&plate.translation.vector);
        let (queue, robot) = (Some(queue), Some(robot));
        let (threads, stop_gauges) = (vec![thread, gauge_thread], Some(stop_gauges));
        Self { queue, results, robot, link, store, threads, stop_gauges, target, _dir: dir }
    }

    fn call(&self, action: &str, parameters: &str) {
        let queue = self.queue.as_ref().expect("not closed");
        assert_eq!(queue.call(CALL, action.to_owned(), parameters.to_owned()), None);
    }

    /// What is said of the call, as soon as `wanted` accepts it. The robot's measurements are read meanwhile, so that it goes on.
    fn until<T>(&self, wanted: impl Fn(Input) -> Option<T>) -> T {
        let (arrivals, begun) = (self.link.arrivals(), Instant::now());
        loop {
            assert!(begun.elapsed() < PATIENCE, "nothing of the kind is said of the action");
            crossbeam_channel::select! {
                recv(arrivals) -> _ => {}
                recv(self.results) -> result => {
                    if let Some(found) = result.ok().and_then(&wanted) {
                        return found;
                    }
                }
                default(Duration::from_millis(50)) => {}
            }
        }
    }

    /// The end of the call.
    fn end(&self) -> ActionOutcome {
        self.until(|input| match input {
            Input::ActionDone { call: CALL, outcome } => Some(outcome),
            _ => None,
        })
    }

    fn capture(&self, action: &str, zoom: &str) -> (ActionReport, Vec<(ReportFile, Vec<u8>)>) {
        let Vec3 { x, y, z } = self.target;
        self.call(action, &format!(r#"{{"target_m": [{x}, {y}, {z}]{zoom}}}"#));
        let ActionOutcome::Succeeded { result } = self.end() else { panic!("no picture") };
        let report: ActionReport = serde_json::from_str(&result).expect("a report");
        let read = |file: &ReportFile| {
            let bytes = std::fs::read(self.store.dir().blob(file.blob)).expect("stored");
            assert_eq!(bytes.len() as u64, file.bytes);
            (file.clone(), bytes)
        };
        let files = report.files.iter().map(read).collect();
        (report, files)
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        drop(self.queue.take());
        drop(self.stop_gauges.take());
        for thread in self.threads.drain(..) {
            thread.join().expect("it ends without a panic");
        }
    }
}

/// An estimate that is wrong by a degree and three centimetres.
fn nudge(truth: Pose) -> Pose {
    let truth = geometry::isometry_from_pose(&truth).expect("a pose");
    let turn = geometry::Rotation::from_euler_angles(0.0, 0.0, 1_f64.to_radians());
    let error = geometry::Isometry::from_parts(nalgebra::Translation3::new(0.02, -0.02, 0.0), turn);
    geometry::pose_from_isometry(&(truth * error))
}

#[test]
fn a_thermal_picture_that_is_aimed_by_the_estimate_has_the_warm_machine_in_its_middle() {
    let bench = Bench::start();
    let (report, files) = bench.capture("thermal_photo", "");
    assert!(report.camera.expect("a camera").aim.pan_rad < -0.8, "the body looks along the wall");
    let (file, bytes) = &files[1];
    assert_eq!(file.media_type, "image/png");
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("small")];
    let info = reader.next_frame(&mut pixels).expect("read");
    let kelvin: Vec<f64> = pixels
        .chunks_exact(2)
        .map(|pixel| f64::from(u16::from_be_bytes([pixel[0], pixel[1]])) / 100.0)
        .collect();
    let limit = kelvin.iter().copied().fold(0.0, f64::max) - 4.0;
    let warm: Vec<usize> = (0..kelvin.len()).filter(|index| kelvin[*index] > limit).collect();
    let mean = |axis: fn(usize, usize) -> usize| {
        warm.iter().map(|index| axis(*index, info.width as usize) as f64).sum::<f64>() / warm.len() as f64
    };
    let (x, y) = (mean(|index, width| index % width), mean(|index, width| index / width));
    // Within five percent of the picture, as inspection asks for.
    let limit_px = 0.05 * f64::from(info.width);
    assert!((x - 160.0).abs() < limit_px && (y - 120.0).abs() < limit_px, "{x:.1} {y:.1}");
    assert!(report.readings[2].value > 40.0, "{:?}", report.readings);
}

#[test]
fn a_photo_of_b1_is_stored_and_says_where_its_target_is_in_it() {
    let bench = Bench::start();
    let (report, files) = bench.capture("photo", r#", "zoom": 2"#);
    let (file, bytes) = &files[0];
    assert_eq!((file.name.as_str(), &bytes[..3]), ("photo.jpg", &[0xff, 0xd8, 0xff][..]));
    assert!((10_000..400_000).contains(&bytes.len()), "{} bytes", bytes.len());
    // By its own report the target is exactly in the middle.
    let (camera, place) = (report.camera.expect("a camera"), report.place.expect("an estimate"));
    let [map_from_base, base_from_camera] = [place.map_from_base, camera.base_from_camera]
        .map(|pose| geometry::isometry_from_pose(&pose).expect("a pose"));
    let target = geometry::vec_from_plain(camera.target_m.expect("a target"));
    let seen = (map_from_base * base_from_camera).inverse_transform_point(&target.into());
    assert!(seen.x.abs() / seen.z < 1e-9 && seen.y.abs() / seen.z < 1e-9 && seen.z > 0.5, "{seen}");
    assert_eq!((camera.aim.zoom, camera.size_px, camera.centre_px), (2.0, [640, 480], [320.0, 240.0]));
}

#[test]
fn the_gauge_of_a_photo_is_read_before_its_action_ends() {
    let bench = Bench::start();
    let (report, files) = bench.capture("photo", "");
    assert_eq!((report.gauge, report.readings.len()), (None, 0));
    let dial = |picture: BlobHash| {
        let dial = GaugeDial {
            picture,
            size_px: [640, 480],
            centre_px: [320.0, 240.0],
            start_px: [270.0, 290.0],
            middle_px: None,
            end_px: Some([370.0, 290.0]),
            direction: DialDirection::Clockwise,
            range: [0.0, 6.0],
            unit: "bar".to_owned(),
        };
        format!(r#", "gauge": {}"#, serde_json::to_string(&dial.parameter()).expect("plain data"))
    };
    let (report, _) = bench.capture("photo", &dial(files[0].0.blob));
    let read = report.readings.first().expect("read");
    assert_eq!((read.name.as_str(), read.value, read.unit.as_str()), ("gauge", 4.2, "bar"));
    assert_eq!(report.gauge, Some(GaugeReport::default()));
    // The picture in which it was described is gone: the photo counts all the same.
    let (report, files) = bench.capture("photo", &dial(BlobHash([1; 32])));
    assert_eq!(report.gauge.and_then(|gauge| gauge.problem).as_deref(), Some("The picture is gone."));
    assert_eq!((report.readings.len(), files.len()), (0, 1));
}

#[test]
fn an_action_of_a_robot_that_dies_fails_once() {
    let mut bench = Bench::start();
    bench.call("gamma_spectrum", r#"{"duration_s": 3600}"#);
    // The robot performs it: it has said how far it is.
    bench.until(|input| matches!(input, Input::ActionFeedback { call: CALL, .. }).then_some(()));
    drop(bench.robot.take());
    let ActionOutcome::Failed { reason } = bench.end() else { panic!("it cannot have been done") };
    assert!(reason.contains("nobody knows"), "{reason}");
    // The next call is refused at once, with what to do.
    bench.call("gamma_spectrum", "{}");
    let ActionOutcome::Failed { reason } = bench.end() else { panic!("it cannot have been done") };
    assert!(reason.contains("not connected"), "{reason}");
}
