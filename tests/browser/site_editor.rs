//! The Site screen in a real browser: several nodes by a box, and drags over the floor.

use super::mapping::wait_for_drawn_map;
use super::missions::{copy, get, make_site, middle};
use crate::support::chromium::Chromium;
use crate::support::page::{At, KeyPress, NEXT_PICTURES, Page};
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
fn nodes_are_boxed_moved_and_taken_back() {
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
    page.key_down(KeyPress::ESCAPE);
    page.key_up(KeyPress::ESCAPE);
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

    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

#[test]
fn a_zone_is_drawn_and_changed_and_a_click_makes_an_inspection_point() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    copy(&workspace_root().join("tests/fixtures/data-2026-11"), data.path());
    let server = Server::start("b1", data.path());
    let mut page = opened(&browser, &server);
    let [a, b] = ["N4", "N5"].map(|name| middle(&mut page, &format!("Node {name} in the scene")));

    page.click("button", "Zones");
    page.click("button", "Draw a zone");
    let from = At { x: a.x - 40.0, y: a.y - 30.0 };
    let to = At { x: b.x + 20.0, y: b.y + 40.0 };
    drag(&mut page, from, to);
    page.screenshot().save("site-zone-drawing-1440x900");
    page.release(to);
    let corners =
        |page: &mut Page| get(page, "/api/v1/site/zones")["items"][0]["object"]["corners_m"].clone();
    let drawn = wait_for("the zone on the robot", LIMIT, || {
        let corners = corners(&mut page);
        (corners.as_array()?.len() == 4).then_some(corners)
    });
    page.control("button", "Zone Zone 1 in the scene");
    // A corner; Escape puts it back.
    let corner = At { x: to.x + 50.0, y: to.y + 30.0 };
    drag(&mut page, to, corner);
    page.key_down(KeyPress::ESCAPE);
    page.key_up(KeyPress::ESCAPE);
    page.release(corner);
    assert_eq!(page.evaluate(NEXT_PICTURES), true);
    assert_eq!(corners(&mut page), drawn);
    drag(&mut page, to, corner);
    page.release(corner);
    wait_for("the corner to be elsewhere", LIMIT, || {
        let now = corners(&mut page);
        let moved = drawn.as_array()?.iter().zip(now.as_array()?).filter(|(a, b)| a != b).count();
        (moved == 1).then_some(())
    });
    page.click("button", "Speed limit");
    page.screenshot().save("site-zone-1440x900");

    page.click("button", "Inspection points");
    page.click("button", "Add inspection points");
    let node = middle(&mut page, "Node N2 in the scene");
    let picture = page.screenshot();
    let left = (1..200).map(|step| At { x: node.x - f64::from(step), y: node.y + 30.0 });
    let target = { left }.find(|at| picture.shows_wall(at.x, at.y)).expect("the wall at the left");
    page.move_to(target);
    page.press(target);
    page.release(target);
    wait_for("the inspection point on the robot", LIMIT, || {
        let points = get(&mut page, "/api/v1/site")["objects"]["inspection-points"].as_u64()?;
        (points == 5).then_some(())
    });
    wait_for("what the camera would see", LIMIT, || page.status("Camera view"));
    page.screenshot().save("site-inspection-point-1440x900");
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
