//! The mission runner in the stack: what it hears, what becomes of what it wants, and what people are told.

use super::super::testing::{AHEAD, Rig, client, node_id};
use super::*;
use executive::Situation;
use messages::{
    ActionOutcome, CommandKind, ExecutiveEvent, GoalKind, LedgerEvent, Notice, Principal, RegisteredAction,
};
use missions::MissionNotice;
use site_model::{
    ActionRequest, Change, Edge, Edit, EditId, FailurePolicy, Mission, MissionEnd, MissionEvent,
    MissionEventKind, MissionId, Object, Parameters, RouteActionEnd, RouteActionStep, RunCause, RunId,
    RunPlan, StartMode, Task, TaskId, TaskOrder, TaskPlace, TaskStep, Zone, ZoneEffect, ZoneId,
};
use uuid::Uuid;
use vocab::{ActionCallId, CommandId, Pose, Span, Vec3};

const RUN: RunId = RunId(Uuid::from_u128(50));
const MISSION: MissionId = MissionId(Uuid::from_u128(51));

/// What becomes of something that the runner wants.
fn handle(rig: &mut Rig, wanted: MissionEffect) -> Vec<StackEffect> {
    let (at, mut effects) = (rig.at, Vec::new());
    rig.running().handle_mission_effect(at, wanted, &mut effects);
    effects
}

fn registered() -> Input {
    let expected = Span::from_millis(1_000);
    Input::ActionsRegistered(vec![RegisteredAction {
        name: "photo".to_owned(),
        is_idempotent: true,
        expected,
    }])
}

fn count(rig: &Rig, is_counted: impl Fn(&StackEffect) -> bool) -> usize {
    rig.effects.iter().filter(|effect| is_counted(effect)).count()
}

/// A mission with a visit to node 2.
fn mission(id: MissionId) -> Object {
    let task = Task {
        id: TaskId(Uuid::from_u128(52)),
        place: TaskPlace::Node { node: node_id(2), request: None },
        on_unreachable: FailurePolicy::default(),
        on_action_failure: FailurePolicy::default(),
    };
    Object::Mission(Mission {
        id,
        name: "Round".to_owned(),
        tasks: vec![task],
        order: TaskOrder::AsListed,
        order_constraints: Vec::new(),
        end: MissionEnd::Stay,
    })
}

#[test]
fn actions_that_are_registered_before_the_site_wait_for_the_runner() {
    let mut rig = Rig::booted();
    rig.step(registered());
    assert!(rig.running().missions.actions.contains_key("photo"));
    rig.give_objects(Vec::new());
    assert!(rig.running().missions.runner.is_some());
    assert!(rig.running().missions.actions.is_empty(), "the runner has them");
    rig.step(registered());
    assert!(rig.running().missions.actions.is_empty() && rig.running().missions.pending.is_empty());
}

#[test]
fn an_edit_that_does_not_apply_changes_nothing() {
    let mut rig = Rig::new();
    let before = Arc::clone(&rig.running().missions.site);
    let Some(node) = before.node(node_id(1)).cloned() else { panic!("no node") };
    let renamed = Object::Node(site_model::Node { name: "Gate".to_owned(), ..node });
    let base = before.revision(renamed.id());
    let edit = |base| {
        let changes = vec![Change::Put { base, object: renamed.clone() }];
        Input::SiteEdited(Box::new(Edit { id: EditId(Uuid::from_u128(9)), changes }))
    };
    let name = |rig: &mut Rig| rig.running().missions.site.node(node_id(1)).map(|node| node.name.clone());
    rig.step(edit(None));
    assert_eq!(name(&mut rig).as_deref(), Some("N1"));
    rig.step(edit(base));
    assert_eq!(name(&mut rig).as_deref(), Some("Gate"));
}

#[test]
fn a_command_is_refused_before_the_site_is_known_and_answered_by_the_runner_afterwards() {
    let pause = || CommandKind::Mission(MissionCommandKind::Pause(RUN));
    let mut rig = Rig::booted();
    assert_eq!(rig.command(1, pause()).as_deref(), Some(texts::NO_SITE));
    let mut rig = Rig::new();
    let refused = rig.command(1, pause());
    assert!(
        refused.as_deref().is_some_and(|text| text != texts::NO_SITE),
        "there is no such run: {refused:?}"
    );
}

#[test]
fn an_answer_goes_to_the_client_that_waits_for_it() {
    let mut rig = Rig::new();
    let [known, unknown] = [60, 61].map(|number| CommandId(Uuid::from_u128(number)));
    rig.running().missions.waiting.push((), known, client(3).client);
    let refused = Some("Not now.".to_owned());
    let answer = |command| MissionEffect::Answer { command, refused: refused.clone() };
    assert_eq!(handle(&mut rig, answer(unknown)), []);
    let to = client(3).client;
    assert_eq!(
        handle(&mut rig, answer(known)),
        [StackEffect::Answer { id: known, to, refused: refused.clone() }]
    );
    assert_eq!(handle(&mut rig, answer(known)), [], "once");
}

#[test]
fn calls_and_notices_are_passed_on() {
    let mut rig = Rig::new();
    let call = ActionCallId(Uuid::from_u128(62));
    let request = || ActionRequest { action: "photo".to_owned(), parameters: Parameters::new() };
    let (run, task) = (RUN, TaskId(Uuid::from_u128(63)));
    let called = StackEffect::CallAction { call, action: "photo".to_owned(), parameters: "{}".to_owned() };
    let wanted = MissionEffect::CallAction { call, run, task, request: request() };
    assert_eq!(handle(&mut rig, wanted), std::slice::from_ref(&called));
    assert_eq!(handle(&mut rig, MissionEffect::CallRouteAction { call, request: request() }), [called]);
    assert_eq!(handle(&mut rig, MissionEffect::CancelAction(call)), [StackEffect::CancelAction(call)]);
    // Of a route that is not under way.
    let refused = MissionEffect::RefuseRouteAction { call, reason: "It may have been done.".to_owned() };
    assert_eq!(handle(&mut rig, refused), []);
    let effects = handle(&mut rig, MissionEffect::Notice(MissionNotice::PlanKept(RUN)));
    let [StackEffect::Publish(Publication::Notice(Notice { severity, .. }))] = effects[..] else {
        panic!("{effects:?}")
    };
    assert_eq!(severity, Severity::Info);
}

#[test]
fn the_runner_hears_of_its_last_commit_that_is_durable() {
    let mut rig = Rig::new();
    rig.running().missions.commits.extend([(15, 100), (17, 101), (19, 102)]);
    let (at, mut effects) = (rig.at, Vec::new());
    rig.running().missions_committed(at, 14, &mut effects);
    assert_eq!(rig.running().missions.commits.len(), 3);
    rig.running().missions_committed(at, 18, &mut effects);
    assert_eq!(rig.running().missions.commits, [(19, 102)]);
}

#[test]
fn commands_are_answered_once_their_commits_are_durable_and_one_message_settles_several() {
    let mut rig = Rig::new();
    let [first, second] = [70, 71].map(|number| MissionId(Uuid::from_u128(number)));
    rig.give_objects(vec![mission(first), mission(second)]);
    for (number, mission) in [(72, first), (73, second)] {
        let run = RunId(Uuid::from_u128(number));
        let start = MissionCommandKind::Start { run, mission, mode: StartMode::Queue };
        assert_eq!(rig.command(1, CommandKind::Mission(start)), None);
    }
    let is_accepted = |effect: &StackEffect| matches!(effect, StackEffect::Answer { refused: None, .. });
    assert_eq!(count(&rig, is_accepted), 0, "nothing is durable yet");
    rig.commit_all();
    assert_eq!(count(&rig, is_accepted), 2);
}

#[test]
fn runs_of_earlier_programs_are_restored_with_the_site() {
    let mut rig = Rig::booted();
    let queued = MissionEventKind::RunQueued {
        run: RUN,
        mission: MISSION,
        cause: RunCause::Command(CommandId(Uuid::nil())),
        priority: 0,
    };
    let event = MissionEvent { utc: None, command: None, kind: queued };
    rig.step(Input::MissionsRestored(vec![event]));
    rig.give_objects(vec![mission(MISSION)]);
    let queue = rig.running().missions.runner.as_ref().map(|runner| runner.records().queue());
    assert_eq!(queue, Some(vec![RUN]));
}

#[test]
fn the_runner_knows_the_calendar_time() {
    let mut rig = Rig::new();
    let settings =
        site_model::SiteSettings { name: "Plant".to_owned(), time_zone: "UTC".to_owned(), map: None };
    rig.give_objects(vec![Object::Settings(settings)]);
    let time_of_day =
        |rig: &mut Rig| rig.running().missions.runner.as_ref().and_then(|runner| runner.time_of_day());
    assert_eq!(time_of_day(&mut rig), None);
    rig.step(Input::WallClock { utc_ns: 7 * 3_600_000_000_000, synchronised: true });
    assert_eq!(time_of_day(&mut rig), Some(site_model::LocalTime { hour: 7, minute: 0 }));
}

#[test]
fn a_robot_that_is_charged_at_a_dock_is_in_it() {
    let mut rig = Rig::new();
    let id = site_model::DockId(Uuid::from_u128(80));
    let dock = site_model::Dock { id, name: "East".to_owned(), node: node_id(1), approach: node_id(2) };
    rig.give_objects(vec![Object::Dock(dock)]);
    rig.running().missions.map_from_base = Some(vocab::Pose::IDENTITY);
    for (charging, docked) in [(false, None), (true, Some(id))] {
        let (at, mut effects) = (rig.at, Vec::new());
        let battery =
            messages::BatteryState { stamp: at, charge: 0.5, voltage_v: 50.0, current_a: 0.0, charging };
        rig.running().mission_battery(at, battery, &mut effects);
        assert_eq!(rig.running().missions.docked(), docked);
    }
}

#[test]
fn the_place_on_the_graph_is_looked_for_now_and_then() {
    let mut rig = Rig::new();
    let period = rig.running().missions.config.place_period;
    rig.run(1.0);
    let Some(looked) = rig.running().missions.looked_at else { panic!("it was not looked for") };
    rig.at = looked + period - Span::from_millis(1);
    rig.step(Input::Tick);
    assert_eq!(rig.running().missions.looked_at, Some(looked));
    rig.at = looked + period;
    rig.step(Input::Tick);
    assert_eq!(rig.running().missions.looked_at, Some(looked + period));
}

#[test]
fn people_are_told_once_of_a_run_that_waits_for_localisation() {
    let mut rig = Rig::new();
    rig.give_objects(vec![mission(MISSION)]);
    let is_told = |effect: &StackEffect| matches!(effect, StackEffect::Publish(Publication::Notice(notice)) if notice.text == texts::RUN_WAITS_FOR_PLACE);
    rig.run(1.0);
    assert_eq!(count(&rig, is_told), 0, "no run waits");
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Queue };
    rig.command(1, CommandKind::Mission(start));
    rig.commit_all();
    rig.run(3.0);
    assert_eq!(count(&rig, is_told), 1, "{:?}", rig.effects);
}

#[test]
fn the_state_of_missions_is_published_when_it_changes() {
    let is_status = |effect: &StackEffect| matches!(effect, StackEffect::Publish(Publication::Missions(_)));
    let mut rig = Rig::new();
    rig.run(1.0);
    assert_eq!(count(&rig, is_status), 1);
    rig.step(registered());
    rig.run(1.0);
    assert_eq!(count(&rig, is_status), 1, "the state is the same");
}

#[test]
fn a_run_keeps_the_account_that_asked_for_it() {
    let mut rig = Rig::new();
    rig.give_objects(vec![mission(MISSION)]);
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Queue };
    let id = CommandId(Uuid::from_u128(90));
    let by = Principal { account: Some("anna".to_owned()), ..client(1) };
    rig.step(Input::Command(Command { id, by, kind: CommandKind::Mission(start) }));
    let expected = RunCause::Account { command: id, account: "anna".to_owned() };
    let queued = rig.ledger_events().find_map(|event| match event {
        LedgerEvent::Mission(MissionEvent { kind: MissionEventKind::RunQueued { cause, .. }, .. }) => {
            Some(cause.clone())
        }
        _ => None,
    });
    assert_eq!(queued, Some(expected));
}

/// The run as it is written when it begins.
fn plan(rig: &Rig) -> Option<&RunPlan> {
    rig.ledger_events().find_map(|event| match event {
        LedgerEvent::Mission(MissionEvent { kind: MissionEventKind::RunBegan { plan, .. }, .. }) => {
            Some(plan)
        }
        _ => None,
    })
}

/// A mission with a photo at node 2, on a robot that stands at node 1 with a pose in the map. All that the run waits for becomes durable.
fn begin_run(rig: &mut Rig, edge: Edge) {
    let Object::Mission(mission) = mission(MISSION) else { panic!("another object") };
    let request = Some(photo());
    let tasks = mission.tasks.into_iter();
    let tasks = tasks
        .map(|task| Task { place: TaskPlace::Node { node: node_id(2), request: request.clone() }, ..task });
    let mission = Mission { tasks: tasks.collect(), ..mission };
    rig.give_objects(vec![Object::Edge(edge), Object::Mission(mission)]);
    rig.look_at_place(Some(Pose::IDENTITY));
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Queue };
    assert_eq!(rig.command(1, CommandKind::Mission(start)), None);
    while rig.commit_all() {}
}

fn photo() -> ActionRequest {
    ActionRequest { action: "photo".to_owned(), parameters: Parameters::new() }
}

fn walk_ahead() -> Edge {
    Edge::walk(AHEAD, node_id(1), node_id(2))
}

#[test]
fn actions_that_are_registered_after_the_site_are_those_of_the_next_run() {
    for is_registered in [false, true] {
        let mut rig = Rig::new();
        if is_registered {
            rig.step(registered());
        }
        begin_run(&mut rig, walk_ahead());
        let Some(plan) = plan(&rig) else { panic!("the run has not begun: {:?}", rig.effects) };
        assert_eq!(plan.tasks.iter().map(|task| task.is_idempotent).collect::<Vec<_>>(), [is_registered]);
    }
}

#[test]
fn the_place_on_the_graph_follows_the_pose() {
    let mut rig = Rig::new();
    for (x, node) in [(0.0, 1), (10.0, 2)] {
        rig.look_at_place(Some(Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::IDENTITY }));
        assert_eq!(rig.running().missions.place().at, Some(node_id(node)));
    }
}

#[test]
fn zones_hold_while_the_pose_in_the_map_is_known() {
    for (map_from_base, is_kept_out) in [(None, false), (Some(Pose::IDENTITY), true)] {
        let mut rig = Rig::new();
        rig.give_objects(vec![Object::Zone(Zone {
            id: ZoneId(Uuid::from_u128(81)),
            name: "Pit".to_owned(),
            corners_m: vec![[4.0, -1.0], [6.0, -1.0], [6.0, 1.0], [4.0, 1.0]],
            height_m: None,
            effect: ZoneEffect::KeepOut,
            daily: None,
        })]);
        rig.look_at_place(map_from_base);
        assert_eq!(rig.begin(1, GoalKind::GoToNode(node_id(2))), Ok(()));
        let map = rig.running().executive.surroundings().elevation_map();
        assert_eq!(map.zones().is_kept_out([5.0, 0.0]), is_kept_out);
    }
}

#[test]
fn a_route_waits_while_the_robot_searches_for_its_pose() {
    let mut rig = Rig::new();
    rig.see_floor();
    rig.look_at_place(Some(Pose::IDENTITY));
    assert_eq!(rig.begin(1, GoalKind::GoToNode(node_id(2))), Ok(()));
    let leg = rig.running().executive.leg();
    assert!(leg.is_some());
    let notify = |rig: &mut Rig, event| {
        let (at, mut effects) = (rig.at, Vec::new());
        let running = rig.running();
        let situation = Situation { is_in_saved_map: true, ..running.situation(running.frames(None)) };
        running.executive.handle_event(at, event, &situation, &mut effects);
    };
    notify(&mut rig, ExecutiveEvent::PoseLost);
    assert!(rig.running().executive.is_recovering());
    rig.give_objects(vec![Object::Edge(Edge { is_enabled: false, ..walk_ahead() })]);
    rig.look_at_place(None);
    assert_eq!(rig.running().executive.leg(), leg, "the route has not seen that its edge is closed");
    notify(&mut rig, ExecutiveEvent::PoseFound);
    rig.look_at_place(Some(Pose::IDENTITY));
    assert_eq!(rig.running().executive.leg(), None);
}

#[test]
fn a_result_says_whether_the_pose_was_known() {
    for is_localised in [false, true] {
        let mut rig = Rig::new();
        begin_run(&mut rig, walk_ahead());
        rig.look_at_place(is_localised.then_some(Pose::IDENTITY));
        let step = TaskStep::Succeeded { result: Some("{}".to_owned()) };
        let task = TaskId(Uuid::from_u128(52));
        let kind = MissionEventKind::Task { run: RUN, task, attempt: 1, step };
        let events = vec![MissionEvent { utc: None, command: None, kind }];
        let effects = handle(&mut rig, MissionEffect::Commit { number: 99, events });
        let Some(StackEffect::Commit { events, .. }) = effects.first() else { panic!("{effects:?}") };
        let body = events.iter().find_map(|event| match event {
            LedgerEvent::Result(result) => Some(&result.body),
            _ => None,
        });
        let Some(body) = body else { panic!("no result: {events:?}") };
        assert!(body.contains(&format!(r#""is_localised":{is_localised}"#)), "{body}");
    }
}

/// How actions on the way of the run ended, as they are written.
fn ends_of_route_actions(rig: &Rig) -> Vec<&RouteActionEnd> {
    let ends = rig.ledger_events().filter_map(|event| match event {
        LedgerEvent::Mission(MissionEvent { kind: MissionEventKind::RouteAction { step, .. }, .. }) => {
            Some(step)
        }
        _ => None,
    });
    let ends = ends.filter_map(|step| match step {
        RouteActionStep::Ended(end) => Some(end),
        RouteActionStep::Began { .. } => None,
    });
    ends.collect()
}

/// A run whose way begins with an action, which is called.
fn with_route_action() -> (Rig, ActionCallId) {
    let mut rig = Rig::new();
    rig.see_floor();
    begin_run(&mut rig, Edge { on_enter: vec![photo()], ..walk_ahead() });
    let calls = rig.running().missions.calls.keys().copied().collect::<Vec<_>>();
    let [call] = calls[..] else { panic!("{calls:?} {:?}", rig.effects) };
    assert!(ends_of_route_actions(&rig).is_empty());
    (rig, call)
}

#[test]
fn the_end_of_an_action_on_the_way_of_a_run_is_written() {
    let (mut rig, call) = with_route_action();
    let result = "{}".to_owned();
    rig.step(Input::ActionDone { call, outcome: ActionOutcome::Succeeded { result: result.clone() } });
    assert_eq!(ends_of_route_actions(&rig), [&RouteActionEnd::Succeeded { result: Some(result) }]);
}

#[test]
fn an_action_on_the_way_that_is_cancelled_while_the_body_turns_has_ended() {
    let (mut rig, call) = with_route_action();
    rig.step(Input::ActionDone { call, outcome: ActionOutcome::NeedsTurn { turn_rad: 0.4 } });
    let (at, mut effects) = (rig.at, Vec::new());
    rig.running().cancel_action(at, call, &mut effects);
    rig.step(Input::Tick);
    assert_eq!(ends_of_route_actions(&rig), [&RouteActionEnd::Cancelled]);
}
