//! The mission editor: dragging with the pointer and by keys, order, name, running.

use crate::test_support::missions::{carry_out, confirmed, mission, names, node, point, with_mission};
use crate::test_support::{TestClient, click, value};
use client_model::ClientCommand;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use site_model::{MissionEnd, TaskOrder};

/// Presses the pointer's button, or lets it go.
fn press(harness: &mut Harness<'_, TestClient>, pos: Pos2, pressed: bool) {
    let modifiers = Modifiers::NONE;
    harness.input_mut().events.push(Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers,
    });
    harness.run_steps(1);
    carry_out(harness);
}

fn move_to(harness: &mut Harness<'_, TestClient>, pos: Pos2) {
    harness.input_mut().events.push(Event::PointerMoved(pos));
    harness.run_steps(1);
    carry_out(harness);
}

/// Drags from a control to a point, in steps as a hand does.
fn drag(harness: &mut Harness<'_, TestClient>, from: &str, to: Pos2) {
    let start = harness.get_by_label(from).rect().center();
    move_to(harness, start);
    press(harness, start, true);
    for step in 1..=8 {
        move_to(harness, start + (to - start) * (step as f32 / 8.0));
    }
}

fn drop_at(harness: &mut Harness<'_, TestClient>, at: Pos2) {
    press(harness, at, false);
    harness.run_steps(2);
    carry_out(harness);
}

#[test]
fn a_task_is_dragged_by_its_handle_or_its_row_and_one_drag_is_one_undo() {
    for from in ["Move task 1 P2", "Task 1 P2"] {
        let mut harness = with_mission(&[point(2), point(3), point(4)]).shown(1440.0, 900.0);
        let last = harness.get_by_label("Task 3 P4").rect().center();
        drag(&mut harness, from, last);
        assert_eq!(names(harness.state()), ["P2", "P3", "P4"], "nothing is changed before the drop");
        assert!(harness.query_by_label("Task 3 P2").is_some(), "and shown where it would be");
        drop_at(&mut harness, last);
        assert_eq!(names(harness.state()), ["P3", "P4", "P2"]);
        assert!(harness.state().model.missions.drag().is_none());
        click(&mut harness, "Undo edit");
        carry_out(&mut harness);
        assert_eq!(names(harness.state()), ["P2", "P3", "P4"]);
        click(&mut harness, "Redo edit");
        carry_out(&mut harness);
        assert_eq!(names(harness.state()), ["P3", "P4", "P2"]);
    }
}

#[test]
fn an_entry_of_the_palette_is_dragged_into_the_list_and_its_route_shown_meanwhile() {
    let mut harness = with_mission(&[point(2), point(4)]).shown(1440.0, 900.0);
    let before = value(&harness, "Way");
    let second = harness.get_by_label("Task 2 P4").rect().center();
    drag(&mut harness, "Add inspection point P5", second);
    assert_ne!(value(&harness, "Way"), before);
    drop_at(&mut harness, second);
    assert_eq!(names(harness.state()), ["P2", "P5", "P4"]);
    let selected = harness.state().model.missions.selected();
    assert!(selected.contains(&mission(harness.state()).tasks[1].id), "to be filled in");
}

#[test]
fn escape_cancels_a_drag_and_stops_nothing_and_outside_the_list_nothing_is_dropped() {
    let mut harness = with_mission(&[point(2), point(3)]).shown(1440.0, 900.0);
    let last = harness.get_by_label("Task 2 P3").rect().center();
    drag(&mut harness, "Move task 1 P2", last);
    harness.key_press(Key::Escape);
    harness.run_steps(1);
    let stopped = harness.state().emitted(&ClientCommand::StopMotion);
    carry_out(&mut harness);
    assert!(!stopped && harness.state().model.missions.drag().is_none());
    drop_at(&mut harness, last);
    assert_eq!(names(harness.state()), ["P2", "P3"]);
    let outside = Pos2::new(640.0, 500.0);
    drag(&mut harness, "Add node N4", outside);
    drop_at(&mut harness, outside);
    assert_eq!(names(harness.state()), ["P2", "P3"]);
    assert!(harness.state().model.missions.drag().is_none());
}

#[test]
fn a_long_list_scrolls_while_something_is_dragged_to_its_edge() {
    let tasks: Vec<_> = (0..30).map(|number| point(2 + number % 4)).collect();
    let mut harness = with_mission(&tasks).shown(1440.0, 900.0);
    let first = harness.get_by_label("Task 1 P2").rect();
    let bottom = Pos2::new(first.center().x, harness.get_by_label("Run now").rect().top() - 24.0);
    drag(&mut harness, "Move task 1 P2", bottom);
    for _ in 0..400 {
        harness.run_steps(1);
        carry_out(&mut harness);
    }
    drop_at(&mut harness, bottom);
    let tasks = mission(harness.state()).tasks.clone();
    let place = tasks.iter().position(|task| {
        harness.state().model.missions.plan().is_some_and(|plan| plan.mission.tasks[29].id == task.id)
    });
    assert_eq!(place, Some(29));
    assert_eq!(names(harness.state())[29], "P2", "the first one is the last now");
}

#[test]
fn a_task_is_moved_by_keys_and_the_robot_does_not_walk_meanwhile() {
    let mut harness = with_mission(&[point(2), point(3), point(4)]).shown(1440.0, 900.0);
    let press_key = |harness: &mut Harness<'_, TestClient>, key: Key| {
        harness.key_press(key);
        harness.run_steps(1);
        let walked =
            harness.state().commands.iter().any(|it| matches!(it, ClientCommand::SetVelocity(Some(_))));
        assert!(!walked, "{key:?}");
        carry_out(harness);
    };
    harness.get_by_label("Move task 1 P2").focus();
    harness.run_steps(2);
    press_key(&mut harness, Key::Enter);
    assert!(
        harness.query_by_label_contains("Moving").is_some()
            || harness.state().model.missions.drag().is_some()
    );
    press_key(&mut harness, Key::ArrowDown);
    press_key(&mut harness, Key::ArrowDown);
    assert_eq!(names(harness.state()), ["P2", "P3", "P4"], "not dropped yet");
    press_key(&mut harness, Key::Enter);
    assert_eq!(names(harness.state()), ["P3", "P4", "P2"]);
    // Once more, and back with Escape.
    press_key(&mut harness, Key::Enter);
    press_key(&mut harness, Key::ArrowUp);
    press_key(&mut harness, Key::Escape);
    assert!(harness.state().model.missions.drag().is_none());
    assert_eq!(names(harness.state()), ["P3", "P4", "P2"]);
    harness.state_mut().commands.push(ClientCommand::Undo);
    carry_out(&mut harness);
    assert_eq!(names(harness.state()), ["P2", "P3", "P4"], "one step");
}

#[test]
fn several_tasks_are_selected_with_ctrl_and_shift_and_deleted_together() {
    let mut harness = with_mission(&[point(2), point(3), point(4), point(5)]).shown(1440.0, 1200.0);
    let click_with = |harness: &mut Harness<'_, TestClient>, name: &str, modifiers: Modifiers| {
        harness.get_by_label(name).click_modifiers(modifiers);
        harness.run_steps(2);
        carry_out(harness);
    };
    click_with(&mut harness, "Task 1 P2", Modifiers::NONE);
    click_with(&mut harness, "Task 3 P4", Modifiers::SHIFT);
    assert_eq!(harness.state().model.missions.selected().len(), 3);
    click_with(&mut harness, "Task 2 P3", Modifiers::COMMAND);
    assert_eq!(harness.state().model.missions.selected().len(), 2);
    click(&mut harness, "Delete task");
    carry_out(&mut harness);
    assert_eq!(names(harness.state()), ["P3", "P5"]);
}

#[test]
fn the_shortest_order_is_shown_taken_or_declined() {
    let mut harness = with_mission(&[point(5), point(2), point(4)]).shown(1440.0, 900.0);
    let optimise = "Optimise: −40 s";
    click(&mut harness, optimise);
    carry_out(&mut harness);
    assert!(harness.query_by_label_contains("The shortest order saves 40 s and 28 m of walking.").is_some());
    click(&mut harness, "Keep my order");
    carry_out(&mut harness);
    assert_eq!(names(harness.state()), ["P5", "P2", "P4"]);
    click(&mut harness, optimise);
    carry_out(&mut harness);
    click(&mut harness, "Use this order");
    carry_out(&mut harness);
    assert_ne!(names(harness.state()), ["P5", "P2", "P4"]);
    assert!(harness.query_by_label(optimise).is_none(), "nothing is left to gain");
}

#[test]
fn order_and_end_are_set() {
    let mut harness = with_mission(&[point(5), point(2), point(4)]).shown(1440.0, 1100.0);
    click(&mut harness, "Shortest");
    carry_out(&mut harness);
    click(&mut harness, "Keep the first");
    carry_out(&mut harness);
    assert_eq!(mission(harness.state()).order, TaskOrder::Shortest { keep_first: true, keep_last: false });
    click(&mut harness, "Stay there");
    carry_out(&mut harness);
    assert_eq!(mission(harness.state()).end, MissionEnd::Stay);
    click(&mut harness, "A node");
    carry_out(&mut harness);
    click(&mut harness, "Go to node");
    click(&mut harness, "N3");
    carry_out(&mut harness);
    assert!(matches!(mission(harness.state()).end, MissionEnd::Node(node) if node.0.as_u128() == 3));
}

#[test]
fn what_cannot_be_reached_is_told_and_the_mission_is_renamed() {
    let mut harness = with_mission(&[point(2), node(9)]).shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Problem of task 2"), "No way from N2: no edges lead there.");
    harness.get_by_label("Mission name").focus();
    harness.run_steps(2);
    harness.get_by_label("Mission name").type_text(" morning");
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert_eq!(mission(harness.state()).name, "Mission 1 morning");
}

#[test]
fn a_mission_runs_once_the_robot_has_the_last_edit() {
    let mut harness = with_mission(&[point(2)]).shown(1440.0, 900.0);
    click(&mut harness, "Run now");
    let started = |harness: &Harness<'_, TestClient>, is_queued| {
        let mission = mission(harness.state()).id;
        harness.state().emitted(&ClientCommand::StartMission { mission, is_queued })
    };
    assert!(!started(&harness, false), "an edit is under way");
    assert!(harness.query_by_label_contains("Waiting until the robot has the last edit").is_some());
    let mut harness = confirmed(harness.state()).shown(1440.0, 900.0);
    click(&mut harness, "Run now");
    assert!(started(&harness, false));
    click(&mut harness, "Queue");
    assert!(started(&harness, true));
}

#[test]
fn everything_of_the_editor_is_within_the_window_on_all_sizes() {
    for (width, height) in [(1440.0, 900.0), (1024.0, 768.0), (390.0, 844.0)] {
        let mut harness = with_mission(&[point(2), node(9)]).shown(width, height);
        if width < 700.0 {
            click(&mut harness, "Missions");
        } else if width < 1100.0 {
            click(&mut harness, "Open panel");
        }
        for name in [
            "All missions",
            "Mission name",
            "Undo edit",
            "Redo edit",
            "Expected time",
            "Way",
            "Run now",
            "Queue",
        ] {
            let rect = harness.get_by_label(name).rect();
            let window = egui::Rect::from_min_size(Pos2::ZERO, vec2(width, height));
            assert!(window.contains_rect(rect) && rect.height() > 0.0, "{width}: {name} at {rect:?}");
        }
        let stop = harness.get_by_label("Stop motion").rect();
        assert!(stop.right() > width - 24.0);
    }
}

#[test]
fn order_constraints_are_added_shown_and_a_circle_is_named_with_what_ends_it() {
    let mut harness = with_mission(&[point(2), point(3), point(4)]).shown(1440.0, 2400.0);
    let constraints = |harness: &Harness<'_, TestClient>| mission(harness.state()).order_constraints.len();
    press_name(&mut harness, "Task 2 P3");
    press_name(&mut harness, "Comes after");
    press_name(&mut harness, "3 P4");
    assert_eq!(constraints(&harness), 1);
    let said = value(&harness, "Problem of the order");
    assert_eq!(said, "3 P4 has to come before 2 P3, but the list has them the other way round.");
    press_name(&mut harness, "Put the list in this order");
    assert_eq!(names(harness.state()), ["P2", "P4", "P3"]);
    assert!(harness.query_by_label("Problem of the order").is_none());
    assert!(harness.query_by_label("Remove: After 2 P4").is_some());

    press_name(&mut harness, "Comes before");
    press_name(&mut harness, "2 P4");
    let said = value(&harness, "Problem of the order");
    assert!(said.contains("2 P4 → 3 P3 → 2 P4") || said.contains("3 P3 → 2 P4 → 3 P3"), "{said}");
    press_name(&mut harness, "Remove: 3 P3 before 2 P4");
    assert!(harness.query_by_label("Problem of the order").is_none());
    click(&mut harness, "Undo edit");
    carry_out(&mut harness);
    assert_eq!(constraints(&harness), 2);
}

/// Clicks the control of this name and carries out what it emitted.
fn press_name(harness: &mut Harness<'_, TestClient>, name: &str) {
    click(harness, name);
    carry_out(harness);
}
