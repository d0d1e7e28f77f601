//! Between the log schema and the contract with clients. They are alike today and need not stay so.

use api::{Event, Order};
use messages::{MappingState, MotionState, Publication};

/// A client's order for the stack.
pub fn order(order: Order) -> messages::Order {
    match order {
        Order::TakeControl { name } => messages::Order::TakeControl { name },
        Order::ReleaseControl => messages::Order::ReleaseControl,
        Order::StartMapping(session) => messages::Order::StartMapping(session),
        Order::FinishMapping { map, name } => messages::Order::FinishMapping { map, name },
        Order::DiscardMapping => messages::Order::DiscardMapping,
        Order::Teleoperate(velocity) => messages::Order::Teleoperate(velocity),
        Order::WalkTo(goal) => messages::Order::WalkTo(goal),
        Order::StopMotion => messages::Order::StopMotion,
        Order::AllowMotion => messages::Order::AllowMotion,
    }
}

/// Where the robot is.
pub fn estimate(estimate: &messages::Estimate) -> api::Estimate {
    api::Estimate {
        stamp: estimate.stamp,
        map_from_base: estimate.map_from_base,
        velocity: estimate.velocity,
        covariance: estimate.covariance,
        degenerate: estimate.degenerate.iter().flatten().count() as u8,
        distance: estimate.distance,
    }
}

/// State of mapping.
pub fn mapping(state: &MappingState) -> api::Mapping {
    match state {
        MappingState::Idle => api::Mapping::Idle,
        MappingState::Starting { session } => api::Mapping::Starting { session: *session },
        MappingState::Mapping { session, since, distance, keyframes } => api::Mapping::Running {
            session: *session,
            since: *since,
            distance: *distance,
            keyframes: *keyframes,
        },
        MappingState::Saving { session: _, map } => api::Mapping::Saving { map: *map },
    }
}

/// The pose graph of a session.
pub fn graph(graph: &messages::PoseGraph, session: Option<vocab::SessionId>) -> api::Graph {
    let node = |node: &messages::GraphNode| api::GraphNode {
        id: node.id,
        stamp: node.stamp,
        map_from_keyframe: node.map_from_keyframe,
    };
    api::Graph {
        session,
        nodes: graph.nodes.iter().map(node).collect(),
        edges: graph.edges.iter().map(|edge| (edge.from, edge.to)).collect(),
    }
}

/// What reaches clients as it is; none for what the publisher treats itself.
pub fn event(publication: Publication) -> Option<Event> {
    Some(match publication {
        Publication::Motion(state) => Event::Motion(motion(state)),
        Publication::Control(state) => Event::Control(api::Control { owner: state.owner, name: state.name }),
        Publication::Health(state) => Event::Health(health(state)),
        Publication::Notice(notice) => Event::Notice(api::Notice {
            at: notice.at,
            severity: severity(notice.severity),
            text: notice.text,
        }),
        Publication::Estimate(_)
        | Publication::Scan(_)
        | Publication::Keyframe(_)
        | Publication::Graph(_)
        | Publication::Mapping(_)
        | Publication::Battery(_) => return None,
    })
}

fn motion(state: MotionState) -> api::Motion {
    match state {
        MotionState::Idle => api::Motion::Idle,
        MotionState::Stopped { by } => api::Motion::Stopped { by },
        MotionState::Teleoperated => api::Motion::Teleoperated,
        MotionState::Walking { goal, path, remaining } => api::Motion::Walking { goal, path, remaining },
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
