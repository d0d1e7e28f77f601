//! Changes of the graph: merged or one by one, lost, repeated, after a reset.

use super::*;
use proptest::prelude::*;
use std::collections::{BTreeMap, VecDeque};
use uuid::Uuid;
use vocab::{Pose, Vec3};

fn node(id: u32, x: f64) -> GraphNode {
    let map_from_keyframe = Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::IDENTITY };
    GraphNode { id: KeyframeId(id), map_from_keyframe, ..GraphNode::default() }
}

fn pair(from: u32, to: u32) -> (KeyframeId, KeyframeId) {
    (KeyframeId(from), KeyframeId(to))
}

#[test]
fn changes_apply_to_one_revision_of_one_session_only() {
    let session = Some(SessionId(Uuid::from_u128(1)));
    let before = Graph { session, revision: 4, nodes: vec![node(0, 0.0)], ..Graph::default() };
    let changed = GraphChanged {
        session,
        base_revision: 4,
        revision: 6,
        nodes: vec![node(1, 1.0)],
        ..GraphChanged::default()
    };
    let mut graph = before.clone();
    assert!(graph.apply(&changed));
    assert_eq!((graph.revision, graph.nodes.len()), (6, 2));
    let after = graph.clone();
    assert!(!graph.apply(&changed), "the same changes again");
    let skipping = GraphChanged { base_revision: 7, revision: 8, ..changed.clone() };
    assert!(!graph.apply(&skipping), "changes between are missing");
    let other = GraphChanged { session: None, base_revision: 6, ..changed.clone() };
    assert!(!graph.apply(&other), "changes of another session");
    assert_eq!(graph, after);

    let mut sum = changed.clone();
    assert!(!sum.append(&changed) && !sum.append(&skipping) && !sum.append(&other));
    assert_eq!(sum, changed);
}

#[test]
fn a_long_graph_comes_in_parts_and_parts_out_of_order_are_dropped() {
    let count = 2 * MAX_GRAPH_ENTRIES as u32 + 7;
    let graph = Graph {
        session: Some(SessionId(Uuid::from_u128(1))),
        revision: 9,
        nodes: (0..count).map(|id| node(id, f64::from(id))).collect(),
        edges: (1..count).map(|id| pair(id - 1, id)).collect(),
        loops: vec![pair(0, 5)],
    };
    assert_eq!((graph.part_count(), Graph::default().part_count()), (3, 1));
    let parts: Vec<GraphPart> = (0..3).map(|index| graph.part(index)).collect();
    let longest = parts.iter().map(|part| crate::encode(part).len()).max();
    assert!(longest < Some(1 << 20), "{longest:?} bytes");
    let mut assembly = GraphAssembly::default();
    // A graph that was given up half way, then the whole one.
    let received: Vec<_> = [0, 1, 0, 1, 2].map(|part: usize| assembly.add(&parts[part])).into();
    assert_eq!(received, [None, None, None, None, Some(graph)]);
    let other = GraphPart { graph: Graph { revision: 8, ..parts[1].graph.clone() }, ..parts[1].clone() };
    for wrong in [vec![&parts[1]], vec![&parts[0], &parts[2]], vec![&parts[0], &other, &parts[1], &parts[2]]]
    {
        assert!(wrong.iter().all(|part| assembly.add(part).is_none()));
    }
}

/// The sending side: a graph that changes, and every graph that it has been.
#[derive(Default)]
struct Sender {
    graph: Graph,
    sessions: u128,
    past: BTreeMap<(Option<SessionId>, u64), Graph>,
}

impl Sender {
    fn begin_session(&mut self) -> Graph {
        self.sessions += 1;
        let session = Some(SessionId(Uuid::from_u128(self.sessions)));
        // The map that a session goes on from is its first revision.
        let first = Graph { session, revision: 1, nodes: vec![node(0, 0.0)], ..Graph::default() };
        self.graph = first;
        self.remember()
    }

    fn remember(&mut self) -> Graph {
        let graph = self.graph.clone();
        self.past.insert((graph.session, graph.revision), graph.clone());
        graph
    }

    /// Adds a keyframe, moves one, and closes and removes loops, as `choice` says.
    fn change(&mut self, choice: u32) -> GraphChanged {
        let Graph { session, revision, nodes, edges, loops } = &mut self.graph;
        let mut changed = GraphChanged {
            session: *session,
            base_revision: *revision,
            revision: *revision + 1 + u64::from(choice % 3),
            ..GraphChanged::default()
        };
        *revision = changed.revision;
        let count = nodes.len() as u32;
        let moved = choice % count;
        nodes[moved as usize] = node(moved, f64::from(choice));
        changed.nodes.push(nodes[moved as usize]);
        if choice.is_multiple_of(2) {
            nodes.push(node(count, f64::from(choice)));
            edges.push(pair(count - 1, count));
            changed.nodes.push(node(count, f64::from(choice)));
            changed.edges.push(pair(count - 1, count));
        }
        let closed = pair(choice % 5, 5 + choice % 3);
        if loops.contains(&closed) {
            loops.retain(|known| *known != closed);
            changed.removed_loops.push(closed);
        }
        if !choice.is_multiple_of(3) {
            loops.push(closed);
            changed.loops.push(closed);
        }
        self.remember();
        changed
    }
}

enum Message {
    Whole(Graph),
    Changed(GraphChanged),
}

/// The receiving side, as a client is.
#[derive(Default)]
struct Receiver {
    graph: Graph,
    is_stale: bool,
    /// Whether the sender owes the whole graph.
    asked: bool,
}

impl Receiver {
    fn receive(&mut self, message: Message) {
        match message {
            Message::Whole(graph) => {
                self.graph = graph;
                self.is_stale = false;
            }
            Message::Changed(changed) if !self.graph.apply(&changed) => {
                self.asked |= !self.is_stale;
                self.is_stale = true;
            }
            Message::Changed(_) => {}
        }
    }
}

proptest! {
    /// Messages are lost, repeated and merged; sessions begin; connections break. The receiver never shows a graph that the sender did not
    /// have, and after the next message it has the sender's.
    #[test]
    fn a_receiver_converges(steps in prop::collection::vec((0_u8..12, 0_u32..1000), 0..200)) {
        let (mut sender, mut receiver) = (Sender::default(), Receiver::default());
        let mut queue = VecDeque::from([Message::Whole(sender.begin_session())]);
        for (step, choice) in steps {
            match step {
                0..4 => queue.push_back(Message::Changed(sender.change(choice))),
                // Waiting changes are merged with the next ones, as the queue to the gateway does.
                4 | 5 => {
                    let changed = sender.change(choice);
                    let merged = match queue.back_mut() {
                        Some(Message::Whole(graph)) => graph.apply(&changed),
                        Some(Message::Changed(before)) => before.append(&changed),
                        None => false,
                    };
                    if !merged {
                        queue.push_back(Message::Changed(changed));
                    }
                }
                // Changes are lost.
                6 => queue.retain(|message| matches!(message, Message::Whole(_))),
                // Changes come twice.
                7 => if let Some(Message::Changed(changed)) = queue.front() {
                    receiver.receive(Message::Changed(changed.clone()));
                },
                8 => queue.push_back(Message::Whole(sender.begin_session())),
                // Another connection begins with the whole graph.
                9 => queue = VecDeque::from([Message::Whole(sender.graph.clone())]),
                _ => if let Some(message) = queue.pop_front() {
                    receiver.receive(message);
                },
            }
            if std::mem::take(&mut receiver.asked) {
                queue.push_back(Message::Whole(sender.graph.clone()));
            }
            let Graph { session, revision, .. } = receiver.graph;
            prop_assert!(receiver.graph == Graph::default()
                || sender.past.get(&(session, revision)) == Some(&receiver.graph));
        }
        queue.push_back(Message::Changed(sender.change(1)));
        while let Some(message) = queue.pop_front() {
            receiver.receive(message);
            if std::mem::take(&mut receiver.asked) {
                queue.push_back(Message::Whole(sender.graph.clone()));
            }
        }
        prop_assert!(!receiver.is_stale);
        prop_assert_eq!(receiver.graph, sender.graph);
    }
}
