//! A day in the life of an operator: a site is mapped, its topological map made and corrected, inspection points and a mission made, scheduled, run at its time and
//! looked at. All of it through the client, from an empty data directory. What it costs a practised person is counted ([`Operator`]).
//!
//! The long form also makes the pictures of `docs/guide/first-day.md`, which says how.

mod wall_targets;

use super::mapping::{WALK_LIMIT, number, wait_for_drawn_map};
use crate::support::chromium::Chromium;
use crate::support::operator::{Operator, WaitsFor};
use crate::support::page::{At, Key, Page};
use crate::support::server::Server;
use crate::support::workspace_root;
use serde_json::Value;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use wall_targets::WallTargets;

/// Longest wait for what the platform computes or stores.
const PLATFORM_LIMIT: Duration = Duration::from_secs(120);
/// Longest wait for a run of the mission.
const RUN_LIMIT: Duration = Duration::from_secs(900);

/// Longest time of a practised person for all of the work, seconds, besides the robot's.
const PERSON_LIMIT_S: f64 = 25.0 * 60.0;

const MAP: &str = "B1 hall";
const MISSION: &str = "Round A";

/// Inspection points in the order in which they are made.
const POINTS: [&str; 9] = [
    "P1 Pump hall",
    "P2 Cable tray",
    "P3 Gauge north",
    "P4 Gauge east",
    "P5 Racks",
    "P6 Tank",
    "P7 Valve",
    "P8 Door east",
    "P9 Crane foot",
];
/// The order in which they are put into the mission: not the shortest.
const LISTED: [usize; 9] = [0, 5, 2, 7, 4, 1, 8, 3, 6];

/// How much of the day is done.
struct Day {
    /// Distance that the robot is driven by hand, m.
    driven_m: f64,
    /// Suggested walks that it makes by itself.
    walks: usize,
    points: usize,
}

#[test]
fn a_place_is_mapped_and_its_first_mission_brings_pictures() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    let day = Day { driven_m: 6.0, walks: 0, points: 2 };
    let server = Server::start("b1", data.path());
    let mut operator = Operator::at(browser.open(1440, 900));
    operator.page.go(&server.url());
    make_map(&mut operator, &day);
    make_graph(&mut operator, &day);
    make_points(&mut operator, &day);
    make_mission(&mut operator, &day);
    operator.begin("Run it now");
    operator.click("button", "Run now");
    operator.click("button", "Runs");
    see_run(&mut operator);
    look_at_pictures(&mut operator, &day);
    operator.report();
    assert_eq!(operator.page.errors(), Vec::<String>::new());
    server.stop();
}

mod nightly {
    use super::*;

    #[test]
    fn a_day_in_the_life_of_an_operator() {
        let Some(browser) = Chromium::start() else { return };
        let data = tempfile::tempdir().unwrap();
        let day = Day { driven_m: 8.0, walks: 3, points: POINTS.len() };
        let (server, offset_s) = start_at(data.path(), 10 * 3600 + 5 * 60);
        let mut operator = Operator::at(open(&browser, &server, offset_s, [1440, 900]));
        operator.page.control("button", "Map your own");
        save(&mut operator.page, "start");
        make_map(&mut operator, &day);
        make_graph(&mut operator, &day);
        make_points(&mut operator, &day);
        make_mission(&mut operator, &day);
        schedule(&mut operator);

        // The clock is moved on, and the robot is in its dock again as every morning.
        operator.page.go("about:blank");
        server.stop();
        let (server, offset_s) = start_at(data.path(), 10 * 3600 + 58 * 60 + 30);
        operator.page = open(&browser, &server, offset_s, [1440, 900]);
        operator.begin("Watch the run at 11:00");
        operator.click("button", "Runs");
        operator.wait(WaitsFor::Platform, "the run at 11:00", RUN_LIMIT, |page| page.status("Progress"));
        see_run(&mut operator);
        look_at_pictures(&mut operator, &day);
        let outcome = get(&mut operator.page, "/api/v1/runs")["items"][0].clone();

        let tablet = open(&browser, &server, offset_s, [1024, 768]);
        let desktop = change_the_schedule(&mut operator, tablet);
        let seconds = operator.report();
        assert_eq!(operator.page.errors(), Vec::<String>::new());
        drop(desktop);
        server.stop();
        assert!(seconds <= PERSON_LIMIT_S, "{seconds} s of a person's time");
        assert_eq!(outcome["state"], "succeeded", "{outcome}");
    }
}

/// Starts the platform with a clock that shows this time of the day, seconds, on a Tuesday. Returns also how far ahead that is.
fn start_at(data: &Path, time_of_day_s: i64) -> (Server, i64) {
    let now_s = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs() as i64;
    let today = now_s / 86_400;
    // The first day of the epoch was a Thursday.
    let tuesday = today + 7 - (today + 2).rem_euclid(7);
    let offset_s = tuesday * 86_400 + time_of_day_s - now_s;
    (Server::start_with("b1", data, &[&format!("--clock-offset={offset_s}")]), offset_s)
}

/// A page whose clock shows the platform's time.
fn open(browser: &Chromium, server: &Server, offset_s: i64, [width, height]: [u32; 2]) -> Page {
    let mut page = browser.open(width, height);
    page.set_clock_offset(offset_s);
    page.go(&server.url());
    page
}

/// Maps the hall and lets the robot find itself in the map.
fn make_map(operator: &mut Operator, day: &Day) {
    operator.begin("Map the hall");
    operator.click("button", "Map your own");
    operator.click("button", "Start mapping");
    operator.wait(WaitsFor::Platform, "mapping to begin", WALK_LIMIT, |page| {
        (page.status("Mapping")? == "Mapping").then_some(())
    });
    let driven_m = day.driven_m;
    operator.hold(Key::W, "the robot to walk", WALK_LIMIT, |page| {
        (number(page, "Distance")? >= driven_m).then_some(())
    });
    for _ in 0..day.walks {
        operator.click("button", "Walk to position 1");
        operator.wait(WaitsFor::Robot, "the walk to begin", WALK_LIMIT, |page| {
            page.find("button", "Cancel walk")
        });
        operator.wait(WaitsFor::Robot, "the robot to arrive", 2 * WALK_LIMIT, |page| {
            page.find("button", "Walk to a point")
        });
    }
    wait_for_drawn_map(&mut operator.page);
    save(&mut operator.page, "mapping");
    operator.begin("Save the map and use it");
    operator.write("Map name", MAP);
    operator.click("button", "Finish and save");
    operator.wait(WaitsFor::Platform, "the saved map", WALK_LIMIT, |page| {
        page.find("status", &format!("Saved map {MAP}"))
    });
    operator.click("button", &format!("Use {MAP}"));
    operator.wait(WaitsFor::Platform, "the robot to find itself", WALK_LIMIT, |page| {
        page.status("Position")?.starts_with("Localised").then_some(())
    });
}

/// Makes the topological map from the map, makes the dock of its first node, moves another node and adds one.
fn make_graph(operator: &mut Operator, day: &Day) {
    operator.begin("Make the topological map");
    operator.click("button", "Site");
    operator.click("button", "Make from the map");
    operator.wait(WaitsFor::Platform, "the topological map", PLATFORM_LIMIT, |page| page.status("Result"));
    operator.click("button", "Top view");
    wait_for_drawn_map(&mut operator.page);
    operator.page.wait_for_pictures();
    save(&mut operator.page, "graph");

    operator.begin("Correct it");
    operator.click("button", "Dismiss the result");
    if day.walks > 0 {
        // Where the robot began.
        operator.click("button", "Node Waypoint 1 in the scene");
        operator.click("button", "Make it a dock");
    }
    let nodes = nodes_on_screen(&mut operator.page);
    let (name, at) = nodes.last().expect("a node in sight").clone();
    let moved = At { x: at.x + 14.0, y: at.y + 10.0 };
    operator.drag(at, moved, |_| {});
    operator.wait(WaitsFor::Platform, "the node to be elsewhere", PLATFORM_LIMIT, |page| {
        let now = place_of(page, &name)?;
        ((now.x - at.x).hypot(now.y - at.y) > 5.0).then_some(())
    });
    let count = number(&mut operator.page, "Nodes").unwrap();
    operator.click("button", "Add nodes");
    operator.click_at(At { x: moved.x + 26.0, y: moved.y + 22.0 });
    operator.wait(WaitsFor::Platform, "another node", PLATFORM_LIMIT, |page| {
        (number(page, "Nodes")? == count + 1.0).then_some(())
    });
    operator.press(Key::ESCAPE);
    save(&mut operator.page, "graph-corrected");
}

/// Makes inspection points by clicks on walls near nodes, and names them. The second one is looked at by the thermal camera.
fn make_points(operator: &mut Operator, day: &Day) {
    operator.begin("Make the inspection points");
    operator.click("button", "Inspection points");
    operator.click("button", "Add inspection points");
    operator.page.wait_for_pictures();
    let nodes: Vec<At> = nodes_on_screen(&mut operator.page).into_iter().map(|(_, at)| at).collect();
    let mut targets = WallTargets::new(operator.page.screenshot(), nodes);
    for (index, name) in POINTS.iter().take(day.points).enumerate() {
        let made = format!("Inspection point P{}", index + 1);
        loop {
            operator.click_at(targets.next().expect("a wall in sight of a node"));
            for _ in 0..10 {
                operator.page.wait_for_pictures();
                if operator.page.find("button", &made).is_some() {
                    break;
                }
            }
            if operator.page.find("button", &made).is_some() {
                break;
            }
        }
        operator.write("Inspection point name", name);
        operator.wait(WaitsFor::Platform, "the name", PLATFORM_LIMIT, |page| {
            page.find("button", &format!("Inspection point {name}"))
        });
        if index == 1 {
            operator.click("button", "Action");
            operator.click("button", "Thermal photo");
        }
    }
    operator.wait(WaitsFor::Platform, "what the camera would see", PLATFORM_LIMIT, |page| {
        page.status("Camera view")
    });
    save(&mut operator.page, "points");
    operator.press(Key::ESCAPE);
}

/// Makes a mission of the points, and takes the shortest order if that is another one.
fn make_mission(operator: &mut Operator, day: &Day) {
    operator.begin("Make the mission");
    operator.click("button", "Missions");
    operator.click("button", "New mission");
    operator.write("Mission name", MISSION);
    for index in LISTED.into_iter().filter(|index| *index < day.points) {
        operator.click("button", &format!("Add inspection point {}", POINTS[index]));
    }
    let wanted = day.points;
    operator.wait(WaitsFor::Platform, "all tasks", PLATFORM_LIMIT, |page| {
        (named(page, "Task ").len() == wanted).then_some(())
    });
    save(&mut operator.page, "mission");
    operator.begin("Optimise its order");
    if let Some(optimise) = named(&mut operator.page, "Optimise: ").pop() {
        operator.click("button", &optimise);
        operator.page.control("button", "Use this order");
        operator.page.wait_for_pictures();
        save(&mut operator.page, "order");
        operator.click("button", "Use this order");
    }
    operator.wait(WaitsFor::Platform, "the robot to have it", PLATFORM_LIMIT, |page| {
        let run = page.find("button", "Run now")?;
        (!run.disabled).then_some(())
    });
}

/// Lets the mission run on all weekdays at 11:00.
fn schedule(operator: &mut Operator) {
    operator.begin("Schedule it");
    operator.click("button", "Schedule");
    // The next whole hour.
    operator.click("button", &format!("Schedule mission {MISSION}"));
    for day in ["Mon", "Wed", "Thu", "Fri"] {
        operator.click("button", day);
    }
    operator.wait(WaitsFor::Platform, "the schedule on the robot", PLATFORM_LIMIT, |page| {
        let schedule = get(page, "/api/v1/site/schedules")["items"][0]["object"].to_string();
        schedule.contains("11:00").then_some(()).filter(|()| schedule.to_lowercase().contains("fri"))
    });
    save(&mut operator.page, "schedule");
}

/// Watches the run until it ends.
fn see_run(operator: &mut Operator) {
    operator.wait(WaitsFor::Robot, "the first picture", RUN_LIMIT, |page| named(page, "Show ").pop());
    operator.page.wait_for_pictures();
    save(&mut operator.page, "run");
    operator.wait(WaitsFor::Robot, "the end of the run", RUN_LIMIT, |page| {
        page.find("button", &format!("Run {MISSION}"))
    });
}

/// Opens the run in the history, and looks at its pictures.
fn look_at_pictures(operator: &mut Operator, day: &Day) {
    operator.begin("Look at the pictures");
    operator.click("button", "History");
    let run = operator.wait(WaitsFor::Platform, "the run in the history", PLATFORM_LIMIT, |page| {
        named(page, &format!("{MISSION}, ")).into_iter().next()
    });
    assert!(run.contains("Succeeded"), "{run}");
    operator.click("button", &run);
    let shown = operator.wait(WaitsFor::Platform, "its pictures", PLATFORM_LIMIT, |page| {
        let shown = named(page, "Show ");
        let of_points = POINTS.iter().filter(|point| shown.iter().any(|name| name.ends_with(*point))).count();
        (of_points == day.points).then_some(shown)
    });
    save(&mut operator.page, "history");
    operator.click("button", &shown[0]);
    let pictures =
        operator.wait(WaitsFor::Platform, "the picture", PLATFORM_LIMIT, |page| page.status("Picture"));
    println!("{pictures}");
    operator.page.wait_for_pictures();
    save(&mut operator.page, "picture");
    operator.click("button", "Next picture");
    operator.click("button", "Close the pictures");
}

/// Moves the round of the week after from 11:00 to 15:00, on a tablet. Returns the page of the desktop, which shows it too.
fn change_the_schedule(operator: &mut Operator, mut tablet: Page) -> Page {
    operator.begin("Change the schedule on a tablet");
    tablet.allow_touch();
    let mut desktop = std::mem::replace(&mut operator.page, tablet);
    operator.tap("button", "Schedule");
    // The card lies over the end of the week.
    operator.tap("button", "Close panel");
    operator.tap("button", "Later week");
    let slot = operator.wait(WaitsFor::Platform, "the week after", PLATFORM_LIMIT, |page| {
        named(page, &format!("{MISSION}, Thu ")).into_iter().find(|name| name.contains("11:00, planned"))
    });
    let from = operator.reveal("button", &slot);
    let to = At { y: from.y + 4.0 * HOUR_PX, ..from };
    operator.drag_by_finger(from, to, |page| save(page, "tablet-dragging"));
    operator.page.control("button", "This and following");
    operator.page.wait_for_pictures();
    save(&mut operator.page, "tablet-question");
    operator.tap("button", "All");
    let is_later = |page: &mut Page| {
        named(page, &format!("{MISSION}, Thu "))
            .into_iter()
            .any(|name| name.contains("15:00, planned"))
            .then_some(())
    };
    operator.wait(WaitsFor::Platform, "the other time", PLATFORM_LIMIT, is_later);
    save(&mut operator.page, "tablet");
    // The desktop shows it without being asked.
    std::mem::swap(&mut operator.page, &mut desktop);
    operator.begin("See the change on the desktop");
    operator.click("button", "Schedule");
    operator.click("button", "Later week");
    operator.wait(WaitsFor::Platform, "the other time on the desktop", PLATFORM_LIMIT, is_later);
    desktop
}

/// Height of an hour of the week on the Schedule screen, CSS pixels.
const HOUR_PX: f64 = 48.0;

/// Names of the buttons that begin so, in document order.
fn named(page: &mut Page, beginning: &str) -> Vec<String> {
    page.all("button").into_iter().map(|(name, _)| name).filter(|name| name.starts_with(beginning)).collect()
}

/// The nodes whose place on the screen no card covers, with those in the middle of the scene last.
fn nodes_on_screen(page: &mut Page) -> Vec<(String, At)> {
    let [width, height] = page.size();
    let middle = At { x: 0.5 * (width - 290.0), y: 0.5 * (height + 40.0) };
    let controls: Vec<_> = page
        .all("button")
        .into_iter()
        .filter(|(name, _)| name.starts_with("Node Waypoint") && name.ends_with(" in the scene"))
        .collect();
    let mut nodes: Vec<(String, At)> =
        controls.into_iter().filter_map(|(name, control)| Some((name, page.middle(&control)?))).collect();
    nodes.retain(|(_, at)| at.x > 180.0 && at.x < width - 400.0 && at.y > 160.0 && at.y < height - 60.0);
    let off = |at: &At| (at.x - middle.x).hypot(at.y - middle.y);
    nodes.sort_by(|(_, a), (_, b)| off(b).total_cmp(&off(a)));
    nodes
}

fn place_of(page: &mut Page, name: &str) -> Option<At> {
    let control = page.find("button", name)?;
    page.middle(&control)
}

fn get(page: &mut Page, path: &str) -> Value {
    page.evaluate(&format!("fetch('{path}').then(answer => answer.json())"))
}

/// Saves a picture of a step among the artefacts and, if asked for, in the guide.
fn save(page: &mut Page, step: &str) {
    page.screenshot().save(&format!("first-day-{step}"));
    if std::env::var_os("AUTOINSPECT_GUIDE").is_some() {
        let path = workspace_root().join(format!("docs/guide/images/first-day-{step}.webp"));
        std::fs::write(path, page.guide_picture()).unwrap();
    }
}
