use crate::testing::TestClient;
use crate::{
    ClientCommand, DraggedTasks, EndProblem, MissionEditorCommand, MissionPlan, NewTask, ParameterProblem,
    PlanStart, PlannedStop, SiteEdit, StopProblem, TaskDrag, constraints_against_list, users_of_mission,
};
use api::{SiteParts, SiteState};
use missions::NoRoute;
use site_model::{
    ActionRequest, Dock, DockId, Edge, EdgeId, EditId, InspectionPoint, InspectionPointId, LocalDate,
    LocalDateTime, LocalTime, MissionId, Node, NodeId, NodeKind, Object, ObjectId, Parameter, Parameters,
    PoseTolerance, Recurrence, Schedule, ScheduleId, Site, TaskId, TaskOrder, TaskPlace,
};
use std::collections::BTreeSet;
use std::sync::Arc;
use uuid::Uuid;
use vocab::{Pose, Span, Vec3};

fn node_id(number: u128) -> NodeId {
    NodeId(Uuid::from_u128(number))
}

fn put(site: &mut Site, object: Object) {
    let edit = site.put(EditId(Uuid::nil()), object);
    site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
}

fn add_node(site: &mut Site, number: u128, x: f64) {
    put(
        site,
        Object::Node(Node {
            id: node_id(number),
            name: format!("N{number}"),
            kind: NodeKind::Waypoint,
            map_from_node: Pose { position: Vec3::new(x, 0.0, 0.5), ..Pose::IDENTITY },
            anchor: None,
            tolerance: PoseTolerance::default(),
            influence_area_m: Vec::new(),
            floor: 0,
            tags: Default::default(),
            properties: Default::default(),
        }),
    );
}

/// Nodes 1 to 5 in a row, 7 m apart (10 s), joined both ways; a dock on node 1 and an inspection point at each node from 2 on. Node 9 is joined to none.
fn site() -> Site {
    let mut site = Site::default();
    for number in 1..=5 {
        add_node(&mut site, number, 7.0 * number as f64);
        for (from, to) in [(number - 1, number), (number, number - 1)] {
            if number > 1 {
                let id = EdgeId(Uuid::from_u128(100 * from + to));
                put(&mut site, Object::Edge(Edge::walk(id, node_id(from), node_id(to))));
            }
        }
        if number > 1 {
            put(
                &mut site,
                Object::InspectionPoint(InspectionPoint {
                    id: InspectionPointId(Uuid::from_u128(number)),
                    name: format!("P{number}"),
                    asset: None,
                    node: node_id(number),
                    target_m: Vec3::new(0.0, 2.0, 1.0),
                    request: ActionRequest { action: "photo".to_owned(), parameters: Parameters::new() },
                    limits: None,
                    gauge: None,
                }),
            );
        }
    }
    add_node(&mut site, 9, 100.0);
    let (id, name) = (DockId(Uuid::from_u128(1)), "Dock".to_owned());
    put(&mut site, Object::Dock(Dock { id, name, node: node_id(1), approach: node_id(1) }));
    site
}

fn point(number: u128) -> NewTask {
    NewTask::InspectionPoint(InspectionPointId(Uuid::from_u128(number)))
}

impl TestClient {
    fn with(site: Site) -> Self {
        let mut client = Self::connected();
        let state = SiteState { site, ..SiteState::default() };
        let part = SiteParts::new(Arc::new(state)).next_part();
        client.event(api::Event::SitePart(part));
        client
    }

    /// Edits a mission of these entries of the palette.
    fn with_mission(tasks: &[NewTask]) -> Self {
        let mut client = Self::with(site());
        let (mission, edit) = client.model.site.adding_mission();
        client.command(ClientCommand::EditSite(edit));
        client.edit(MissionEditorCommand::Open(Some(mission)));
        for task in tasks {
            let (_, edit) = client.model.missions.adding(*task, &client.model.site);
            client.command(ClientCommand::EditSite(edit));
        }
        client
    }

    fn edit(&mut self, command: MissionEditorCommand) {
        self.command(ClientCommand::MissionEditor(command));
    }

    fn mission(&self) -> MissionId {
        self.model.missions.open().expect("open")
    }

    fn tasks(&self) -> Vec<TaskId> {
        let mission = self.model.site.site().and_then(|site| site.mission(self.mission()));
        mission.expect("there").tasks.iter().map(|task| task.id).collect()
    }

    /// The places of the tasks, by the number of the inspection point or node.
    fn places(&self) -> Vec<u128> {
        let mission = self.model.site.site().and_then(|site| site.mission(self.mission()));
        let number = |place: &TaskPlace| match place {
            TaskPlace::InspectionPoint(point) => point.0.as_u128(),
            TaskPlace::Node { node, .. } => node.0.as_u128(),
            TaskPlace::ByAction { .. } => 0,
        };
        mission.expect("there").tasks.iter().map(|task| number(&task.place)).collect()
    }

    fn plan(&self) -> &MissionPlan {
        self.model.missions.plan().expect("of the open mission")
    }

    fn drag(&mut self, what: DraggedTasks, index: Option<usize>) {
        self.edit(MissionEditorCommand::Drag(TaskDrag { what, index }));
    }

    fn drop_tasks(&mut self) {
        let edit = self.model.missions.dropping(&self.model.site);
        if edit != SiteEdit::default() {
            self.command(ClientCommand::EditSite(edit));
        }
        self.edit(MissionEditorCommand::EndDrag);
    }

    fn change(&mut self, change: impl FnOnce(&mut site_model::Mission)) {
        let edit = self.model.site.changing_mission(self.mission(), change);
        self.command(ClientCommand::EditSite(edit));
    }
}

#[test]
fn a_drag_shows_its_route_at_once_changes_nothing_until_it_is_dropped_and_is_one_undo() {
    let mut client = TestClient::with_mission(&[point(2), point(3), point(4)]);
    let before_m = client.plan().length_m;
    assert!((before_m - 42.0).abs() < 1e-6, "dock, three points and back: {before_m}");
    let first = client.tasks()[0];
    let one = DraggedTasks::Listed(BTreeSet::from([first]));
    for index in [0, 1, 2] {
        client.drag(one.clone(), Some(index));
    }
    assert_eq!(client.places(), [2, 3, 4], "nothing is changed yet");
    assert_eq!(client.plan().mission.tasks[2].id, first);
    assert_eq!(client.model.missions.drag_cost().map(|cost| cost.length_m.round()), Some(0.0));
    assert!((client.plan().length_m - 42.0).abs() < 1e-6, "on the way back: {}", client.plan().length_m);
    client.drop_tasks();
    assert_eq!(client.places(), [3, 4, 2]);
    client.command(ClientCommand::Undo);
    assert_eq!(client.places(), [2, 3, 4]);
    client.command(ClientCommand::Redo);
    assert_eq!(client.places(), [3, 4, 2]);
}

#[test]
fn a_drag_that_is_cancelled_or_ends_outside_the_list_changes_nothing() {
    let mut client = TestClient::with_mission(&[point(2), point(3)]);
    let first = DraggedTasks::Listed(BTreeSet::from([client.tasks()[0]]));
    client.drag(first.clone(), Some(1));
    client.edit(MissionEditorCommand::EndDrag);
    assert_eq!(client.plan().mission.tasks[0].id, client.tasks()[0]);
    client.drag(first, None);
    client.drop_tasks();
    client.drag(DraggedTasks::New(point(4)), None);
    assert_eq!(client.plan().stops.len(), 2);
    client.drop_tasks();
    assert_eq!(client.places(), [2, 3]);
    client.command(ClientCommand::Undo);
    assert_eq!(client.places(), [2], "the drags left no step");
}

#[test]
fn an_entry_of_the_palette_is_dropped_where_it_is_shown_and_an_action_takes_the_place_before_it() {
    let mut client = TestClient::with_mission(&[point(2), point(5)]);
    client.drag(DraggedTasks::New(NewTask::Node(node_id(3))), Some(1));
    assert_eq!(client.plan().stops.len(), 3);
    client.drop_tasks();
    assert_eq!(client.places(), [2, 3, 5]);
    client.drag(DraggedTasks::New(NewTask::Action("wait")), Some(2));
    let stop = client.plan().stops[2].clone();
    assert_eq!((stop.node, stop.action_s, stop.walk.length_m), (Some(node_id(3)), 10.0, 0.0));
    client.drop_tasks();
    assert_eq!(client.places(), [2, 3, 3, 5]);
}

#[test]
fn several_tasks_move_together_and_are_duplicated_and_deleted_together() {
    let mut client = TestClient::with_mission(&[point(2), point(3), point(4), point(5)]);
    let tasks = client.tasks();
    let two = BTreeSet::from([tasks[0], tasks[2]]);
    client.edit(MissionEditorCommand::Select(two.clone()));
    client.drag(DraggedTasks::Listed(two.clone()), Some(2));
    client.drop_tasks();
    assert_eq!(client.places(), [3, 5, 2, 4]);
    for (towards_end, places) in [(false, [3, 2, 4, 5]), (true, [3, 5, 2, 4]), (true, [3, 5, 2, 4])] {
        let edit = client.model.missions.moving_selected(towards_end, &client.model.site);
        client.command(ClientCommand::EditSite(edit));
        assert_eq!(client.places(), places);
    }
    client.change(|mission| mission.order_constraints.push([tasks[0], tasks[1]]));
    let (copies, edit) = client.model.site.duplicating_tasks(client.mission(), &two);
    client.command(ClientCommand::EditSite(edit));
    assert_eq!((client.places(), copies.len()), (vec![3, 5, 2, 4, 2, 4], 2));
    let edit = client.model.site.deleting_tasks(client.mission(), &two);
    client.command(ClientCommand::EditSite(edit));
    assert_eq!(client.places(), [3, 5, 2, 4]);
    let mission = client.model.site.site().and_then(|site| site.mission(client.mission())).expect("there");
    assert!(mission.order_constraints.is_empty(), "no constraint names a task that is gone");
    assert!(client.model.missions.selected().is_empty());
}

#[test]
fn time_and_length_include_the_actions_and_the_route_from_the_dock_and_back() {
    let client = TestClient::with_mission(&[point(3)]);
    let plan = client.plan();
    assert!(matches!(plan.start, Some((PlanStart::Dock(_), _))));
    assert!((plan.length_m - 28.0).abs() < 1e-6, "{}", plan.length_m);
    assert!((plan.time_s - 46.0).abs() < 1e-6, "40 s of walking and a photo: {}", plan.time_s);
    assert_eq!(plan.end.route.len(), 3);
    assert_eq!(plan.gain, None);
}

#[test]
fn what_cannot_be_reached_says_why_and_the_others_are_planned_all_the_same() {
    let mut client = TestClient::with_mission(&[
        point(2),
        NewTask::Node(node_id(9)),
        point(3),
        NewTask::Action("message"),
    ]);
    let problems =
        |client: &TestClient| client.plan().stops.iter().map(|stop| stop.problem.clone()).collect::<Vec<_>>();
    let found = problems(&client);
    assert!(
        matches!(&found[1], Some(StopProblem::NoRoute(from, NoRoute::NotConnected)) if *from == node_id(2))
    );
    assert!(
        matches!(&found[3], Some(StopProblem::Parameter(field, ParameterProblem::Missing)) if field.name == "text")
    );
    assert_eq!((&found[0], &found[2]), (&None, &None));
    assert!((client.plan().length_m - 28.0).abs() < 1e-6, "{}", client.plan().length_m);

    // An edge on the way is closed: what is behind it cannot be reached any more.
    let edge = EdgeId(Uuid::from_u128(203));
    let edit = client.model.site.changing_edge(edge, |edge| edge.is_enabled = false);
    client.command(ClientCommand::EditSite(edit));
    let found = problems(&client);
    assert!(
        matches!(&found[2], Some(StopProblem::NoRoute(_, NoRoute::Closed { edges })) if edges[0].0 == edge)
    );

    let removed = vec![ObjectId::InspectionPoint(InspectionPointId(Uuid::from_u128(2)))];
    client.command(ClientCommand::EditSite(SiteEdit { put: Vec::new(), removed }));
    assert_eq!(problems(&client)[0], Some(StopProblem::NoPlace));
    client.command(ClientCommand::EditSite(SiteEdit {
        put: Vec::new(),
        removed: vec![ObjectId::Dock(DockId(Uuid::from_u128(1)))],
    }));
    assert_eq!(client.plan().end.problem, Some(EndProblem::NoDock));
    assert!(matches!(client.plan().start, Some((PlanStart::FirstTask, _))));
}

#[test]
fn the_shortest_order_is_shown_before_it_is_chosen_and_can_be_declined() {
    let mut client = TestClient::with_mission(&[point(5), point(2), point(4)]);
    let gain = client.plan().gain.clone().expect("the list goes to and fro");
    assert!(gain.is_shortest && (gain.saved.length_m - 28.0).abs() < 1e-6, "{gain:?}");
    client.edit(MissionEditorCommand::ProposeOrder(true));
    assert!((client.plan().length_m - 56.0).abs() < 1e-6, "{}", client.plan().length_m);
    assert_eq!(client.places(), [5, 2, 4], "only shown");
    client.edit(MissionEditorCommand::ProposeOrder(false));
    assert!((client.plan().length_m - 84.0).abs() < 1e-6, "{}", client.plan().length_m);

    client.edit(MissionEditorCommand::ProposeOrder(true));
    let edit = client.model.missions.accepting_order(&client.model.site);
    client.command(ClientCommand::EditSite(edit));
    client.edit(MissionEditorCommand::ProposeOrder(false));
    assert_eq!(client.places().len(), 3);
    assert_eq!((client.plan().gain.clone(), client.plan().length_m), (None, 56.0));
    client.command(ClientCommand::Undo);
    assert_eq!(client.places(), [5, 2, 4]);

    // Always the shortest order: the list stays, the route is the shortest one from the first task on.
    client.change(|mission| mission.order = TaskOrder::Shortest { keep_first: true, keep_last: false });
    assert_eq!(client.plan().stops[0].task, client.tasks()[0]);
    assert!((client.plan().length_m - 56.0).abs() < 1e-6, "{}", client.plan().length_m);
}

#[test]
fn a_copy_has_tasks_of_its_own_and_a_mission_takes_its_schedules_with_it() {
    let mut client = TestClient::with_mission(&[point(2), point(3)]);
    let original = client.mission();
    let tasks = client.tasks();
    client.change(|mission| mission.order_constraints.push([tasks[0], tasks[1]]));
    let date = LocalDate { year: 2026, month: 11, day: 24 };
    let schedule = Schedule {
        id: ScheduleId(Uuid::from_u128(1)),
        name: "Daily".to_owned(),
        mission: original,
        recurrence: Recurrence::Once(LocalDateTime { date, time: LocalTime { hour: 11, minute: 0 } }),
        is_paused: false,
        skipped: Vec::new(),
        grace: Span::ZERO,
        missed: Default::default(),
        overlap: Default::default(),
        priority: 0,
    };
    client.command(ClientCommand::EditSite(SiteEdit {
        put: vec![Object::Schedule(schedule)],
        removed: Vec::new(),
    }));
    let (copy, edit) = client.model.site.duplicating_mission(original).expect("there");
    client.command(ClientCommand::EditSite(edit));
    let site = client.model.site.site().expect("loaded");
    let copied = site.mission(copy).expect("made");
    assert_eq!((copied.name.as_str(), copied.tasks.len()), ("Mission 1 copy", 2));
    assert!(copied.tasks.iter().all(|task| !tasks.contains(&task.id)));
    assert_eq!(copied.order_constraints, [[copied.tasks[0].id, copied.tasks[1].id]]);
    assert_eq!(users_of_mission(site, original), (vec!["Daily"], vec![]));
    assert_eq!(users_of_mission(site, copy), (vec![], vec![]));

    client.command(ClientCommand::EditSite(client.model.site.removing_mission(original)));
    assert_eq!(client.model.missions.open(), None, "it is gone");
    assert_eq!(client.model.site.site().map(|site| site.schedules().count()), Some(0));
    client.command(ClientCommand::Undo);
    let site = client.model.site.site().expect("loaded");
    assert!(site.mission(original).is_some() && site.schedules().count() == 1, "one step brings back both");
}

#[test]
fn the_charge_of_a_plan_counts_the_energy_of_actions_that_the_robot_offers() {
    let mut client = TestClient::with_mission(&[point(2), NewTask::Node(node_id(3))]);
    let (second, before) = (client.tasks()[1], client.plan().charge_used);
    assert!(before > 0.0);
    client.event(api::Event::Actions(vec![api::OfferedAction {
        name: "sniff".to_owned(),
        title: "Sniff".to_owned(),
        parameter_schema: "{}".to_owned(),
        expected: Span::from_millis(60_000),
        expected_energy_j: 33_480,
        is_idempotent: true,
    }]));
    client.change(|mission| {
        let task = mission.tasks.iter_mut().find(|task| task.id == second).expect("there");
        let request = Some(ActionRequest { action: "sniff".to_owned(), parameters: Default::default() });
        task.place = TaskPlace::Node { node: node_id(3), request };
    });
    // A hundredth of 930 Wh, and a minute of standing.
    let added = client.plan().charge_used - before;
    assert!((added - 0.01 - 60.0 / 18_000.0).abs() < 1e-9, "{added}");
    assert_eq!(client.plan().stops[1].action_s, 60.0);
}

#[test]
fn docking_on_the_way_is_planned_from_where_the_robot_is_then_with_its_charging() {
    let docking = [point(3), NewTask::Action("dock"), NewTask::Action("undock"), point(2)];
    let mut client = TestClient::with_mission(&docking);
    let stops = |client: &TestClient| {
        let stop = |stop: &PlannedStop| (stop.node, stop.walk.length_m.round(), stop.action_s.round());
        client.plan().stops.iter().map(stop).collect::<Vec<_>>()
    };
    let [first, dock, undock, second] = stops(&client)[..] else { panic!("{:?}", client.plan()) };
    assert_eq!((first.0, dock), (Some(node_id(3)), (Some(node_id(1)), 14.0, 15.0)));
    assert_eq!((undock.2, second.0), (5.0, Some(node_id(2))));
    assert!(client.plan().stops.iter().all(|stop| stop.problem.is_none()), "{:?}", client.plan().stops);
    assert!(client.plan().gain.is_none(), "no other order is proposed");
    let before = client.plan().charge_used;
    let (number, task) = (1, client.tasks()[1]);
    let set = |client: &mut TestClient, name: &str, value: Parameter| {
        client.change(|mission| {
            let task = mission.tasks.iter_mut().find(|it| it.id == task).expect("there");
            let TaskPlace::ByAction { request } = &mut task.place else { panic!("{task:?}") };
            request.parameters.insert(name.to_owned(), value);
        });
    };
    set(&mut client, "charge_until_percent", Parameter::Integer(100));
    // Some 0.5 % are used on the way to the dock; a percent takes 72 s.
    let charging_s = client.plan().stops[number].action_s - 15.0;
    assert!(charging_s > 20.0 && charging_s < 72.0, "{charging_s}");
    assert!(client.plan().charge_used < before, "what was used before the dock does not count twice");
    let missing = Parameter::Text(Uuid::from_u128(99).to_string());
    set(&mut client, "dock", missing);
    assert_eq!(client.plan().stops[number].problem, Some(StopProblem::NoPlace));
}

#[test]
fn order_constraints_are_made_removed_and_met_by_the_list() {
    let mut client = TestClient::with_mission(&[point(2), point(3), point(4)]);
    let tasks = client.tasks();
    let site = |client: &TestClient| client.model.site.clone();
    for [first, second] in [[2, 0], [1, 0], [2, 0]] {
        let edit = site(&client).constraining_order(client.mission(), tasks[first], tasks[second]);
        client.command(ClientCommand::EditSite(edit));
    }
    let same = site(&client).constraining_order(client.mission(), tasks[1], tasks[1]);
    assert_eq!(same, SiteEdit::default());
    let mission = |client: &TestClient| {
        client.model.site.site().and_then(|site| site.mission(client.mission())).cloned().expect("there")
    };
    assert_eq!(constraints_against_list(&mission(&client)), [[tasks[2], tasks[0]], [tasks[1], tasks[0]]]);
    let edit = site(&client).listing_in_constrained_order(client.mission());
    client.command(ClientCommand::EditSite(edit));
    assert_eq!(client.places(), [3, 4, 2], "tasks stay in their order where they may");
    assert!(constraints_against_list(&mission(&client)).is_empty());

    let edit = site(&client).constraining_order(client.mission(), tasks[0], tasks[2]);
    client.command(ClientCommand::EditSite(edit));
    let edit = site(&client).listing_in_constrained_order(client.mission());
    assert_eq!(edit, SiteEdit::default(), "no order meets a circle");
    let edit = site(&client).freeing_order(client.mission(), [tasks[0], tasks[2]]);
    client.command(ClientCommand::EditSite(edit));
    client.command(ClientCommand::Undo);
    assert_eq!(mission(&client).order_constraints.len(), 3);
}

#[test]
fn the_duration_of_a_schedule_counts_no_block_because_it_has_ended_by_then() {
    let mut client = TestClient::with_mission(&[point(3)]);
    let durations = |client: &TestClient| crate::expected_durations(client.model.site.site().expect("there"));
    let before = durations(&client);
    let edges = client.model.site.site().into_iter().flat_map(|site| site.edges());
    let blocks = edges.map(|edge| {
        let (until, reason) = (vocab::Stamp::from_secs_f64(60.0), String::new());
        Object::EdgeBlock(site_model::EdgeBlock { edge: edge.id, until, failures: 1, reason })
    });
    let put = blocks.collect();
    client.command(ClientCommand::EditSite(SiteEdit { put, removed: Vec::new() }));
    assert_eq!(durations(&client), before);
    assert!(!before.is_empty());
}
