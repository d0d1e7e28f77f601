use super::*;
use api::{Battery, Estimate, Severity, TileHash};
use proptest::prelude::*;
use vocab::Stamp;

fn battery(charge: f32) -> Event {
    Event::Battery(Battery { charge, ..Battery::default() })
}

fn tile(number: u32) -> TileEntry {
    let mut hash = [0; 32];
    hash[..4].copy_from_slice(&number.to_le_bytes());
    TileEntry {
        hash: TileHash(hash),
        anchor: api::TileAnchor::Map,
        level: 0,
        spacing_m: 1.0,
        bounds: vocab::Aabb::EMPTY,
        points: number,
        bytes: 0,
    }
}

fn tiles(reset: bool, numbers: std::ops::Range<u32>) -> Event {
    Event::Tiles(TilesChanged { reset, added: numbers.map(tile).collect() })
}

fn loops(reset: bool, numbers: std::ops::Range<u32>) -> Event {
    let decision = |number| LoopDecision {
        from: vocab::KeyframeId(0),
        to: vocab::KeyframeId(number),
        source: api::LoopSource::Geometry,
        verdict: api::LoopVerdict::Held,
        by_hand: false,
        reason: String::new(),
        overlap: [0.5; 2],
        residual_m: 0.01,
        free_space_violation: [0.0; 2],
        runner_up_ratio: 0.0,
        guess: vocab::Pose::IDENTITY,
        from_from_to: vocab::Pose::IDENTITY,
    };
    Event::Loops(LoopsChanged { reset, added: numbers.map(decision).collect() })
}

fn notice(at: i64) -> Event {
    Event::Notice(Notice { at: Stamp::from_nanos(at), severity: Severity::Info, text: String::new() })
}

/// Everything owed to the cursor.
fn drain(snapshot: &Snapshot, cursor: &mut Cursor) -> Vec<Event> {
    std::iter::from_fn(|| snapshot.next(cursor)).map(|event| (*event).clone()).collect()
}

/// A snapshot and a cursor that knows it.
fn settled() -> (Snapshot, Cursor) {
    let (snapshot, mut cursor) = (Snapshot::new(None), Cursor::default());
    assert_eq!(drain(&snapshot, &mut cursor), [Event::Platform(Platform::default())]);
    (snapshot, cursor)
}

#[test]
fn the_latest_value_wins_and_is_told_once() {
    let (mut snapshot, mut cursor) = settled();
    (0..1000).for_each(|i| snapshot.apply(battery(i as f32)));
    assert_eq!(drain(&snapshot, &mut cursor), [battery(999.0)]);
    assert_eq!(drain(&snapshot, &mut cursor), []);
}

#[test]
fn state_is_told_in_the_order_of_its_last_change() {
    let (mut snapshot, _) = settled();
    let mapping = Event::Mapping(api::Mapping::Idle);
    snapshot.apply(battery(0.1));
    snapshot.apply(mapping.clone());
    snapshot.apply(battery(0.2));
    assert_eq!(drain(&snapshot, &mut Cursor::default())[1..], [mapping, battery(0.2)]);
}

#[test]
fn tiles_coalesce_to_what_the_client_lacks() {
    let (mut snapshot, mut cursor) = settled();
    snapshot.apply(tiles(false, 0..3));
    assert_eq!(drain(&snapshot, &mut cursor), [tiles(true, 0..3)], "the first always resets");
    snapshot.apply(tiles(false, 3..4));
    snapshot.apply(tiles(false, 4..6));
    assert_eq!(drain(&snapshot, &mut cursor), [tiles(false, 3..6)]);
    snapshot.apply(tiles(true, 10..11));
    snapshot.apply(tiles(false, 11..12));
    assert_eq!(drain(&snapshot, &mut cursor), [tiles(true, 10..12)]);
    assert_eq!(drain(&snapshot, &mut Cursor::default())[1..], [tiles(true, 10..12)], "a new client gets all");
}

#[test]
fn a_reset_to_the_same_number_of_tiles_is_not_missed() {
    let (mut snapshot, mut cursor) = settled();
    snapshot.apply(tiles(true, 0..2));
    drain(&snapshot, &mut cursor);
    snapshot.apply(tiles(true, 2..4));
    assert_eq!(drain(&snapshot, &mut cursor), [tiles(true, 2..4)]);
    snapshot.apply(tiles(true, 0..0));
    assert_eq!(drain(&snapshot, &mut cursor), [tiles(true, 0..0)], "forgetting all is news too");
}

#[test]
fn a_big_map_comes_in_pieces_between_which_other_state_passes() {
    let (mut snapshot, mut cursor) = settled();
    let pieces = 10;
    snapshot.apply(tiles(true, 0..pieces * MAX_TILES_PER_EVENT as u32));
    let mut received = 0;
    for turn in 0..2 * pieces {
        // The pose changes without pause, so both are always owed.
        let pose = Event::Estimate(Estimate { distance_m: f64::from(turn), ..Estimate::default() });
        snapshot.apply(pose.clone());
        match snapshot.next(&mut cursor).as_deref() {
            Some(Event::Tiles(change)) => received += change.added.len(),
            Some(event) => assert_eq!(*event, pose),
            None => panic!("the pose is always owed"),
        }
    }
    assert_eq!(received, pieces as usize * MAX_TILES_PER_EVENT, "each gets every second turn");
}

#[test]
fn loops_add_up_come_in_pieces_and_the_oldest_go() {
    let (mut snapshot, mut cursor) = settled();
    snapshot.apply(loops(true, 0..0));
    snapshot.apply(loops(false, 0..3));
    assert_eq!(drain(&snapshot, &mut cursor), [loops(true, 0..3)]);
    snapshot.apply(loops(false, 3..4));
    snapshot.apply(loops(false, 4..6));
    assert_eq!(drain(&snapshot, &mut cursor), [loops(false, 3..6)]);
    // More than are kept: who was slow misses some, and gets the last in pieces.
    let (most, piece) = (MAX_LOOP_DECISIONS as u32, FIXED.max_loops_per_event as u32);
    snapshot.apply(loops(false, 6..106 + most));
    let pieces = |first_resets: bool| -> Vec<Event> {
        let starts = (106..106 + most).step_by(piece as usize);
        starts.map(|start| loops(first_resets && start == 106, start..start + piece)).collect()
    };
    assert_eq!(drain(&snapshot, &mut cursor), pieces(false));
    assert_eq!(drain(&snapshot, &mut Cursor::default())[1..], pieces(true));
    snapshot.apply(loops(true, 0..0));
    assert_eq!(drain(&snapshot, &mut cursor), [loops(true, 0..0)], "another session");
}

#[test]
fn notices_add_up_repetitions_do_not_and_the_oldest_go() {
    let (mut snapshot, mut cursor) = settled();
    (0..60).chain(55..60).for_each(|at| snapshot.apply(notice(at)));
    let kept: Vec<Event> = (10..60).map(notice).collect();
    assert_eq!(drain(&snapshot, &mut cursor), kept);
    snapshot.apply(notice(60));
    assert_eq!(drain(&snapshot, &mut cursor), [notice(60)]);
}

#[test]
fn the_gateway_knows_better_who_is_connected() {
    let (mut snapshot, mut cursor) = settled();
    snapshot.change_platform(|platform| platform.clients = 3);
    snapshot.apply(Event::Platform(Platform { robot: "r".into(), clients: 77, ..Platform::default() }));
    let expected = Platform { robot: "r".into(), clients: 3, core_connected: true, ..Platform::default() };
    assert_eq!(drain(&snapshot, &mut cursor), [Event::Platform(expected)]);
}

const SESSION: Option<vocab::SessionId> = Some(vocab::SessionId(uuid::Uuid::from_u128(1)));

fn graph_node(id: u64) -> api::GraphNode {
    api::GraphNode { id: vocab::KeyframeId(id as u32), ..api::GraphNode::default() }
}

/// A graph with this number of keyframes. The number is also its revision.
fn graph(revision: u64) -> Graph {
    Graph { session: SESSION, revision, nodes: (0..revision).map(graph_node).collect(), ..Graph::default() }
}

/// The change from that graph to the next.
fn next_keyframe(base_revision: u64) -> GraphChanged {
    let nodes = vec![graph_node(base_revision)];
    GraphChanged {
        session: SESSION,
        base_revision,
        revision: base_revision + 1,
        nodes,
        ..GraphChanged::default()
    }
}

#[test]
fn changes_of_the_graph_reach_a_client_that_follows_and_the_whole_graph_one_that_does_not() {
    let (mut snapshot, mut cursor) = settled();
    snapshot.apply(Event::Graph(graph(1)));
    assert_eq!(drain(&snapshot, &mut cursor), [Event::Graph(graph(1))]);
    for base in 1..3 {
        snapshot.apply(Event::GraphChanged(next_keyframe(base)));
    }
    let changes = [1, 2].map(|base| Event::GraphChanged(next_keyframe(base)));
    assert_eq!(drain(&snapshot, &mut cursor), changes);
    assert_eq!(drain(&snapshot, &mut Cursor::default())[1..], [Event::Graph(graph(3))], "a new client");
    cursor.forget_graph();
    assert_eq!(drain(&snapshot, &mut cursor), [Event::Graph(graph(3))], "one that asks for it");
    let last = 4 + FIXED.max_graph_changes as u64;
    for base in 3..last {
        snapshot.apply(Event::GraphChanged(next_keyframe(base)));
    }
    assert_eq!(drain(&snapshot, &mut cursor), [Event::Graph(graph(last))], "one that is far behind");
}

#[test]
fn a_long_graph_goes_in_parts_and_what_changes_meanwhile_follows() {
    let (mut snapshot, mut cursor) = settled();
    let nodes = MAX_GRAPH_ENTRIES as u64 * 2 + 5;
    (0..3).for_each(|index| snapshot.apply(Event::GraphPart(graph(nodes).part(index))));
    let mut assembly = GraphAssembly::default();
    let mut received = Graph::default();
    for turn in 0..4 {
        match snapshot.next(&mut cursor).as_deref() {
            Some(Event::GraphPart(part)) => received = assembly.add(part).unwrap_or(received),
            Some(Event::GraphChanged(changed)) => assert!(received.apply(changed)),
            other => panic!("{other:?}"),
        }
        if turn == 0 {
            snapshot.apply(Event::GraphChanged(next_keyframe(nodes)));
        }
    }
    assert_eq!((snapshot.next(&mut cursor), received == graph(nodes + 1)), (None, true));
    // More moves than fit into a message: the whole graph goes again.
    let moved = GraphChanged { nodes: graph(nodes + 1).nodes, ..next_keyframe(nodes + 1) };
    snapshot.apply(Event::GraphChanged(moved));
    assert!(drain(&snapshot, &mut cursor).iter().all(|event| matches!(event, Event::GraphPart(_))));
    assert!(snapshot.graph_changes.is_empty() && snapshot.changed_nodes == 0);
}

#[test]
fn changes_that_do_not_apply_leave_the_graph_as_it_is_until_the_whole_graph_comes() {
    let (mut snapshot, mut cursor) = settled();
    snapshot.apply(Event::GraphChanged(next_keyframe(0)));
    assert!(snapshot.is_graph_stale(), "there is no graph yet");
    snapshot.apply(Event::Graph(graph(1)));
    assert!(!snapshot.is_graph_stale());
    snapshot.apply(Event::GraphChanged(next_keyframe(2)));
    assert!(snapshot.is_graph_stale());
    assert_eq!(drain(&snapshot, &mut cursor), [Event::Graph(graph(1))]);
    snapshot.apply(Event::Graph(graph(4)));
    assert!(!snapshot.is_graph_stale());
    assert_eq!(drain(&snapshot, &mut cursor), [Event::Graph(graph(4))]);
}

proptest! {
    /// The core changes the graph, changes are lost on the way to the gateway, and clients read slowly, lose changes and connect anew. Each
    /// client always has a graph that the core had. Once everything is read and asked for, it has the core's.
    #[test]
    fn graphs_of_clients_converge(steps in prop::collection::vec((0_u8..10, 1_u64..400), 0..100)) {
        let (mut snapshot, mut cursor) = settled();
        let (mut revision, mut client, mut is_stale) = (1, Graph::default(), false);
        snapshot.apply(Event::Graph(graph(revision)));
        let mut assembly = GraphAssembly::default();
        let mut receive = |snapshot: &Snapshot, cursor: &mut Cursor, client: &mut Graph, is_stale: &mut bool| {
            let Some(event) = snapshot.next(cursor) else { return false };
            match &*event {
                Event::Graph(whole) => (*client, *is_stale) = (whole.clone(), false),
                Event::GraphPart(part) => {
                    if let Some(whole) = assembly.add(part) {
                        (*client, *is_stale) = (whole, false);
                    }
                }
                Event::GraphChanged(changed) => {
                    let is_lost = !client.apply(changed);
                    if is_lost && !std::mem::replace(is_stale, true) {
                        cursor.forget_graph();
                    }
                }
                _ => {}
            }
            true
        };
        for (step, count) in steps {
            match step {
                // More changes than are kept, now and then.
                0..3 => for _ in 0..count {
                    snapshot.apply(Event::GraphChanged(next_keyframe(revision)));
                    revision += 1;
                },
                3 => revision += 1,
                4 => snapshot.apply(Event::GraphChanged(next_keyframe(revision - 1))),
                // The client loses one.
                5 => { snapshot.next(&mut cursor); }
                6 => (cursor, client, is_stale) = (Cursor::default(), Graph::default(), false),
                _ => for _ in 0..count {
                    receive(&snapshot, &mut cursor, &mut client, &mut is_stale);
                },
            }
            if snapshot.is_graph_stale() {
                snapshot.apply(Event::Graph(graph(revision)));
            }
            prop_assert!(client == Graph::default() || client == graph(client.revision));
        }
        for _ in 0..2 {
            snapshot.apply(Event::GraphChanged(next_keyframe(revision)));
            revision += 1;
            if snapshot.is_graph_stale() {
                snapshot.apply(Event::Graph(graph(revision)));
            }
            while receive(&snapshot, &mut cursor, &mut client, &mut is_stale) {}
        }
        prop_assert!(!is_stale);
        prop_assert_eq!(client, graph(revision));
    }
}

proptest! {
    /// However changes and reads interleave, a client that has read everything knows what a new client would be told.
    #[test]
    fn readers_converge(steps in prop::collection::vec(0_u8..8, 0..200)) {
        let (mut snapshot, mut cursor) = settled();
        let (mut known, mut charge) = (Vec::new(), None);
        let mut number = 0;
        let mut learn = |event: &Event| match event {
            Event::Tiles(change) => {
                if change.reset { known.clear() }
                known.extend(change.added.iter().map(|tile| tile.points));
            }
            Event::Battery(battery) => charge = Some(battery.charge),
            _ => {}
        };
        for step in steps {
            match step {
                0 => snapshot.apply(tiles(true, number..number + 1)),
                1 | 2 => snapshot.apply(tiles(false, number..number + 700)),
                3 => snapshot.apply(battery(number as f32)),
                4 => snapshot.forget_tiles(),
                _ => if let Some(event) = snapshot.next(&mut cursor) { learn(&event) },
            }
            number += 1000;
        }
        drain(&snapshot, &mut cursor).iter().for_each(&mut learn);
        let (mut fresh, mut fresh_charge) = (Vec::new(), None);
        for event in drain(&snapshot, &mut Cursor::default()) {
            match event {
                Event::Tiles(change) => fresh.extend(change.added.iter().map(|tile| tile.points)),
                Event::Battery(battery) => fresh_charge = Some(battery.charge),
                _ => {}
            }
        }
        prop_assert_eq!(known, fresh);
        prop_assert_eq!(charge, fresh_charge);
    }
}
