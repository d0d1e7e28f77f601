//! The Site screen in a real browser: several nodes by a box, drags over the floor, floors.

use super::mapping::{NEXT_PICTURES, wait_for_drawn_map};
use super::missions::{copy, get, make_site, middle};
use crate::support::chromium::Chromium;
use crate::support::page::{At, Key, Page};
use crate::support::server::Server;
use crate::support::{wait_for, workspace_root};
use serde_json::Value;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(60);

/// A page with the site of the fixture's map on the Site screen.
fn opened(browser: &Chromium, server: &Server) -> Page {
    let mut page = browser.open(1440, 900);
    page.go(&server.url());
    page.control("button", "Missions");
    make_site(&mut page);
    page.click("button", "Map");
    page.click("button", "View Hall, first walk");
    page.click("button", "Site");
    page.click("button", "Top view");
    wait_for_drawn_map(&mut page);
    page.control("button", "Node N3 in the scene");
    page
}

#[test]
fn nodes_are_boxed_moved_and_taken_back_by_mouse_touch_and_keys() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    copy(&workspace_root().join("tests/fixtures/data-2026-11"), data.path());
    let server = Server::start("b1", data.path());
    let mut page = opened(&browser, &server);

    // A box round N3 and N4, by the mouse.
    page.click("button", "Select several");
    let [a, b] = ["N3", "N4"].map(|name| middle(&mut page, &format!("Node {name} in the scene")));
    let corners = [
        At { x: a.x.min(b.x) - 30.0, y: a.y.min(b.y) - 30.0 },
        At { x: a.x.max(b.x) + 30.0, y: a.y.max(b.y) + 30.0 },
    ];
    drag(&mut page, corners[0], corners[1]);
    page.screenshot().save("site-box-1440x900");
    page.release(corners[1]);
    expect_status(&mut page, "Selected", "2");

    // One of them moves both; Escape puts them back, and the robot goes on.
    let before = places(&mut page);
    let to = At { x: a.x + 40.0, y: a.y - 60.0 };
    drag(&mut page, a, to);
    page.key_down(Key::ESCAPE);
    page.key_up(Key::ESCAPE);
    page.release(to);
    assert_eq!(page.evaluate(NEXT_PICTURES), true);
    assert_eq!(places(&mut page), before);
    assert!(page.find("button", "Allow motion").is_none(), "motion is not stopped");
    expect_status(&mut page, "Selected", "2");
    let a = middle(&mut page, "Node N3 in the scene");
    drag(&mut page, a, to);
    page.screenshot().save("site-dragging-1440x900");
    page.release(to);
    let moved = |page: &mut Page| {
        let after = places(page);
        let changed = before.iter().zip(&after).filter(|(before, after)| before != after).count();
        (changed == 2).then_some(())
    };
    wait_for("both nodes to be elsewhere on the robot", LIMIT, || moved(&mut page));
    page.click("button", "Hold");
    page.screenshot().save("site-group-1440x900");

    // A finger draws a box too, which adds to what is selected; Delete deletes all of it.
    page.resize(1024, 768);
    page.key_down(Key::ESCAPE);
    page.key_up(Key::ESCAPE);
    page.click("button", "Fit view");
    page.click("button", "Select several");
    assert_eq!(page.evaluate(NEXT_PICTURES), true);
    let at = middle(&mut page, "Node N5 in the scene");
    let [from, to] = [[40.0, 40.0], [-20.0, -14.0]].map(|[x, y]| At { x: at.x + x, y: at.y + y });
    page.touch("touchStart", Some(from));
    for step in 1..=6 {
        let share = f64::from(step) / 6.0;
        let point = At { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y) };
        page.touch("touchMove", Some(point));
        assert_eq!(page.evaluate(NEXT_PICTURES), true);
    }
    page.touch("touchEnd", None);
    expect_status(&mut page, "Selected", "3");
    page.screenshot().save("site-group-1024x768");
    page.key_down(Key::DELETE);
    page.key_up(Key::DELETE);
    wait_for("the nodes to be gone", LIMIT, || (places(&mut page).len() == 6).then_some(()));
    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

#[test]
fn a_draft_outlives_a_reload_and_is_published_and_a_point_shows_what_the_camera_would_see() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    copy(&workspace_root().join("tests/fixtures/data-2026-11"), data.path());
    let server = Server::start("b1", data.path());
    let mut page = opened(&browser, &server);

    page.click("button", "Inspection points");
    page.click("button", "Inspection point Gate valve");
    page.click("button", "Turn the node to the target");
    wait_for("the line of sight", LIMIT, || page.status("Camera view").filter(|text| text.contains("way")));
    page.click("button", "Fit view");
    assert_eq!(page.evaluate(NEXT_PICTURES), true);
    page.screenshot().save("site-camera-view-1440x900");

    page.click("button", "Draft");
    page.click("button", "Edit as draft");
    page.click("button", "Topological map");
    page.click("button", "Node N5 in the scene");
    let before = places(&mut page);
    page.click("button", "More: x (m)");
    page.click("button", "More: Heading (°)");
    page.click("button", "Node N9 in the scene");
    page.click("button", "Delete node N9");
    page.click("button", "Draft");
    // The node and its two edges are removed, and another node is changed.
    expect_status(&mut page, "Changes", "4");
    page.screenshot().save("site-draft-1440x900");
    page.resize(1024, 768);
    assert_eq!(page.evaluate(NEXT_PICTURES), true);
    page.screenshot().save("site-draft-1024x768");
    page.resize(1440, 900);
    assert_eq!(places(&mut page), before, "nothing is published");

    page.reload();
    page.click("button", "Site");
    page.click("button", "Draft");
    expect_status(&mut page, "Changes", "4");
    page.click("button", "Publish");
    wait_for("the node to be gone on the robot", LIMIT, || (places(&mut page).len() == 8).then_some(()));
    page.control("button", "Edit as draft");
    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

/// Drags with the mouse, and does not let go.
fn drag(page: &mut Page, from: At, to: At) {
    page.move_to(from);
    page.press(from);
    for step in 1..=8 {
        let share = f64::from(step) / 8.0;
        page.move_to(At { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y) });
        assert_eq!(page.evaluate(NEXT_PICTURES), true);
    }
}

/// Positions of all nodes on the robot.
fn places(page: &mut Page) -> Vec<Value> {
    let nodes = get(page, "/api/v1/site/nodes")["items"].clone();
    let items = nodes.as_array().cloned().unwrap_or_default();
    items.iter().map(|node| node["object"]["map_from_node"]["position"].clone()).collect()
}

#[track_caller]
fn expect_status(page: &mut Page, name: &str, value: &str) {
    wait_for(&format!("{name} to be {value}"), LIMIT, || {
        (page.status(name).as_deref() == Some(value)).then_some(())
    });
}
