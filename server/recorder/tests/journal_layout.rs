//! The bytes of the present journal entries. If this test fails, the layout has changed. Then raise the schema's version, freeze copies of
//! the changed types in `src/legacy.rs`, and write the new bytes with `UPDATE_EXPECT=1`.

#![allow(clippy::unwrap_used, reason = "a test may panic at the first error")]

use expect_test::expect_file;
use messages::{
    ActionOutcome, Approach, BootRecord, Command, CommandKind, GoalKind, Input, JobDone, JobId, JobOwner,
    JobResult, LoopEvidence, LoopRejection, LoopSource, LoopTask, MapQuality, PlaceComparison,
    PoseCorrection, PoseGoal, PoseInMap, Principal, RegisteredAction, RobotProfile, SiteSnapshot, StopLatch,
    VerifiedLoop,
};
use site_model::{
    ActionRequest, Alert, AlertCause, AlertId, AlertSeverity, AlertState, Change, DockId, EarlierVisit,
    EdgeId, EdgeStage, Edit, EditId, FailurePolicy, InspectionPointId, Mission, MissionCommandKind,
    MissionEnd, MissionEvent, MissionEventKind, MissionId, MutexHold, MutexHoldId, NodeId, Object, ObjectId,
    OrientedBox, OutsideLimits, OutsideReading, Parameters, PhysicalObject, PhysicalObjectId, PoseTolerance,
    ReviewState, Revision, RouteActionPlace, RouteActionStep, RunCause, RunId, RunState, SceneChange,
    SceneChangeId, SceneChangeKind, ShapeDescriptor, SiteSettings, Task, TaskId, TaskOrder, TaskPlace, Utc,
    Versioned,
};
use std::fmt::Write;
use uuid::Uuid;
use vocab::{
    Aabb, ActionCallId, ClientId, CommandId, GoalId, KeyframeId, MapId, Pose, SessionId, Span, Twist, Vec3,
};

fn id(number: u128) -> Uuid {
    Uuid::from_u128(number)
}

/// Every kind of journal entry. Left out are sensor messages, which have topics of their own, and most results that jobs compute.
fn inputs() -> Vec<Input> {
    let map = MapId(id(1));
    let profile = RobotProfile {
        name: "Rex".to_owned(),
        self_filter: Some(Aabb { min: [-0.5; 3], max: [0.5; 3] }),
        ..RobotProfile::default()
    };
    let place = PoseInMap { map, map_from_base: Pose::IDENTITY };
    let docks = vec![place].into();
    let by = Principal { account: Some("ada".to_owned()), ..Principal::operator(ClientId(id(7))) };
    let stop_latch = Some(StopLatch { by: Some(by.clone()) });
    let boot = BootRecord { profile, last_pose: Some(place), docks, stop_latch, ..BootRecord::default() };
    let (from, to) = (KeyframeId(3), KeyframeId(300));
    let pose_goal = PoseGoal {
        map_from_goal: Pose::IDENTITY,
        tolerance: Some(PoseTolerance::default()),
        max_speed_m_s: Some(0.5),
        approach: Approach::Straight,
    };
    let run = RunId(id(11));
    let kinds = [
        CommandKind::TakeControl { name: "Ada".to_owned() },
        CommandKind::ReleaseControl,
        CommandKind::StartMapping(SessionId(id(2))),
        CommandKind::FinishMapping { map, name: "Hall".to_owned() },
        CommandKind::DiscardMapping,
        CommandKind::Teleoperate(Twist { linear: Vec3::new(0.5, 0.0, 0.0), ..Twist::default() }),
        CommandKind::StartGoal { goal: GoalId(id(4)), kind: GoalKind::WalkTo(Vec3::new(1.0, 2.0, 0.0)) },
        CommandKind::StartGoal { goal: GoalId(id(5)), kind: GoalKind::Relocalise },
        CommandKind::CancelGoal(GoalId(id(4))),
        CommandKind::StopMotion,
        CommandKind::AllowMotion,
        CommandKind::AcceptLoop { from, to },
        CommandKind::RejectLoop { from, to },
        CommandKind::ProposeLoop { from, to, guess: Pose::IDENTITY },
        CommandKind::ExtendMap { session: SessionId(id(2)), map },
        CommandKind::Localise { map, at: None },
        CommandKind::LeaveMap,
        CommandKind::StartGoal { goal: GoalId(id(4)), kind: GoalKind::WalkToPose(pose_goal) },
        CommandKind::StartGoal { goal: GoalId(id(4)), kind: GoalKind::GoToNode(NodeId(id(9))) },
        CommandKind::StartGoal { goal: GoalId(id(4)), kind: GoalKind::GoToDock(DockId(id(10))) },
        CommandKind::StartGoal { goal: GoalId(id(4)), kind: GoalKind::Undock },
        CommandKind::Mission(MissionCommandKind::Pause(run)),
    ];
    let command = |kind| Input::Command(Command { id: CommandId(id(6)), by: by.clone(), kind });
    let call = ActionCallId(id(8));
    let quality = MapQuality { revision: 7, covered_m2: 1.0, ..MapQuality::default() };
    let source = LoopSource::Appearance(0.25);
    let task = LoopTask { session: SessionId(id(2)), from, to, source, guess: Pose::IDENTITY };
    let evidence = LoopEvidence {
        residual_m: 0.5,
        degenerate_directions: 2,
        correction: PoseCorrection { distance_m: 0.75, rotation_rad: 0.125 },
        mahalanobis_squared: Some(4.0),
        ..LoopEvidence::default()
    };
    let verified = VerifiedLoop {
        task,
        from_from_to: Pose::IDENTITY,
        information: [[0.0; 6]; 6],
        evidence,
        rejection: Some(LoopRejection::Residual),
    };
    let compared = PlaceComparison::Loop(Box::new(verified));
    let failed = ActionOutcome::Failed { reason: "no".to_owned() };
    let node = ObjectId::Node(NodeId(id(9)));
    let settings = Object::Settings(SiteSettings {
        name: "Hall".to_owned(),
        time_zone: "Europe/London".to_owned(),
        map: Some(map),
    });
    let settings = Versioned { revision: Revision(2), object: settings };
    let edit = Edit {
        id: EditId(id(12)),
        changes: vec![Change::Remove { base: Revision(2), object: ObjectId::Settings }],
    };
    let held = MutexHold { id: MutexHoldId(id(14)), group: "Lift".to_owned(), holder: "Forklift".to_owned() };
    let hold = Change::Put { base: None, object: Object::MutexHold(held) };
    let moved_box =
        OrientedBox { centre_m: Vec3::new(1.0, 2.0, 0.5), size_m: [1.0, 0.5, 0.25], yaw_rad: 0.5 };
    let scene_change = SceneChange {
        id: SceneChangeId(id(16)),
        map,
        kind: SceneChangeKind::Moved { from: moved_box },
        place: moved_box,
        points: 150,
        confidence: 0.75,
        before: EarlierVisit::Map(map),
        after: run,
        first_seen: Utc(5),
        last_seen: Utc(6),
        times_seen: 2,
        review: ReviewState::Dismissed { reason: "ours".to_owned() },
        comment: "why".to_owned(),
        clouds: None,
        physical_object: Some(PhysicalObject { id: PhysicalObjectId(id(17)), probability: 0.75 }),
        descriptor: Some(ShapeDescriptor { name: "geometric-1".to_owned(), values: vec![1, -2] }),
    };
    let found = Change::Put { base: None, object: Object::SceneChange(scene_change) };
    let outside = OutsideReading {
        name: "gauge".to_owned(),
        value: 5.5,
        unit: "bar".to_owned(),
        outside: OutsideLimits::Above(5.0),
    };
    let point = InspectionPointId(id(22));
    let alert = Alert {
        id: AlertId(id(23)),
        severity: AlertSeverity::Critical,
        state: AlertState::Closed { by: "Ada".to_owned(), at: Utc(7), remark: "new valve".to_owned() },
        cause: AlertCause::OutsideLimits { point, run, result: 9, reading: outside },
        owner: "Ada".to_owned(),
        work_order: "Replace it.".to_owned(),
        comment: "why".to_owned(),
        first_raised: Utc(5),
        last_raised: Utc(6),
        times_raised: 2,
        recovered: None,
    };
    let raised = Change::Put { base: None, object: Object::Alert(alert) };
    let request = ActionRequest { action: "dock".to_owned(), parameters: Parameters::new() };
    let task_of_dock = Task {
        id: TaskId(id(20)),
        place: TaskPlace::ByAction { request },
        on_unreachable: FailurePolicy::default(),
        on_action_failure: FailurePolicy::default(),
    };
    let mission = Mission {
        id: MissionId(id(19)),
        name: "Round".to_owned(),
        tasks: vec![task_of_dock],
        order: TaskOrder::default(),
        order_constraints: Vec::new(),
        end: MissionEnd::default(),
    };
    let docking = Change::Put { base: None, object: Object::Mission(mission) };
    let place = RouteActionPlace::Edge { edge: EdgeId(id(15)), stage: EdgeStage::Enter, index: 0 };
    let request = ActionRequest { action: "open".to_owned(), parameters: Parameters::new() };
    let step = RouteActionStep::Began { place, request, is_idempotent: false, task: None };
    let route_action = MissionEventKind::RouteAction { run, call, step };
    let cause = RunCause::Account { command: CommandId(id(22)), account: "anna".to_owned() };
    let asked =
        MissionEventKind::RunQueued { run: RunId(id(23)), mission: MissionId(id(24)), cause, priority: 2 };
    let ended = MissionEventKind::RunEnded { run, outcome: RunState::Succeeded };
    let photo = RegisteredAction {
        name: "photo".to_owned(),
        is_idempotent: true,
        expected: Span::from_millis(2_000),
    };
    let others = [
        Input::JobDone(JobDone { number: 300, result: JobResult::MapSaving(Ok(map)) }),
        Input::JobDone(JobId { owner: JobOwner::LoopClosing, number: 301 }.failed("why")),
        Input::JobDone(JobDone { number: 3, result: JobResult::Relinearisation(Ok(vec![Pose::IDENTITY])) }),
        Input::JobDone(JobDone { number: 4, result: JobResult::MapQuality(Ok(quality)) }),
        Input::JobDone(JobId { owner: JobOwner::Disambiguation, number: 5 }.not_done()),
        Input::WallClock { utc_ns: 1_700_000_000_000_000_000, synchronised: true },
        Input::Committed { seq: 9 },
        Input::ActionFeedback { call, progress: Some(0.5), text: "half".to_owned() },
        Input::ActionDone { call, outcome: ActionOutcome::Succeeded { result: "{}".to_owned() } },
        Input::ActionDone { call, outcome: failed },
        Input::ActionDone { call, outcome: ActionOutcome::Cancelled },
        Input::ActionDone { call, outcome: ActionOutcome::NeedsTurn { turn_rad: -0.25 } },
        Input::GraphRequested,
        Input::JobDone(JobDone { number: 6, result: JobResult::LoopClosing(Ok(compared)) }),
        Input::Site(Box::new(SiteSnapshot { objects: vec![settings], removed: vec![(node, Revision(3))] })),
        Input::SiteEdited(Box::new(edit)),
        Input::MissionsRestored(vec![MissionEvent { utc: Some(Utc(5)), command: None, kind: ended }]),
        Input::ActionsRegistered(vec![photo]),
        Input::SiteEdited(Box::new(Edit { id: EditId(id(13)), changes: vec![hold] })),
        Input::MissionsRestored(vec![MissionEvent { utc: None, command: None, kind: route_action }]),
        Input::SiteEdited(Box::new(Edit { id: EditId(id(17)), changes: vec![found] })),
        Input::SiteEdited(Box::new(Edit { id: EditId(id(18)), changes: vec![docking] })),
        Input::SiteEdited(Box::new(Edit { id: EditId(id(21)), changes: vec![raised] })),
        Input::MissionsRestored(vec![MissionEvent { utc: None, command: None, kind: asked }]),
    ];
    [Input::Boot(Box::new(boot)), Input::Tick].into_iter().chain(kinds.map(command)).chain(others).collect()
}

#[test]
fn the_bytes_of_journal_entries_are_unchanged() {
    let mut text = format!("{}\n", recorder::topics::INPUT_SCHEMA);
    for input in inputs() {
        let bytes = postcard::to_stdvec(&input).unwrap();
        assert_eq!(postcard::from_bytes::<Input>(&bytes).unwrap(), input);
        for byte in bytes {
            let _ = write!(text, "{byte:02x}");
        }
        text.push('\n');
    }
    expect_file!["journal_layout.txt"].assert_eq(&text);
}
