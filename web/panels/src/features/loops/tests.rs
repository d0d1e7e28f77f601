//! The loops of a map: list, evidence, deciding, adding by hand.

use crate::features::tabs;
use crate::screens;
use crate::test_support::{OTHER, TestClient, click, contrast, running, value};
use crate::theme::Tokens;
use api::LoopVerdict::{Accepted, Held, Rejected};
use api::{Control, Event, Graph, GraphNode, LoopDecision, LoopSource, LoopVerdict, LoopsChanged};
use client_model::{
    CameraMove, ClientCommand, ClientEvent, ClientTime, LoopPair, LoopPick, ScanOverlay, Selection, Theme,
};
use egui_kittest::kittest::Queryable;
use uuid::Uuid;
use vocab::{KeyframeId, Pose, SessionId, Vec3};

fn pair(from: u32, to: u32) -> LoopPair {
    LoopPair::of(KeyframeId(from), KeyframeId(to))
}

fn decided(from: u32, to: u32, verdict: LoopVerdict) -> LoopDecision {
    LoopDecision {
        from: KeyframeId(from),
        to: KeyframeId(to),
        source: LoopSource::Appearance(0.2),
        verdict,
        by_hand: false,
        reason: "It fits, and lies where the graph expects it.".into(),
        overlap: [0.766, 0.635],
        residual_m: 0.0302,
        free_space_violation: [0.004, 0.0],
        runner_up_ratio: 0.42,
        guess: Pose::IDENTITY,
        from_from_to: Pose { position: Vec3::new(0.12, 0.0, 0.0), ..Pose::IDENTITY },
    }
}

fn loops(decisions: Vec<LoopDecision>) -> TestClient {
    let node = |id: u32| GraphNode {
        id: KeyframeId(id),
        map_from_keyframe: Pose { position: Vec3::new(f64::from(id), 0.0, 0.0), ..Pose::IDENTITY },
        ..GraphNode::default()
    };
    let graph = Graph {
        session: Some(SessionId(Uuid::from_u128(5))),
        nodes: (0..200).map(node).collect(),
        ..Graph::default()
    };
    let mut client = TestClient::connected()
        .event(Event::Mapping(running()))
        .event(Event::Graph(graph))
        .event(Event::Loops(LoopsChanged { reset: true, added: decisions }))
        .on(screens::MAP);
    client.panels.frame.open_tab(super::TAB);
    client
}

#[test]
fn loops_are_counted_and_the_newest_is_listed_first_of_those_in_sight() {
    let mut decisions: Vec<LoopDecision> = (10..190).map(|to| decided(0, to, Accepted)).collect();
    decisions.push(decided(3, 199, Held));
    decisions.push(decided(4, 198, Rejected));
    let harness = loops(decisions).shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Accepted loops"), "180");
    assert_eq!(value(&harness, "Under test loops"), "1");
    assert_eq!(value(&harness, "Rejected loops"), "1");
    let rows: Vec<_> = harness.get_all_by_label_contains("lies where the graph expects it").collect();
    assert!((5..40).contains(&rows.len()), "only what is in sight is made: {} rows", rows.len());
    let newest =
        harness.get_by_label("Loop 4 → 198: rejected. It fits, and lies where the graph expects it.");
    let next =
        harness.get_by_label("Loop 3 → 199: under test. It fits, and lies where the graph expects it.");
    assert!(newest.rect().bottom() <= next.rect().top());
    assert!(newest.rect().height() >= 44.0);
}

#[test]
fn choosing_a_row_selects_the_loop_and_moves_the_camera_there() {
    let mut harness = loops(vec![decided(5, 150, Held)]).shown(1440.0, 900.0);
    harness.get_by_label_contains("Loop 5 → 150").click();
    harness.run_steps(2);
    let commands = &harness.state().commands;
    assert!(commands.contains(&ClientCommand::Select(Some(Selection::Loop(pair(5, 150))))), "{commands:?}");
    assert!(commands.contains(&ClientCommand::MoveCamera(CameraMove::Loop(pair(5, 150)))), "{commands:?}");
}

#[test]
fn the_evidence_has_a_unit_for_every_number() {
    let selected = ClientCommand::Select(Some(Selection::Loop(pair(5, 150))));
    for (width, height) in [(1440.0, 900.0), (1024.0, 768.0)] {
        let harness = loops(vec![decided(5, 150, Held)]).command(selected.clone()).shown(width, height);
        for (name, expected) in [
            ("Overlap", "77 % and 64 %"),
            ("Residual", "3.0 cm"),
            ("Free-space violation", "0.4 % and 0 %"),
            ("Runner-up", "42 % as good"),
            ("Correction", "0.12 m, 0.0°"),
            ("Found by", "likeness 80 %"),
        ] {
            assert_eq!(value(&harness, name), expected, "{name}");
        }
        let verdict = value(&harness, "Verdict");
        assert_eq!(verdict, "Under test. It fits, and lies where the graph expects it.");
    }
}

#[test]
fn a_loop_selected_in_the_scene_brings_its_evidence_forth() {
    let mut client = loops(vec![decided(5, 150, Held)]).on(screens::LIVE);
    client.panels.frame.open_tab(tabs::SESSION);
    let mut harness = client.shown(1024.0, 768.0);
    assert!(harness.query_by_label("Verdict").is_none());
    let selected = ClientEvent::Command(ClientCommand::Select(Some(Selection::Loop(pair(5, 150)))));
    harness.state_mut().model.handle_event(ClientTime(1.0), selected, &mut Vec::new());
    harness.run_steps(2);
    assert!(harness.state().emitted(&ClientCommand::ShowScreen(screens::MAP)));
    let client = harness.state_mut();
    client.model.handle_event(
        ClientTime(1.0),
        ClientEvent::Command(ClientCommand::ShowScreen(screens::MAP)),
        &mut Vec::new(),
    );
    harness.run_steps(2);
    assert!(harness.query_by_label("Verdict").is_some(), "the drawer opens by itself");
}

#[test]
fn a_loop_can_be_decided_on_as_its_verdict_allows() {
    let unfitted = LoopDecision { overlap: [0.0; 2], ..decided(1, 90, Rejected) };
    for (decision, accept, reject) in [
        (decided(1, 90, Held), true, true),
        (decided(1, 90, Accepted), false, true),
        (decided(1, 90, Rejected), true, false),
        (unfitted, false, false),
    ] {
        let selected = ClientCommand::Select(Some(Selection::Loop(pair(1, 90))));
        let mut harness = loops(vec![decision]).command(selected).shown(1440.0, 900.0);
        click(&mut harness, "Accept loop");
        click(&mut harness, "Reject loop");
        let client = harness.state();
        assert_eq!(client.emitted(&ClientCommand::AcceptLoop(pair(1, 90))), accept, "{:?}", client.commands);
        assert_eq!(client.emitted(&ClientCommand::RejectLoop(pair(1, 90))), reject, "{:?}", client.commands);
    }
}

#[test]
fn who_does_not_control_is_told_why_nothing_can_be_decided() {
    let control = Control { owner: Some(OTHER), name: "Anna".into(), request: None };
    let selected = ClientCommand::Select(Some(Selection::Loop(pair(1, 90))));
    let client = loops(vec![decided(1, 90, Held)]).event(Event::Control(control)).command(selected);
    let mut harness = client.shown(1440.0, 900.0);
    for button in ["Accept loop", "Reject loop", "Add a loop"] {
        click(&mut harness, button);
    }
    let forbidden = |command: &ClientCommand| {
        matches!(
            command,
            ClientCommand::AcceptLoop(_) | ClientCommand::RejectLoop(_) | ClientCommand::PickLoopKeyframes(_)
        )
    };
    assert!(!harness.state().commands.iter().any(forbidden), "{:?}", harness.state().commands);
    let remarks = harness.get_all_by_value("Anna controls the robot. Take control to decide on loops.");
    assert!(remarks.count() >= 1);
}

#[test]
fn adding_a_loop_says_which_step_it_is_and_ends_in_a_proposal() {
    let keyframe = |id| ClientCommand::Select(Some(Selection::Keyframe(KeyframeId(id))));
    let mut harness = loops(Vec::new()).shown(1440.0, 900.0);
    click(&mut harness, "Add a loop");
    assert!(harness.state().emitted(&ClientCommand::PickLoopKeyframes(true)));

    let both = loops(Vec::new())
        .command(ClientCommand::PickLoopKeyframes(true))
        .command(keyframe(150))
        .command(keyframe(5));
    assert_eq!(both.model.loop_pick(), Some(LoopPick::Both(pair(5, 150))));
    let mut harness = both.shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Message"), "Step 3 of 3: propose keyframes 5 → 150 as a loop.");
    assert_eq!(value(&harness, "Apart in the graph"), "145.0 m");
    click(&mut harness, "Propose");
    assert!(harness.state().emitted(&ClientCommand::ProposeLoop));

    let adjacent = loops(Vec::new())
        .command(ClientCommand::PickLoopKeyframes(true))
        .command(keyframe(8))
        .command(keyframe(9));
    let mut harness = adjacent.shown(1440.0, 900.0);
    click(&mut harness, "Propose");
    assert!(!harness.state().emitted(&ClientCommand::ProposeLoop), "they are joined already");
}

#[test]
fn escape_stops_and_puts_away_what_is_selected_or_begun() {
    let selected = ClientCommand::Select(Some(Selection::Loop(pair(1, 90))));
    for (before, expected) in [
        (selected, ClientCommand::Select(None)),
        (ClientCommand::PickLoopKeyframes(true), ClientCommand::PickLoopKeyframes(false)),
    ] {
        let mut harness = loops(vec![decided(1, 90, Held)]).command(before).shown(1440.0, 900.0);
        harness.key_press(egui::Key::Escape);
        harness.run_steps(2);
        let commands = &harness.state().commands;
        assert!(
            commands.contains(&expected) && commands.contains(&ClientCommand::StopMotion),
            "{commands:?}"
        );
    }
}

#[test]
fn the_last_decision_can_be_undone_with_a_button() {
    let mut harness = loops(vec![decided(1, 90, Held)]).shown(1440.0, 900.0);
    click(&mut harness, "Undo the decision");
    assert!(!harness.state().emitted(&ClientCommand::UndoLoop), "nothing to undo");
    let client = loops(vec![decided(1, 90, Held)]).command(ClientCommand::AcceptLoop(pair(1, 90)));
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Undo the decision");
    assert!(harness.state().emitted(&ClientCommand::UndoLoop));
}

#[test]
fn the_overlay_can_be_chosen() {
    let selected = ClientCommand::Select(Some(Selection::Loop(pair(1, 90))));
    let mut harness = loops(vec![decided(1, 90, Held)]).command(selected).shown(1440.0, 900.0);
    for (button, overlay) in [("In the graph", ScanOverlay::Graph), ("Map only", ScanOverlay::Off)] {
        click(&mut harness, button);
        assert!(harness.state().emitted(&ClientCommand::SetScanOverlay(overlay)));
    }
}

#[test]
fn colours_of_loops_stand_out_in_every_theme() {
    for name in Theme::ALL {
        let tokens = Tokens::of(name);
        let least = if name == Theme::Sunlight { 10.0 } else { 4.5 };
        for colour in [tokens.closed, tokens.older, tokens.newer] {
            let card = tokens.card.to_opaque();
            assert!(contrast(colour, card) >= least, "{name:?}: {colour:?} on {card:?}");
        }
    }
}
