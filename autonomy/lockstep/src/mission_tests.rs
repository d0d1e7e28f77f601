//! Missions on the simulated site: routes are walked edge by edge, actions are called in the right poses, and the robot goes back to its dock.

use crate::day::{Day, FIRST, first};
use crate::replay;
use geometry::{Vector3, isometry_from_pose};
use messages::{CommandKind, GoalKind, Input, LedgerEvent, LocalisationState, Sensor};
use sim::Start;
use site_model::{
    ActionRequest, CHARGE_PARAMETER, Dock, DockId, Edge, EdgeId, EditId, FailurePolicy, Mission,
    MissionCommandKind, MissionEnd, MissionId, Node, NodeId, NodeKind, Object, Parameter, Parameters,
    PoseTolerance, RunId, RunState, Site, SiteSettings, StartMode, Task, TaskId, TaskOrder, TaskPlace,
    TaskState, Traversal,
};
use stack::Stack;
use std::sync::Arc;
use uuid::Uuid;
use vocab::{Pose, Quat, Vec3};

const LOCALISED: LocalisationState = LocalisationState::Localised { map: FIRST, degradation: None };
pub(crate) const MISSION: MissionId = MissionId(Uuid::from_u128(70));
pub(crate) const RUN: RunId = RunId(Uuid::from_u128(71));
pub(crate) const DOCK: DockId = DockId(Uuid::from_u128(72));

/// Places of the site: number, position in the site, heading, and what the node is for.
const PLACES: [(u128, [f64; 2], f64, NodeKind); 7] = [
    (1, [16.4, 23.5], 0.0, NodeKind::Dock),
    (2, [18.2, 23.5], 0.0, NodeKind::DockApproach),
    (3, [24.0, 22.9], 0.0, NodeKind::Waypoint),
    (4, [29.0, 22.0], -1.2, NodeKind::Inspection),
    (5, [29.0, 17.4], 3.0, NodeKind::Waypoint),
    (6, [21.0, 17.4], 1.57, NodeKind::Inspection),
    (7, [21.0, 22.6], 1.57, NodeKind::Waypoint),
];

pub(crate) fn node(number: u128) -> NodeId {
    NodeId(Uuid::from_u128(number))
}

pub(crate) fn heading(yaw: f64) -> Quat {
    Quat { w: (yaw / 2.0).cos(), x: 0.0, y: 0.0, z: (yaw / 2.0).sin() }
}

/// The graph round the hall, with a mission of two photos. The frame of the map begins at `origin` with the heading of the site.
pub(crate) fn site(origin: &Vector3) -> Site {
    let mut site = Site::default();
    let mut put = |object| {
        let id = EditId(Uuid::nil());
        let edit = site.put(id, object);
        assert!(site.apply(&edit, id).is_ok());
    };
    put(Object::Settings(SiteSettings {
        name: "B1".to_owned(),
        time_zone: "Europe/London".to_owned(),
        map: Some(FIRST),
    }));
    for (number, [x, y], yaw, kind) in PLACES {
        let position = Vec3::new(x - origin.x, y - origin.y, 0.0);
        put(Object::Node(Node {
            id: node(number),
            name: format!("N{number}"),
            kind,
            map_from_node: Pose { position, orientation: heading(yaw) },
            anchor: None,
            tolerance: PoseTolerance::default(),
            influence_area_m: Vec::new(),
            floor: 0,
            tags: [].into(),
            properties: [].into(),
        }));
    }
    for (a, b) in [(2, 3), (3, 4), (4, 5), (5, 6), (6, 7), (7, 2)] {
        for (from, to) in [(a, b), (b, a)] {
            let id = EdgeId(Uuid::from_u128(from * 100 + to));
            put(Object::Edge(Edge::walk(id, node(from), node(to))));
        }
    }
    for (from, to) in [(1, 2), (2, 1)] {
        let walk = Edge::walk(EdgeId(Uuid::from_u128(from * 100 + to)), node(from), node(to));
        put(Object::Edge(Edge { traversal: Traversal::Dock, ..walk }));
    }
    put(Object::Dock(Dock { id: DOCK, name: "Dock".to_owned(), node: node(1), approach: node(2) }));
    let photo = ActionRequest { action: "photo".to_owned(), parameters: Parameters::new() };
    let task = |number| Task {
        id: TaskId(Uuid::from_u128(number)),
        place: TaskPlace::Node { node: node(number), request: Some(photo.clone()) },
        on_unreachable: FailurePolicy::default(),
        on_action_failure: FailurePolicy::default(),
    };
    put(Object::Mission(Mission {
        id: MISSION,
        name: "Round".to_owned(),
        tasks: vec![task(4), task(6)],
        order: TaskOrder::AsListed,
        order_constraints: Vec::new(),
        end: MissionEnd::NearestDock,
    }));
    site
}

/// A robot that is localised on its dock, with the site.
fn morning(seed: u64, people: u32) -> Day {
    let (_, _, origin) = first();
    let start = Start { position: Vec3::new(16.4, 23.5, 0.0), yaw: 0.0 };
    localised(Day::among(people, start, seed, None), site(origin))
}

/// The robot once it is localised, with a site.
pub(crate) fn localised(mut day: Day, site: Site) -> Day {
    let (prior_map, _, _) = first();
    day.lockstep.keep_map(Arc::clone(prior_map));
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.lockstep.give_site(site);
    let mut tenths = 0;
    while day.localisation != LOCALISED && tenths < 200 {
        day.run(0.1);
        tenths += 1;
    }
    assert_eq!(day.localisation, LOCALISED);
    day.run(1.0);
    day
}

/// Runs until the run has ended, and returns its outcome.
pub(crate) fn until_ended(day: &mut Day, max_seconds: u32) -> Option<RunState> {
    for _ in 0..max_seconds {
        day.run(1.0);
        let ended = day.missions.ended.iter().find(|ended| ended.run == RUN);
        if let Some(ended) = ended {
            return Some(ended.outcome);
        }
    }
    None
}

/// Distance and difference of heading between the robot by the truth and a node.
fn error_at(day: &Day, call: usize, number: u128) -> (f64, f64) {
    let (_, _, origin) = first();
    let call = &day.lockstep.calls()[call];
    let (_, [x, y], yaw, _) = PLACES[number as usize - 1];
    let truth = call.truth.site_from_base;
    // The map begins at `origin` where the robot stood by the truth.
    let _ = origin;
    let distance = (truth.position.x - x).hypot(truth.position.y - y);
    let ahead = isometry_from_pose(&truth).map(|pose| pose.rotation * Vector3::x());
    let heading = ahead.map_or(f64::NAN, |ahead| ahead.y.atan2(ahead.x));
    (distance, (heading - yaw).sin().atan2((heading - yaw).cos()).abs())
}

#[test]
fn a_mission_leaves_the_dock_takes_its_photos_and_comes_back_to_charge() {
    let mut day = morning(51, 0);
    assert_eq!(day.route.docked, Some(DOCK));
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Now };
    day.command(CommandKind::Mission(start));
    day.run(1.0);
    assert_eq!(day.missions.runs.len(), 1, "{:?}", day.refusals);
    let outcome = until_ended(&mut day, 240);
    assert_eq!(outcome, Some(RunState::Succeeded), "{:?} {:?} {:?}", day.missions, day.route, day.motion);
    let calls: Vec<_> = day.lockstep.calls().iter().map(|call| call.action.as_str()).collect();
    assert_eq!(calls, ["photo", "photo"]);
    for (call, number) in [(0, 4), (1, 6)] {
        let (distance_m, yaw_rad) = error_at(&day, call, number);
        assert!(distance_m < 0.1 && yaw_rad < 0.0524, "{distance_m} m, {yaw_rad} rad");
    }
    assert_eq!(day.route.docked, Some(DOCK));
    assert!(day.refusals.is_empty(), "{:?}", day.refusals);
    let again = replay(day.lockstep.log().iter().cloned(), &mut Stack::new());
    assert_eq!(again.hex(), day.lockstep.digest().hex());
}

/// The newest state of the robot's battery, 0 to 1.
fn charge(day: &Day) -> f64 {
    let battery = day.lockstep.log().iter().rev().find_map(|(_, input)| match input {
        Input::Sensor(Sensor::Battery(battery)) => Some(battery.charge),
        _ => None,
    });
    battery.expect("the battery tells its charge").into()
}

#[test]
fn a_mission_docks_and_charges_between_its_photos_and_goes_on_after_undocking() {
    let mut day = morning(55, 0);
    let began_with = charge(&day);
    // What the walk takes is charged again. Half a percent is the tolerance.
    let percent = Parameter::Number((100.0 * began_with + 0.5).min(100.0));
    let of = |action: &str, parameters: Parameters| TaskPlace::ByAction {
        request: ActionRequest { action: action.to_owned(), parameters },
    };
    let Some(mission) = day.lockstep.site().mission(MISSION).cloned() else { panic!("no mission") };
    let [first, second] = [0, 1].map(|index| mission.tasks[index].clone());
    let with = |number, place| Task { id: TaskId(Uuid::from_u128(number)), place, ..first.clone() };
    let dock = with(90, of("dock", [(CHARGE_PARAMETER.to_owned(), percent)].into()));
    let undock = with(91, of("undock", Parameters::new()));
    let tasks = vec![first.clone(), dock, undock, second];
    let edit = day.lockstep.site().put(
        EditId(Uuid::from_u128(9)),
        Object::Mission(Mission { tasks, end: MissionEnd::Stay, ..mission }),
    );
    day.lockstep.give(Input::SiteEdited(Box::new(edit)));
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Now };
    day.command(CommandKind::Mission(start));
    let outcome = until_ended(&mut day, 600);
    assert_eq!(outcome, Some(RunState::Succeeded), "{:?} {:?} {:?}", day.missions, day.route, day.motion);
    let calls: Vec<_> = day.lockstep.calls().iter().map(|call| call.action.as_str()).collect();
    assert_eq!(calls, ["photo", "photo"], "docking is no call");
    let charged = day.lockstep.rows().iter().find_map(|row| match row {
        LedgerEvent::Result(result) if result.kind == "dock" => {
            let body: serde_json::Value = serde_json::from_str(&result.body).ok()?;
            body["value"]["readings"][0]["value"].as_f64()
        }
        _ => None,
    });
    let charged = charged.expect("a result like that of other tasks");
    assert!(charged > 100.0 * began_with - 0.1, "{charged} % after {began_with}");
    assert_eq!(day.route.docked, None);
    let again = replay(day.lockstep.log().iter().cloned(), &mut Stack::new());
    assert_eq!(again.hex(), day.lockstep.digest().hex());
}

#[test]
fn driving_by_hand_pauses_a_run_and_resuming_goes_on() {
    let mut day = morning(52, 0);
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Now };
    day.command(CommandKind::Mission(start));
    day.run(12.0);
    assert_eq!(day.missions.runs[0].tasks[0].state, TaskState::Navigating, "{:?}", day.missions);
    day.command(CommandKind::Teleoperate(vocab::Twist::default()));
    day.run(1.0);
    assert_eq!(day.missions.runs[0].state, RunState::Paused);
    day.command(CommandKind::Mission(MissionCommandKind::Resume(RUN)));
    assert_eq!(until_ended(&mut day, 240), Some(RunState::Succeeded), "{:?}", day.missions);
}

#[test]
fn a_person_sends_the_robot_to_a_node_and_the_route_goes_round_a_closed_edge() {
    let mut day = morning(53, 0);
    let closed = EdgeId(Uuid::from_u128(203));
    let Some(edge) = day.lockstep.site().edge(closed).cloned() else { panic!("no edge") };
    let id = EditId(Uuid::from_u128(9));
    let edit = day.lockstep.site().put(id, Object::Edge(Edge { is_enabled: false, ..edge }));
    day.lockstep.give(Input::SiteEdited(Box::new(edit)));
    day.start_goal(GoalKind::GoToNode(node(4)));
    day.run(2.0);
    let route = day.route.route.clone().map(|route| route.edges.len());
    for _ in 0..120 {
        day.run(1.0);
        if day.route.at == Some(node(4)) && day.route.route.is_none() {
            break;
        }
    }
    assert_eq!(day.route.at, Some(node(4)), "{:?} {:?} {:?}", route, day.route, day.refusals);
    assert!(day.route.route.is_none());
}

#[test]
fn people_are_told_once_that_a_run_waits_for_the_place_of_the_robot() {
    let (_, _, origin) = first();
    let start = Start { position: Vec3::new(16.4, 23.5, 0.0), yaw: 0.0 };
    let mut day = Day::begin(start, 54, None);
    day.lockstep.give_site(site(origin));
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Queue };
    day.command(CommandKind::Mission(start));
    day.run(3.0);
    let notices = day.notices.iter().filter(|text| text.contains("waits until the robot is localised"));
    assert_eq!(notices.count(), 1, "{:?}", day.notices);
}
