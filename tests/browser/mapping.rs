//! Tests of the first task of an operator: make a map with a robot, save it, and open it again.

use std::time::{Duration, Instant};

use crate::support::chromium::{Chromium, LAN_HOST};
use crate::support::page::{At, KeyPress, NEXT_PICTURES, Page, PageControl};
use crate::support::server::Server;
use crate::support::wait_for;

/// Longest wait for a walk of the robot, on a machine that draws, simulates and serves on two cores.
pub(super) const WALK_LIMIT: Duration = Duration::from_secs(120);
const DRAW_LIMIT: Duration = Duration::from_secs(60);

/// Smallest share of lit pixels in the middle of the window for a map to count as drawn. A blank canvas has none.
const LIT_MIN: f64 = 0.03;
/// Smallest number of colours there for a map to count as drawn. A robot on an empty grid has a few.
const COLOURS_MIN: usize = 100;

#[test]
fn a_hall_is_mapped_saved_and_opened_again() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    let server = Server::start("b1", data.path());
    let mut page = browser.open(1440, 900);
    page.go(&server.url());

    page.click("button", "Map");
    page.click("button", "Start mapping");
    wait_for("mapping to begin", WALK_LIMIT, || (page.status("Mapping")? == "Mapping").then_some(()));
    let points_at_first =
        wait_for("a first map", WALK_LIMIT, || number(&mut page, "Points in map").filter(|n| *n > 0.0));
    let keyframes_at_first = number(&mut page, "Keyframes").unwrap();

    drive_by_keys(&mut page, 2.0);
    drive_by_joystick(&mut page, 2.0);
    wait_for("the map to grow", WALK_LIMIT, || {
        let grown = number(&mut page, "Keyframes")? > keyframes_at_first
            && number(&mut page, "Points in map")? > points_at_first;
        grown.then_some(())
    });
    wait_for_drawn_map(&mut page);
    page.screenshot().save("mapping-1440x900");
    page.resize(1024, 768);
    wait_for_drawn_map(&mut page);
    page.screenshot().save("mapping-1024x768");
    page.resize(1440, 900);
    start_adding_a_loop(&mut page);

    page.click("textbox", "Map name");
    page.type_text("Test hall");
    page.click("button", "Finish and save");
    wait_for("the saved map", WALK_LIMIT, || page.find("status", "Saved map Test hall"));

    page.reload();
    page.click("button", "Map");
    wait_for("the map after a reload", DRAW_LIMIT, || page.find("status", "Saved map Test hall"));
    page.click("button", "View Test hall");
    wait_for_drawn_map(&mut page);
    page.screenshot().save("saved-map-1440x900");
    extend(&mut page, "Test hall", "Larger hall");
    localise(&mut page, "Larger hall");
    zoom_to_the_robot(&mut page);
    set_pose(&mut page, "Larger hall");
    cover_the_lidar(&mut page);

    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

#[test]
fn the_client_works_on_a_plain_http_name_of_the_local_network() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    let server = Server::start("b1", data.path());
    let mut page = browser.open(1440, 900);
    let url = format!("http://{LAN_HOST}:{}/", server.port);
    page.go(&url);
    page.click("button", "Map");
    assert_eq!(
        page.evaluate("isSecureContext"),
        false,
        "the test needs an origin that browsers do not trust"
    );
    page.click("button", "Start mapping");
    wait_for("a first map", WALK_LIMIT, || number(&mut page, "Points in map").filter(|n| *n > 0.0));
    wait_for_drawn_map(&mut page);

    // Time until the map of a robot that is mapping already is drawn. It starts from an empty page, because a reload would include the end of the
    // old page.
    page.go("about:blank");
    assert_eq!(page.evaluate(NEXT_PICTURES), true, "the old page has drawn its last frames");
    page.go(&url);
    wait_for("the first map in the page's timeline", DRAW_LIMIT, || {
        let marks = page.marks();
        marks.iter().any(|(moment, _)| moment == "autoinspect: first map drawn").then(|| {
            for (moment, at) in marks {
                println!("{at:.2} s after navigation: {moment}");
            }
        })
    });
    wait_for_drawn_map(&mut page);
    let mut errors = page.errors();
    // The browser reports that this header has an effect on trusted origins only, which is intended.
    errors.retain(|error| !error.contains("Cross-Origin-Opener-Policy header has been ignored"));
    assert_eq!(errors, Vec::<String>::new());
    server.stop();
}

/// Extends the saved map on the screen, in which the robot still stands, and saves the larger map.
#[track_caller]
fn extend(page: &mut Page, map: &str, larger: &str) {
    page.click("button", &format!("Extend {map}"));
    wait_for("the robot to go on in its map", WALK_LIMIT, || (page.status("Extends")? == map).then_some(()));
    wait_for_drawn_map(page);
    drive_by_keys(page, 2.0);
    page.screenshot().save("extending-1440x900");
    page.click("textbox", "Map name");
    page.type_text(larger);
    page.click("button", "Finish and save");
    let saved = format!("Saved map {larger}");
    wait_for("the larger map", WALK_LIMIT, || page.find("status", &saved));
}

/// Localises the robot in the saved map on the screen, in which it stands.
#[track_caller]
pub(super) fn localise(page: &mut Page, map: &str) {
    page.click("button", &format!("Use {map}"));
    page.click("button", "Live");
    wait_for("the robot to find itself", WALK_LIMIT, || {
        (page.status("Localisation")? == "Localised").then_some(())
    });
    wait_for_drawn_map(page);
    page.screenshot().save("localised-1440x900");
}

/// Zooms to the robot as near as it goes while the camera follows it, and away again until the hall is small.
#[track_caller]
fn zoom_to_the_robot(page: &mut Page) {
    for (delta_y, picture) in [(-700.0, "near"), (-3000.0, "nearest"), (1400.0, "far")] {
        let robot = page.control("button", "Robot in the scene");
        let at = page.middle(&robot).expect("it is in the image");
        page.move_to(at);
        page.wheel(at, delta_y);
        wait_for_drawn_map(page);
        page.screenshot().save(&format!("robot-{picture}-1440x900"));
    }
}

/// Sets the pose of the robot on the saved map, near its newest keyframe and facing ahead, and waits until the robot is localised.
#[track_caller]
fn set_pose(page: &mut Page, map: &str) {
    page.click("button", "Map");
    page.click("button", &format!("View {map}"));
    page.click("button", "Top view");
    let mut last = None;
    let (newest, before) = wait_for("two keyframes to rest on the screen", DRAW_LIMIT, || {
        let mut keyframes: Vec<(u32, PageControl)> = page
            .all("button")
            .into_iter()
            .filter_map(|(name, control)| Some((name.strip_prefix("Keyframe ")?.parse().ok()?, control)))
            .collect();
        keyframes.sort_by_key(|(number, _)| std::cmp::Reverse(*number));
        let mut middles = keyframes.iter().filter_map(|(_, control)| page.middle(control));
        let now = (middles.next()?, middles.next()?);
        assert_eq!(page.evaluate(NEXT_PICTURES), true);
        // The camera flies there; the loop waits until the control no longer moves.
        (last.replace(now) == Some(now)).then_some(now)
    });
    page.click("button", "Set the pose");
    wait_for("the hint", DRAW_LIMIT, || page.find("button", "Cancel"));
    page.press(newest);
    let ahead = At { x: 4.0 * newest.x - 3.0 * before.x, y: 4.0 * newest.y - 3.0 * before.y };
    page.move_to(ahead);
    page.screenshot().save("showing-where-it-stands-1440x900");
    page.release(ahead);
    page.click("button", "Live");
    wait_for("the place to snap", WALK_LIMIT, || (page.status("Localisation")? == "Localised").then_some(()));
}

/// Covers the LiDAR of the simulated robot, and waits until the robot reports that and recovers.
#[track_caller]
fn cover_the_lidar(page: &mut Page) {
    page.click("button", "Cover the LiDAR for 20 s");
    wait_for("the robot to report that its LiDAR sees nothing", WALK_LIMIT, || {
        (page.status("Localisation")? == "Uncertain: the LiDAR sees nothing").then_some(())
    });
    page.screenshot().save("lidar-covered-1440x900");
    wait_for("the robot to be localised again", WALK_LIMIT, || {
        (page.status("Localisation")? == "Localised").then_some(())
    });
}

/// Opens the list of loops, starts to add one by hand, and goes back.
#[track_caller]
fn start_adding_a_loop(page: &mut Page) {
    page.click("button", "Loops");
    wait_for("the number of loops", DRAW_LIMIT, || number(page, "Accepted loops"));
    page.click("button", "Add a loop");
    wait_for("the first step", DRAW_LIMIT, || {
        page.status("Message")?.starts_with("Step 1 of 3").then_some(())
    });
    page.click("button", "Cancel adding");
    page.click("button", "Session");
}

/// Holds W until the robot has walked `distance_m` more, and turns a little.
#[track_caller]
pub(super) fn drive_by_keys(page: &mut Page, distance_m: f64) {
    let goal = number(page, "Distance").unwrap_or(0.0) + distance_m;
    page.key_down(KeyPress::W);
    wait_for("the robot to walk by keyboard", WALK_LIMIT, || {
        (number(page, "Distance")? >= goal).then_some(())
    });
    page.key_down(KeyPress::Q);
    page.key_up(KeyPress::Q);
    page.key_up(KeyPress::W);
}

/// Drags the joystick on the screen ahead until the robot has walked `distance_m` more.
#[track_caller]
fn drive_by_joystick(page: &mut Page, distance_m: f64) {
    let goal = number(page, "Distance").unwrap_or(0.0) + distance_m;
    let joystick = page.control("group", "Joystick");
    let middle = page.middle(&joystick).unwrap();
    page.press(middle);
    page.move_to(At { x: middle.x + 25.0, y: middle.y - 50.0 });
    wait_for("the robot to walk by the joystick", WALK_LIMIT, || {
        (number(page, "Distance")? >= goal).then_some(())
    });
    page.release(middle);
}

/// Waits until a map is drawn; after the time limit, saves the picture and fails.
#[track_caller]
pub(super) fn wait_for_drawn_map(page: &mut Page) {
    let started = Instant::now();
    loop {
        let picture = page.screenshot();
        let (lit, colours) = (picture.lit(picture.middle(), 30), picture.colours(picture.middle()));
        if lit >= LIT_MIN && colours >= COLOURS_MIN {
            return;
        }
        if started.elapsed() > DRAW_LIMIT {
            let kept = picture.save("not-drawn");
            panic!("no map is drawn: {lit:.3} lit, {colours} colours; see {}", kept.display());
        }
    }
}

/// The number of a status in its plain unit, from texts like `12.3 m`, `64 k` and `1\u{a0}234`.
pub(super) fn number(page: &mut Page, status: &str) -> Option<f64> {
    let text = page.status(status)?;
    let (digits, unit) = text.split_once(' ').unwrap_or((&text, ""));
    let value: f64 = digits.replace('\u{a0}', "").parse().ok()?;
    Some(match unit {
        "k" | "km" => 1e3 * value,
        "million" => 1e6 * value,
        _ => value,
    })
}
