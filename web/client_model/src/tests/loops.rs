//! Loops: which decision counts, what undo sends, choosing two keyframes, which scans are fetched.

use super::*;
use api::LoopVerdict::{Accepted, Held, Rejected};
use api::{LoopDecision, LoopsChanged};

const SESSION: SessionId = SessionId(Uuid::from_u128(4));

fn pair(from: u32, to: u32) -> LoopPair {
    LoopPair::of(KeyframeId(from), KeyframeId(to))
}

fn keyframe(id: u32) -> ClientCommand {
    ClientCommand::Select(Some(Selection::Keyframe(KeyframeId(id))))
}

/// Keyframes a metre apart along x, in control, and these decisions.
fn mapping(decisions: Vec<LoopDecision>) -> Bench {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(ME), name: String::new() }));
    let node = |id: u32| GraphNode {
        id: KeyframeId(id),
        map_from_keyframe: Pose { position: Vec3::new(f64::from(id), 0.0, 0.0), ..Pose::IDENTITY },
        ..GraphNode::default()
    };
    let nodes = (0..20).map(node).collect();
    bench.event(api::Event::Graph(Graph { session: Some(SESSION), nodes, ..Graph::default() }));
    bench.event(api::Event::Loops(LoopsChanged { reset: true, added: decisions }));
    bench.take();
    bench
}

fn fetched(bench: &mut Bench) -> Vec<u32> {
    let cloud = |effect| match effect {
        ClientEffect::FetchCloud { session: SESSION, keyframe } => Some(keyframe.0),
        _ => None,
    };
    bench.take().into_iter().filter_map(cloud).collect()
}

/// The ids of the orders sent, and what they say.
fn sent(bench: &mut Bench) -> Vec<(vocab::CommandId, Command)> {
    let order = |effect| match effect {
        ClientEffect::Send(ClientMessage::Command { id, command: order }) => Some((id, order)),
        _ => None,
    };
    bench.take().into_iter().filter_map(order).collect()
}

fn accept(from: u32, to: u32) -> Command {
    Command::AcceptLoop { from: KeyframeId(from), to: KeyframeId(to) }
}

fn reject(from: u32, to: u32) -> Command {
    Command::RejectLoop { from: KeyframeId(from), to: KeyframeId(to) }
}

#[test]
fn the_last_decision_on_a_pair_counts_and_the_newest_comes_first() {
    let bench = mapping(vec![decided(0, 9, Held), decided(1, 8, Rejected), decided(0, 9, Accepted)]);
    let loops = &bench.model.loops;
    let listed: Vec<_> = loops.latest().map(|it| (it.from.0, it.verdict)).collect();
    assert_eq!(listed, [(0, Accepted), (1, Rejected)]);
    assert_eq!(loops.counts(), LoopCounts { accepted: 1, held: 0, rejected: 1 });
    assert_eq!(loops.get(pair(9, 0)).map(|it| it.verdict), Some(Accepted));
    assert_eq!(loops.nth_latest(1).map(|it| it.from.0), Some(1));
    assert!(loops.nth_latest(2).is_none());
}

#[test]
fn undo_sends_the_other_decision_and_redo_the_first_again() {
    let mut bench = mapping(vec![decided(0, 9, Held)]);
    bench.command(ClientCommand::AcceptLoop(pair(0, 9)));
    bench.command(ClientCommand::Undo);
    bench.command(ClientCommand::Redo);
    bench.command(ClientCommand::UndoLoop);
    assert_eq!(bench.orders(), [accept(0, 9), reject(0, 9), accept(0, 9), reject(0, 9)]);
    assert_eq!(bench.model.last_loop_step(), None);
    bench.command(ClientCommand::UndoLoop);
    assert_eq!(bench.orders(), []);
}

#[test]
fn undo_takes_back_whatever_came_last() {
    let mut bench = mapping(vec![]);
    bench.wait(10.0);
    let dim = ViewSettings { ceiling_m: 5.0, ..ViewSettings::default() };
    bench.command(ClientCommand::RejectLoop(pair(1, 7)));
    bench.command(ClientCommand::EditView(dim.clone()));
    bench.command(ClientCommand::AcceptLoop(pair(2, 8)));
    bench.take();
    bench.command(ClientCommand::Undo);
    assert_eq!((bench.orders(), bench.model.view_settings()), (vec![reject(2, 8)], &dim));
    bench.command(ClientCommand::Undo);
    assert_eq!((bench.orders(), bench.model.view_settings()), (vec![], &ViewSettings::default()));
    bench.command(ClientCommand::Undo);
    assert_eq!(bench.orders(), [accept(1, 7)]);
}

#[test]
fn a_decision_that_was_refused_cannot_be_undone() {
    let mut bench = mapping(vec![]);
    bench.command(ClientCommand::AcceptLoop(pair(0, 9)));
    let (id, _) = sent(&mut bench)[0].clone();
    bench.event(api::Event::CommandDone { id, outcome: CommandOutcome::Refused("No. Propose it.".into()) });
    bench.command(ClientCommand::Undo);
    assert_eq!(bench.orders(), []);
}

#[test]
fn what_others_control_is_undone_later_and_another_session_forgets_it() {
    let mut bench = mapping(vec![]);
    bench.command(ClientCommand::AcceptLoop(pair(0, 9)));
    bench.event(api::Event::Control(Control { owner: Some(OTHER), name: "Anna".into() }));
    bench.take();
    bench.command(ClientCommand::Undo);
    assert_eq!(bench.orders(), []);
    assert!(bench.model.notices.visible()[0].text.contains("Anna controls"));
    assert!(bench.model.last_loop_step().is_some());
    bench.event(api::Event::Graph(Graph { session: None, ..Graph::default() }));
    assert!(bench.model.last_loop_step().is_none());
}

#[test]
fn two_keyframes_are_chosen_and_proposed_with_a_guess_from_the_graph() {
    let mut bench = mapping(vec![]);
    bench.command(ClientCommand::PickLoopKeyframes(true));
    bench.command(keyframe(12));
    bench.command(keyframe(12));
    assert_eq!(bench.model.loop_pick, Some(LoopPick::First), "the same again takes it back");
    bench.command(keyframe(12));
    bench.command(ClientCommand::Select(None));
    assert_eq!(bench.model.loop_pick, Some(LoopPick::Second(KeyframeId(12))));
    bench.command(keyframe(3));
    assert_eq!(bench.model.loop_pick, Some(LoopPick::Both(pair(3, 12))));
    assert_eq!(fetched(&mut bench), [3, 12], "they are laid over each other before they are proposed");
    bench.command(ClientCommand::ProposeLoop);
    let orders = bench.orders();
    let [Command::ProposeLoop { from, to, guess }] = &orders[..] else { panic!("{orders:?}") };
    assert_eq!((from.0, to.0, guess.position.x), (3, 12, 9.0));
    assert!(bench.model.proposed.is_some() && bench.model.loop_pick.is_none());

    bench.event(api::Event::Loops(LoopsChanged { reset: false, added: vec![decided(3, 12, Held)] }));
    assert_eq!(bench.model.selection, Some(Selection::Loop(pair(3, 12))), "what came of it is shown");
    assert!(bench.model.proposed.is_none());
}

#[test]
fn a_drifted_pair_can_be_guessed_at_the_same_place() {
    let mut bench = mapping(vec![]);
    for command in [
        ClientCommand::PickLoopKeyframes(true),
        keyframe(2),
        keyframe(15),
        ClientCommand::SetLoopInitialGuess(LoopInitialGuess::SamePlace),
    ] {
        bench.command(command);
    }
    bench.command(ClientCommand::ProposeLoop);
    let proposed =
        |order: &Command| matches!(order, Command::ProposeLoop { guess, .. } if guess.position.x == 0.0);
    assert!(bench.orders().iter().any(proposed));
}

#[test]
fn a_proposal_that_nothing_comes_of_is_given_up_and_a_refused_one_at_once() {
    for refused in [false, true] {
        let mut bench = mapping(vec![]);
        for command in
            [ClientCommand::PickLoopKeyframes(true), keyframe(2), keyframe(15), ClientCommand::ProposeLoop]
        {
            bench.command(command);
        }
        let (id, _) = sent(&mut bench).pop().unwrap();
        if refused {
            let outcome = CommandOutcome::Refused("No. Choose two others.".into());
            bench.event(api::Event::CommandDone { id, outcome });
        } else {
            bench.wait(29.0);
            assert!(bench.model.proposed.is_some());
            bench.wait(2.0);
        }
        assert!(bench.model.proposed.is_none());
    }
}

#[test]
fn scans_lie_as_found_as_in_the_graph_or_not_at_all() {
    let mut bench = mapping(vec![decided(2, 9, Accepted)]);
    bench.command(ClientCommand::Select(Some(Selection::Loop(pair(2, 9)))));
    assert_eq!(fetched(&mut bench), [2, 9]);
    let at = |bench: &Bench| bench.model.scan_comparison().map(|it| it.map_from_to.position.to_array());
    assert_eq!(at(&bench), Some([2.0, 0.3, 0.0]));
    bench.command(ClientCommand::SetScanOverlay(ScanOverlay::Graph));
    assert_eq!(at(&bench), Some([9.0, 0.0, 0.0]));
    assert_eq!(fetched(&mut bench), [], "they are here already");
    bench.apply(ClientEvent::CloudFetched { session: SESSION, keyframe: KeyframeId(2), result: Ok(()) });
    assert_eq!(bench.model.cloud(KeyframeId(2)), Some(&CloudState::Ready));
    assert_eq!(bench.model.cloud(KeyframeId(9)), Some(&CloudState::Loading));
    bench.command(ClientCommand::SetScanOverlay(ScanOverlay::Off));
    assert_eq!((at(&bench), bench.model.cloud(KeyframeId(2))), (None, None));
    bench.apply(ClientEvent::CloudFetched { session: SESSION, keyframe: KeyframeId(9), result: Ok(()) });
    assert_eq!(bench.model.cloud(KeyframeId(9)), None, "nobody wants it any more");
}

#[test]
fn a_pair_that_could_not_be_fitted_lies_as_it_was_guessed() {
    let unfitted = LoopDecision { overlap: [0.0; 2], ..decided(2, 9, Rejected) };
    let mut bench = mapping(vec![unfitted]);
    bench.command(ClientCommand::Select(Some(Selection::Loop(pair(2, 9)))));
    let at = bench.model.scan_comparison().unwrap().map_from_to.position.to_array();
    assert_eq!(at, [2.0, 0.0, 0.0]);
}

#[test]
fn the_shift_is_measured_between_guess_and_result() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turned = vocab::Quat { w: half, x: 0.0, y: 0.0, z: half };
    let found = Pose { position: Vec3::new(3.0, 4.0, 0.0), orientation: turned };
    let (metres, radians) = shift(&LoopDecision { from_from_to: found, ..decided(0, 5, Accepted) });
    assert!((metres - 5.0).abs() < 1e-9 && (radians - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
}

proptest! {
    /// Whatever is decided, undone and refused, undoing everything sends each decision's inverse once.
    #[test]
    fn undoing_everything_is_the_inverse_of_all_that_was_done(kinds in proptest::collection::vec(any::<(bool, u8)>(), 1..40)) {
        let mut bench = mapping(vec![]);
        for (accepted, to) in &kinds {
            let pair = pair(0, u32::from(*to) + 2);
            bench.command(if *accepted { ClientCommand::AcceptLoop(pair) } else { ClientCommand::RejectLoop(pair) });
        }
        bench.orders();
        for _ in 0..kinds.len() { bench.command(ClientCommand::Undo); }
        let inverse = |(accepted, to): &(bool, u8)| {
            let to = u32::from(*to) + 2;
            if *accepted { reject(0, to) } else { accept(0, to) }
        };
        prop_assert_eq!(bench.orders(), kinds.iter().rev().map(inverse).collect::<Vec<_>>());
    }
}
