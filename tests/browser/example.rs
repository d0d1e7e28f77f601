//! The example in a real browser: from an empty data directory to the first picture of its mission, by two presses.

use super::mapping::wait_for_drawn_map;
use crate::support::chromium::Chromium;
use crate::support::page::Page;
use crate::support::server::Server;
use crate::support::wait_for;
use serde_json::Value;
use std::time::{Duration, Instant};

/// Longest wait for the example. A release build on two idle cores takes less than a minute; tests run unoptimised code beside a drawing browser.
const MAKING_LIMIT: Duration = Duration::from_secs(420);
const LIMIT: Duration = Duration::from_secs(120);
/// A part of the walk: enough for some inspection points and their mission.
const SHORT: [&str; 1] = ["--example-minutes=2"];

#[test]
fn an_empty_site_becomes_the_example_whose_mission_runs_at_once() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    let server = Server::start_with("b1", data.path(), &SHORT);
    let mut page = browser.open(1024, 768);
    page.go(&server.url());
    page.control("button", "Explore the example");
    page.screenshot().save("example-start-1024x768");
    page.resize(1440, 900);
    page.control("button", "Map your own");
    page.screenshot().save("example-start-1440x900");

    page.click("button", "Explore the example");
    let begun = Instant::now();
    wait_for("the walk to go on", MAKING_LIMIT, || {
        let progress = page.status("Example")?;
        (progress.contains("walks") && !progress.contains(" 0 %")).then_some(())
    });
    page.screenshot().save("example-walk-1440x900");
    wait_for("the mission of the example", MAKING_LIMIT, || page.find("button", "Run now"));
    println!("the example was made in {:.0} s", begun.elapsed().as_secs_f64());
    wait_for("the robot to be localised", LIMIT, || {
        let health = get(&mut page, "/api/v1/runs/current");
        health["route"]["at"].is_string().then_some(())
    });
    wait_for_drawn_map(&mut page);
    page.screenshot().save("example-mission-1440x900");

    page.click("button", "Run now");
    let result = wait_for("the first result", MAKING_LIMIT, || {
        let run = get(&mut page, "/api/v1/runs")["items"][0]["run"].as_str()?.to_owned();
        let results = get(&mut page, &format!("/api/v1/runs/{run}/results"));
        (!results["items"][0].is_null()).then(|| results["items"][0].clone())
    });
    page.click("button", "Runs");
    page.control("button", "Pause");
    page.screenshot().save("example-run-1440x900");
    see_history(&mut page);
    assert!(result["kind"].is_string(), "{result}");
    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

/// The history of the point of the first result: its time line, and its picture large.
fn see_history(page: &mut Page) {
    let name = wait_for("a result of an inspection point", MAKING_LIMIT, || {
        let buttons = page.all("button").into_iter().map(|(name, _)| name);
        buttons.into_iter().find(|name| name.starts_with("History of this point: "))
    });
    page.click("button", &name);
    page.control("slider", "Time line");
    page.wait_for_pictures();
    page.screenshot().save("example-point-1440x900");
    if page.find("button", "Compare large").is_some() {
        page.click("button", "Compare large");
        page.control("button", "Close the comparison");
        page.wait_for_pictures();
        page.screenshot().save("example-point-compared-1440x900");
        page.click("button", "Close the comparison");
    }
}

fn get(page: &mut Page, path: &str) -> Value {
    page.evaluate(&format!("fetch('{path}').then(answer => answer.json())"))
}
