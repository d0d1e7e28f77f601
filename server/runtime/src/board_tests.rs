use super::*;
use api::{Battery, CommandOutcome, Notice, Severity, TileEntry, TileHash};
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
        anchor: api::Anchor::Map,
        level: 0,
        spacing: 1.0,
        bounds: vocab::Aabb::EMPTY,
        points: 1,
        bytes: 1,
    };
    Event::Tiles(TilesChanged { reset, added: vec![tile] })
}

/// Everything that waits for a connection.
fn drain(board: &Board, connection: u64) -> Vec<Event> {
    let waiting = board.lock().queue.len();
    let messages = (0..waiting).filter_map(|_| board.next(connection));
    messages
        .filter_map(|message| match message {
            CoreMessage::Event { event, .. } => Some(event),
            _ => None,
        })
        .collect()
}

#[test]
fn a_gateway_that_connects_gets_the_latest_of_each_kind_and_every_tile() {
    let board = Board::default();
    for event in [battery(0.9), tiles(true, 1), notice(1), tiles(false, 2), battery(0.8), notice(2)] {
        board.set(event);
    }
    let connection = board.connect();
    assert_eq!(board.next(connection), Some(CoreMessage::Hello { version: api::VERSION }));
    let events = drain(&board, connection);
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
    let board = Board::default();
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
            evidence: messages::LoopEvidence { residual: 0.25, ..messages::LoopEvidence::default() },
            verdict: messages::LoopVerdict::Held,
            by_hand: false,
            reason: "Why not.".to_owned(),
        };
        crate::convert::event(messages::Publication::LoopDecided(decision)).expect("told to clients")
    };
    board.set(decided(7));
    board.set(Event::Loops(LoopsChanged { reset: true, added: Vec::new() }));
    for to in 0..MAX_LOOP_DECISIONS as u32 + 20 {
        board.set(decided(to));
    }
    let connection = board.connect();
    let events = drain(&board, connection);
    let Some(Event::Loops(changed)) = events.iter().find(|event| matches!(event, Event::Loops(_))) else {
        panic!("no loops in {events:?}");
    };
    assert_eq!((changed.reset, changed.added.len()), (true, MAX_LOOP_DECISIONS));
    let first = &changed.added[0];
    assert_eq!((first.to.0, first.residual, first.source), (20, 0.25, api::LoopSource::Person));
    // Decisions add up while they wait.
    board.set(decided(1));
    board.set(decided(2));
    assert_eq!(drain(&board, connection), [decided(1), decided(2)]);
}

#[test]
fn a_slow_gateway_gets_only_the_newest_of_what_goes_out_of_date() {
    let board = Board::default();
    let connection = board.connect();
    drain(&board, connection);
    for number in 0..10_000_i64 {
        board.set(battery(number as f32));
        board.push(CoreMessage::Scan {
            stamp: Stamp::from_nanos(number),
            map_from_base: vocab::Pose::IDENTITY,
            points: vec![0; 1000],
        });
    }
    board.set(notice(7));
    assert_eq!(board.lock().queue.len(), 3);
    assert_eq!(drain(&board, connection), [battery(9999.0), notice(7)]);
}

#[test]
fn a_gateway_that_does_not_read_loses_its_connection_and_finds_all_again() {
    let board = Board::default();
    let connection = board.connect();
    board.set(battery(0.5));
    for number in 0..=QUEUE_MAX as i64 {
        board.set(notice(number));
    }
    assert_eq!(board.next(connection), None);
    let again = board.connect();
    assert!(drain(&board, again).contains(&battery(0.5)));
}

#[test]
fn answers_go_to_whoever_asked_and_are_not_kept() {
    let board = Board::default();
    let (id, to) = (CommandId(uuid::Uuid::from_u128(1)), ClientId(uuid::Uuid::from_u128(2)));
    let connection = board.connect();
    drain(&board, connection);
    board.answer(id, to, Some("no".to_owned()));
    let outcome = CommandOutcome::Refused("no".to_owned());
    let expected = CoreMessage::Event { to: Some(to), event: Event::CommandDone { id, outcome } };
    assert_eq!(board.next(connection), Some(expected));
    let again = board.connect();
    assert!(!drain(&board, again).iter().any(|event| matches!(event, Event::CommandDone { .. })));
}
