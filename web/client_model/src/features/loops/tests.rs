//! Decisions, undo, choosing two keyframes, which scans are fetched and where they are drawn.

use crate::testing::*;
use crate::*;
use api::LoopVerdict::{Accepted, Held, Rejected};
use api::{ClientMessage, Command, CommandOutcome, Control, Graph, GraphNode, LoopDecision, LoopsChanged};
use proptest::prelude::*;
use uuid::Uuid;
use vocab::{KeyframeId, Pose, SessionId, Vec3};

const SESSION: SessionId = SessionId(Uuid::from_u128(4));

fn pair(from: u32, to: u32) -> LoopPair {
    LoopPair::of(KeyframeId(from), KeyframeId(to))
}

fn keyframe(id: u32) -> ClientCommand {
    ClientCommand::Select(Some(Selection::Keyframe(KeyframeId(id))))
}

/// Keyframes a metre apart along x, in control, and these decisions.
fn mapping(decisions: Vec<LoopDecision>) -> TestClient {
    let mut client = TestClient::connected();
    client.event(api::Event::Control(Control { owner: Some(ME), name: String::new(), request: None }));
    let node = |id: u32| GraphNode {
        id: KeyframeId(id),
        map_from_keyframe: Pose { position: Vec3::new(f64::from(id), 0.0, 0.0), ..Pose::IDENTITY },
        ..GraphNode::default()
    };
    let nodes = (0..20).map(node).collect();
    client.event(api::Event::Graph(Graph { session: Some(SESSION), nodes, ..Graph::default() }));
    client.event(api::Event::Loops(LoopsChanged { reset: true, added: decisions }));
    client.take_effects();
    client
}

fn fetched(client: &mut TestClient) -> Vec<u32> {
    let cloud = |effect| match effect {
        ClientEffect::FetchCloud { session: SESSION, keyframe } => Some(keyframe.0),
        _ => None,
    };
    client.take_effects().into_iter().filter_map(cloud).collect()
}

/// The ids of the commands sent, and what they say.
fn sent(client: &mut TestClient) -> Vec<(vocab::CommandId, Command)> {
    let order = |effect| match effect {
        ClientEffect::Send(ClientMessage::Command { id, command: order }) => Some((id, order)),
        _ => None,
    };
    client.take_effects().into_iter().filter_map(order).collect()
}

fn accept(from: u32, to: u32) -> Command {
    Command::AcceptLoop { from: KeyframeId(from), to: KeyframeId(to) }
}

fn reject(from: u32, to: u32) -> Command {
    Command::RejectLoop { from: KeyframeId(from), to: KeyframeId(to) }
}

#[test]
fn the_last_decision_on_a_pair_counts_and_the_newest_comes_first() {
    let client = mapping(vec![decided(0, 9, Held), decided(1, 8, Rejected), decided(0, 9, Accepted)]);
    let loops = client.model.loops.decisions();
    let listed: Vec<_> = loops.latest().map(|it| (it.from.0, it.verdict)).collect();
    assert_eq!(listed, [(0, Accepted), (1, Rejected)]);
    assert_eq!(loops.counts(), LoopCounts { accepted: 1, held: 0, rejected: 1 });
    assert_eq!(loops.get(pair(9, 0)).map(|it| it.verdict), Some(Accepted));
    assert_eq!(loops.nth_latest(1).map(|it| it.from.0), Some(1));
    assert!(loops.nth_latest(2).is_none());
}

#[test]
fn undo_sends_the_other_decision_and_redo_the_first_again() {
    let mut client = mapping(vec![decided(0, 9, Held)]);
    client.command(ClientCommand::AcceptLoop(pair(0, 9)));
    client.command(ClientCommand::Undo);
    client.command(ClientCommand::Redo);
    client.command(ClientCommand::UndoLoop);
    assert_eq!(client.take_commands(), [accept(0, 9), reject(0, 9), accept(0, 9), reject(0, 9)]);
    assert_eq!(client.model.last_loop_edit(), None);
    client.command(ClientCommand::UndoLoop);
    assert_eq!(client.take_commands(), []);
}

#[test]
fn undo_takes_back_whatever_came_last() {
    let mut client = mapping(vec![]);
    client.wait(10.0);
    let dim = ViewSettings { ceiling_m: 5.0, ..ViewSettings::default() };
    client.command(ClientCommand::RejectLoop(pair(1, 7)));
    client.command(ClientCommand::EditView(dim.clone()));
    client.command(ClientCommand::AcceptLoop(pair(2, 8)));
    client.take_effects();
    client.command(ClientCommand::Undo);
    assert_eq!((client.take_commands(), client.model.view_settings()), (vec![reject(2, 8)], &dim));
    client.command(ClientCommand::Undo);
    assert_eq!((client.take_commands(), client.model.view_settings()), (vec![], &ViewSettings::default()));
    client.command(ClientCommand::Undo);
    assert_eq!(client.take_commands(), [accept(1, 7)]);
}

#[test]
fn a_decision_that_was_refused_cannot_be_undone() {
    let mut client = mapping(vec![]);
    client.command(ClientCommand::AcceptLoop(pair(0, 9)));
    let (id, _) = sent(&mut client)[0].clone();
    client.event(api::Event::CommandDone { id, outcome: CommandOutcome::Refused("No. Propose it.".into()) });
    client.command(ClientCommand::Undo);
    assert_eq!(client.take_commands(), []);
}

#[test]
fn what_others_control_is_undone_later_and_another_session_forgets_it() {
    let mut client = mapping(vec![]);
    client.command(ClientCommand::AcceptLoop(pair(0, 9)));
    client.event(api::Event::Control(Control { owner: Some(OTHER), name: "Anna".into(), request: None }));
    client.take_effects();
    client.command(ClientCommand::Undo);
    assert_eq!(client.take_commands(), []);
    assert!(client.model.notices().visible()[0].text.contains("Anna controls"));
    assert!(client.model.last_loop_edit().is_some());
    client.event(api::Event::Graph(Graph { session: None, ..Graph::default() }));
    assert!(client.model.last_loop_edit().is_none());
}

#[test]
fn two_keyframes_are_chosen_and_proposed_with_a_guess_from_the_graph() {
    let mut client = mapping(vec![]);
    client.command(ClientCommand::PickLoopKeyframes(true));
    client.command(keyframe(12));
    client.command(keyframe(12));
    assert_eq!(client.model.loop_pick(), Some(LoopPick::First), "the same again takes it back");
    client.command(keyframe(12));
    client.command(ClientCommand::Select(None));
    assert_eq!(client.model.loop_pick(), Some(LoopPick::Second(KeyframeId(12))));
    client.command(keyframe(3));
    assert_eq!(client.model.loop_pick(), Some(LoopPick::Both(pair(3, 12))));
    assert_eq!(fetched(&mut client), [3, 12], "they are laid over each other before they are proposed");
    client.command(ClientCommand::ProposeLoop);
    let commands = client.take_commands();
    let [Command::ProposeLoop { from, to, guess }] = &commands[..] else { panic!("{commands:?}") };
    assert_eq!((from.0, to.0, guess.position.x), (3, 12, 9.0));
    assert!(client.model.loops.proposal().is_some() && client.model.loop_pick().is_none());

    client.event(api::Event::Loops(LoopsChanged { reset: false, added: vec![decided(3, 12, Held)] }));
    assert_eq!(client.model.selection(), Some(Selection::Loop(pair(3, 12))), "what came of it is shown");
    assert!(client.model.loops.proposal().is_none());
}

#[test]
fn a_drifted_pair_can_be_guessed_at_the_same_place() {
    let mut client = mapping(vec![]);
    for command in [
        ClientCommand::PickLoopKeyframes(true),
        keyframe(2),
        keyframe(15),
        ClientCommand::SetLoopInitialGuess(LoopInitialGuess::SamePosition),
    ] {
        client.command(command);
    }
    client.command(ClientCommand::ProposeLoop);
    let proposed =
        |command: &Command| matches!(command, Command::ProposeLoop { guess, .. } if guess.position.x == 0.0);
    assert!(client.take_commands().iter().any(proposed));
}

#[test]
fn a_proposal_that_nothing_comes_of_is_given_up_and_a_refused_one_at_once() {
    for refused in [false, true] {
        let mut client = mapping(vec![]);
        for command in
            [ClientCommand::PickLoopKeyframes(true), keyframe(2), keyframe(15), ClientCommand::ProposeLoop]
        {
            client.command(command);
        }
        let (id, _) = sent(&mut client).pop().unwrap();
        if refused {
            let outcome = CommandOutcome::Refused("No. Choose two others.".into());
            client.event(api::Event::CommandDone { id, outcome });
        } else {
            client.wait(29.0);
            assert!(client.model.loops.proposal().is_some());
            client.wait(2.0);
        }
        assert!(client.model.loops.proposal().is_none());
    }
}

#[test]
fn scans_lie_as_found_as_in_the_graph_or_not_at_all() {
    let mut client = mapping(vec![decided(2, 9, Accepted)]);
    client.command(ClientCommand::Select(Some(Selection::Loop(pair(2, 9)))));
    assert_eq!(fetched(&mut client), [2, 9]);
    let at =
        |client: &TestClient| client.model.scan_comparison().map(|it| it.map_from_to.position.to_array());
    assert_eq!(at(&client), Some([2.0, 0.3, 0.0]));
    client.command(ClientCommand::SetScanOverlay(ScanOverlay::Graph));
    assert_eq!(at(&client), Some([9.0, 0.0, 0.0]));
    assert_eq!(fetched(&mut client), Vec::<u32>::new(), "they are here already");
    client.apply(ClientEvent::CloudFetched { session: SESSION, keyframe: KeyframeId(2), result: Ok(()) });
    assert_eq!(client.model.cloud(KeyframeId(2)), Some(&CloudState::Ready));
    assert_eq!(client.model.cloud(KeyframeId(9)), Some(&CloudState::Loading));
    client.command(ClientCommand::SetScanOverlay(ScanOverlay::Off));
    assert_eq!((at(&client), client.model.cloud(KeyframeId(2))), (None, None));
    client.apply(ClientEvent::CloudFetched { session: SESSION, keyframe: KeyframeId(9), result: Ok(()) });
    assert_eq!(client.model.cloud(KeyframeId(9)), None, "nobody wants it any more");
}

#[test]
fn a_pair_that_could_not_be_fitted_lies_as_it_was_guessed() {
    let unfitted = LoopDecision { overlap: [0.0; 2], ..decided(2, 9, Rejected) };
    let mut client = mapping(vec![unfitted]);
    client.command(ClientCommand::Select(Some(Selection::Loop(pair(2, 9)))));
    let at = client.model.scan_comparison().unwrap().map_from_to.position.to_array();
    assert_eq!(at, [2.0, 0.0, 0.0]);
}

#[test]
fn the_shift_is_measured_between_guess_and_result() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turned = vocab::Quat { w: half, x: 0.0, y: 0.0, z: half };
    let found = Pose { position: Vec3::new(3.0, 4.0, 0.0), orientation: turned };
    let (metres, radians) = correction_of(&LoopDecision { from_from_to: found, ..decided(0, 5, Accepted) });
    assert!((metres - 5.0).abs() < 1e-9 && (radians - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
}

#[test]
fn decisions_on_loops_add_up_until_another_session_and_the_oldest_go() {
    let mut client = TestClient::connected();
    let mut publish = |reset, added: std::ops::Range<u32>| {
        client.event(api::Event::Loops(LoopsChanged {
            reset,
            added: added.map(|to| decided(0, to, Accepted)).collect(),
        }));
        let loops = client.model.loops.decisions();
        (loops.latest().last().map(|decision| decision.to.0), loops.len())
    };
    assert_eq!(publish(true, 0..2), (Some(0), 2));
    assert_eq!(publish(false, 2..3), (Some(0), 3));
    let most = api::MAX_LOOP_DECISIONS;
    assert_eq!(publish(false, 3..most as u32 + 5), (Some(5), most));
    assert_eq!(publish(true, 0..0), (None, 0));
}

proptest! {
    /// Whatever is decided, undone and refused, undoing everything sends each decision's inverse once.
    #[test]
    fn undoing_everything_is_the_inverse_of_all_that_was_done(kinds in proptest::collection::vec(any::<(bool, u8)>(), 1..40)) {
        let mut client = mapping(vec![]);
        for (accepted, to) in &kinds {
            let pair = pair(0, u32::from(*to) + 2);
            client.command(if *accepted { ClientCommand::AcceptLoop(pair) } else { ClientCommand::RejectLoop(pair) });
        }
        client.take_commands();
        for _ in 0..kinds.len() { client.command(ClientCommand::Undo); }
        let inverse = |(accepted, to): &(bool, u8)| {
            let to = u32::from(*to) + 2;
            if *accepted { reject(0, to) } else { accept(0, to) }
        };
        prop_assert_eq!(client.take_commands(), kinds.iter().rev().map(inverse).collect::<Vec<_>>());
    }
}
