//! Conversion between the log schema (`messages`) and the contract with clients (`api`). Each can change without the other.

use crate::imports::ImportSource;
use crate::interrupted_sessions::SessionDecision;
use crate::stored_data::StoredDataChange;
use api::{Command, Event, LoopsChanged};
use messages::{
    CommandKind, DegradationReason, EdgeKind, LocalisationState, MappingState, MotionState, PoseInMap,
    Publication,
};
use ports::SimulatedFault;
use site_model::EditId;
use std::sync::Arc;
use vocab::{MapId, Span, UploadId};

/// A client's command, by the part that handles it.
pub enum RoutedCommand {
    /// The stack. Only these commands are in the log.
    Stack(CommandKind),
    /// The link of a simulated robot. The stack must not know simulated faults.
    SimulatedFault(SimulatedFault),
    /// The import thread: makes a map of this name of an uploaded file or a saved map.
    Import(UploadId, String, ImportSource),
    /// The disk lane: a decision on a session that was interrupted.
    InterruptedSession(SessionDecision),
    /// The disk lane: a change of stored maps or uploaded files.
    StoredData(StoredDataChange),
    /// The import thread: cancels the import of this upload.
    CancelImport(UploadId),
    /// The import thread: makes a site to try, in this time zone.
    MakeExample(UploadId, String),
    /// The arbiter of the lease: its holder keeps it.
    RefuseTakeOver,
    /// Disk lane, compute lane and ledger: makes a topological map of this map, with an edit of this id.
    GenerateTopomap(MapId, EditId),
}

/// Finds the part that handles a client's command.
pub fn route(command: Command) -> RoutedCommand {
    RoutedCommand::Stack(match command {
        Command::InjectFault(fault) => return RoutedCommand::SimulatedFault(limit_fault(fault)),
        Command::ImportMap { upload, name, frame } => {
            return RoutedCommand::Import(upload, name, ImportSource::File { frame });
        }
        Command::AlignMap { upload, name, map, onto, mut pairs } => {
            pairs.truncate(api::MAX_PAIRS);
            let source = ImportSource::Map { map, onto, pairs };
            return RoutedCommand::Import(upload, name, source);
        }
        Command::SaveInterruptedSession { session, map, name, resume_as } => {
            let decision = SessionDecision::Save { session, map, name, resume_as };
            return RoutedCommand::InterruptedSession(decision);
        }
        Command::DiscardInterruptedSession(session) => {
            return RoutedCommand::InterruptedSession(SessionDecision::Discard(session));
        }
        Command::RenameMap { map, name } => {
            return RoutedCommand::StoredData(StoredDataChange::RenameMap(map, name));
        }
        Command::DeleteMap(map) => return RoutedCommand::StoredData(StoredDataChange::DeleteMap(map)),
        Command::RestoreMap(map) => return RoutedCommand::StoredData(StoredDataChange::RestoreMap(map)),
        Command::DeleteMapPermanently(map) => {
            return RoutedCommand::StoredData(StoredDataChange::DeleteMapPermanently(map));
        }
        Command::DeleteUpload(upload) => {
            return RoutedCommand::StoredData(StoredDataChange::DeleteUpload(upload));
        }
        Command::CancelImport(upload) => return RoutedCommand::CancelImport(upload),
        Command::GenerateTopomap { map, edit } => return RoutedCommand::GenerateTopomap(map, edit),
        Command::MakeExample { upload, time_zone } => return RoutedCommand::MakeExample(upload, time_zone),
        Command::MakeNormal { upload, name, mut changes } => {
            changes.truncate(api::MAX_ACCEPTED_CHANGES);
            return RoutedCommand::Import(upload, name, ImportSource::Normal { changes });
        }
        Command::RefuseTakeOver => return RoutedCommand::RefuseTakeOver,
        Command::TakeControl { name } => CommandKind::TakeControl { name },
        Command::ReleaseControl => CommandKind::ReleaseControl,
        Command::StartMapping(session) => CommandKind::StartMapping(session),
        Command::ExtendMap { session, map } => CommandKind::ExtendMap { session, map },
        Command::FinishMapping { map, name } => CommandKind::FinishMapping { map, name },
        Command::DiscardMapping => CommandKind::DiscardMapping,
        Command::Teleoperate(velocity) => CommandKind::Teleoperate(velocity),
        Command::StartGoal { goal, kind } => CommandKind::StartGoal { goal, kind: goal_kind(kind) },
        Command::CancelGoal(goal) => CommandKind::CancelGoal(goal),
        Command::StopMotion => CommandKind::StopMotion,
        Command::AllowMotion => CommandKind::AllowMotion,
        Command::AcceptLoop { from, to } => CommandKind::AcceptLoop { from, to },
        Command::RejectLoop { from, to } => CommandKind::RejectLoop { from, to },
        Command::ProposeLoop { from, to, guess } => CommandKind::ProposeLoop { from, to, guess },
        Command::Localise { map, at } => CommandKind::Localise { map, at },
        Command::LeaveMap => CommandKind::LeaveMap,
        Command::Mission(command) => CommandKind::Mission(command),
    })
}

/// Limits of simulated faults.
#[derive(Clone, Copy, Debug)]
struct FaultLimits {
    /// Longest time that a simulated fault lasts. A forgotten fault must not be taken for a real one the next day.
    max_duration: Span,
}

const FAULT_LIMITS: FaultLimits = FaultLimits { max_duration: Span::from_millis(600_000) };

fn limit_fault(fault: SimulatedFault) -> SimulatedFault {
    let limited = |span: Span| span.clamp(Span::ZERO, FAULT_LIMITS.max_duration);
    match fault {
        SimulatedFault::CoverLidar(span) => SimulatedFault::CoverLidar(limited(span)),
        SimulatedFault::SilenceLidar(span) => SimulatedFault::SilenceLidar(limited(span)),
        SimulatedFault::SilenceImu(span) => SimulatedFault::SilenceImu(limited(span)),
        SimulatedFault::SlipFeet(span) => SimulatedFault::SlipFeet(limited(span)),
        SimulatedFault::CarryAway | SimulatedFault::End => fault,
    }
}

/// Estimate of the robot's pose.
pub fn estimate(estimate: &messages::Estimate) -> api::Estimate {
    api::Estimate {
        stamp: estimate.stamp,
        map_from_base: estimate.map_from_base,
        velocity: estimate.velocity,
        covariance: estimate.covariance,
        degenerate: estimate.degenerate.iter().flatten().count() as u8,
        distance_m: estimate.distance_m,
    }
}

/// State of mapping.
pub fn mapping(state: &MappingState) -> api::Mapping {
    match state {
        MappingState::Idle => api::Mapping::Idle,
        MappingState::Starting { session } => api::Mapping::Starting { session: *session },
        MappingState::Loading { session, map } => api::Mapping::Loading { session: *session, map: *map },
        MappingState::Finding { session, map, distance_m, ambiguous } => api::Mapping::Finding {
            session: *session,
            map: *map,
            distance_m: *distance_m,
            ambiguous: *ambiguous,
        },
        MappingState::Mapping { session, extends, since, distance_m, keyframes, on_known_ground } => {
            api::Mapping::Running {
                session: *session,
                extends: *extends,
                since: *since,
                distance_m: *distance_m,
                keyframes: *keyframes,
                on_known_ground: *on_known_ground,
            }
        }
        MappingState::Saving { session: _, map } => api::Mapping::Saving { map: *map },
    }
}

/// State of localisation in a saved map.
pub fn localisation(state: &LocalisationState) -> api::Localisation {
    let to_api = |reason: DegradationReason| match reason {
        DegradationReason::MapMismatch => api::DegradationReason::MapMismatch,
        DegradationReason::PoseUncertain => api::DegradationReason::PoseUncertain,
        DegradationReason::LidarBlind => api::DegradationReason::LidarBlind,
        DegradationReason::Unmapped => api::DegradationReason::Unmapped,
        DegradationReason::Unconfirmed => api::DegradationReason::Unconfirmed,
    };
    match *state {
        LocalisationState::Idle => api::Localisation::Idle,
        LocalisationState::Loading { map } => api::Localisation::Loading { map },
        LocalisationState::Relocalising { map, hypotheses } => {
            api::Localisation::Relocalising { map, hypotheses }
        }
        LocalisationState::Localised { map, degradation } => {
            api::Localisation::Localised { map, degradation: degradation.map(to_api) }
        }
    }
}

/// The pose graph of a session.
pub fn graph(graph: &messages::PoseGraph, session: Option<vocab::SessionId>) -> api::Graph {
    let of_kind = |kind| {
        let edges = graph.edges.iter().filter(move |edge| edge.kind == kind);
        edges.map(|edge| (edge.from, edge.to)).collect()
    };
    api::Graph {
        session,
        revision: graph.revision,
        nodes: graph.nodes.iter().map(graph_node).collect(),
        edges: of_kind(EdgeKind::Odometry),
        loops: of_kind(EdgeKind::Loop),
    }
}

/// Changes of the pose graph of a session.
pub fn graph_changed(delta: &messages::GraphDelta) -> api::GraphChanged {
    let of_kind = |kind| {
        let edges = delta.edges.iter().filter(move |edge| edge.kind == kind);
        edges.map(|edge| (edge.from, edge.to)).collect()
    };
    api::GraphChanged {
        session: Some(delta.session),
        base_revision: delta.base_revision,
        revision: delta.revision,
        nodes: delta.nodes.iter().map(graph_node).collect(),
        edges: of_kind(EdgeKind::Odometry),
        removed_loops: delta.removed_loops.clone(),
        loops: of_kind(EdgeKind::Loop),
    }
}

fn graph_node(node: &messages::GraphNode) -> api::GraphNode {
    api::GraphNode { id: node.id, stamp: node.stamp, map_from_keyframe: node.map_from_keyframe }
}

/// A decision on a pair of keyframes.
pub fn loop_decision(decision: messages::LoopDecision) -> api::LoopDecision {
    let evidence = decision.evidence;
    let pair = |shares: [f64; 2]| shares.map(|share| share as f32);
    api::LoopDecision {
        from: decision.task.from,
        to: decision.task.to,
        source: match decision.task.source {
            messages::LoopSource::Geometry => api::LoopSource::Geometry,
            messages::LoopSource::Appearance(distance) => api::LoopSource::Appearance(distance),
            messages::LoopSource::Person => api::LoopSource::Person,
        },
        verdict: match decision.verdict {
            messages::LoopVerdict::Accepted => api::LoopVerdict::Accepted,
            messages::LoopVerdict::Held => api::LoopVerdict::Held,
            messages::LoopVerdict::Rejected => api::LoopVerdict::Rejected,
            messages::LoopVerdict::Dropped => api::LoopVerdict::Dropped,
        },
        by_hand: decision.by_hand,
        reason: decision.reason,
        overlap: pair(evidence.overlap),
        residual_m: evidence.residual_m as f32,
        free_space_violation: pair(evidence.free_space_violation),
        runner_up_ratio: evidence.runner_up_ratio as f32,
        guess: decision.task.guess,
        from_from_to: decision.from_from_to,
    }
}

/// The event of a publication that needs no other state; `None` for publications that the publisher handles itself.
pub fn event(publication: Publication) -> Option<Event> {
    Some(match publication {
        Publication::Motion(state) => Event::Motion(motion(state)),
        Publication::Executive(status) => Event::Executive(executive(status)),
        Publication::Health(state) => Event::Health(health(state)),
        Publication::LoopDecided(decision) => {
            Event::Loops(LoopsChanged { reset: false, added: vec![loop_decision(decision)] })
        }
        Publication::Quality(quality) => Event::Quality(self::quality(quality)),
        Publication::Missions(status) => Event::Missions(Arc::unwrap_or_clone(status)),
        Publication::Route(status) => Event::Route(Arc::unwrap_or_clone(status)),
        Publication::Notice(notice) => Event::Notice(api::Notice {
            at: notice.at,
            severity: severity(notice.severity),
            text: notice.text,
        }),
        Publication::Estimate(_)
        | Publication::Scan(_)
        | Publication::Keyframe(_)
        | Publication::Graph { .. }
        | Publication::GraphDelta(_)
        | Publication::Reanchored(_)
        | Publication::Mapping(_)
        | Publication::Localisation(_)
        | Publication::Docks(_)
        | Publication::Goal(_)
        | Publication::Battery(_)
        | Publication::Control(_) => return None,
    })
}

/// Docks of saved maps.
pub fn docks(docks: &[PoseInMap]) -> Vec<api::MapDock> {
    docks.iter().map(|dock| api::MapDock { map: dock.map, map_from_base: dock.map_from_base }).collect()
}

fn quality(quality: messages::MapQuality) -> api::Quality {
    let target = |target: messages::SurveyTarget| api::SurveyTarget {
        at: target.at,
        why: match target.why {
            messages::SurveyReason::FromAfar { area_m2 } => api::SurveyReason::FromAfar { area_m2 },
            messages::SurveyReason::Uncertain { deviation_m } => api::SurveyReason::Uncertain { deviation_m },
        },
    };
    api::Quality {
        covered_m2: quality.covered_m2,
        from_afar_m2: quality.from_afar_m2,
        deviations_m: quality.deviations_m,
        targets: quality.targets.into_iter().map(target).collect(),
    }
}

fn goal_kind(kind: api::GoalKind) -> messages::GoalKind {
    match kind {
        api::GoalKind::WalkTo(point) => messages::GoalKind::WalkTo(point),
        api::GoalKind::Relocalise => messages::GoalKind::Relocalise,
        api::GoalKind::GoToNode(node) => messages::GoalKind::GoToNode(node),
        api::GoalKind::GoToDock(dock) => messages::GoalKind::GoToDock(dock),
        api::GoalKind::Undock => messages::GoalKind::Undock,
    }
}

/// A goal of the robot.
pub fn goal(update: messages::GoalUpdate) -> api::Goal {
    api::Goal {
        id: update.id,
        kind: match update.kind {
            messages::GoalKind::WalkTo(point) => api::GoalKind::WalkTo(point),
            messages::GoalKind::Relocalise => api::GoalKind::Relocalise,
            // People ask for points and nodes. The contract with clients has no poses.
            messages::GoalKind::WalkToPose(pose) => api::GoalKind::WalkTo(pose.map_from_goal.position),
            messages::GoalKind::GoToNode(node) => api::GoalKind::GoToNode(node),
            messages::GoalKind::GoToDock(dock) => api::GoalKind::GoToDock(dock),
            messages::GoalKind::Undock => api::GoalKind::Undock,
        },
        by: update.by.client,
        accepted: update.accepted,
        status: goal_status(update.status),
    }
}

fn goal_status(status: messages::GoalStatus) -> api::GoalStatus {
    use messages::{CancelCause, GoalAttempt, GoalStatus, WaitReason};
    match status {
        GoalStatus::Accepted => api::GoalStatus::Accepted,
        GoalStatus::Running(progress) => api::GoalStatus::Running(api::GoalProgress {
            remaining_m: progress.remaining_m,
            waits_for: progress.waits_for.map(|reason| match reason {
                WaitReason::Sight => api::WaitReason::Sight,
                WaitReason::FreePath => api::WaitReason::FreePath,
                WaitReason::Relocalisation => api::WaitReason::Relocalisation,
            }),
        }),
        GoalStatus::Succeeded(result) => {
            api::GoalStatus::Succeeded { map_from_base: result.map_from_base, duration: result.duration }
        }
        GoalStatus::Failed { reason, tried } => api::GoalStatus::Failed {
            reason,
            tried: tried
                .into_iter()
                .map(|attempt| match attempt {
                    GoalAttempt::PlannedPaths(count) => api::GoalAttempt::PlannedPaths(count),
                    GoalAttempt::WaitedForPath(span) => api::GoalAttempt::WaitedForPath(span),
                    GoalAttempt::SearchedForPose(span) => api::GoalAttempt::SearchedForPose(span),
                    GoalAttempt::ExploredPaths(count) => api::GoalAttempt::ExploredPaths(count),
                    GoalAttempt::DockingAttempts(count) => api::GoalAttempt::DockingAttempts(count),
                })
                .collect(),
        },
        GoalStatus::Cancelled { by, cause } => api::GoalStatus::Cancelled {
            by: by.client,
            cause: match cause {
                CancelCause::Requested => api::CancelCause::Requested,
                CancelCause::MotionStopped => api::CancelCause::MotionStopped,
                CancelCause::DrivenByHand => api::CancelCause::DrivenByHand,
                CancelCause::Replaced(goal) => api::CancelCause::Replaced(goal),
            },
        },
    }
}

fn executive(status: messages::ExecutiveStatus) -> api::ExecutiveStatus {
    use messages::{ExecutiveEvent, ExecutiveState};
    api::ExecutiveStatus {
        state: match status.state {
            ExecutiveState::Stopped => api::ExecutiveState::Stopped,
            ExecutiveState::ManualDriving => api::ExecutiveState::ManualDriving,
            ExecutiveState::Recovering => api::ExecutiveState::Recovering,
            ExecutiveState::Executing => api::ExecutiveState::Executing,
            ExecutiveState::Idle => api::ExecutiveState::Idle,
        },
        since: status.since,
        cause: match status.cause {
            ExecutiveEvent::Started => api::ExecutiveEvent::Started,
            ExecutiveEvent::StopRequested => api::ExecutiveEvent::StopRequested,
            ExecutiveEvent::MotionAllowed => api::ExecutiveEvent::MotionAllowed,
            ExecutiveEvent::VelocityCommanded => api::ExecutiveEvent::VelocityCommanded,
            ExecutiveEvent::VelocityTimedOut => api::ExecutiveEvent::VelocityTimedOut,
            ExecutiveEvent::LeaseLost => api::ExecutiveEvent::LeaseLost,
            ExecutiveEvent::GoalRequested => api::ExecutiveEvent::GoalRequested,
            ExecutiveEvent::CancelRequested => api::ExecutiveEvent::CancelRequested,
            ExecutiveEvent::BehaviourSucceeded => api::ExecutiveEvent::BehaviourSucceeded,
            ExecutiveEvent::BehaviourFailed => api::ExecutiveEvent::BehaviourFailed,
            ExecutiveEvent::PoseLost => api::ExecutiveEvent::PoseLost,
            ExecutiveEvent::PoseFound => api::ExecutiveEvent::PoseFound,
            ExecutiveEvent::OdometryRestarted => api::ExecutiveEvent::OdometryRestarted,
            ExecutiveEvent::MapReplaced => api::ExecutiveEvent::MapReplaced,
        },
        goal: status.goal,
    }
}

fn motion(state: MotionState) -> api::Motion {
    match state {
        MotionState::Idle => api::Motion::Idle,
        MotionState::Stopped { by } => api::Motion::Stopped { by },
        MotionState::Teleoperated => api::Motion::Teleoperated,
        MotionState::Walking { goal, path, remaining_m } => api::Motion::Walking { goal, path, remaining_m },
        MotionState::Waiting { goal } => api::Motion::Waiting { goal },
        MotionState::Relocalising { goal } => api::Motion::Relocalising { goal },
        MotionState::Blocked { goal, reason } => api::Motion::Blocked { goal, reason },
    }
}

fn health(state: messages::Health) -> api::Health {
    let sensor = |sensor: messages::SensorHealth| api::SensorHealth {
        name: sensor.name,
        rate_hz: sensor.rate_hz,
        age: sensor.age,
    };
    let finding = |finding: messages::Finding| api::Finding {
        severity: severity(finding.severity),
        what: finding.what,
        remedy: finding.remedy,
    };
    api::Health {
        sensors: state.sensors.into_iter().map(sensor).collect(),
        findings: state.findings.into_iter().map(finding).collect(),
        points_used: state.points_used,
    }
}

fn severity(severity: messages::Severity) -> api::Severity {
    match severity {
        messages::Severity::Info => api::Severity::Info,
        messages::Severity::Warning => api::Severity::Warning,
        messages::Severity::Error => api::Severity::Error,
    }
}
