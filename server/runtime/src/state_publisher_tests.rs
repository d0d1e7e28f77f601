use super::*;
use api::{
    Battery, CommandOutcome, LoopsChanged, MAX_LOOP_DECISIONS, Notice, Severity, TileEntry, TileHash,
    TilesChanged,
};
use proptest::prelude::*;
use vocab::Stamp;

fn notice(number: i64) -> Event {
    Event::Notice(Notice { at: Stamp::from_nanos(number), severity: Severity::Info, text: String::new() })
}

fn battery(charge: f32) -> Event {
    Event::Battery(Battery { charge, ..Battery::default() })
}

fn tiles(reset: bool, first_byte: u8) -> Event {
    let tile = TileEntry {
        hash: TileHash([first_byte; 32]),
        anchor: api::TileAnchor::Map,
        level: 0,
        spacing_m: 1.0,
        bounds: vocab::Aabb::EMPTY,
        points: 1,
        bytes: 1,
    };
    Event::Tiles(TilesChanged { reset, added: vec![tile] })
}

/// Every message that waits for a connection.
fn drain_messages(state_publisher: &StatePublisher, connection: u64) -> Vec<CoreMessage> {
    let mut state = state_publisher.lock();
    let State { snapshot, queue, .. } = &mut *state;
    let mut queue = queue.as_mut().filter(|queue| queue.connection == connection);
    std::iter::from_fn(|| queue.as_mut()?.next(snapshot)).collect()
}

/// Every event that waits for a connection.
fn drain(state_publisher: &StatePublisher, connection: u64) -> Vec<Event> {
    let event = |message| match message {
        CoreMessage::Event { event, .. } => Some(event),
        _ => None,
    };
    drain_messages(state_publisher, connection).into_iter().filter_map(event).collect()
}

fn queue_length(state_publisher: &StatePublisher) -> Option<usize> {
    state_publisher.lock().queue.as_ref().map(GatewayQueue::len)
}

#[test]
fn a_gateway_that_connects_gets_the_latest_of_each_kind_and_every_tile() {
    let state_publisher = StatePublisher::default();
    for event in [battery(0.9), tiles(true, 1), notice(1), tiles(false, 2), battery(0.8), notice(2)] {
        state_publisher.publish(event);
    }
    let connection = state_publisher.connect();
    assert_eq!(state_publisher.next(connection), Some(CoreMessage::Hello { version: api::VERSION }));
    let events = drain(&state_publisher, connection);
    let Some(Event::Tiles(changed)) = events.iter().find(|event| matches!(event, Event::Tiles(_))) else {
        panic!("no tiles in {events:?}");
    };
    assert!(changed.reset);
    assert_eq!(changed.added.iter().map(|tile| tile.hash.0[0]).collect::<Vec<_>>(), [1, 2]);
    assert_eq!(events.len(), 5, "no loops, which is said too");
    assert!(events.contains(&battery(0.8)) && events.contains(&notice(1)) && events.contains(&notice(2)));
}

#[test]
fn a_gateway_that_connects_gets_the_last_decisions_on_loops_of_the_session() {
    let state_publisher = StatePublisher::default();
    let decided = |to: u32| {
        let task = messages::LoopTask {
            session: vocab::SessionId(uuid::Uuid::nil()),
            from: vocab::KeyframeId(0),
            to: vocab::KeyframeId(to),
            source: messages::LoopSource::Person,
            guess: vocab::Pose::IDENTITY,
        };
        let decision = messages::LoopDecision {
            task,
            from_from_to: vocab::Pose::IDENTITY,
            evidence: messages::LoopEvidence { residual_m: 0.25, ..messages::LoopEvidence::default() },
            verdict: messages::LoopVerdict::Held,
            by_hand: false,
            reason: "Why not.".to_owned(),
        };
        crate::convert::event(messages::Publication::LoopDecided(decision)).expect("told to clients")
    };
    state_publisher.publish(decided(7));
    state_publisher.publish(Event::Loops(LoopsChanged { reset: true, added: Vec::new() }));
    for to in 0..MAX_LOOP_DECISIONS as u32 + 20 {
        state_publisher.publish(decided(to));
    }
    let connection = state_publisher.connect();
    let events = drain(&state_publisher, connection);
    let Some(Event::Loops(changed)) = events.iter().find(|event| matches!(event, Event::Loops(_))) else {
        panic!("no loops in {events:?}");
    };
    assert_eq!((changed.reset, changed.added.len()), (true, MAX_LOOP_DECISIONS));
    let first = &changed.added[0];
    assert_eq!((first.to.0, first.residual_m, first.source), (20, 0.25, api::LoopSource::Person));
    // Decisions add up while they wait, as many as are kept.
    let added = |events: Vec<Event>| match &events[..] {
        [Event::Loops(LoopsChanged { reset, added })] => {
            (*reset, added.iter().map(|loop_| loop_.to.0).collect())
        }
        other => panic!("{other:?}"),
    };
    state_publisher.publish(decided(1));
    state_publisher.publish(decided(2));
    assert_eq!(added(drain(&state_publisher, connection)), (false, vec![1, 2]));
    for to in 0..2 * MAX_LOOP_DECISIONS as u32 {
        state_publisher.publish(decided(to));
    }
    let last = (MAX_LOOP_DECISIONS as u32..2 * MAX_LOOP_DECISIONS as u32).collect();
    assert_eq!(added(drain(&state_publisher, connection)), (false, last));
    state_publisher.publish(decided(1));
    state_publisher.publish(Event::Loops(LoopsChanged { reset: true, added: Vec::new() }));
    state_publisher.publish(decided(2));
    assert_eq!(added(drain(&state_publisher, connection)), (true, vec![2]));
}

#[test]
fn a_slow_gateway_gets_only_the_newest_of_what_goes_out_of_date() {
    let state_publisher = StatePublisher::default();
    let connection = state_publisher.connect();
    drain(&state_publisher, connection);
    for number in 0..10_000_i64 {
        state_publisher.publish(battery(number as f32));
        state_publisher.push(CoreMessage::Scan {
            stamp: Stamp::from_nanos(number),
            map_from_base: vocab::Pose::IDENTITY,
            points: vec![0; 1000],
        });
    }
    state_publisher.publish(notice(7));
    assert_eq!(queue_length(&state_publisher), Some(3));
    assert_eq!(drain(&state_publisher, connection), [battery(9999.0), notice(7)]);
}

#[test]
fn a_gateway_that_does_not_read_loses_its_connection_and_finds_all_again() {
    let state_publisher = StatePublisher::default();
    let connection = state_publisher.connect();
    state_publisher.publish(battery(0.5));
    for number in 0..=CONFIG.max_queued_messages as i64 {
        state_publisher.publish(notice(number));
    }
    assert_eq!(state_publisher.next(connection), None);
    let again = state_publisher.connect();
    assert!(drain(&state_publisher, again).contains(&battery(0.5)));
}

#[test]
fn answers_go_to_whoever_asked_and_are_not_kept() {
    let state_publisher = StatePublisher::default();
    let (id, to) = (CommandId(uuid::Uuid::from_u128(1)), ClientId(uuid::Uuid::from_u128(2)));
    let connection = state_publisher.connect();
    drain(&state_publisher, connection);
    state_publisher.answer(id, to, Some("no".to_owned()));
    let outcome = CommandOutcome::Refused("no".to_owned());
    let expected = CoreMessage::Event { to: Some(to), event: Event::CommandDone { id, outcome } };
    assert_eq!(state_publisher.next(connection), Some(expected));
    let again = state_publisher.connect();
    assert!(!drain(&state_publisher, again).iter().any(|event| matches!(event, Event::CommandDone { .. })));
}

#[test]
fn a_map_of_any_size_reaches_a_gateway_in_messages_of_less_than_one_megabyte() {
    let state_publisher = StatePublisher::default();
    let (tile_count, node_count) = (550_000_u32, 600_000_u64);
    let tile = |number: u32| {
        let mut hash = [7; 32];
        hash[..4].copy_from_slice(&number.to_le_bytes());
        let anchor = api::TileAnchor::Keyframe(vocab::KeyframeId(number));
        let bounds = vocab::Aabb { min: [-30.0; 3], max: [30.0; 3] };
        TileEntry {
            hash: TileHash(hash),
            anchor,
            level: 3,
            spacing_m: 0.25,
            bounds,
            points: 9_000,
            bytes: 50_000,
        }
    };
    let added: Vec<TileEntry> = (0..tile_count).map(tile).collect();
    let whole = graph(node_count);
    let in_one =
        [Event::Tiles(TilesChanged { reset: true, added: added.clone() }), Event::Graph(whole.clone())];
    for event in in_one {
        let bytes = api::encode(&CoreMessage::Event { to: None, event: event.clone() }).len();
        assert!(bytes > api::MAX_MESSAGE_BYTES, "{bytes} bytes would have been accepted as one message");
        state_publisher.publish(event);
    }
    let connection = state_publisher.connect();
    // What comes while the rest is being sent is sent too, after what it belongs to.
    for _ in 0..3 {
        state_publisher.next(connection).expect("more");
    }
    let again = state_publisher.connect();
    assert!(state_publisher.publish_graph_changes(next_keyframes(node_count, 1)));
    let (mut assembly, mut gateway, mut tiles) = (api::GraphAssembly::default(), None, Vec::new());
    let mut longest = 0;
    for message in drain_messages(&state_publisher, again) {
        longest = longest.max(api::encode(&message).len());
        match message {
            CoreMessage::Event { event: Event::Tiles(changed), .. } => {
                assert_eq!(changed.reset, tiles.is_empty());
                tiles.extend(changed.added);
            }
            CoreMessage::Event { event: Event::GraphPart(part), .. } => {
                gateway = assembly.add(&part).or(gateway)
            }
            CoreMessage::Event { event: Event::GraphChanged(changed), .. } => {
                assert!(gateway.as_mut().is_some_and(|graph| graph.apply(&changed)));
            }
            _ => {}
        }
    }
    assert!(longest < 1 << 20, "{longest} bytes");
    assert_eq!(tiles, added);
    assert!(gateway == Some(graph(node_count + 1)), "the whole graph");
    // A change of all keyframes at once goes out as the whole graph, in parts.
    let moved = GraphChanged { base_revision: node_count + 1, ..next_keyframes(0, node_count + 2) };
    assert!(state_publisher.publish_graph_changes(moved));
    let events = drain(&state_publisher, again);
    assert!(events.iter().all(|event| matches!(event, Event::GraphPart(_))), "{} events", events.len());
    assert_eq!(events.len(), graph(node_count + 2).part_count() as usize);
}

const SESSION: Option<vocab::SessionId> = Some(vocab::SessionId(uuid::Uuid::from_u128(1)));

fn graph_node(id: u64) -> api::GraphNode {
    api::GraphNode { id: vocab::KeyframeId(id as u32), ..api::GraphNode::default() }
}

/// A graph with this number of keyframes. The number is also its revision.
fn graph(revision: u64) -> api::Graph {
    let nodes = (0..revision).map(graph_node).collect();
    api::Graph { session: SESSION, revision, nodes, ..api::Graph::default() }
}

/// The change from that graph to one with `count` keyframes more.
fn next_keyframes(base_revision: u64, count: u64) -> GraphChanged {
    let revision = base_revision + count;
    let nodes = (base_revision..revision).map(graph_node).collect();
    GraphChanged { session: SESSION, base_revision, revision, nodes, ..GraphChanged::default() }
}

#[test]
fn changes_of_the_graph_are_merged_while_they_wait_and_dropped_if_they_do_not_apply() {
    let state_publisher = StatePublisher::default();
    let connection = state_publisher.connect();
    drain(&state_publisher, connection);
    assert!(!state_publisher.publish_graph_changes(next_keyframes(0, 1)), "there is no graph");
    state_publisher.publish(Event::Graph(graph(1)));
    assert!(state_publisher.publish_graph_changes(next_keyframes(1, 1)));
    assert_eq!(drain(&state_publisher, connection), [Event::Graph(graph(2))]);
    assert!(state_publisher.publish_graph_changes(next_keyframes(2, 1)));
    assert!(state_publisher.publish_graph_changes(next_keyframes(3, 1)));
    assert!(!state_publisher.publish_graph_changes(next_keyframes(3, 1)), "twice");
    assert!(!state_publisher.publish_graph_changes(next_keyframes(5, 1)), "one is missing");
    assert!(!state_publisher.publish_graph_changes(GraphChanged { session: None, ..next_keyframes(4, 1) }));
    assert_eq!(drain(&state_publisher, connection), [Event::GraphChanged(next_keyframes(2, 2))]);

    state_publisher.publish_graph_changes(next_keyframes(4, 1));
    state_publisher.resend_graph();
    state_publisher.resend_graph();
    assert_eq!(drain(&state_publisher, connection), [Event::Graph(graph(5))]);
}

proptest! {
    /// However changes, requests, reads and connections interleave, changes always apply to the gateway's graph, and in the end it has all of
    /// them.
    #[test]
    fn the_graph_of_the_gateway_converges(steps in prop::collection::vec((0_u8..8, 1_u64..4), 0..100)) {
        let state_publisher = StatePublisher::default();
        let mut connection = state_publisher.connect();
        let (mut revision, mut gateway) = (1, api::Graph::default());
        state_publisher.publish(Event::Graph(graph(revision)));
        let mut read = |connection| for event in drain(&state_publisher, connection) {
            match event {
                Event::Graph(whole) => gateway = whole,
                Event::GraphChanged(changed) => assert!(gateway.apply(&changed), "{changed:?}"),
                _ => {}
            }
        };
        for (step, count) in steps {
            match step {
                0..3 => {
                    prop_assert!(state_publisher.publish_graph_changes(next_keyframes(revision, count)));
                    revision += count;
                }
                3 => prop_assert!(!state_publisher.publish_graph_changes(next_keyframes(revision + 1, 1))),
                4 => {
                    revision = count;
                    state_publisher.publish(Event::Graph(graph(revision)));
                }
                5 => state_publisher.resend_graph(),
                6 => connection = state_publisher.connect(),
                _ => read(connection),
            }
        }
        read(connection);
        prop_assert_eq!(gateway, graph(revision));
    }
}
