//! What an operator does on the first day: maps a place, makes the topological map of it, a mission on that, runs it and looks at what it brought.

use super::mapping::{WALK_LIMIT, drive_by_keys, localise, wait_for_drawn_map};
use crate::support::chromium::Chromium;
use crate::support::page::Page;
use crate::support::server::Server;
use crate::support::wait_for;
use serde_json::Value;
use std::time::Duration;

/// Longest wait for a run of a mission of a few metres.
const RUN_LIMIT: Duration = Duration::from_secs(240);

#[test]
fn from_an_empty_data_directory_to_the_picture_of_a_mission() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    let server = Server::start("b1", data.path());
    let mut page = browser.open(1440, 900);
    page.go(&server.url());

    page.click("button", "Map");
    page.click("button", "Start mapping");
    wait_for("mapping to begin", WALK_LIMIT, || (page.status("Mapping")? == "Mapping").then_some(()));
    drive_by_keys(&mut page, 6.0);
    page.click("textbox", "Map name");
    page.type_text("Hall");
    page.click("button", "Finish and save");
    wait_for("the saved map", WALK_LIMIT, || page.find("status", "Saved map Hall"));
    localise(&mut page, "Hall");

    page.click("button", "Site");
    page.click("button", "Make from the map");
    wait_for("the topological map", WALK_LIMIT, || {
        let nodes = get(&mut page, "/api/v1/site")["objects"]["nodes"].as_u64()?;
        (nodes >= 2).then_some(())
    });
    wait_for_drawn_map(&mut page);
    page.screenshot().save("operating-site-1440x900");

    page.click("button", "Missions");
    page.click("button", "New mission");
    let node = wait_for("a node to visit", WALK_LIMIT, || {
        let names = page.all("button").into_iter().map(|(name, _)| name);
        names.into_iter().find(|name| name.starts_with("Add node Waypoint"))
    });
    page.click("button", &node);
    page.click("button", "Add action Photo");
    page.screenshot().save("operating-mission-1440x900");
    page.click("button", "Run now");
    page.click("button", "Runs");
    wait_for("the run to be under way", WALK_LIMIT, || {
        let runs = get(&mut page, "/api/v1/runs/current");
        (!runs["missions"]["runs"].as_array()?.is_empty()).then_some(())
    });
    page.screenshot().save("operating-run-1440x900");
    let outcome = wait_for("the end of the run", RUN_LIMIT, || {
        let runs = get(&mut page, "/api/v1/runs/current");
        runs["missions"]["ended"][0]["outcome"].as_str().map(str::to_owned)
    });
    page.screenshot().save("operating-ended-1440x900");
    let run = get(&mut page, "/api/v1/runs")["items"][0]["run"].as_str().unwrap().to_owned();
    let results = get(&mut page, &format!("/api/v1/runs/{run}/results"));
    let steps = get(&mut page, &format!("/api/v1/runs/{run}/steps"));
    assert_eq!(outcome, "succeeded", "{steps}");
    assert_eq!(results["items"][0]["kind"], "photo", "{results}");
    assert!(results["items"][0]["blob"].is_string(), "{results}");
    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

fn get(page: &mut Page, path: &str) -> Value {
    page.evaluate(&format!("fetch('{path}').then(answer => answer.json())"))
}
