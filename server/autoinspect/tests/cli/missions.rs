//! Missions through the core's process: they go on when it is killed, and each task has one result of record.

use crate::core_process::{CoreProcess, RobotProcess, finish, map_a_little};
use crate::fake_gateway::{CommandSender, FakeGateway};
use api::{Command, EditOutcome, Event, Localisation, Mapping};
use site_model::{
    ActionRequest, Change, Edge, EdgeId, Edit, EditId, FailurePolicy, Mission, MissionCommandKind,
    MissionEnd, MissionId, MissionStatus, Node, NodeId, NodeKind, Object, Parameter, PoseTolerance, RunId,
    RunState, SiteSettings, StartMode, Task, TaskId, TaskOrder, TaskPlace,
};
use store::Store;
use uuid::Uuid;
use vocab::{MapId, Pose};

const MAP: u128 = 7;
pub const MISSION: MissionId = MissionId(Uuid::from_u128(20));
pub const RUN: RunId = RunId(Uuid::from_u128(21));

fn node_id(number: u128) -> NodeId {
    NodeId(Uuid::from_u128(100 + number))
}

pub fn task_id(number: u128) -> TaskId {
    TaskId(Uuid::from_u128(200 + number))
}

/// An action that is performed by the core.
pub fn request(action: &str, parameter: &str, value: Parameter) -> ActionRequest {
    ActionRequest { action: action.to_owned(), parameters: [(parameter.to_owned(), value)].into() }
}

/// The two ends of the walk that made the map, and a mission with these actions, at one end and the other in turn.
pub fn site(ends: [Pose; 2], requests: Vec<ActionRequest>) -> Vec<Object> {
    let map = Some(MapId(Uuid::from_u128(MAP)));
    let settings = SiteSettings { name: "Hall".to_owned(), time_zone: "Europe/London".to_owned(), map };
    let mut objects = vec![Object::Settings(settings)];
    for (number, map_from_node) in (0..).zip(ends) {
        objects.push(Object::Node(Node {
            id: node_id(number),
            name: format!("N{number}"),
            kind: NodeKind::Inspection,
            map_from_node,
            anchor: None,
            tolerance: PoseTolerance::default(),
            influence_area_m: Vec::new(),
            floor: 0,
            tags: Default::default(),
            properties: Default::default(),
        }));
    }
    for (id, from, to) in [(300, 0, 1), (301, 1, 0)] {
        let id = EdgeId(Uuid::from_u128(id));
        objects.push(Object::Edge(Edge::walk(id, node_id(from), node_id(to))));
    }
    let task = |(number, request): (u128, ActionRequest)| Task {
        id: task_id(number),
        place: TaskPlace::Node { node: node_id(number % 2), request: Some(request) },
        on_unreachable: FailurePolicy::default(),
        on_action_failure: FailurePolicy::default(),
    };
    objects.push(Object::Mission(Mission {
        id: MISSION,
        name: "Round".to_owned(),
        tasks: (0..).zip(requests).map(task).collect(),
        order: TaskOrder::AsListed,
        order_constraints: Vec::new(),
        end: MissionEnd::Stay,
    }));
    objects
}

/// Maps a little, and localises in that map. Returns the poses at both ends of the walk.
pub fn localised(gateway: &mut impl CommandSender) -> [Pose; 2] {
    map_a_little(gateway, 1);
    gateway.command(finish(MAP));
    gateway.event(|event| matches!(event, Event::Mapping(Mapping::Idle)).then_some(()));
    gateway.command(Command::Localise { map: MapId(Uuid::from_u128(MAP)), at: None });
    let known = |event: &Event| {
        matches!(event, Event::Localisation(Localisation::Localised { degradation: None, .. })).then_some(())
    };
    gateway.event(known);
    let end = gateway.event(|event| match event {
        Event::Estimate(estimate) => Some(estimate.map_from_base),
        _ => None,
    });
    // Both on the ground, upright.
    let flat = |pose: Pose| {
        let (w, z) = (pose.orientation.w, pose.orientation.z);
        let length = w.hypot(z);
        let orientation = vocab::Quat { w: w / length, x: 0.0, y: 0.0, z: z / length };
        Pose { orientation, ..pose }
    };
    [Pose::IDENTITY, flat(end)]
}

/// Puts objects into the site.
pub fn put(gateway: &mut impl CommandSender, objects: Vec<Object>) {
    let changes = objects.into_iter().map(|object| Change::Put { base: None, object }).collect();
    let edit = Edit { id: EditId(Uuid::from_u128(30)), changes };
    let id = edit.id;
    gateway.edit(edit);
    let done = gateway.event(|event| match event {
        Event::EditDone(done) if done.id == id => Some(done.outcome.clone()),
        _ => None,
    });
    assert!(matches!(done, EditOutcome::Applied { .. }), "{done:?}");
}

pub fn missions(event: &Event) -> Option<MissionStatus> {
    match event {
        Event::Missions(status) => Some(status.clone()),
        _ => None,
    }
}

/// Changes of the run's state after which the core is killed: before it sets out, on the way, at an action, between tasks.
const KILLS: usize = 5;

#[test]
fn a_mission_goes_on_when_its_core_is_killed_and_each_task_has_one_result() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let robot = RobotProcess::start(dir.path(), &["--lidar-columns", "200", "--people", "0", "--speed", "4"]);
    let mut core = CoreProcess::start_with(dir.path(), &robot);
    let mut gateway = FakeGateway::connect(&core.socket);
    let ends = localised(&mut gateway);
    let wait = || request("wait", "duration_s", Parameter::Number(1.0));
    put(&mut gateway, site(ends, vec![wait(), wait()]));
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Queue };
    gateway.command(Command::Mission(start));

    let mut kills = 0;
    let ended = loop {
        let status = gateway.event(missions);
        if let Some(ended) = status.ended.iter().find(|ended| ended.run == RUN) {
            break *ended;
        }
        let is_going = status.runs.iter().any(|run| run.run == RUN && run.state == RunState::Running);
        if kills < KILLS && is_going {
            kills += 1;
            core.kill();
            core = CoreProcess::start_with(dir.path(), &robot);
            gateway = FakeGateway::connect(&core.socket);
        }
    };
    assert_eq!((ended.outcome, kills), (RunState::Succeeded, KILLS));
    core.stop();

    let store = Store::open(dir.path()).expect("opens");
    let (ledger, _) = store.open_ledger().expect("opens");
    let runs = ledger.runs(&api::RunFilter::default(), None, 9).expect("read");
    assert_eq!((runs.len(), runs[0].state.as_str(), runs[0].is_ended), (1, "succeeded", true));
    assert!(runs[0].body.contains("\"revisions\""), "{}", runs[0].body);
    let results = ledger.results(RUN, None, 99).expect("read");
    let steps: Vec<_> = results.iter().map(|result| (result.step, result.kind.as_str())).collect();
    assert_eq!(steps, [(0, "wait"), (1, "wait")]);
    let done = ledger.steps(RUN, None, 99).expect("read");
    let succeeded: Vec<_> =
        done.iter().filter(|step| step.state == "succeeded").map(|step| step.step).collect();
    assert_eq!(succeeded, [0, 1]);
}
