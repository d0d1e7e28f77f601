//! Changes of the pose graph of the current mapping session.
//!
//! A receiver holds one graph. Changes name the session and the revision that they apply to. A receiver applies them only to exactly
//! that graph. If they do not apply, it drops them and asks its sender for the whole graph, once:
//! [`crate::ClientMessage::RequestGraph`], [`crate::GatewayMessage::RequestGraph`]. Until that comes, it drops all changes.
//!
//! A whole graph with more than [`MAX_GRAPH_ENTRIES`] keyframes, edges or loops is sent in parts, so that no message is long. Its sender sends no changes
//! between them.

use crate::{Graph, GraphNode};
use serde::{Deserialize, Serialize};
use vocab::{KeyframeId, SessionId};

/// Greatest number of keyframes in a message, and of edges, and of loops: about 600 kB. Changes with more of them are sent as the whole graph.
pub const MAX_GRAPH_ENTRIES: usize = 8_192;

/// A part of a whole graph that is too long for one message. [`GraphAssembly`] puts them together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GraphPart {
    /// Counts from 0. Part 0 begins a graph, whatever came before.
    pub index: u32,
    /// Whether it is the last.
    pub is_last: bool,
    /// Session and revision of the whole graph, and the next keyframes, edges and loops of it.
    pub graph: Graph,
}

/// The parts of a whole graph that have come.
#[derive(Clone, Debug, Default)]
pub struct GraphAssembly {
    next_index: u32,
    graph: Option<Graph>,
}

impl GraphAssembly {
    /// Adds a part. Returns the whole graph after its last part. A part that does not follow the one before is dropped together with them; then
    /// later changes do not apply, and the whole graph is asked for.
    pub fn add(&mut self, part: &GraphPart) -> Option<Graph> {
        let expected = std::mem::take(&mut self.next_index);
        let before = self.graph.take();
        let graph = match before {
            _ if part.index == 0 => part.graph.clone(),
            Some(mut graph) if graph.is_continued_by(part, expected) => {
                graph.nodes.extend(&part.graph.nodes);
                graph.edges.extend(&part.graph.edges);
                graph.loops.extend(&part.graph.loops);
                graph
            }
            _ => return None,
        };
        if part.is_last {
            return Some(graph);
        }
        self.next_index = part.index.saturating_add(1);
        self.graph = Some(graph);
        None
    }
}

/// What changed in the graph of [`crate::Event::Graph`]. Changes add up, in the order in which they are sent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GraphChanged {
    /// Which session.
    pub session: Option<SessionId>,
    /// Revision of the graph that the changes apply to.
    pub base_revision: u64,
    /// Its revision afterwards.
    pub revision: u64,
    /// New keyframes, and those that moved noticeably, in the order of their ids.
    pub nodes: Vec<GraphNode>,
    /// New edges of the odometry.
    pub edges: Vec<(KeyframeId, KeyframeId)>,
    /// Loops that are gone, the older keyframe first.
    pub removed_loops: Vec<(KeyframeId, KeyframeId)>,
    /// New loops, the older keyframe first.
    pub loops: Vec<(KeyframeId, KeyframeId)>,
}

impl Graph {
    /// Number of messages that the whole graph takes.
    pub fn part_count(&self) -> u32 {
        let longest = self.nodes.len().max(self.edges.len()).max(self.loops.len());
        longest.div_ceil(MAX_GRAPH_ENTRIES).max(1) as u32
    }

    /// The part of this index of [`Self::part_count`].
    pub fn part(&self, index: u32) -> GraphPart {
        fn slice<T: Copy>(all: &[T], index: u32) -> Vec<T> {
            all.chunks(MAX_GRAPH_ENTRIES).nth(index as usize).unwrap_or_default().to_vec()
        }
        let graph = Self {
            session: self.session,
            revision: self.revision,
            nodes: slice(&self.nodes, index),
            edges: slice(&self.edges, index),
            loops: slice(&self.loops, index),
        };
        GraphPart { index, is_last: index + 1 >= self.part_count(), graph }
    }

    fn is_continued_by(&self, part: &GraphPart, index: u32) -> bool {
        (part.graph.session, part.graph.revision, part.index) == (self.session, self.revision, index)
    }

    /// Applies changes. Returns whether they are changes of this revision of this session; the graph is unchanged if not.
    pub fn apply(&mut self, changed: &GraphChanged) -> bool {
        if (changed.session, changed.base_revision) != (self.session, self.revision) {
            return false;
        }
        for node in &changed.nodes {
            match self.nodes.get_mut(node.id.0 as usize) {
                Some(known) => *known = *node,
                None => self.nodes.push(*node),
            }
        }
        self.edges.extend(&changed.edges);
        self.loops.retain(|pair| !changed.removed_loops.contains(pair));
        self.loops.extend(&changed.loops);
        self.revision = changed.revision;
        true
    }
}

impl GraphChanged {
    /// Whether it is too long for one message, so that the whole graph is sent in its place.
    pub fn is_too_long(&self) -> bool {
        let lengths = [self.nodes.len(), self.edges.len(), self.removed_loops.len(), self.loops.len()];
        lengths.iter().any(|length| *length > MAX_GRAPH_ENTRIES)
    }

    /// Appends the changes that follow. Returns whether they are those; nothing is appended if not.
    pub fn append(&mut self, later: &Self) -> bool {
        if (later.session, later.base_revision) != (self.session, self.revision) {
            return false;
        }
        for node in &later.nodes {
            match self.nodes.binary_search_by_key(&node.id, |known| known.id) {
                Ok(at) => self.nodes[at] = *node,
                Err(at) => self.nodes.insert(at, *node),
            }
        }
        self.edges.extend(&later.edges);
        // A loop that came and is gone again was never sent.
        let removed = &later.removed_loops;
        let (gone, here): (Vec<_>, Vec<_>) =
            self.loops.iter().copied().partition(|pair| removed.contains(pair));
        self.loops = here;
        self.removed_loops.extend(removed.iter().filter(|pair| !gone.contains(pair)));
        self.loops.extend(&later.loops);
        self.revision = later.revision;
        true
    }
}

#[cfg(test)]
#[path = "graph_tests.rs"]
mod tests;
