//! Messages about the site: an object of every kind, with a value in every field that may be empty.

use super::{AT, CLIENT, COMMAND, NOW, SECOND, name, pose};
use api::*;
use site_model::*;
use std::collections::BTreeMap;
use uuid::Uuid;
use vocab::{BlobHash, GoalId, KeyframeId, MapId, Stamp};

const ID: Uuid = Uuid::from_u128(20);
const OTHER: Uuid = Uuid::from_u128(21);
pub const EDIT: EditId = EditId(Uuid::from_u128(22));
const RUN: RunId = RunId(Uuid::from_u128(23));
const TASK: TaskId = TaskId(Uuid::from_u128(24));
pub const NODE: NodeId = NodeId(ID);
pub const DOCK: DockId = DockId(ID);

fn request() -> ActionRequest {
    let nested = Parameters::from([("width".to_owned(), Parameter::Integer(640))]);
    let parameters = [
        ("zoom".to_owned(), Parameter::Number(1.5)),
        ("flash".to_owned(), Parameter::Bool(true)),
        ("views".to_owned(), Parameter::List(vec![Parameter::Text("front".to_owned())])),
        ("size".to_owned(), Parameter::Map(nested)),
    ];
    ActionRequest { action: "photo".to_owned(), parameters: parameters.into() }
}

fn node(kind: NodeKind) -> Object {
    Object::Node(Node {
        id: NodeId(ID),
        name: name(),
        kind,
        map_from_node: pose(),
        anchor: Some(Anchor { keyframe: KeyframeId(3), keyframe_from_node: pose() }),
        tolerance: PoseTolerance::default(),
        influence_area_m: vec![[1.0, 2.0]],
        floor: -1,
        tags: [name()].into(),
        properties: BTreeMap::from([(name(), name())]),
    })
}

fn edge(traversal: Traversal, cost: EdgeCost, direction: TravelDirection) -> Object {
    Object::Edge(Edge {
        id: EdgeId(ID),
        from: NodeId(ID),
        to: NodeId(OTHER),
        traversal,
        cost,
        max_speed_m_s: Some(0.5),
        corridor: Corridor::default(),
        direction,
        on_enter: vec![request()],
        during: vec![request()],
        on_leave: vec![request()],
        fail_policy: vec![
            EdgeFailStep::Retry(2),
            EdgeFailStep::Wait(SECOND),
            EdgeFailStep::Replan,
            EdgeFailStep::Fail,
        ],
        mutex_group: Some(name()),
        is_enabled: true,
    })
}

fn zone(effect: ZoneEffect) -> Object {
    let time = |hour| LocalTime { hour, minute: 30 };
    Object::Zone(Zone {
        id: ZoneId(ID),
        name: name(),
        corners_m: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        height_m: Some([0.0, 2.0]),
        effect,
        daily: Some([time(22), time(6)]),
    })
}

fn mission(order: TaskOrder, end: MissionEnd) -> Object {
    let policy = |then| FailurePolicy { retries: 2, then };
    let ask = |default| FailureStep::Ask { time_limit: SECOND, default };
    let task = |place, on_unreachable, on_action_failure| Task {
        id: TaskId(ID),
        place,
        on_unreachable: policy(on_unreachable),
        on_action_failure: policy(on_action_failure),
    };
    let point = TaskPlace::InspectionPoint(InspectionPointId(ID));
    let node = TaskPlace::Node { node: NodeId(ID), request: Some(request()) };
    let tasks = vec![
        task(point.clone(), FailureStep::Skip, FailureStep::TryLater),
        task(node, FailureStep::EndAtDock, FailureStep::EndHere),
        task(point.clone(), ask(AskDefault::Skip), ask(AskDefault::EndAtDock)),
        task(point, ask(AskDefault::EndHere), FailureStep::Skip),
        task(TaskPlace::ByAction { request: request() }, FailureStep::Skip, FailureStep::Skip),
    ];
    let order_constraints = vec![[TaskId(ID), TaskId(OTHER)]];
    Object::Mission(Mission { id: MissionId(ID), name: name(), tasks, order, order_constraints, end })
}

fn schedule(recurrence: Recurrence, missed: MissedSlots, overlap: OverlapPolicy) -> Object {
    Object::Schedule(Schedule {
        id: ScheduleId(ID),
        name: name(),
        mission: MissionId(ID),
        recurrence,
        is_paused: true,
        skipped: vec![local()],
        grace: SECOND,
        missed,
        overlap,
        priority: -2,
    })
}

fn local() -> LocalDateTime {
    let date = LocalDate { year: 2026, month: 11, day: 24 };
    LocalDateTime { date, time: LocalTime { hour: 11, minute: 0 } }
}

fn monitor(condition: MonitorCondition, response: MonitorResponse) -> Object {
    Object::Monitor(Monitor {
        id: MonitorId(ID),
        name: name(),
        signal: "battery.charge".to_owned(),
        condition,
        hold: SECOND,
        response,
        is_enabled: true,
    })
}

fn place() -> OrientedBox {
    OrientedBox { centre_m: AT, size_m: [1.0, 0.5, 0.75], yaw_rad: 0.25 }
}

fn scene_change(kind: SceneChangeKind, before: EarlierVisit, review: ReviewState) -> Object {
    let cloud = BlobHash([7; 32]);
    Object::SceneChange(SceneChange {
        id: SceneChangeId(ID),
        map: MapId(ID),
        kind,
        place: place(),
        points: 150,
        confidence: 0.75,
        before,
        after: RUN,
        first_seen: Utc(5),
        last_seen: Utc(6),
        times_seen: 2,
        review,
        comment: name(),
        clouds: Some(SceneChangeClouds { object: cloud, changed: cloud, unchanged: cloud }),
        physical_object: Some(PhysicalObject { id: PhysicalObjectId(ID), probability: 0.75 }),
        descriptor: Some(ShapeDescriptor { name: name(), values: vec![7, -7] }),
    })
}

fn alert(severity: AlertSeverity, state: AlertState, cause: AlertCause) -> Object {
    Object::Alert(Alert {
        id: AlertId(ID),
        severity,
        state,
        cause,
        owner: name(),
        work_order: name(),
        comment: name(),
        first_raised: Utc(5),
        last_raised: Utc(6),
        times_raised: 2,
        recovered: Some(Utc(7)),
    })
}

fn alerts() -> Vec<Object> {
    let point = InspectionPointId(ID);
    let reading = |outside| OutsideReading { name: name(), value: 5.5, unit: "bar".to_owned(), outside };
    let outside =
        |outside| AlertCause::OutsideLimits { point, run: RUN, result: 9, reading: reading(outside) };
    let acknowledged = AlertState::Acknowledged { by: name(), at: Utc(8) };
    let closed = AlertState::Closed { by: name(), at: Utc(9), remark: name() };
    let not_read = AlertCause::GaugeNotRead { point, run: RUN, result: 9, reason: name() };
    let failed =
        AlertCause::TaskFailed { mission: Some(MissionId(ID)), task: TASK, run: RUN, reason: name() };
    vec![
        alert(AlertSeverity::Warning, AlertState::Open, outside(OutsideLimits::Above(5.0))),
        alert(AlertSeverity::Critical, acknowledged.clone(), outside(OutsideLimits::Below(6.0))),
        alert(AlertSeverity::Information, closed, not_read),
        alert(AlertSeverity::Warning, acknowledged.clone(), failed),
        alert(AlertSeverity::Warning, AlertState::Open, AlertCause::SceneChange(SceneChangeId(ID))),
        alert(AlertSeverity::Warning, acknowledged, AlertCause::ByHand { point: Some(point) }),
    ]
}

fn objects() -> Vec<Object> {
    let (date, time) = (local().date, local().time);
    let interrupt = |afterwards| MonitorResponse::Interrupt { mission: MissionId(ID), afterwards };
    let weekly = Recurrence::Weekly {
        days: [Weekday::Monday, Weekday::Sunday].into(),
        times: vec![time],
        first_day: date,
        last_day: Some(date),
    };
    let below = MonitorCondition::Below { threshold: 0.2, release: 0.3 };
    let above = MonitorCondition::Above { threshold: 60.0, release: 50.0 };
    let mut objects = vec![
        Object::Settings(SiteSettings {
            name: name(),
            time_zone: "Europe/London".to_owned(),
            map: Some(MapId(ID)),
        }),
        node(NodeKind::Waypoint),
        node(NodeKind::Safe),
        edge(Traversal::Walk, EdgeCost::Length, TravelDirection::Forward),
        edge(Traversal::Stairs, EdgeCost::Fixed(7.5), TravelDirection::Backward),
        edge(
            Traversal::Action { name: name(), parameters: request().parameters },
            EdgeCost::Learned,
            TravelDirection::Any,
        ),
        Object::EdgeBlock(EdgeBlock { edge: EdgeId(ID), until: NOW, failures: 2, reason: name() }),
        zone(ZoneEffect::KeepOut),
        zone(ZoneEffect::SpeedLimit(0.5)),
        zone(ZoneEffect::Penalty(2.0)),
        zone(ZoneEffect::Action(request())),
        Object::Dock(Dock { id: DockId(ID), name: name(), node: NodeId(ID), approach: NodeId(OTHER) }),
        Object::MutexHold(MutexHold { id: MutexHoldId(ID), group: name(), holder: name() }),
        scene_change(SceneChangeKind::Appeared, EarlierVisit::Map(MapId(ID)), ReviewState::New),
        scene_change(SceneChangeKind::Removed, EarlierVisit::Run(RUN), ReviewState::Acknowledged),
        scene_change(
            SceneChangeKind::Moved { from: place() },
            EarlierVisit::Run(RUN),
            ReviewState::Dismissed { reason: name() },
        ),
        scene_change(SceneChangeKind::Appeared, EarlierVisit::Run(RUN), ReviewState::Watched),
        scene_change(
            SceneChangeKind::Appeared,
            EarlierVisit::Run(RUN),
            ReviewState::Normal { map: MapId(ID) },
        ),
        Object::Asset(Asset { id: AssetId(ID), name: name(), tags: [name()].into() }),
        Object::InspectionPoint(InspectionPoint {
            id: InspectionPointId(ID),
            name: name(),
            asset: Some(AssetId(ID)),
            node: NodeId(ID),
            target_m: AT,
            request: request(),
            limits: Some(ReadingLimits { min: Some(3.8), max: Some(5.0), unit: "bar".to_owned() }),
            gauge: Some(GaugeDial {
                picture: BlobHash([7; 32]),
                size_px: [640, 480],
                centre_px: [320.0, 240.0],
                start_px: [270.0, 290.0],
                middle_px: Some([320.0, 170.0]),
                end_px: Some([370.0, 290.0]),
                direction: DialDirection::Counterclockwise,
                range: [0.0, 6.0],
                unit: "bar".to_owned(),
            }),
        }),
        mission(TaskOrder::AsListed, MissionEnd::NearestDock),
        mission(TaskOrder::Shortest { keep_first: true, keep_last: false }, MissionEnd::Node(NodeId(ID))),
        mission(TaskOrder::AsListed, MissionEnd::Stay),
        schedule(Recurrence::Once(local()), MissedSlots::Skip, OverlapPolicy::Skip),
        schedule(weekly, MissedSlots::RunOnce, OverlapPolicy::Queue),
        schedule(
            Recurrence::Every { first: local(), interval: SECOND },
            MissedSlots::RunAll,
            OverlapPolicy::Replace,
        ),
        schedule(
            Recurrence::Rule { first: local(), rule: "FREQ=DAILY".to_owned() },
            MissedSlots::Skip,
            OverlapPolicy::Skip,
        ),
        monitor(below, MonitorResponse::BlockMissions),
        monitor(above, interrupt(Resumption::Resume)),
        monitor(MonitorCondition::Silent(SECOND), interrupt(Resumption::Drop)),
        monitor(below, MonitorResponse::Pause),
        monitor(below, MonitorResponse::Notify),
        monitor(below, MonitorResponse::GoToDock { afterwards: Resumption::Resume }),
    ];
    objects.extend(alerts());
    objects
}

/// Every kind of object, put and removed.
pub fn edit() -> Edit {
    let ids = objects().into_iter().map(|object| object.id());
    let removals = ids.map(|object| Change::Remove { base: Revision(300), object });
    let puts = objects().into_iter().map(|object| Change::Put { base: Some(Revision(2)), object });
    let new = Change::Put { base: None, object: node(NodeKind::Dock) };
    Edit { id: EDIT, changes: puts.chain(removals).chain([new]).collect() }
}

pub fn events() -> Vec<Event> {
    let object = ObjectId::Node(NodeId(ID));
    let versioned = |object| Versioned { revision: Revision(2), object };
    let done = |outcome| Event::EditDone(EditDone { id: EDIT, outcome });
    let refused = |refusal| done(EditOutcome::Refused(refusal));
    let change = RevisionChange { object, before: Some(Revision(1)), after: Some(Revision(2)) };
    let errors = vec![
        EditError::Conflict { object, revision: Some(Revision(3)) },
        EditError::ChangedTwice(object),
        EditError::NotFinite(object),
    ];
    vec![
        Event::SitePart(SitePart {
            revision: 300,
            index: 1,
            is_last: true,
            objects: objects().into_iter().map(versioned).collect(),
            removed: vec![(object, Revision(4))],
        }),
        Event::ResultStored(stored_result()),
        Event::SiteChanged(SiteChanged { revision: 300, by: Some(CLIENT), edit: edit() }),
        done(EditOutcome::Applied { revision: 300, changes: vec![change] }),
        refused(EditRefusal::Invalid(errors)),
        refused(EditRefusal::Rejected(name())),
        refused(EditRefusal::Unavailable(name())),
        Event::Missions(missions()),
        Event::Route(RouteStatus {
            at: Some(NODE),
            nearest: Some(NODE),
            on: Some(EdgeId(ID)),
            docked: Some(DOCK),
            route: Some(route(None)),
        }),
    ]
    .into_iter()
    .chain(route_waits().map(|wait| {
        let route = Some(route(Some(wait)));
        Event::Route(RouteStatus { at: None, nearest: None, on: None, docked: None, route })
    }))
    .collect()
}

fn route(waits_for: Option<RouteWait>) -> RouteProgress {
    let edges = vec![EdgeId(ID)];
    RouteProgress { goal: GoalId(ID), target: NODE, edges, remaining_s: 2.5, remaining_m: 1.5, waits_for }
}

/// All that a robot on a route waits for.
fn route_waits() -> impl Iterator<Item = RouteWait> {
    let edge = EdgeId(ID);
    let on_edge = |stage| RouteWait::Action(RouteActionPlace::Edge { edge, stage, index: 1 });
    [
        RouteWait::Place,
        RouteWait::Block { until: NOW },
        RouteWait::Retry { edge, until: NOW },
        RouteWait::Hold { edge, group: name(), holder: name() },
        on_edge(EdgeStage::Enter),
        on_edge(EdgeStage::During),
        on_edge(EdgeStage::Leave),
        RouteWait::Action(RouteActionPlace::Zone(ZoneId(ID))),
        RouteWait::Charge,
    ]
    .into_iter()
}

/// Every command of missions.
pub fn mission_commands() -> impl Iterator<Item = MissionCommandKind> {
    let start = |mode| MissionCommandKind::Start { run: RUN, mission: MissionId(ID), mode };
    let answer = |answer| MissionCommandKind::Answer(RUN, TASK, answer);
    [
        start(StartMode::Now),
        start(StartMode::Queue),
        MissionCommandKind::Pause(RUN),
        MissionCommandKind::Resume(RUN),
        MissionCommandKind::SkipTask(RUN, TASK),
        MissionCommandKind::RedoTask(RUN, TASK),
        MissionCommandKind::Cancel(RUN),
        MissionCommandKind::Abort(RUN),
        answer(QuestionAnswer::TryAgain),
        answer(QuestionAnswer::Skip),
        answer(QuestionAnswer::EndAtDock),
        answer(QuestionAnswer::EndHere),
    ]
    .into_iter()
}

/// Runs with every cause, and tasks with every state and failure.
fn missions() -> MissionStatus {
    let failures = [
        TaskFailure::NotReached(ReachFailure::NoSuchPlace),
        TaskFailure::NotReached(ReachFailure::NoRoute { closed: vec![EdgeId(ID)] }),
        TaskFailure::NotReached(ReachFailure::PathBlocked),
        TaskFailure::NotReached(ReachFailure::PoseNotFound),
        TaskFailure::NotReached(ReachFailure::MapReplaced),
        TaskFailure::NotReached(ReachFailure::NotUndocked),
        TaskFailure::NotReached(ReachFailure::NotDocked),
        TaskFailure::ActionFailed(name()),
        TaskFailure::ActionUnavailable,
        TaskFailure::ActionTimedOut,
        TaskFailure::OutcomeUnknown,
        TaskFailure::RouteActionUnknown(name()),
    ];
    let failures = failures.into_iter().map(Some).chain([None]);
    let tasks = failures.zip(TaskState::ALL.into_iter().cycle()).map(|(failure, state)| TaskStatus {
        task: TASK,
        node: Some(NODE),
        action: Some("photo".to_owned()),
        state,
        attempt: 2,
        failure,
    });
    let tasks: Vec<TaskStatus> = tasks.collect();
    let causes = [
        RunCause::Command(COMMAND),
        RunCause::Schedule { schedule: ScheduleId(ID), slot: local() },
        RunCause::Monitor(MonitorId(ID)),
        RunCause::Account { command: COMMAND, account: "anna".to_owned() },
    ];
    let runs = causes.into_iter().cycle().zip(RunState::ALL).map(|(cause, state)| RunStatus {
        run: RUN,
        mission: MissionId(ID),
        cause,
        state,
        outcome: Some(state),
        began: Some(Utc(5)),
        tasks: tasks.clone(),
        question: Some(TASK),
    });
    MissionStatus {
        runs: runs.collect(),
        ended: vec![EndedRun { run: RUN, mission: MissionId(ID), outcome: RunState::Cancelled }],
        blocked_by: Some(MonitorId(ID)),
        monitors: vec![MonitorId(ID)],
    }
}

pub fn queries() -> impl Iterator<Item = Query> {
    let object = ObjectId::Node(NodeId(ID));
    [
        Query::Revisions { object, before: Some(Revision(3)), limit: 100 },
        Query::Runs { filter: RunFilter::default(), before: Some(RUN), limit: 100 },
        Query::Runs {
            filter: RunFilter {
                mission: Some(MissionId(ID)),
                state: Some(RunState::Failed),
                from: Some(Stamp::from_nanos(5)),
                to: Some(NOW),
            },
            before: None,
            limit: 100,
        },
        Query::Run(RUN),
        Query::Steps { run: RUN, after: Some((3, 1)), limit: 100 },
        Query::Results { run: RUN, after: Some(7), limit: 100 },
        Query::PointResults { point: InspectionPointId(ID), before: Some(7), limit: 1 },
        Query::PictureComparison { before: 3, after: 7 },
        Query::Slots { before: Some((NOW, ScheduleId(ID))), limit: 100 },
        Query::Audit { before: Some(7), containing: "ada".into(), limit: 100 },
    ]
    .into_iter()
}

fn stored_result() -> StoredResult {
    StoredResult {
        number: 7,
        run: RUN,
        step: 3,
        attempt: 1,
        kind: "photo".to_owned(),
        blob: Some([0xab; 32]),
        body: "{}".to_owned(),
        comparison: Some("{}".to_owned()),
        at: Stamp::from_nanos(5),
    }
}

pub fn replies() -> impl Iterator<Item = QueryReply> {
    let at = Stamp::from_nanos(5);
    let revision = StoredRevision {
        revision: Revision(2),
        object: Some(node(NodeKind::Hold)),
        author: Some(name()),
        at,
    };
    let run = StoredRun {
        run: RUN,
        mission: MissionId(ID),
        state: name(),
        is_ended: true,
        body: "{}".to_owned(),
        began: at,
        changed: NOW,
    };
    let step = StoredStep {
        step: 3,
        attempt: 1,
        state: name(),
        body: "{}".to_owned(),
        intended: at,
        done: Some(NOW),
    };
    let slot = StoredSlot {
        schedule: ScheduleId(ID),
        due: NOW,
        run: Some(RUN),
        outcome: name(),
        body: "{}".to_owned(),
    };
    let audit = StoredAudit { number: 7, at, origin: Some(name()), command: name(), outcome: name() };
    [
        QueryReply::Revisions(vec![revision]),
        QueryReply::Runs(vec![run]),
        QueryReply::Steps(vec![step]),
        QueryReply::Results(vec![stored_result()]),
        QueryReply::PictureComparison(Some("{}".to_owned())),
        QueryReply::Slots(vec![slot]),
        QueryReply::Audit(vec![audit]),
    ]
    .into_iter()
}
