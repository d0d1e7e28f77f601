//! The palette of the mission editor.

use crate::screens;
use crate::test_support::click;
use crate::test_support::missions::{carry_out, mission, names, point, with_mission};
use egui_kittest::kittest::Queryable;

#[test]
fn an_entry_that_is_pressed_is_added_behind_what_is_selected() {
    let mut harness = with_mission(&[point(2), point(3)]).shown(1440.0, 900.0);
    click(&mut harness, "Task 1 P2");
    carry_out(&mut harness);
    click(&mut harness, "Add inspection point P5");
    carry_out(&mut harness);
    assert_eq!(names(harness.state()), ["P2", "P5", "P3"]);
    // The new one is selected, so that the next goes behind it.
    click(&mut harness, "Add action Wait");
    carry_out(&mut harness);
    assert_eq!(names(harness.state()), ["P2", "P5", "N5", "P3"]);
    assert_eq!(mission(harness.state()).tasks.len(), 4);
}

#[test]
fn the_search_finds_names_and_actions() {
    let mut harness = with_mission(&[]).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Add node N4").is_some());
    harness.get_by_label("Search places and actions").focus();
    harness.run_steps(2);
    harness.get_by_label("Search places and actions").type_text("p4");
    harness.run_steps(3);
    assert!(harness.query_by_label("Add inspection point P4").is_some());
    assert!(
        harness.query_by_label("Add node N4").is_none()
            && harness.query_by_label("Add action Wait").is_none()
    );
}

#[test]
fn the_palette_is_a_card_beside_the_tools_and_part_of_the_sheet_on_narrow_windows() {
    for (width, height) in [(1440.0, 900.0), (1024.0, 768.0)] {
        let mut harness = with_mission(&[point(2)]).shown(width, height);
        if width < 1100.0 {
            assert!(harness.query_by_label("Places and actions").is_none(), "nothing to drop it into");
            click(&mut harness, "Open panel");
            harness.run_steps(2);
        }
        let palette = harness.get_by_label("Add inspection point P2").rect();
        let task = harness.get_by_label("Task 1 P2").rect();
        let tools = harness.get_by_label("Theme").rect();
        assert!(
            tools.right() < palette.left() && palette.right() < task.left(),
            "{width}: {palette:?} {task:?}"
        );
        assert!(harness.query_by_label("Joystick").is_none(), "the drive card gives way");
    }
    let mut harness = with_mission(&[point(2)]).shown(390.0, 844.0);
    click(&mut harness, "Missions");
    carry_out(&mut harness);
    assert!(harness.query_by_label("Add inspection point P2").is_none());
    click(&mut harness, "Add tasks");
    click(&mut harness, "Add inspection point P2");
    carry_out(&mut harness);
    assert_eq!(names(harness.state()), ["P2", "P2"]);
}

#[test]
fn other_screens_have_no_palette() {
    let harness = with_mission(&[point(2)]).on(screens::SITE).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Places and actions").is_none());
}
