//! What a mapping session has to publish: types of the log, made of those of `mapping`.

use crate::loop_texts;
use crate::mapping_messages as plain;
use mapping::{LoopClosing, LoopEvents};
use messages::{Keyframe, LoopDecision, Publication, Reanchored};
use vocab::SessionId;

/// What a waypoint changed in the map.
pub(crate) enum MapUpdate {
    /// It became a keyframe.
    Keyframe { keyframe: Keyframe, graph: Option<Publication>, events: MappingEvents },
    /// It is on known ground, or the robot is not localised yet in the map that the session extends. It may have been localised by this waypoint.
    NoKeyframe(MappingEvents),
}

/// What to publish.
#[derive(Debug, Default)]
pub(crate) struct MappingEvents {
    /// New decisions about loops.
    pub decisions: Vec<LoopDecision>,
    /// The robot's pose was confirmed on known ground.
    pub reanchored: Option<Reanchored>,
    /// Whether edges or poses of the graph changed.
    pub is_graph_changed: bool,
    /// Whether the robot was localised in the map that the session extends.
    pub is_localised: bool,
    /// Why loops are not closed any more; said once.
    pub warning: Option<String>,
}

impl MappingEvents {
    /// What loop closing has done in a session.
    pub fn new(session: SessionId, events: &LoopEvents, loops: &LoopClosing) -> Self {
        let config = &loops.config().verification;
        let decision = |record| plain::decision_to_plain(session, record, config);
        Self {
            decisions: events.decisions.iter().map(decision).collect(),
            is_graph_changed: events.is_graph_changed,
            warning: events.failure.as_ref().map(loop_texts::graph_failed),
            ..Self::default()
        }
    }
}

/// All decisions of a session about loops.
pub(crate) fn decisions_to_plain(session: SessionId, loops: &LoopClosing) -> Vec<LoopDecision> {
    let config = &loops.config().verification;
    loops.decisions().iter().map(|record| plain::decision_to_plain(session, record, config)).collect()
}
