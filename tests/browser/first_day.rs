//! A day in the life of an operator: a site is mapped, its topological map made and corrected, inspection points and a mission made, scheduled, run at its time and
//! looked at. All of it through the client, from an empty data directory. What it costs a practised person is counted ([`Operator`]).
//!
//! With `AUTOINSPECT_GUIDE=1` it makes the pictures of `docs/guide/first-day.md`. `operating` is its short form, which runs on every change.

mod wall_targets;

use super::mapping::{WALK_LIMIT, number, wait_for_drawn_map};
use crate::support::chromium::Chromium;
use crate::support::operator::{Operator, WaitsFor};
use crate::support::page::{At, KeyPress, Page};
use crate::support::picture::Picture;
use crate::support::server::Server;
use crate::support::{wait_for, workspace_root};
use serde_json::Value;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use wall_targets::WallTargets;

/// Longest wait for what the platform computes or stores.
const PLATFORM_LIMIT: Duration = Duration::from_secs(120);
/// Longest wait for the robot to find its place by itself after a start.
const FIND_LIMIT: Duration = Duration::from_secs(30);
/// Longest wait for the results of a run that has ended.
const FETCH_LIMIT: Duration = Duration::from_secs(20);
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

/// Distance that the robot is driven by hand, m.
const DRIVEN_M: f64 = 8.0;
/// Suggested walks that it makes by itself after that.
const WALKS: usize = 2;

mod nightly {
    use super::*;

    #[test]
    fn a_day_in_the_life_of_an_operator() {
        let Some(browser) = Chromium::start() else { return };
        let data = tempfile::tempdir().unwrap();
        let (server, offset_s) = start_at(data.path(), 10 * 3600 + 5 * 60);
        let mut operator = Operator::at(open(&browser, &server, offset_s, [1440, 900]));
        operator.page.control("button", "Map your own");
        save(&mut operator.page, "start");
        make_map(&mut operator);
        make_graph(&mut operator);
        make_points(&mut operator);
        make_mission(&mut operator);
        schedule(&mut operator);

        // The clock is moved on, and the robot is in its dock again as every morning.
        operator.page.go("about:blank");
        server.stop();
        let (server, offset_s) = start_at(data.path(), 10 * 3600 + 59 * 60);
        operator.page = open(&browser, &server, offset_s, [1440, 900]);
        operator.begin("Watch the run at 11:00");
        find_itself(&mut operator);
        operator.click("button", "Runs");
        operator.wait(WaitsFor::Platform, "the run at 11:00", RUN_LIMIT, |page| page.status("Progress"));
        see_run(&mut operator);
        let (run, pictures) = look_at_pictures(&mut operator);

        let tablet = open(&browser, &server, offset_s, [1024, 768]);
        let mut tablet = change_the_schedule(&mut operator, tablet);
        let seconds = operator.report();
        for page in [&mut operator.page, &mut tablet] {
            assert_eq!(page.errors(), Vec::<String>::new());
        }
        server.stop();
        assert!(seconds <= PERSON_LIMIT_S, "{seconds} s of a person's time");
        assert!(run.contains("Succeeded") && pictures == POINTS.len(), "{run}, {pictures} pictures");
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
fn make_map(operator: &mut Operator) {
    operator.begin("Map the hall");
    operator.click("button", "Map your own");
    operator.click("button", "Start mapping");
    operator.wait(WaitsFor::Platform, "mapping to begin", WALK_LIMIT, |page| {
        (page.status("Mapping")? == "Mapping").then_some(())
    });
    operator.hold(KeyPress::W, "the robot to walk", WALK_LIMIT, |page| {
        (number(page, "Distance")? >= DRIVEN_M).then_some(())
    });
    for _ in 0..WALKS {
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

/// Waits until the robot knows where it is, and asks it to look if it does not find out by itself.
fn find_itself(operator: &mut Operator) {
    let is_localised =
        |page: &mut Page| page.status("Position").is_some_and(|text| text.starts_with("Localised"));
    let begun = Instant::now();
    let found = operator.wait(WaitsFor::Platform, "the robot's place", PLATFORM_LIMIT, |page| {
        if is_localised(page) { Some(true) } else { (begun.elapsed() > FIND_LIMIT).then_some(false) }
    });
    if !found {
        operator.click("button", "Live");
        operator.click("button", "Relocalise");
        operator.wait(WaitsFor::Platform, "the robot's place", PLATFORM_LIMIT, |page| {
            is_localised(page).then_some(())
        });
    }
}

/// Makes the topological map from the map, makes the dock of its first node, moves another node and adds one.
fn make_graph(operator: &mut Operator) {
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
    // Where the robot began.
    operator.click("button", "Node Waypoint 1 in the scene");
    operator.click("button", "Make it a dock");
    let nodes = nodes_on_screen(&mut operator.page);
    let (name, at) = nodes.last().expect("a node in sight").clone();
    let moved = At { x: at.x + 10.0, y: at.y + 6.0 };
    operator.drag(at, moved, |_| {});
    operator.wait(WaitsFor::Platform, "the node to be elsewhere", PLATFORM_LIMIT, |page| {
        let now = place_of(page, &name)?;
        ((now.x - at.x).hypot(now.y - at.y) > 5.0).then_some(())
    });
    let count = number(&mut operator.page, "Nodes").unwrap();
    let others: Vec<At> = nodes_on_screen(&mut operator.page).into_iter().map(|(_, at)| at).collect();
    let floor = free_floor_beside(&operator.page.screenshot(), moved, &others).expect("free floor");
    operator.click("button", "Add nodes");
    operator.click_at(floor);
    operator.wait(WaitsFor::Platform, "another node", PLATFORM_LIMIT, |page| {
        (number(page, "Nodes")? == count + 1.0).then_some(())
    });
    operator.press(KeyPress::ESCAPE);
    save(&mut operator.page, "graph-corrected");
}

/// Makes inspection points by clicks on walls near nodes, and names them. The second one is looked at by the thermal camera.
fn make_points(operator: &mut Operator) {
    operator.begin("Make the inspection points");
    operator.click("button", "Inspection points");
    operator.click("button", "Add inspection points");
    operator.page.wait_for_pictures();
    let nodes: Vec<At> = nodes_on_screen(&mut operator.page).into_iter().map(|(_, at)| at).collect();
    let mut targets = WallTargets::new(operator.page.screenshot(), nodes);
    for (index, name) in POINTS.iter().enumerate() {
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
    operator.press(KeyPress::ESCAPE);
}

/// Makes a mission of the points, and takes the shortest order if that is another one.
fn make_mission(operator: &mut Operator) {
    operator.begin("Make the mission");
    operator.click("button", "Missions");
    operator.click("button", "New mission");
    operator.write("Mission name", MISSION);
    for index in LISTED {
        operator.click("button", &format!("Add inspection point {}", POINTS[index]));
    }
    operator.wait(WaitsFor::Platform, "all tasks", PLATFORM_LIMIT, |page| {
        (named(page, "Task ").len() == POINTS.len()).then_some(())
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
        schedule.to_lowercase().contains("fri").then_some(())
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

/// Opens the run in the history, and looks at its pictures. Returns the row of the run and the number of inspection points with a picture.
fn look_at_pictures(operator: &mut Operator) -> (String, usize) {
    operator.begin("Look at the pictures");
    operator.click("button", "History");
    let run = operator.wait(WaitsFor::Platform, "the run in the history", PLATFORM_LIMIT, |page| {
        named(page, &format!("{MISSION}, ")).into_iter().next()
    });
    println!("{run}");
    operator.click("button", &run);
    let begun = Instant::now();
    let shown = operator.wait(WaitsFor::Platform, "its pictures", PLATFORM_LIMIT, |page| {
        let shown = named(page, "Show ");
        let is_all = pictured(&shown) == POINTS.len() || begun.elapsed() > FETCH_LIMIT;
        (is_all && !shown.is_empty()).then_some(shown)
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
    (run, pictured(&shown))
}

/// Number of inspection points of which there is a picture among these names.
fn pictured(shown: &[String]) -> usize {
    POINTS.iter().filter(|point| shown.iter().any(|name| name.ends_with(*point))).count()
}

/// Moves the round of the week after from 11:00 to 15:00, on a tablet. Returns the page of the desktop, which shows it too.
fn change_the_schedule(operator: &mut Operator, mut tablet: Page) -> Page {
    operator.begin("Change the schedule on a tablet");
    tablet.allow_touch();
    let mut desktop = std::mem::replace(&mut operator.page, tablet);
    operator.tap("button", "Schedule");
    let planned = |page: &mut Page| {
        named(page, &format!("{MISSION}, Thu ")).into_iter().find(|name| name.contains("11:00, planned"))
    };
    let this_week = operator.wait(WaitsFor::Platform, "this week", PLATFORM_LIMIT, planned);
    operator.tap("button", "Later week");
    let slot = operator.wait(WaitsFor::Platform, "the week after", PLATFORM_LIMIT, |page| {
        planned(page).filter(|name| *name != this_week)
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
    operator.page.bring_to_front();
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

/// The nodes whose place on the screen no card covers, once the camera rests, with those in the middle of the scene last.
fn nodes_on_screen(page: &mut Page) -> Vec<(String, At)> {
    let [width, height] = page.size();
    let middle = At { x: 0.5 * (width - 290.0), y: 0.5 * (height + 40.0) };
    let mut last = Vec::new();
    let mut nodes = wait_for("the nodes to rest on the screen", PLATFORM_LIMIT, || {
        page.wait_for_pictures();
        let is_node = |name: &str| name.starts_with("Node Waypoint") && name.ends_with(" in the scene");
        let controls: Vec<_> = page.all("button").into_iter().filter(|(name, _)| is_node(name)).collect();
        let now: Vec<(String, At)> =
            controls.into_iter().filter_map(|(name, control)| Some((name, page.middle(&control)?))).collect();
        let is_at_rest = !now.is_empty() && now == last;
        last.clone_from(&now);
        is_at_rest.then_some(now)
    });
    nodes.retain(|(_, at)| is_free(*at, [width, height]));
    let off = |at: &At| (at.x - middle.x).hypot(at.y - middle.y);
    nodes.sort_by(|(_, a), (_, b)| off(b).total_cmp(&off(a)));
    nodes
}

/// Whether no card of the Site screen covers a place in a window of this size, CSS pixels.
fn is_free(at: At, [width, height]: [f64; 2]) -> bool {
    let is_under_drive_card = at.x < 430.0 && at.y > height - 180.0;
    at.x > 180.0 && at.x < width - 395.0 && at.y > 160.0 && at.y < height - 30.0 && !is_under_drive_card
}

/// The place on the floor beside a node that is farthest from the other nodes, among those that no wall hides.
fn free_floor_beside(picture: &Picture, node: At, others: &[At]) -> Option<At> {
    const REACH_PX: f64 = 28.0;
    let at = |direction: u32, reach_px: f64| {
        let angle = f64::from(direction) / 16.0 * std::f64::consts::TAU;
        At { x: (node.x + reach_px * angle.cos()).round(), y: (node.y + reach_px * angle.sin()).round() }
    };
    let is_clear = |direction: &u32| {
        (4..18).all(|step| {
            let at = at(*direction, REACH_PX * f64::from(step) / 14.0);
            !picture.shows_wall(at.x, at.y)
        })
    };
    let apart = |direction: &u32| {
        let at = at(*direction, REACH_PX);
        others.iter().map(|it| (it.x - at.x).hypot(it.y - at.y)).fold(f64::INFINITY, f64::min)
    };
    let best = (0..16).filter(is_clear).max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    Some(at(best, REACH_PX))
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
