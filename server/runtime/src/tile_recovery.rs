//! Keyframes that the mailbox has dropped: their tiles are cut from their files, a few in each turn of the publisher, once their poses are known.

use crate::mailbox::DroppedKeyframes;
use messages::{GraphNode, PoseGraph};
use std::collections::VecDeque;
use vocab::SessionId;

/// Parameters of [`TileRecovery`].
#[derive(Clone, Copy, Debug)]
pub struct TileRecoveryConfig {
    /// Keyframes that are read in one turn of the publisher: each takes some 20 ms. Chosen: 80 ms, after which clients get their state.
    pub keyframes_per_turn: usize,
}

impl Default for TileRecoveryConfig {
    fn default() -> Self {
        Self { keyframes_per_turn: 4 }
    }
}

/// What has to be recovered. As long as the graph at most.
#[derive(Default)]
pub struct TileRecovery {
    config: TileRecoveryConfig,
    /// Waits for the whole graph.
    dropped: Option<DroppedKeyframes>,
    /// The session and the keyframes of it that are next.
    ready: Option<(SessionId, VecDeque<GraphNode>)>,
}

impl TileRecovery {
    /// Adds keyframes that were dropped.
    pub fn add(&mut self, dropped: DroppedKeyframes) {
        self.dropped = Some(DroppedKeyframes::merge(self.dropped, dropped));
    }

    /// The whole graph has come.
    pub fn set_graph(&mut self, session: SessionId, graph: &PoseGraph) {
        let Some(dropped) = self.dropped.take_if(|dropped| dropped.session == session) else { return };
        let (_, ready) = match &mut self.ready {
            Some(ready) if ready.0 == session => ready,
            ready => ready.insert((session, VecDeque::new())),
        };
        let is_dropped = |node: &&GraphNode| (dropped.first..=dropped.last).contains(&node.id);
        ready.extend(graph.nodes.iter().filter(is_dropped));
    }

    /// Whether [`Self::take_next`] has keyframes.
    pub fn is_ready(&self) -> bool {
        self.ready.is_some()
    }

    /// The next keyframes, if they are of the session that is shown.
    pub fn take_next(&mut self, session: Option<SessionId>) -> Vec<GraphNode> {
        let Some((_, nodes)) = self.ready.as_mut().filter(|(of, _)| Some(*of) == session) else {
            self.ready = None;
            return Vec::new();
        };
        let next = nodes.drain(..nodes.len().min(self.config.keyframes_per_turn)).collect();
        if nodes.is_empty() {
            self.ready = None;
        }
        next
    }
}
