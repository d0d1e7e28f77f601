//! The tool column: switches, menus, and folding on narrow windows.

use crate::test_support::{TestClient, click};
use client_model::{CameraMove, ClientCommand, ColourBy, ViewSettings};
use egui::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

/// The view settings that the panel asked for last.
fn edited<'a>(harness: &'a Harness<'_, TestClient>) -> Option<&'a ViewSettings> {
    harness.state().commands.iter().rev().find_map(|command| match command {
        ClientCommand::EditView(settings) => Some(settings),
        _ => None,
    })
}

#[test]
fn a_colour_is_chosen_in_its_menu() {
    let mut harness = TestClient::connected().shown(1440.0, 900.0);
    assert!(harness.query_by_label("Colour by intensity").is_none(), "the menu is closed");
    click(&mut harness, "Colour");
    click(&mut harness, "Colour by intensity");
    assert_eq!(edited(&harness).map(|settings| settings.colour), Some(ColourBy::Intensity));
}

#[test]
fn following_the_robot_moves_the_camera_to_it() {
    for follow in [true, false] {
        let settings = ViewSettings { follow, ..ViewSettings::default() };
        let mut harness =
            TestClient::connected().command(ClientCommand::EditView(settings)).shown(1440.0, 900.0);
        click(&mut harness, "Follow robot");
        assert_eq!(edited(&harness).map(|settings| settings.follow), Some(!follow));
        let moved = harness.state().emitted(&ClientCommand::MoveCamera(CameraMove::Robot));
        assert_eq!(moved, !follow, "only when following begins");
    }
}

#[test]
fn a_view_is_remembered_under_the_name_typed_or_a_number() {
    for (typed, expected) in [(" Pump hall ", "Pump hall"), ("", "View 1")] {
        let mut harness = TestClient::connected().shown(1440.0, 900.0);
        click(&mut harness, "Remembered views");
        harness.state_mut().panels.features.view_settings.bookmark_name = typed.into();
        click(&mut harness, "Remember this view");
        let save = ClientCommand::MoveCamera(CameraMove::SaveBookmark(expected.into()));
        assert!(harness.state().emitted(&save), "{:?}", harness.state().commands);
    }
}

#[test]
fn on_a_narrow_window_the_tools_unfold() {
    let mut harness = TestClient::connected().shown(390.0, 844.0);
    assert!(harness.query_by_label("Fit view").is_none());
    harness.get_by_role_and_label(Role::Button, "View tools").click();
    harness.run_steps(2);
    click(&mut harness, "Fit view");
    assert!(harness.state().emitted(&ClientCommand::MoveCamera(CameraMove::Fit)));
    assert!(harness.query_by_label("Keyboard shortcuts").is_none(), "a narrow window has no keyboard");
}
