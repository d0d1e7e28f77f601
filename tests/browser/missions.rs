//! The Missions screen in a real browser: a mission is made by mouse, keys and touch, and is on the robot afterwards.

use super::mapping::wait_for_drawn_map;
use crate::support::chromium::Chromium;
use crate::support::page::{At, KeyPress, NEXT_PICTURES, Page};
use crate::support::server::Server;
use crate::support::{wait_for, workspace_root};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(60);
/// The map of the fixture.
pub(super) const MAP: &str = "a0a00000-0000-4000-8000-000000000001";
/// Places of the nodes in it, metres: a round through the hall that begins at the dock.
const PLACES: [[f64; 2]; 9] = [
    [0.0, 0.0],
    [2.5, 0.0],
    [5.5, 0.0],
    [8.5, -0.7],
    [11.5, -1.0],
    [11.5, 3.0],
    [8.0, 4.5],
    [4.0, 5.0],
    [1.0, 3.5],
];

#[test]
fn a_mission_is_dragged_together_by_mouse_keys_and_touch_and_is_on_the_robot() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    let fixture = workspace_root().join("tests/fixtures/data-2026-11");
    copy(&fixture, data.path());
    let server = Server::start("b1", data.path());
    let mut page = browser.open(1440, 900);
    page.go(&server.url());
    page.control("button", "Missions");
    make_site(&mut page);

    page.click("button", "Map");
    page.click("button", "View Hall, first walk");
    page.click("button", "Missions");
    page.click("button", "New mission");
    // By a press, by the mouse from the palette, by keys, and by a finger on the handle.
    for name in ["Gate valve", "Pump 7", "Switchboard"] {
        page.click("button", &format!("Add inspection point {name}"));
    }
    expect_tasks(&mut page, &["Gate valve", "Pump 7", "Switchboard"]);
    // A press on the one that is selected folds its form.
    page.click("button", "Task 3 Switchboard");
    drag(&mut page, "Add inspection point Cable tray", "Task 2 Pump 7");
    page.screenshot().save("missions-dragging-1440x900");
    let at = middle(&mut page, "Task 2 Cable tray");
    page.release(at);
    expect_tasks(&mut page, &["Gate valve", "Cable tray", "Pump 7", "Switchboard"]);
    page.click("button", "Task 2 Cable tray");
    touch_drag(&mut page, "Move task 1 Gate valve", "Task 3 Pump 7");
    expect_tasks(&mut page, &["Cable tray", "Pump 7", "Gate valve", "Switchboard"]);
    page.click("button", "Undo edit");
    expect_tasks(&mut page, &["Gate valve", "Cable tray", "Pump 7", "Switchboard"]);

    // Escape puts a dragged task back, and the robot is not stopped.
    drag(&mut page, "Move task 1 Gate valve", "Task 4 Switchboard");
    page.key_down(KeyPress::ESCAPE);
    page.key_up(KeyPress::ESCAPE);
    wait_for("the task to be back", LIMIT, || page.find("button", "Task 1 Gate valve"));
    page.release(At { x: 700.0, y: 500.0 });
    expect_tasks(&mut page, &["Gate valve", "Cable tray", "Pump 7", "Switchboard"]);
    assert!(page.find("button", "Allow motion").is_none(), "motion is not stopped");

    page.click("button", "Add action Gamma spectrum");
    wait_for_drawn_map(&mut page);
    page.screenshot().save("missions-1440x900");
    wait_for("all edits to be on the robot", LIMIT, || {
        let missions = get(&mut page, "/api/v1/site/missions")["items"].clone();
        (missions[0]["object"]["tasks"].as_array()?.len() == 5).then_some(())
    });
    page.resize(1024, 768);
    page.control("button", "Task 1 Gate valve");
    assert_eq!(page.evaluate(NEXT_PICTURES), true);
    page.screenshot().save("missions-1024x768");
    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

/// The tasks of the list, in its order.
#[track_caller]
fn expect_tasks(page: &mut Page, names: &[&str]) {
    let wanted: Vec<String> =
        (1..).zip(names).map(|(number, name)| format!("Task {number} {name}")).collect();
    wait_for(&wanted.join(", "), LIMIT, || {
        let shown = page.all("button").into_iter().map(|(name, _)| name);
        let tasks: Vec<String> = shown.filter(|name| name.starts_with("Task ")).collect();
        (tasks == wanted).then_some(())
    });
}

#[track_caller]
pub(super) fn middle(page: &mut Page, name: &str) -> At {
    wait_for(name, LIMIT, || {
        let control = page.find("button", name)?;
        page.middle(&control)
    })
}

/// Points from one control to another, as a hand passes them.
#[track_caller]
fn path(page: &mut Page, from: &str, to: &str) -> (At, Vec<At>) {
    let (start, end) = (middle(page, from), middle(page, to));
    let at =
        |share: f64| At { x: start.x + share * (end.x - start.x), y: start.y + share * (end.y - start.y) };
    (start, (1..=8).map(|step| at(f64::from(step) / 8.0)).collect())
}

/// Drags with the mouse, and does not let go.
#[track_caller]
fn drag(page: &mut Page, from: &str, to: &str) {
    let (start, points) = path(page, from, to);
    page.move_to(start);
    page.press(start);
    for point in points {
        page.move_to(point);
        assert_eq!(page.evaluate(NEXT_PICTURES), true);
    }
}

/// Drags with a finger.
#[track_caller]
fn touch_drag(page: &mut Page, from: &str, to: &str) {
    let (start, points) = path(page, from, to);
    page.touch("touchStart", Some(start));
    for point in points {
        page.touch("touchMove", Some(point));
        assert_eq!(page.evaluate(NEXT_PICTURES), true);
    }
    page.touch("touchEnd", None);
}

pub(super) fn get(page: &mut Page, path: &str) -> Value {
    page.evaluate(&format!("fetch('{path}').then(answer => answer.json())"))
}

/// Nodes, a dock on the first, and inspection points at some of the others.
#[track_caller]
pub(super) fn make_site(page: &mut Page) {
    let id = |kind: u32, number: usize| format!("{kind:08}-0000-4000-8000-{number:012}");
    let put = |object: Value| json!({ "put": { "base": null, "object": object } });
    let mut changes =
        vec![put(json!({ "settings": { "name": "B1 hall", "time_zone": "Europe/London", "map": MAP } }))];
    for (number, [x, y]) in PLACES.iter().enumerate() {
        let kind = if number == 0 { "dock" } else { "waypoint" };
        changes.push(put(json!({ "node": {
            "id": id(1, number), "name": format!("N{}", number + 1), "kind": kind,
            "map_from_node": { "position": { "x": x, "y": y, "z": 0 }, "orientation": { "w": 1, "x": 0, "y": 0, "z": 0 } },
        } })));
        for (edge, [from, to]) in
            [[number.wrapping_sub(1), number], [number, number.wrapping_sub(1)]].into_iter().enumerate()
        {
            if number > 0 {
                changes.push(put(json!({ "edge": {
                    "id": id(2 + edge as u32, number), "from": id(1, from), "to": id(1, to), "traversal": "walk", "is_enabled": true,
                } })));
            }
        }
    }
    changes.push(put(json!({ "dock": {
        "id": id(4, 0), "name": "Dock by the gate", "node": id(1, 0), "approach": id(1, 1),
    } })));
    let points = [
        ("Gate valve", 2, "photo"),
        ("Pump 7", 4, "thermal_photo"),
        ("Cable tray", 5, "point_cloud"),
        ("Switchboard", 7, "photo"),
    ];
    for (number, (name, node, action)) in points.into_iter().enumerate() {
        changes.push(put(json!({ "inspection_point": {
            "id": id(5, number), "name": name, "node": id(1, node), "target_m": { "x": 1.0, "y": 3.0, "z": 1.2 },
            "request": { "action": action },
        } })));
    }
    let edit = json!({ "id": id(9, 9), "changes": changes }).to_string();
    let request = format!(
        "fetch('/api/v1/site/edits', {{ method: 'POST', body: {} }}).then(answer => answer.text())",
        json!(edit)
    );
    let answer = page.evaluate(&request);
    assert!(answer.as_str().unwrap().contains("\"revision\""), "{answer}");
}

pub(super) fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            true => copy(&entry.path(), &target),
            false => drop(fs::copy(entry.path(), target).unwrap()),
        }
    }
}
