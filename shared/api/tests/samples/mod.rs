//! At least one message of every kind, with a value in every field that may be empty.

pub mod access;
mod site;

use api::*;
use uuid::Uuid;
use vocab::{
    Aabb, CameraHead, ClientId, CommandId, Covariance6, GoalId, KeyframeId, MapId, Pose, SessionId, Span,
    Stamp, Twist, UploadId, Vec3,
};

const MAP: MapId = MapId(Uuid::from_u128(1));
const OTHER_MAP: MapId = MapId(Uuid::from_u128(2));
const SESSION: SessionId = SessionId(Uuid::from_u128(3));
const GOAL: GoalId = GoalId(Uuid::from_u128(4));
const UPLOAD: UploadId = UploadId(Uuid::from_u128(5));
const CLIENT: ClientId = ClientId(Uuid::from_u128(6));
const COMMAND: CommandId = CommandId(Uuid::from_u128(7));
const AT: Vec3 = Vec3::new(1.0, -2.0, 0.5);
const FROM: KeyframeId = KeyframeId(3);
const TO: KeyframeId = KeyframeId(300);
const NOW: Stamp = Stamp::from_nanos(1_700_000_000_123_456_789);
const SECOND: Span = Span::from_millis(1_000);

fn pose() -> Pose {
    Pose { position: AT, ..Pose::IDENTITY }
}

fn twist() -> Twist {
    Twist { linear: Vec3::new(0.5, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, -0.25) }
}

fn name() -> String {
    "Hall".to_owned()
}

pub fn commands() -> Vec<Command> {
    let fault = |fault| Command::InjectFault(fault);
    vec![
        Command::TakeControl { name: name() },
        Command::ReleaseControl,
        Command::RefuseTakeOver,
        Command::StartMapping(SESSION),
        Command::ExtendMap { session: SESSION, map: MAP },
        Command::FinishMapping { map: MAP, name: name() },
        Command::DiscardMapping,
        Command::Teleoperate(twist()),
        Command::StartGoal { goal: GOAL, kind: GoalKind::WalkTo(AT) },
        Command::StartGoal { goal: GOAL, kind: GoalKind::Relocalise },
        Command::StartGoal { goal: GOAL, kind: GoalKind::GoToNode(site::NODE) },
        Command::StartGoal { goal: GOAL, kind: GoalKind::GoToDock(site::DOCK) },
        Command::StartGoal { goal: GOAL, kind: GoalKind::Undock },
        Command::CancelGoal(GOAL),
        Command::StopMotion,
        Command::AllowMotion,
        Command::AcceptLoop { from: FROM, to: TO },
        Command::RejectLoop { from: FROM, to: TO },
        Command::ProposeLoop { from: FROM, to: TO, guess: pose() },
        Command::Localise { map: MAP, at: Some(pose()) },
        Command::Localise { map: MAP, at: None },
        Command::LeaveMap,
        fault(SimulatedFault::CoverLidar(SECOND)),
        fault(SimulatedFault::SilenceLidar(SECOND)),
        fault(SimulatedFault::SilenceImu(SECOND)),
        fault(SimulatedFault::SlipFeet(SECOND)),
        fault(SimulatedFault::CarryAway),
        fault(SimulatedFault::End),
        Command::ImportMap { upload: UPLOAD, name: name(), frame: Some(MAP) },
        Command::AlignMap {
            upload: UPLOAD,
            name: name(),
            map: MAP,
            onto: OTHER_MAP,
            pairs: vec![[AT, Vec3::default()]],
        },
        Command::CancelImport(UPLOAD),
        Command::SaveInterruptedSession {
            session: SESSION,
            map: MAP,
            name: name(),
            resume_as: Some(SESSION),
        },
        Command::DiscardInterruptedSession(SESSION),
        Command::RenameMap { map: MAP, name: name() },
        Command::DeleteMap(MAP),
        Command::RestoreMap(MAP),
        Command::DeleteMapPermanently(MAP),
        Command::DeleteUpload(UPLOAD),
        Command::GenerateTopomap { map: MAP, edit: site::EDIT },
        Command::MakeExample { upload: UPLOAD, time_zone: name() },
        Command::MakeNormal {
            upload: UPLOAD,
            name: name(),
            changes: vec![site_model::SceneChangeId(Uuid::from_u128(20))],
        },
    ]
    .into_iter()
    .chain(site::mission_commands().map(Command::Mission))
    .collect()
}

fn goals() -> Vec<Goal> {
    let progress = |waits_for| GoalStatus::Running(GoalProgress { remaining_m: Some(2.5), waits_for });
    let failed = |reason, attempt| GoalStatus::Failed { reason, tried: vec![attempt] };
    let cancelled = |cause| GoalStatus::Cancelled { by: CLIENT, cause };
    let statuses = vec![
        GoalStatus::Accepted,
        progress(None),
        progress(Some(WaitReason::Sight)),
        progress(Some(WaitReason::FreePath)),
        progress(Some(WaitReason::Relocalisation)),
        GoalStatus::Succeeded { map_from_base: pose(), duration: SECOND },
        failed(GoalFailure::PathBlocked, GoalAttempt::PlannedPaths(7)),
        failed(GoalFailure::PathBlocked, GoalAttempt::WaitedForPath(SECOND)),
        failed(GoalFailure::PoseNotFound, GoalAttempt::SearchedForPose(SECOND)),
        failed(GoalFailure::MapReplaced, GoalAttempt::ExploredPaths(2)),
        failed(GoalFailure::NoSuchPlace, GoalAttempt::ExploredPaths(2)),
        failed(GoalFailure::NoRoute, GoalAttempt::ExploredPaths(2)),
        failed(GoalFailure::NotDocked, GoalAttempt::ExploredPaths(2)),
        failed(GoalFailure::NotUndocked, GoalAttempt::ExploredPaths(2)),
        cancelled(CancelCause::Requested),
        cancelled(CancelCause::MotionStopped),
        cancelled(CancelCause::DrivenByHand),
        cancelled(CancelCause::Replaced(GOAL)),
    ];
    let goal = |status| Goal { id: GOAL, kind: GoalKind::WalkTo(AT), by: CLIENT, accepted: NOW, status };
    statuses.into_iter().map(goal).collect()
}

fn tile(anchor: TileAnchor) -> TileEntry {
    TileEntry {
        hash: TileHash([0xab; 32]),
        anchor,
        level: 2,
        spacing_m: 0.5,
        bounds: Aabb { min: [-1.0; 3], max: [2.0; 3] },
        points: 1_000,
        bytes: 7_000,
    }
}

fn graph_node() -> GraphNode {
    GraphNode { id: TO, stamp: NOW, map_from_keyframe: pose() }
}

fn executives() -> impl Iterator<Item = Event> {
    let states = [
        ExecutiveState::Stopped,
        ExecutiveState::ManualDriving,
        ExecutiveState::Recovering,
        ExecutiveState::Executing,
        ExecutiveState::Idle,
    ];
    let causes = [
        ExecutiveEvent::Started,
        ExecutiveEvent::StopRequested,
        ExecutiveEvent::MotionAllowed,
        ExecutiveEvent::VelocityCommanded,
        ExecutiveEvent::VelocityTimedOut,
        ExecutiveEvent::LeaseLost,
        ExecutiveEvent::GoalRequested,
        ExecutiveEvent::CancelRequested,
        ExecutiveEvent::BehaviourSucceeded,
        ExecutiveEvent::BehaviourFailed,
        ExecutiveEvent::PoseLost,
        ExecutiveEvent::PoseFound,
        ExecutiveEvent::OdometryRestarted,
        ExecutiveEvent::MapReplaced,
    ];
    let pairs = states.into_iter().cycle().zip(causes);
    pairs.map(|(state, cause)| {
        Event::Executive(ExecutiveStatus { state, since: NOW, cause, goal: Some(GOAL) })
    })
}

fn states() -> Vec<Event> {
    let reasons = [
        DegradationReason::MapMismatch,
        DegradationReason::PoseUncertain,
        DegradationReason::LidarBlind,
        DegradationReason::Unmapped,
        DegradationReason::Unconfirmed,
    ];
    let localised = |degradation| Event::Localisation(Localisation::Localised { map: MAP, degradation });
    let mut events = vec![
        Event::Mapping(Mapping::Idle),
        Event::Mapping(Mapping::Starting { session: SESSION }),
        Event::Mapping(Mapping::Loading { session: SESSION, map: MAP }),
        Event::Mapping(Mapping::Finding { session: SESSION, map: MAP, distance_m: 1.5, ambiguous: true }),
        Event::Mapping(Mapping::Running {
            session: SESSION,
            extends: Some(MAP),
            since: NOW,
            distance_m: 1.5,
            keyframes: 300,
            on_known_ground: true,
        }),
        Event::Mapping(Mapping::Saving { map: MAP }),
        Event::Localisation(Localisation::Idle),
        Event::Localisation(Localisation::Loading { map: MAP }),
        Event::Localisation(Localisation::Relocalising { map: MAP, hypotheses: 4 }),
        localised(None),
        Event::Motion(Motion::Idle),
        Event::Motion(Motion::Stopped { by: Some(CLIENT) }),
        Event::Motion(Motion::Teleoperated),
        Event::Motion(Motion::Walking { goal: AT, path: vec![AT], remaining_m: 2.5 }),
        Event::Motion(Motion::Waiting { goal: AT }),
        Event::Motion(Motion::Relocalising { goal: Some(AT) }),
        Event::Motion(Motion::Blocked { goal: AT, reason: name() }),
    ];
    events.extend(reasons.map(|reason| localised(Some(reason))));
    events
}

fn imports() -> Vec<Event> {
    let running = |stage| Import::Running { upload: UPLOAD, name: name(), stage, share: 0.5 };
    let imports = [
        Import::None,
        running(ImportStage::Reading),
        running(ImportStage::ComputingViewpoints),
        running(ImportStage::Writing),
        running(ImportStage::Walking),
        running(ImportStage::MakingTopomap),
        Import::Done { upload: UPLOAD, map: MAP },
        Import::Failed { upload: UPLOAD, name: name(), reason: name() },
    ];
    imports.map(Event::Import).into()
}

fn loops() -> Event {
    let sources = [LoopSource::Geometry, LoopSource::Appearance(0.25), LoopSource::Person];
    let verdicts = [LoopVerdict::Accepted, LoopVerdict::Held, LoopVerdict::Rejected, LoopVerdict::Dropped];
    let decision = |(verdict, source)| LoopDecision {
        from: FROM,
        to: TO,
        source,
        verdict,
        by_hand: true,
        reason: name(),
        overlap: [0.5, 0.75],
        residual_m: 0.25,
        free_space_violation: [0.125, 0.0],
        runner_up_ratio: 0.5,
        guess: pose(),
        from_from_to: pose(),
    };
    let added = verdicts.into_iter().zip(sources.into_iter().cycle()).map(decision).collect();
    Event::Loops(LoopsChanged { reset: true, added })
}

fn graph_changed() -> GraphChanged {
    GraphChanged {
        session: Some(SESSION),
        base_revision: 7,
        revision: 8,
        nodes: vec![graph_node()],
        edges: vec![(FROM, TO)],
        removed_loops: vec![(TO, FROM)],
        loops: vec![(FROM, TO)],
    }
}

pub fn events() -> Vec<Event> {
    let severities = [Severity::Info, Severity::Warning, Severity::Error];
    let mut events = vec![
        Event::Estimate(Estimate {
            stamp: NOW,
            map_from_base: pose(),
            velocity: twist(),
            covariance: Covariance6::default(),
            degenerate: 1,
            distance_m: 12.5,
        }),
        Event::Graph(Graph {
            session: Some(SESSION),
            revision: 7,
            nodes: vec![graph_node()],
            edges: vec![(FROM, TO)],
            loops: vec![(TO, FROM)],
        }),
        Event::Tiles(TilesChanged {
            reset: true,
            added: vec![tile(TileAnchor::Map), tile(TileAnchor::Keyframe(TO))],
        }),
        Event::Quality(Quality {
            covered_m2: 100.0,
            from_afar_m2: 5.0,
            deviations_m: vec![0.25],
            targets: vec![
                SurveyTarget { at: AT, why: SurveyReason::FromAfar { area_m2: 5.0 } },
                SurveyTarget { at: AT, why: SurveyReason::Uncertain { deviation_m: 0.25 } },
            ],
        }),
        Event::Goals(goals()),
        Event::Control(Control {
            owner: Some(CLIENT),
            name: name(),
            request: Some(ControlRequest { by: CLIENT, name: name(), seconds_left: 5.0 }),
        }),
        Event::Battery(Battery { stamp: NOW, charge: 0.75, left: Some(SECOND), charging: true }),
        Event::Maps(vec![MapSummary {
            id: MAP,
            name: name(),
            created: NOW,
            distance_m: 12.5,
            keyframes: 300,
            points: 1_000,
            bytes: 7_000,
            has_pose_graph: true,
        }]),
        loops(),
        Event::CommandDone { id: COMMAND, outcome: CommandOutcome::Accepted },
        Event::CommandDone { id: COMMAND, outcome: CommandOutcome::Refused(name()) },
        Event::Platform(Platform {
            robot: name(),
            site: Some(name()),
            now: NOW,
            real_time_factor: 1.0,
            cpu_cores: 0.5,
            memory_bytes: 1 << 28,
            disk_free_bytes: 1 << 40,
            core_connected: true,
            clients: 2,
            restarts: [ProcessRole::Core, ProcessRole::Gateway, ProcessRole::SimulatedRobot]
                .map(|process| ProcessRestart { process, cause: name(), count: 3 })
                .into(),
            manual_limits: Some(SpeedLimits { forward_m_s: 1.25, sideways_m_s: 0.5, turn_rad_s: 1.0 }),
            body: Some(RobotBody {
                footprint_radius_m: 0.375,
                clearance_height_m: 0.75,
                standing_height_m: 0.5,
                step_height_m: 0.25,
                camera_head: CameraHead {
                    base_from_head_m: [0.25, 0.0, 0.125],
                    pan_max_rad: 3.0,
                    tilt_min_rad: -0.5,
                    tilt_max_rad: 1.0,
                    zoom_max: 20.0,
                    field_of_view_rad: 1.0,
                },
            }),
            autonomous_limits: Some(SpeedLimits { forward_m_s: 1.0, sideways_m_s: 0.25, turn_rad_s: 0.5 }),
            disk: Some(DiskUse {
                total_bytes: 1 << 41,
                recordings_bytes: 1 << 30,
                max_recordings_bytes: 1 << 35,
            }),
        }),
        Event::Actions(vec![OfferedAction {
            name: name(),
            title: name(),
            parameter_schema: "{}".to_owned(),
            expected: SECOND,
            expected_energy_j: 300,
            is_idempotent: true,
        }]),
        Event::Docks(vec![MapDock { map: MAP, map_from_base: pose() }]),
        Event::GraphChanged(graph_changed()),
        Event::GraphPart(GraphPart {
            index: 1,
            is_last: true,
            graph: Graph {
                session: Some(SESSION),
                revision: 7,
                nodes: vec![graph_node()],
                edges: vec![(FROM, TO)],
                loops: vec![(TO, FROM)],
            },
        }),
        Event::DamagedMaps(vec![DamagedMap { folder: name(), problem: name(), remedy: name() }]),
        Event::BinnedMaps(vec![BinnedMap {
            id: MAP,
            name: name(),
            bytes: 7_000,
            kept_until: Some(NOW),
            time_left: Some(SECOND),
            problem: Some(name()),
        }]),
        Event::Uploads(vec![StoredUpload {
            upload: UPLOAD,
            name: Some(name()),
            frame: Some(MAP),
            bytes: 7_000,
            problem: Some(name()),
            kept_until: Some(NOW),
        }]),
        Event::InterruptedSessions(vec![InterruptedSession {
            session: SESSION,
            at: NOW,
            keyframes: 37,
            distance_m: 12.5,
            extends: Some(MAP),
        }]),
    ];
    events.extend(severities.map(|severity| {
        let finding = Finding { severity, what: name(), remedy: name() };
        let sensor = SensorHealth { name: name(), rate_hz: 10.0, age: SECOND };
        Event::Health(Health { sensors: vec![sensor], findings: vec![finding], points_used: 900 })
    }));
    events.extend(severities.map(|severity| Event::Notice(Notice { at: NOW, severity, text: name() })));
    events.extend(states());
    events.extend(imports());
    events.extend(executives());
    events.extend(topomap_generations());
    events.extend(site::events());
    events
}

fn topomap_generations() -> Vec<Event> {
    let summary = TopomapSummary {
        nodes: 42,
        edges: 96,
        docks: 1,
        floors: 2,
        length_m: 300.5,
        pieces: 1,
        blocked: vec![[AT, AT]],
        kept_nodes: 3,
    };
    let stages = [TopomapStage::Reading, TopomapStage::Generating, TopomapStage::Storing];
    let mut states = vec![
        TopomapGeneration::None,
        TopomapGeneration::Done { map: MAP, edit: site::EDIT, summary },
        TopomapGeneration::Failed { map: MAP, reason: name() },
    ];
    states.extend(stages.map(|stage| TopomapGeneration::Running { map: MAP, stage }));
    states.into_iter().map(Event::TopomapGeneration).collect()
}

pub fn client_messages() -> Vec<ClientMessage> {
    vec![
        ClientMessage::Hello { version: VERSION, lease: LeaseToken(CLIENT.0) },
        ClientMessage::Command { id: COMMAND, command: Command::StopMotion },
        ClientMessage::Ping { token: 300 },
        ClientMessage::RequestGraph,
        ClientMessage::Edit(site::edit()),
        ClientMessage::RequestSite,
    ]
}

pub fn server_messages() -> Vec<ServerMessage> {
    vec![
        ServerMessage::Welcome { version: VERSION, program: name(), you: access::you() },
        ServerMessage::Refused { reason: name() },
        ServerMessage::Event { sequence: 300, event: Event::Motion(Motion::Idle) },
        ServerMessage::Pong { token: 300, now: NOW },
    ]
}

pub fn stream_requests() -> Vec<StreamRequest> {
    vec![StreamRequest::Open { version: VERSION, max_hz: 10.0 }, StreamRequest::Acknowledge { sequence: 300 }]
}

pub fn scan_frame() -> ScanFrame {
    ScanFrame { sequence: 300, stamp: NOW, map_from_base: pose(), points: vec![1, 2, 3] }
}

pub fn core_messages() -> Vec<CoreMessage> {
    let mut messages = vec![
        CoreMessage::Hello { version: VERSION },
        CoreMessage::Event { to: Some(CLIENT), event: Event::Motion(Motion::Idle) },
        CoreMessage::Scan { stamp: NOW, map_from_base: pose(), points: vec![1, 2, 3] },
        CoreMessage::Reply { number: 300, result: Err(name()) },
        CoreMessage::Access(access::state()),
    ];
    let result = |result| CoreMessage::AccountReply { number: 300, result };
    messages.extend(access::results().into_iter().map(result));
    messages.extend(site::replies().map(|reply| CoreMessage::Reply { number: 300, result: Ok(reply) }));
    messages
}

pub fn gateway_messages() -> Vec<GatewayMessage> {
    let mut messages = vec![
        GatewayMessage::Hello { version: VERSION },
        GatewayMessage::Command { id: COMMAND, by: access::caller(), command: Command::StopMotion },
        GatewayMessage::Clients(vec![CLIENT]),
        GatewayMessage::CredentialsUsed(vec![access::CREDENTIAL]),
        GatewayMessage::Listeners { clients: 2, streams: 1 },
        GatewayMessage::RequestGraph,
        GatewayMessage::Edit { by: CLIENT.into(), edit: site::edit() },
        GatewayMessage::RequestSite,
        GatewayMessage::Audit(vec![AuditNote {
            by: access::caller(),
            request: name(),
            refused: Some(name()),
            count: 300,
        }]),
    ];
    let query = |query| GatewayMessage::Query { number: 300, by: CLIENT.into(), query };
    messages.extend(queries().into_iter().map(query));
    let account = |request| GatewayMessage::Account { number: 300, by: access::caller(), request };
    messages.extend(access::requests().into_iter().map(account));
    messages
}

pub fn queries() -> Vec<Query> {
    site::queries().collect()
}
