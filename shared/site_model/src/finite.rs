//! Whether the numbers of objects are finite. Nothing else is ever stored.

use crate::{
    ActionRequest, AlertCause, EdgeCost, GaugeDial, MonitorCondition, Object, OrientedBox, OutsideLimits,
    Parameter, SceneChangeKind, TaskPlace, Traversal, ZoneEffect,
};
use vocab::Pose;

/// Whether all numbers of an object are finite.
pub(crate) fn is_finite(object: &Object) -> bool {
    let pose = |pose: &Pose| {
        let q = pose.orientation;
        pose.position.is_finite() && [q.w, q.x, q.y, q.z].iter().all(|c| c.is_finite())
    };
    let corners = |corners: &[[f64; 2]]| corners.as_flattened().iter().all(|c| c.is_finite());
    let requests = |requests: &[ActionRequest]| requests.iter().all(is_request_finite);
    match object {
        Object::Settings(_) | Object::EdgeBlock(_) | Object::Dock(_) | Object::Asset(_) => true,
        Object::Schedule(_) | Object::MutexHold(_) => true,
        Object::Node(node) => {
            let tolerance = &node.tolerance;
            pose(&node.map_from_node)
                && node.anchor.as_ref().is_none_or(|anchor| pose(&anchor.keyframe_from_node))
                && [tolerance.along_m, tolerance.across_m, tolerance.yaw_rad].iter().all(|c| c.is_finite())
                && corners(&node.influence_area_m)
        }
        Object::Edge(edge) => {
            let cost = match edge.cost {
                EdgeCost::Fixed(cost) => cost,
                EdgeCost::Length | EdgeCost::Learned => 0.0,
            };
            let traversal = match &edge.traversal {
                Traversal::Action { parameters, .. } => parameters.values().all(is_parameter_finite),
                _ => true,
            };
            let numbers =
                [cost, edge.max_speed_m_s.unwrap_or(0.0), edge.corridor.left_m, edge.corridor.right_m];
            traversal
                && numbers.iter().all(|c| c.is_finite())
                && [&edge.on_enter, &edge.during, &edge.on_leave].iter().all(|list| requests(list))
        }
        Object::Zone(zone) => {
            let effect = match &zone.effect {
                ZoneEffect::KeepOut => true,
                ZoneEffect::SpeedLimit(number) | ZoneEffect::Penalty(number) => number.is_finite(),
                ZoneEffect::Action(request) => is_request_finite(request),
            };
            effect && corners(&zone.corners_m) && zone.height_m.iter().flatten().all(|c| c.is_finite())
        }
        Object::InspectionPoint(point) => {
            let limits = point.limits.iter().flat_map(|limits| [limits.min, limits.max]);
            point.target_m.is_finite()
                && limits.flatten().all(f64::is_finite)
                && point.gauge.iter().flat_map(GaugeDial::numbers).all(f64::is_finite)
                && is_request_finite(&point.request)
        }
        Object::Mission(mission) => mission.tasks.iter().all(|task| match &task.place {
            TaskPlace::Node { request: Some(request), .. } | TaskPlace::ByAction { request } => {
                is_request_finite(request)
            }
            _ => true,
        }),
        Object::SceneChange(change) => {
            let from = match &change.kind {
                SceneChangeKind::Moved { from } => is_box_finite(from),
                SceneChangeKind::Appeared | SceneChangeKind::Removed => true,
            };
            let probability = change.physical_object.map_or(0.0, |object| object.probability);
            from && is_box_finite(&change.place) && change.confidence.is_finite() && probability.is_finite()
        }
        Object::Alert(alert) => match &alert.cause {
            AlertCause::OutsideLimits { reading, .. } => {
                let (OutsideLimits::Below(limit) | OutsideLimits::Above(limit)) = reading.outside;
                reading.value.is_finite() && limit.is_finite()
            }
            _ => true,
        },
        Object::Monitor(monitor) => match monitor.condition {
            MonitorCondition::Below { threshold, release }
            | MonitorCondition::Above { threshold, release } => threshold.is_finite() && release.is_finite(),
            MonitorCondition::Silent(_) => true,
        },
    }
}

fn is_box_finite(place: &OrientedBox) -> bool {
    place.centre_m.is_finite()
        && place.yaw_rad.is_finite()
        && place.size_m.iter().all(|side| side.is_finite())
}

fn is_request_finite(request: &ActionRequest) -> bool {
    request.parameters.values().all(is_parameter_finite)
}

fn is_parameter_finite(parameter: &Parameter) -> bool {
    match parameter {
        Parameter::Number(number) => number.is_finite(),
        Parameter::List(list) => list.iter().all(is_parameter_finite),
        Parameter::Map(map) => map.values().all(is_parameter_finite),
        Parameter::Bool(_) | Parameter::Integer(_) | Parameter::Text(_) => true,
    }
}
