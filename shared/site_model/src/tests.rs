//! Laws of edits, and the problems that validation finds.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeMap;
use uuid::Uuid;
use vocab::{Pose, Span, Vec3};

fn uuid(number: u128) -> Uuid {
    Uuid::from_u128(number)
}

fn edit_id(number: u128) -> EditId {
    EditId(uuid(number))
}

fn node(number: u128, name: &str, kind: NodeKind) -> Node {
    Node {
        id: NodeId(uuid(number)),
        name: name.to_owned(),
        kind,
        map_from_node: Pose { position: Vec3::new(number as f64, 0.0, 0.0), ..Pose::IDENTITY },
        anchor: None,
        tolerance: PoseTolerance::default(),
        influence_area_m: Vec::new(),
        floor: 0,
        tags: ["pump".to_owned()].into(),
        properties: BTreeMap::new(),
    }
}

fn edge(number: u128, from: u128, to: u128) -> Edge {
    Edge {
        id: EdgeId(uuid(number)),
        from: NodeId(uuid(from)),
        to: NodeId(uuid(to)),
        traversal: Traversal::Walk,
        cost: EdgeCost::Length,
        max_speed_m_s: Some(0.5),
        corridor: Corridor::default(),
        direction: TravelDirection::Forward,
        on_enter: Vec::new(),
        during: Vec::new(),
        on_leave: Vec::new(),
        fail_policy: vec![
            EdgeFailStep::Retry(2),
            EdgeFailStep::Wait(Span::from_millis(30_000)),
            EdgeFailStep::Fail,
        ],
        mutex_group: None,
        is_enabled: true,
    }
}

fn photo() -> ActionRequest {
    let size = Parameters::from([("width".to_owned(), Parameter::Integer(640))]);
    let parameters = [
        ("zoom".to_owned(), Parameter::Number(1.5)),
        ("flash".to_owned(), Parameter::Bool(true)),
        ("views".to_owned(), Parameter::List(vec![Parameter::Text("front".to_owned())])),
        ("size".to_owned(), Parameter::Map(size)),
    ];
    ActionRequest { action: "photo".to_owned(), parameters: parameters.into() }
}

fn mission(tasks: Vec<TaskPlace>) -> Mission {
    let task = |(number, place): (usize, TaskPlace)| Task {
        id: TaskId(uuid(100 + number as u128)),
        place,
        on_unreachable: FailurePolicy::default(),
        on_action_failure: FailurePolicy::default(),
    };
    Mission {
        id: MissionId(uuid(20)),
        name: "Round A".to_owned(),
        tasks: tasks.into_iter().enumerate().map(task).collect(),
        order: TaskOrder::Shortest { keep_first: true, keep_last: false },
        order_constraints: Vec::new(),
        end: MissionEnd::NearestDock,
    }
}

const MORNING: LocalTime = LocalTime { hour: 11, minute: 0 };
const FIRST_DAY: LocalDate = LocalDate { year: 2026, month: 11, day: 24 };

/// A gauge that is looked at from the first node.
fn point() -> InspectionPoint {
    InspectionPoint {
        id: InspectionPointId(uuid(10)),
        name: "Gauge north".to_owned(),
        asset: Some(AssetId(uuid(9))),
        node: NodeId(uuid(1)),
        target_m: Vec3::new(1.0, 2.0, 1.5),
        request: photo(),
        limits: Some(ReadingLimits { min: Some(3.8), max: Some(5.0), unit: "bar".to_owned() }),
        gauge: Some(dial()),
    }
}

fn dial() -> GaugeDial {
    GaugeDial {
        picture: vocab::BlobHash([7; 32]),
        size_px: [640, 480],
        centre_px: [320.0, 240.0],
        start_px: [270.0, 290.0],
        middle_px: Some([320.0, 170.0]),
        end_px: Some([370.0, 290.0]),
        direction: DialDirection::Clockwise,
        range: [0.0, 6.0],
        unit: "bar".to_owned(),
    }
}

/// Two nodes that are joined both ways, a dock, an inspection point, a mission, a schedule and a monitor; nothing is wrong with it.
fn objects() -> Vec<Object> {
    let point = point();
    let tasks = vec![
        TaskPlace::InspectionPoint(point.id),
        TaskPlace::Node { node: NodeId(uuid(2)), request: Some(photo()) },
    ];
    let schedule = Schedule {
        id: ScheduleId(uuid(30)),
        name: "Weekdays".to_owned(),
        mission: MissionId(uuid(20)),
        recurrence: Recurrence::Weekly {
            days: [Weekday::Monday, Weekday::Friday].into(),
            times: vec![MORNING],
            first_day: FIRST_DAY,
            last_day: None,
        },
        is_paused: false,
        skipped: Vec::new(),
        grace: Span::from_millis(900_000),
        missed: MissedSlots::RunOnce,
        overlap: OverlapPolicy::Queue,
        priority: 0,
    };
    let monitor = Monitor {
        id: MonitorId(uuid(40)),
        name: "Battery low".to_owned(),
        signal: "battery.charge".to_owned(),
        condition: MonitorCondition::Below { threshold: 0.2, release: 0.3 },
        hold: Span::from_millis(5_000),
        response: MonitorResponse::Interrupt { mission: MissionId(uuid(20)), afterwards: Resumption::Resume },
        is_enabled: true,
    };
    let zone = Zone {
        id: ZoneId(uuid(50)),
        name: "Crane".to_owned(),
        corners_m: vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]],
        height_m: Some([0.0, 2.0]),
        effect: ZoneEffect::SpeedLimit(0.3),
        daily: Some([MORNING, LocalTime { hour: 2, minute: 30 }]),
    };
    let dock = Dock {
        id: DockId(uuid(60)),
        name: "Dock 1".to_owned(),
        node: NodeId(uuid(3)),
        approach: NodeId(uuid(4)),
    };
    vec![
        Object::Settings(SiteSettings {
            name: "Hall".to_owned(),
            time_zone: "Europe/London".to_owned(),
            map: None,
        }),
        Object::Node(node(1, "North", NodeKind::Inspection)),
        Object::Node(node(2, "South", NodeKind::Waypoint)),
        Object::Node(node(3, "On dock 1", NodeKind::Dock)),
        Object::Node(node(4, "Before dock 1", NodeKind::DockApproach)),
        Object::Edge(edge(5, 1, 2)),
        Object::Edge(edge(6, 2, 1)),
        Object::Edge(edge(7, 2, 4)),
        Object::Edge(edge(8, 4, 2)),
        Object::Asset(Asset { id: AssetId(uuid(9)), name: "Pump 7".to_owned(), tags: Default::default() }),
        Object::InspectionPoint(point),
        Object::Mission(mission(tasks)),
        Object::Schedule(schedule),
        Object::Monitor(monitor),
        Object::Zone(zone),
        Object::Dock(dock),
    ]
}

fn site() -> Site {
    let mut site = Site::default();
    let changes = objects().into_iter().map(|object| Change::Put { base: None, object }).collect();
    site.apply(&Edit { id: edit_id(1), changes }, edit_id(2)).expect("applies");
    site
}

fn values(site: &Site) -> Vec<Object> {
    site.objects().map(|versioned| versioned.object.clone()).collect()
}

fn problems(site: &Site) -> Vec<(ObjectId, ProblemKind)> {
    let problems = site.problems(&ValidationConfig::default()).into_iter();
    problems.map(|problem| (problem.object, problem.kind)).collect()
}

/// The problems of the site after an object was changed.
fn problems_with(object: Object) -> Vec<(ObjectId, ProblemKind)> {
    let mut site = site();
    site.apply(&site.put(edit_id(3), object), edit_id(4)).expect("applies");
    problems(&site)
}

#[test]
fn nothing_is_wrong_with_the_site_of_these_tests() {
    assert_eq!(problems(&site()), []);
    assert_eq!(problems(&Site::default()), []);
}

#[test]
fn an_edit_of_a_changed_object_is_a_conflict_and_changes_nothing() {
    let mut site = site();
    let mine = site.put(edit_id(3), Object::Node(node(1, "Mine", NodeKind::Inspection)));
    let mut both = site.put(edit_id(4), Object::Node(node(2, "New", NodeKind::Waypoint)));
    both.changes.extend(mine.changes.clone());
    site.apply(&site.put(edit_id(5), Object::Node(node(1, "Theirs", NodeKind::Inspection))), edit_id(6))
        .expect("applies");
    let before = site.clone();
    let object = ObjectId::Node(NodeId(uuid(1)));
    let conflict = EditError::Conflict { object, revision: Some(Revision(2)) };
    assert_eq!(site.apply(&both, edit_id(7)), Err(conflict));
    assert_eq!(site, before);
}

#[test]
fn edits_of_different_objects_do_not_conflict_and_each_is_undone_by_itself() {
    let mut site = site();
    let start = values(&site);
    let one = site.put(edit_id(3), Object::Node(node(1, "One", NodeKind::Inspection)));
    let two = site.put(edit_id(4), Object::Node(node(2, "Two", NodeKind::Waypoint)));
    let undo_one = site.apply(&one, edit_id(5)).expect("applies").inverse;
    let undo_two = site.apply(&two, edit_id(6)).expect("applies").inverse;
    site.apply(&undo_one, edit_id(7)).expect("applies");
    assert_eq!(site.node(NodeId(uuid(2))).map(|node| node.name.as_str()), Some("Two"));
    site.apply(&undo_two, edit_id(8)).expect("applies");
    assert_eq!(values(&site), start);
}

#[test]
fn what_somebody_else_has_changed_since_is_not_undone_and_the_edit_before_is() {
    let mut site = site();
    let mut history = UndoHistory::default();
    let renamed = |site: &mut Site, number, name: &str| {
        let edit = site.put(edit_id(3), Object::Node(node(number, name, NodeKind::Waypoint)));
        site.apply(&edit, edit_id(4)).expect("of this state")
    };
    history.record(renamed(&mut site, 2, "Mine"));
    history.record(renamed(&mut site, 1, "Mine too"));
    renamed(&mut site, 1, "Theirs");
    let conflict = history.undo(&mut site, edit_id(5));
    assert!(matches!(conflict, Err(EditError::Conflict { .. })), "{conflict:?}");
    assert!(history.undo(&mut site, edit_id(6)).expect("no conflict").is_some());
    let name = |number| site.node(NodeId(uuid(number))).map(|node| node.name.as_str());
    assert_eq!((name(1), name(2)), (Some("Theirs"), Some("South")));
    assert!(!history.can_undo() && history.can_redo());
}

#[test]
fn a_node_is_removed_with_its_edges_and_docks_and_comes_back_with_them() {
    let mut site = site();
    let block = EdgeBlock {
        edge: EdgeId(uuid(7)),
        until: vocab::Stamp::from_parts(9, 0),
        failures: 1,
        reason: "The path is blocked near racks.".to_owned(),
    };
    site.apply(&site.put(edit_id(3), Object::EdgeBlock(block)), edit_id(4)).expect("applies");
    let before = values(&site);
    let approach = ObjectId::Node(NodeId(uuid(4)));
    let removal = site.removal(edit_id(5), approach);
    let removed: Vec<_> = removal.changes.iter().map(Change::object_id).collect();
    assert_eq!(
        removed,
        [
            approach,
            ObjectId::Edge(EdgeId(uuid(7))),
            ObjectId::Edge(EdgeId(uuid(8))),
            ObjectId::EdgeBlock(EdgeId(uuid(7))),
            ObjectId::Dock(DockId(uuid(60))),
        ]
    );
    let undo = site.apply(&removal, edit_id(6)).expect("applies").inverse;
    assert_eq!(problems(&site), []);
    site.apply(&undo, edit_id(7)).expect("applies");
    assert_eq!(values(&site), before);
}

#[test]
fn a_revision_never_occurs_twice() {
    let mut site = site();
    let id = ObjectId::Node(NodeId(uuid(2)));
    let stale = site.put(edit_id(3), Object::Node(node(2, "Stale", NodeKind::Waypoint)));
    let undo = site.apply(&site.removal(edit_id(4), id), edit_id(5)).expect("applies").inverse;
    site.apply(&undo, edit_id(6)).expect("applies");
    assert_eq!(site.revision(id), Some(Revision(3)));
    assert!(matches!(site.apply(&stale, edit_id(7)), Err(EditError::Conflict { .. })));
}

#[test]
fn missions_that_a_removal_breaks_are_listed() {
    let mut site = site();
    let needed = ObjectId::Node(NodeId(uuid(1)));
    assert_eq!(site.missions_that_need(needed), [MissionId(uuid(20))].into());
    assert!(site.missions_that_need(ObjectId::Node(NodeId(uuid(4)))).is_empty());
    site.apply(&site.removal(edit_id(3), needed), edit_id(4)).expect("applies");
    let point = ObjectId::InspectionPoint(InspectionPointId(uuid(10)));
    assert_eq!(problems(&site), [(point, ProblemKind::Missing(needed))]);
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    let mut site = site();
    let mut wrong = node(1, "North", NodeKind::Inspection);
    wrong.map_from_node.position.x = f64::NAN;
    let object = ObjectId::Node(wrong.id);
    assert_eq!(
        site.apply(&site.put(edit_id(3), Object::Node(wrong)), edit_id(4)),
        Err(EditError::NotFinite(object))
    );
    let mut wrong = mission(vec![TaskPlace::Node { node: NodeId(uuid(1)), request: Some(photo()) }]);
    if let TaskPlace::Node { request: Some(request), .. } = &mut wrong.tasks[0].place {
        let list = Parameter::List(vec![Parameter::Number(f64::INFINITY)]);
        request.parameters.insert("views".to_owned(), list);
    }
    let edit = site.put(edit_id(3), Object::Mission(wrong));
    assert!(matches!(site.apply(&edit, edit_id(4)), Err(EditError::NotFinite(_))));
}

#[test]
fn every_problem_is_found_with_its_object() {
    let node_id = |number| ObjectId::Node(NodeId(uuid(number)));
    let edge_id = |number| ObjectId::Edge(EdgeId(uuid(number)));
    let unnamed = problems_with(Object::Node(node(1, " ", NodeKind::Inspection)));
    assert_eq!(unnamed, [(node_id(1), ProblemKind::NoName)]);
    let alike = problems_with(Object::Node(node(2, "North", NodeKind::Waypoint)));
    assert_eq!(alike, [(node_id(2), ProblemKind::SameName(node_id(1)))]);
    let looped = problems_with(Object::Edge(edge(15, 1, 1)));
    assert_eq!(looped, [(edge_id(15), ProblemKind::EdgeToItself)]);
    let second = problems_with(Object::Edge(edge(15, 1, 2)));
    assert_eq!(second, [(edge_id(15), ProblemKind::SameEdge(edge_id(5)))]);
    let dangling = problems_with(Object::Edge(edge(15, 1, 99)));
    assert_eq!(dangling, [(edge_id(15), ProblemKind::Missing(node_id(99)))]);
    let fast = problems_with(Object::Edge(Edge { max_speed_m_s: Some(9.0), ..edge(5, 1, 2) }));
    assert!(matches!(&fast[..], [(_, ProblemKind::OutOfRange { field, .. })] if field == "max_speed_m_s"));
    let cut = problems_with(Object::Edge(Edge { is_enabled: false, ..edge(7, 2, 4) }));
    assert_eq!(cut, [(ObjectId::Dock(DockId(uuid(60))), ProblemKind::NoEdgeTo(NodeId(uuid(4))))]);
    let kind = problems_with(Object::Node(node(4, "Before dock 1", NodeKind::Waypoint)));
    assert!(kind.contains(&(ObjectId::Dock(DockId(uuid(60))), ProblemKind::WrongNodeKind(NodeId(uuid(4))))));

    let no_unit = GaugeDial { unit: String::new(), ..dial() };
    let point = problems_with(Object::InspectionPoint(InspectionPoint { gauge: Some(no_unit), ..point() }));
    let sentence = point.iter().map(|(_, problem)| problem.to_string()).collect::<Vec<_>>();
    assert_eq!(sentence, ["gauge must be a dial with a unit"]);

    let mission_id = ObjectId::Mission(MissionId(uuid(20)));
    assert_eq!(problems_with(Object::Mission(mission(Vec::new()))), [(mission_id, ProblemKind::NoTasks)]);
    let missing = mission(vec![TaskPlace::Node { node: NodeId(uuid(77)), request: None }]);
    let (task, object) = (TaskId(uuid(100)), node_id(77));
    let found = problems_with(Object::Mission(missing));
    assert_eq!(found, [(mission_id, ProblemKind::TaskMissing { task, object })]);

    let place = || TaskPlace::Node { node: NodeId(uuid(1)), request: None };
    let constrained = |order_constraints: &[[u128; 2]]| {
        let order_constraints = order_constraints.iter().map(|pair| pair.map(|task| TaskId(uuid(task))));
        let order_constraints = order_constraints.collect();
        let three = mission(vec![place(), place(), place()]);
        problems_with(Object::Mission(Mission { order_constraints, ..three }))
    };
    assert_eq!(constrained(&[[100, 101], [101, 102], [100, 102]]), []);
    let circular = constrained(&[[100, 101], [101, 102], [102, 100]]);
    assert_eq!(circular, [(mission_id, ProblemKind::OrderConstraintsCircular)]);
    let unknown = constrained(&[[100, 107]]);
    assert_eq!(unknown, [(mission_id, ProblemKind::OrderConstraintMissing(TaskId(uuid(107))))]);

    let crossed = vec![[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]];
    for corners_m in [crossed, vec![[0.0, 0.0], [1.0, 1.0]], vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]] {
        let zone = Zone {
            id: ZoneId(uuid(50)),
            name: "Crane".to_owned(),
            corners_m,
            height_m: None,
            effect: ZoneEffect::KeepOut,
            daily: None,
        };
        let found = problems_with(Object::Zone(zone));
        assert_eq!(found, [(ObjectId::Zone(ZoneId(uuid(50))), ProblemKind::NotAnArea)]);
    }
}

#[test]
fn days_are_those_of_the_calendar() {
    let day = |year, month, day| LocalDate { year, month, day };
    assert!(day(2028, 2, 29).is_valid() && day(2000, 2, 29).is_valid() && day(2026, 12, 31).is_valid());
    assert!(!day(2026, 2, 29).is_valid() && !day(1900, 2, 29).is_valid() && !day(2026, 4, 31).is_valid());
    assert!(!day(2026, 13, 1).is_valid() && !day(2026, 1, 0).is_valid());
}

#[test]
fn objects_are_the_same_after_json_and_after_the_wire() {
    for object in objects() {
        let json = serde_json::to_string(&object).expect("JSON");
        assert_eq!(serde_json::from_str::<Object>(&json).expect("the same"), object, "{json}");
        let bytes = postcard::to_stdvec(&object).expect("bytes");
        assert_eq!(postcard::from_bytes::<Object>(&bytes).expect("the same"), object);
    }
    let json = serde_json::to_value(photo()).expect("JSON");
    assert_eq!(json["parameters"]["zoom"], 1.5, "parameters are plain JSON");
    // What people leave out has defaults.
    let minimal = r#"{"id":"00000000-0000-0000-0000-000000000001","name":"A","kind":"waypoint",
        "map_from_node":{"position":{"x":1,"y":2,"z":0},"orientation":{"w":1,"x":0,"y":0,"z":0}}}"#;
    let node: Node = serde_json::from_str(minimal).expect("a node");
    assert_eq!((node.floor, node.tolerance), (0, PoseTolerance::default()));
}

#[test]
fn missions_and_schedules_are_saved_to_a_file_and_loaded_into_a_site() {
    let full = site();
    let json = serde_json::to_string(&PlanFile::of(&full)).expect("JSON");
    let file: PlanFile = serde_json::from_str(&json).expect("the same");
    assert_eq!((file.missions.len(), file.schedules.len()), (1, 1));
    let mut other = full.clone();
    for object in [ObjectId::Mission(MissionId(uuid(20))), ObjectId::Schedule(ScheduleId(uuid(30)))] {
        other.apply(&other.removal(edit_id(1), object), edit_id(2)).expect("applies");
    }
    other.apply(&file.edit(&other, edit_id(3)).expect("of this version"), edit_id(4)).expect("applies");
    assert_eq!(values(&other), values(&full));
    assert_eq!(file.edit(&other, edit_id(5)).expect("of this version").changes, [], "nothing is new");
    let newer = PlanFile { format_version: 2, ..file };
    assert_eq!(newer.edit(&other, edit_id(6)), Err(PlanFileError::TooNew(2)));
}

#[test]
fn what_only_one_side_changed_is_merged_and_what_both_changed_is_for_a_person() {
    let before = site();
    let renamed = |name: &str, number| Object::Node(node(number, name, NodeKind::Inspection));
    let (mut ours, mut theirs) = (before.clone(), before.clone());
    ours.apply(&ours.put(edit_id(3), renamed("Ours", 1)), edit_id(4)).expect("applies");
    theirs.apply(&theirs.put(edit_id(5), renamed("Theirs", 1)), edit_id(6)).expect("applies");
    theirs.apply(&theirs.put(edit_id(7), renamed("Theirs 2", 2)), edit_id(8)).expect("applies");
    let schedule = ObjectId::Schedule(ScheduleId(uuid(30)));
    theirs.apply(&theirs.removal(edit_id(9), schedule), edit_id(10)).expect("applies");
    let Merged { edit, conflicts } = merge(edit_id(11), &before, &ours, &theirs);
    let [conflict] = &conflicts[..] else { panic!("{conflicts:?}") };
    assert_eq!(conflict.object, ObjectId::Node(NodeId(uuid(1))));
    assert_eq!(conflict.theirs, Some(renamed("Theirs", 1)));
    ours.apply(&edit, edit_id(12)).expect("applies");
    let name = |number| ours.node(NodeId(uuid(number))).map(|node| node.name.as_str());
    assert_eq!((name(1), name(2), ours.get(schedule)), (Some("Ours"), Some("Theirs 2"), None));
}

/// Random edits of a few nodes and edges: put with a name, or removed.
fn random_steps() -> impl Strategy<Value = Vec<(u128, Option<u8>)>> {
    proptest::collection::vec((1_u128..9, proptest::option::of(0_u8..4)), 0..12)
}

fn edit_of(site: &Site, number: u128, put: Option<u8>) -> Edit {
    let id = edit_id(1_000);
    match (number, put) {
        (1..=4, Some(name)) => {
            site.put(id, Object::Node(node(number, &format!("N{name}"), NodeKind::Waypoint)))
        }
        (_, Some(name)) => site.put(id, Object::Edge(edge(number, 1 + u128::from(name), 2))),
        (1..=4, None) => site.removal(id, ObjectId::Node(NodeId(uuid(number)))),
        (_, None) => site.removal(id, ObjectId::Edge(EdgeId(uuid(number)))),
    }
}

fn changed(mut site: Site, steps: &[(u128, Option<u8>)]) -> Site {
    for (number, put) in steps {
        site.apply(&edit_of(&site, *number, *put), edit_id(1_001)).expect("made from this state");
    }
    site
}

proptest! {
    #[test]
    fn edits_are_undone_and_redone_while_somebody_else_edits_other_objects(steps in random_steps()) {
        let mut site = site();
        let mut history = UndoHistory::default();
        let mut states = vec![values(&site)];
        for (number, put) in steps {
            history.record(site.apply(&edit_of(&site, number, put), edit_id(1_001)).expect("of this state"));
            states.push(values(&site));
        }
        let somebody = Object::Node(node(5_000, "Somebody else's", NodeKind::Waypoint));
        site.apply(&site.put(edit_id(1_002), somebody.clone()), edit_id(1_003)).expect("new");
        let ours = |site: &Site| -> Vec<Object> {
            values(site).into_iter().filter(|object| *object != somebody).collect()
        };
        for _ in 0..2 {
            for state in states.iter().rev().skip(1) {
                prop_assert!(history.undo(&mut site, edit_id(1_004)).expect("no conflict").is_some());
                prop_assert_eq!(&ours(&site), state);
            }
            prop_assert!(!history.can_undo());
            for state in states.iter().skip(1) {
                prop_assert!(history.redo(&mut site, edit_id(1_005)).expect("no conflict").is_some());
                prop_assert_eq!(&ours(&site), state);
            }
            prop_assert!(!history.can_redo());
        }
    }

    #[test]
    fn a_difference_turns_one_state_into_the_other(a in random_steps(), b in random_steps()) {
        let (mut from, to) = (changed(site(), &a), changed(site(), &b));
        from.apply(&diff(edit_id(1), &from, &to), edit_id(2)).expect("made from this state");
        prop_assert_eq!(values(&from), values(&to));
        prop_assert!(diff(edit_id(1), &from, &to).changes.is_empty());
    }

    #[test]
    fn a_merge_keeps_ours_and_brings_in_theirs(a in random_steps(), b in random_steps()) {
        let before = site();
        let (mut ours, theirs) = (changed(before.clone(), &a), changed(before.clone(), &b));
        let start = ours.clone();
        let Merged { edit, conflicts } = merge(edit_id(1), &before, &ours, &theirs);
        ours.apply(&edit, edit_id(2)).expect("made from this state");
        let value = |site: &Site, id| site.get(id).map(|versioned| versioned.object.clone());
        for id in [&before, &start, &theirs].iter().flat_map(|site| site.objects().map(|it| it.object.id())) {
            let is_conflict = conflicts.iter().any(|conflict| conflict.object == id);
            let changed_by_us = value(&start, id) != value(&before, id);
            let expected = if is_conflict || changed_by_us { value(&start, id) } else { value(&theirs, id) };
            prop_assert_eq!(value(&ours, id), expected);
        }
    }
}
