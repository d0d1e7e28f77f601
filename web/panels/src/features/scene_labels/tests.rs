//! Labels can be clicked, say what they are, and show their tags.

use super::{SceneLabel, show_labels};
use crate::test_support::TestClient;
use crate::theme::{self, Tokens};
use api::SurveyReason;
use client_model::{ClientCommand, Selection, Theme};
use egui::{pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use vocab::KeyframeId;

/// These labels in a window of 800 x 600 points, and the commands that they emitted.
fn shown<'a>(labels: Vec<SceneLabel>) -> Harness<'a, Vec<ClientCommand>> {
    let mut has_fonts = false;
    let model = TestClient::connected().model;
    let mut harness = Harness::builder().with_size(vec2(800.0, 600.0)).build_ui_state(
        move |ui, commands: &mut Vec<ClientCommand>| {
            if has_fonts {
                show_labels(ui, &model, &Tokens::of(Theme::Dark), &labels, commands);
            } else {
                theme::install_fonts(ui.ctx());
                has_fonts = true;
            }
        },
        Vec::new(),
    );
    harness.run_steps(3);
    harness
}

#[test]
fn a_click_selects_a_keyframe_and_a_second_one_deselects_it() {
    let keyframe = KeyframeId(41);
    for (is_selected, expected) in [(false, Some(Selection::Keyframe(keyframe))), (true, None)] {
        let label = SceneLabel::keyframe(pos2(400.0, 300.0), keyframe, None, is_selected);
        let mut harness = shown(vec![label]);
        harness.get_by_label("Keyframe 41").click();
        harness.run_steps(2);
        assert_eq!(*harness.state(), [ClientCommand::Select(expected)]);
    }
}

#[test]
fn labels_that_select_nothing_are_no_buttons() {
    let harness = shown(vec![SceneLabel::dock(pos2(400.0, 300.0), 1)]);
    assert!(harness.query_by_label("Dock 1 in the scene").is_none());
}

#[test]
fn tags_carry_units() {
    let at = pos2(400.0, 300.0);
    let keyframe = |sigma_m, is_selected| SceneLabel::keyframe(at, KeyframeId(41), sigma_m, is_selected).tag;
    for (tag, expected) in [
        (
            SceneLabel::robot(egui::Rect::from_center_size(at, vec2(40.0, 30.0)), 0.84, false).tag,
            "Robot · 0.8 m/s",
        ),
        (SceneLabel::goal(at, 12.34).tag, "Goal · 12.3 m"),
        (
            SceneLabel::survey_target(at, 1, SurveyReason::FromAfar { area_m2: 34.0 }).tag,
            "Seen from afar only · 34 m²",
        ),
        (
            SceneLabel::survey_target(at, 2, SurveyReason::Uncertain { deviation_m: 0.42 }).tag,
            "Known to 0.42 m only",
        ),
        (keyframe(Some(0.0), true), "Keyframe 41 · known to 1 mm"),
        (keyframe(None, true), "Keyframe 41"),
        (keyframe(Some(0.0), false), ""),
    ] {
        assert_eq!(tag, expected);
    }
}
