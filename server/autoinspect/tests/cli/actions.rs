//! Actions of missions through the whole program: a picture is stored and fetched over HTTP, and a robot that dies during an action fails it.

use crate::core_process::{CoreProcess, RobotProcess, finish, map_a_little};
use crate::fake_gateway::{CLIENT, FakeGateway, until};
use crate::program::{program, text};
use api::{
    Command, CommandOutcome, CoreMessage, Event, GatewayMessage, Localisation, Mapping, Query, QueryReply,
    RunFilter, StoredResult, StoredStep,
};
use site_model::{
    ActionReport, ActionRequest, Change, DialDirection, Edit, EditId, FailurePolicy, FailureStep,
    GAUGE_READING, GaugeDial, InspectionPoint, InspectionPointId, Mission, MissionCommandKind, MissionEnd,
    MissionId, Node, NodeId, NodeKind, Object, Parameter, Parameters, PictureComparison,
    PictureComparisonOutcome, PoseTolerance, RunId, SiteSettings, StartMode, Task, TaskId, TaskOrder,
    TaskPlace,
};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::{Child, Stdio};
use uuid::Uuid;
use vocab::{BlobHash, MapId, Pose, Vec3};

const MAP: u128 = 9;
const NODE: NodeId = NodeId(Uuid::from_u128(20));

/// A core whose robot is localised in the map that it has just made, with a node where it stands.
struct Bench {
    core: CoreProcess,
    robot: Option<RobotProcess>,
    gateway: FakeGateway,
    map_from_base: Pose,
    edits: u128,
    queries: u64,
    dir: tempfile::TempDir,
}

impl Bench {
    fn start() -> Self {
        let dir = tempfile::tempdir().expect("temporary directory");
        let fast = ["--lidar-columns", "200", "--people", "0", "--speed", "4"];
        let robot = RobotProcess::start(dir.path(), &fast);
        let core = CoreProcess::start_with(dir.path(), &robot);
        let mut gateway = FakeGateway::connect(&core.socket);
        map_a_little(&mut gateway, 1);
        gateway.command(finish(MAP));
        gateway.event(|event| matches!(event, Event::Maps(maps) if !maps.is_empty()).then_some(()));
        gateway.event(|event| matches!(event, Event::Mapping(Mapping::Idle)).then_some(()));
        gateway.command(Command::Localise { map: MapId(Uuid::from_u128(MAP)), at: None });
        gateway.event(|event| {
            matches!(event, Event::Localisation(Localisation::Localised { .. })).then_some(())
        });
        // It has come to rest when two estimates agree.
        let mut last: Option<Pose> = None;
        let map_from_base = gateway.event(|event| {
            let Event::Estimate(estimate) = event else { return None };
            let now = estimate.map_from_base;
            let before = last.replace(now)?;
            let moved = [now.position.x - before.position.x, now.position.y - before.position.y];
            (moved[0].hypot(moved[1]) < 1e-3).then_some(now)
        });
        let robot = Some(robot);
        let mut bench = Self { core, robot, gateway, map_from_base, edits: 0, queries: 0, dir };
        bench.put(Object::Settings(SiteSettings {
            name: "B1".to_owned(),
            time_zone: "Europe/London".to_owned(),
            map: Some(MapId(Uuid::from_u128(MAP))),
        }));
        bench.put(Object::Node(Node {
            id: NODE,
            name: "Here".to_owned(),
            kind: NodeKind::Inspection,
            map_from_node: map_from_base,
            anchor: None,
            // The robot stays where it is.
            tolerance: PoseTolerance { along_m: 0.5, across_m: 0.5, yaw_rad: 0.5 },
            influence_area_m: Vec::new(),
            floor: 0,
            tags: [].into(),
            properties: [].into(),
        }));
        bench
    }

    fn put(&mut self, object: Object) {
        self.edits += 1;
        let id = EditId(Uuid::from_u128(self.edits));
        let edit = Edit { id, changes: vec![Change::Put { base: None, object }] };
        self.gateway.send(&GatewayMessage::Edit { by: CLIENT.into(), edit });
        self.gateway.event(|event| match event {
            Event::EditDone(done) if done.id == id => {
                assert!(matches!(done.outcome, api::EditOutcome::Applied { .. }), "{:?}", done.outcome);
                Some(())
            }
            _ => None,
        });
    }

    /// An action at the node, as a mission of this number.
    fn put_mission(&mut self, number: u128, action: &str, parameters: Parameters) {
        self.put_mission_with_gauge(number, action, parameters, None);
    }

    /// The same, with a gauge in its pictures.
    fn put_mission_with_gauge(
        &mut self,
        number: u128,
        action: &str,
        parameters: Parameters,
        gauge: Option<GaugeDial>,
    ) {
        let Vec3 { x, y, z } = self.map_from_base.position;
        let id = InspectionPointId(Uuid::from_u128(number + 100));
        self.put(Object::InspectionPoint(InspectionPoint {
            id,
            name: format!("Point {number}"),
            asset: None,
            node: NODE,
            target_m: self.ahead(2.5, Vec3::new(x, y, z + 0.4)),
            request: ActionRequest { action: action.to_owned(), parameters },
            limits: None,
            gauge,
        }));
        let task = Task {
            id: TaskId(Uuid::from_u128(number + 200)),
            place: TaskPlace::InspectionPoint(id),
            on_unreachable: Default::default(),
            // A second attempt would wait for a robot that sees something.
            on_action_failure: FailurePolicy { retries: 0, then: FailureStep::Skip },
        };
        self.put(Object::Mission(Mission {
            id: MissionId(Uuid::from_u128(number)),
            name: format!("Mission {number}"),
            tasks: vec![task],
            order: TaskOrder::AsListed,
            order_constraints: Vec::new(),
            end: MissionEnd::Stay,
        }));
    }

    /// A point before the robot.
    fn ahead(&self, distance_m: f64, from: Vec3) -> Vec3 {
        let pose = geometry::isometry_from_pose(&self.map_from_base).expect("a pose");
        let ahead = pose.rotation * geometry::Vector3::x() * distance_m;
        Vec3::new(from.x + ahead.x, from.y + ahead.y, from.z)
    }

    fn begin(&mut self, number: u128) -> RunId {
        self.begin_run(number, number)
    }

    /// A run of this number, of a mission of that number.
    fn begin_run(&mut self, number: u128, mission: u128) -> RunId {
        let run = RunId(Uuid::from_u128(number + 300));
        let mission = MissionId(Uuid::from_u128(mission));
        let start = MissionCommandKind::Start { run, mission, mode: StartMode::Now };
        // The stack may learn of an edit a moment after whoever made it.
        until("the run begins", || {
            let outcome = self.gateway.outcome(Command::Mission(start));
            (outcome == CommandOutcome::Accepted).then_some(())
        });
        run
    }

    /// Its outcome, once the ledger has it.
    fn until_ended(&mut self, run: RunId) -> String {
        until("the run ends", || {
            match self.ask(Query::Runs { filter: RunFilter::default(), before: None, limit: 10 }) {
                QueryReply::Runs(runs) => {
                    runs.into_iter().find(|stored| stored.run == run && stored.is_ended).map(|run| run.state)
                }
                other => panic!("{other:?}"),
            }
        })
    }

    /// Waits for the end of the run. Its steps say why it ended otherwise.
    #[track_caller]
    fn expect_end(&mut self, run: RunId, outcome: &str) {
        let ended = self.until_ended(run);
        let steps = self.steps(run);
        assert_eq!(ended, outcome, "{steps:#?}");
    }

    fn ask(&mut self, query: Query) -> QueryReply {
        self.queries += 1;
        let asked = self.queries;
        self.gateway.send(&GatewayMessage::Query { number: asked, by: CLIENT.into(), query });
        loop {
            if let CoreMessage::Reply { number, result } = self.gateway.message()
                && number == asked
            {
                return result.expect("answered");
            }
        }
    }

    fn results(&mut self, run: RunId) -> Vec<StoredResult> {
        match self.ask(Query::Results { run, after: None, limit: 10 }) {
            QueryReply::Results(results) => results,
            other => panic!("{other:?}"),
        }
    }

    fn steps(&mut self, run: RunId) -> Vec<StoredStep> {
        match self.ask(Query::Steps { run, after: None, limit: 10 }) {
            QueryReply::Steps(steps) => steps,
            other => panic!("{other:?}"),
        }
    }
}

/// A gateway of a data directory, without a core; killed when dropped.
struct Gateway(Child, SocketAddr);

impl Gateway {
    fn start(data: &Path) -> Self {
        let mut child = program()
            .args(["gateway", "--demo", "--data", text(data), "--socket", text(&data.join("none.sock"))])
            .args(["--static", text(data), "--listen", "127.0.0.1:0"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("starts");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("piped")).read_line(&mut line).expect("a line");
        let address = line.split_whitespace().find_map(|word| word.parse().ok());
        Self(child, address.unwrap_or_else(|| panic!("no address in {line:?}")))
    }

    /// Head and body of the answer.
    fn get(&self, path: &str) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(self.1).expect("a connection");
        let host = self.1;
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").expect("written");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("read");
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
        (String::from_utf8_lossy(&answer[..end]).into_owned(), answer[end + 4..].to_vec())
    }
}

impl Drop for Gateway {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Files that actions have gathered. Beside them are the clouds of what has changed (PLY), if the run was compared already and something was found.
fn files_of_actions(data: &Path) -> usize {
    let folders = fs::read_dir(data.join("blobs")).expect("readable");
    let files = folders.flat_map(|folder| fs::read_dir(folder.expect("an entry").path()).expect("readable"));
    let bytes = files.map(|file| fs::read(file.expect("an entry").path()).expect("readable"));
    bytes.filter(|bytes| !bytes.starts_with(b"ply")).count()
}

#[test]
fn a_photo_of_a_mission_in_b1_is_stored_with_its_place_and_fetched_over_http() {
    let mut bench = Bench::start();
    bench.put_mission(1, "photo", [("zoom".to_owned(), Parameter::Integer(2))].into());
    let run = bench.begin(1);
    // Clients are told of the result as soon as it is in the ledger.
    let stored = loop {
        if let CoreMessage::Event { to: None, event: Event::ResultStored(stored) } = bench.gateway.message() {
            break stored;
        }
    };
    let results = bench.results(run);
    assert_eq!(results, [stored]);
    bench.expect_end(run, "succeeded");
    let [result] = &results[..] else { panic!("{results:?}") };
    assert_eq!(result.kind, "photo");
    let blob = BlobHash(result.blob.expect("a picture"));
    let body: serde_json::Value = serde_json::from_str(&result.body).expect("JSON");
    let report: ActionReport = serde_json::from_value(body["value"].clone()).expect("a report");
    assert_eq!((report.files[0].blob, report.files[0].media_type.as_str()), (blob, "image/jpeg"));
    // Straight ahead and a little up: by the estimate at the time of the picture, which is the node's but for millimetres.
    let camera = report.camera.expect("a camera");
    assert!(camera.aim.pan_rad.abs() < 0.1 && camera.aim.zoom == 2.0, "{camera:?}");
    let place = report.place.expect("localised");
    assert_eq!(place.map, Some(MapId(Uuid::from_u128(MAP))));
    let [x, y] = [
        place.map_from_base.position.x - bench.map_from_base.position.x,
        place.map_from_base.position.y - bench.map_from_base.position.y,
    ];
    assert!(x.hypot(y) < 0.1, "{x} {y}");
    let data = bench.dir.path().to_owned();
    bench.core.stop();

    // What is stored can be fetched while no core runs.
    let gateway = Gateway::start(&data);
    let (head, list) = gateway.get(&api::paths::RUN_CLOUDS_PATH.replace("{run}", &run.to_string()));
    let list: serde_json::Value = serde_json::from_slice(&list).expect("JSON");
    let first = &list["items"][0];
    assert!(head.starts_with("HTTP/1.1 200") && first["points"].as_u64() > Some(1_000), "{list}");
    let hash = first["cloud"].as_str().expect("a hash");
    let path = api::paths::RUN_CLOUD_PATH.replace("{run}", &run.to_string()).replace("{hash}", hash);
    let (head, cloud) = gateway.get(&path);
    assert!(head.starts_with("HTTP/1.1 200") && cloud.starts_with(b"AIrc"), "{head}");
    let (head, _) = gateway.get(&path.replace(hash, &"0".repeat(64)));
    assert!(head.starts_with("HTTP/1.1 404"), "{head}");
    let (head, picture) = gateway.get(&api::paths::BLOB_PATH.replace("{hash}", &blob.to_string()));
    assert!(head.starts_with("HTTP/1.1 200") && head.contains("image/jpeg"), "{head}");
    assert_eq!(*blake3::hash(&picture).as_bytes(), blob.0);
    assert_eq!(&picture[..3], &[0xff, 0xd8, 0xff]);
    assert_eq!(files_of_actions(&data), 1, "one picture, one file");
}

#[test]
fn a_gauge_that_was_described_in_one_picture_is_looked_for_in_the_next_one() {
    let mut bench = Bench::start();
    let zoom: Parameters = [("zoom".to_owned(), Parameter::Integer(2))].into();
    let report_of = |bench: &mut Bench, number: u128| {
        let run = bench.begin(number);
        bench.expect_end(run, "succeeded");
        let results = bench.results(run);
        let body: serde_json::Value = serde_json::from_str(&results[0].body).expect("JSON");
        serde_json::from_value::<ActionReport>(body["value"].clone()).expect("a report")
    };
    bench.put_mission(1, "photo", zoom.clone());
    let first = report_of(&mut bench, 1);
    assert_eq!(first.gauge, None);
    // There is no gauge there.
    let dial = GaugeDial {
        picture: first.files[0].blob,
        size_px: [640, 480],
        centre_px: [320.0, 240.0],
        start_px: [280.0, 280.0],
        middle_px: None,
        end_px: Some([360.0, 280.0]),
        direction: DialDirection::Clockwise,
        range: [0.0, 6.0],
        unit: "bar".to_owned(),
    };
    bench.put_mission_with_gauge(2, "photo", zoom, Some(dial));
    let second = report_of(&mut bench, 2);
    let gauge = second.gauge.expect("looked for");
    assert!(gauge.alignment_residual_px.is_some_and(|residual_px| residual_px < 3.0), "{gauge:?}");
    assert!(!second.files.is_empty());
    // Whatever stands there may look like a needle. A value then, and a sentence otherwise.
    match (gauge.problem, second.readings.first()) {
        (Some(problem), None) => {
            assert!(problem.starts_with("The gauge was not read: ") && problem.ends_with('.'), "{problem}");
        }
        (None, Some(reading)) => {
            assert_eq!((reading.name.as_str(), reading.unit.as_str()), (GAUGE_READING, "bar"));
            assert!((0.0..=6.0).contains(&reading.value) && gauge.needle_px.is_some(), "{reading:?}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn each_photo_of_a_point_is_compared_with_the_one_before_it() {
    let mut bench = Bench::start();
    bench.put_mission(1, "photo", [("zoom".to_owned(), Parameter::Integer(2))].into());
    let mut photos = Vec::new();
    for number in 1..=3 {
        let run = bench.begin_run(number, 1);
        bench.expect_end(run, "succeeded");
        photos.push((run, bench.results(run)[0].number));
    }
    let aligned = |comparison: &str| {
        let comparison: PictureComparison = serde_json::from_str(comparison).expect("JSON");
        match comparison.outcome {
            PictureComparisonOutcome::Aligned(aligned) => (comparison.before, aligned),
            PictureComparisonOutcome::NotAligned(sentence) => panic!("{sentence}"),
        }
    };
    for pair in photos.windows(2) {
        let ((_, before), (run, _)) = (pair[0], pair[1]);
        let comparison = until("the photo is compared", || bench.results(run)[0].comparison.clone());
        let (compared_with, aligned) = aligned(&comparison);
        assert_eq!(compared_with, before);
        // The robot has stood still.
        assert!(aligned.residual_px < 1.5 && aligned.changes.is_empty(), "{aligned:?}");
        let [x, y] = aligned.map([320.0, 240.0]).expect("ahead");
        assert!((x - 320.0).hypot(y - 240.0) < 3.0, "{aligned:?}");
    }
    assert_eq!(bench.results(photos[0].0)[0].comparison, None, "nothing is before the first one");
    let (before, after) = (photos[0].1, photos[2].1);
    match bench.ask(Query::PictureComparison { before, after }) {
        QueryReply::PictureComparison(Some(comparison)) => assert_eq!(aligned(&comparison).0, before),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_robot_that_is_killed_during_an_action_fails_the_task_and_the_run_ends() {
    let mut bench = Bench::start();
    let long = [("duration_s".to_owned(), Parameter::Integer(3_000))];
    bench.put_mission(1, "gamma_spectrum", long.into());
    let run = bench.begin(1);
    until("the action is called", || {
        let steps = bench.steps(run);
        steps.iter().any(|step| step.state == "running").then_some(())
    });
    drop(bench.robot.take());
    bench.expect_end(run, "failed");
    let steps = bench.steps(run);
    // The call may have been on its way when the robot died.
    let reasons = ["nobody knows whether it was done", "The robot is not connected"];
    let is_reported = steps.iter().any(|step| reasons.iter().any(|reason| step.body.contains(reason)));
    assert!(is_reported, "{steps:?}");
    assert!(bench.results(run).is_empty());
    // Nothing of it is left on the disk.
    assert_eq!(files_of_actions(bench.dir.path()), 0);
}

#[test]
fn a_task_that_is_skipped_cancels_its_action_in_the_robot() {
    let mut bench = Bench::start();
    let long = [("duration_s".to_owned(), Parameter::Integer(3_000))];
    bench.put_mission(1, "gamma_spectrum", long.into());
    let run = bench.begin(1);
    until("the action is called", || {
        let steps = bench.steps(run);
        steps.iter().any(|step| step.state == "running").then_some(())
    });
    let skip = MissionCommandKind::SkipTask(run, TaskId(Uuid::from_u128(201)));
    let outcome = bench.gateway.outcome(Command::Mission(skip));
    assert_eq!(outcome, CommandOutcome::Accepted, "{:#?}", bench.steps(run));
    // 3000 s of the robot are 750 s here: it ends long before that.
    bench.expect_end(run, "failed");
    until("the step is stored", || bench.steps(run).iter().any(|step| step.state == "skipped").then_some(()));
    // The robot is free for the next one.
    bench.put_mission(2, "temperature_humidity", Parameters::new());
    let run = bench.begin(2);
    bench.expect_end(run, "succeeded");
    let results = bench.results(run);
    assert!(results[0].body.contains("relative_humidity"), "{results:?}");
}
