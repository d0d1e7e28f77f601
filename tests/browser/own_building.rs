//! A building in a glTF file, the example of the guide (`docs/guide/own-building.md`), walked and mapped in the browser.

use super::mapping::{WALK_LIMIT, drive_by_keys, number, wait_for_drawn_map};
use crate::support::chromium::Chromium;
use crate::support::page::{KeyPress, Page};
use crate::support::server::Server;
use crate::support::{wait_for, workspace_root};

#[test]
fn a_building_in_a_gltf_file_is_walked_and_mapped() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    let building = workspace_root().join("docs/guide/examples/workshop.glb");
    let server = Server::start(&building.display().to_string(), data.path());
    let mut page = browser.open(1440, 900);
    page.go(&server.url());

    page.click("button", "Map");
    page.click("button", "Start mapping");
    wait_for("a first map", WALK_LIMIT, || number(&mut page, "Points in map").filter(|n| *n > 0.0));
    // From the dock past the bench and the columns, then round to the left towards the gate.
    drive_by_keys(&mut page, 6.5);
    drive_in_an_arc(&mut page, 1.5);
    drive_by_keys(&mut page, 2.0);
    wait_for("the keyframes of the walk", WALK_LIMIT, || {
        number(&mut page, "Keyframes").filter(|keyframes| *keyframes >= 5.0)
    });
    wait_for_drawn_map(&mut page);
    page.screenshot().save("own-building-1440x900");

    page.click("textbox", "Map name");
    page.type_text("Workshop");
    page.click("button", "Finish and save");
    wait_for("the saved map", WALK_LIMIT, || page.find("status", "Saved map Workshop"));
    // The page shows the map that was just saved.
    page.control("button", "Use Workshop");
    wait_for_drawn_map(&mut page);
    page.screenshot().save("own-building-saved-1440x900");
    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

/// Holds W and Q until the robot has walked `distance_m` more.
#[track_caller]
fn drive_in_an_arc(page: &mut Page, distance_m: f64) {
    let goal = number(page, "Distance").unwrap_or(0.0) + distance_m;
    page.key_down(KeyPress::W);
    page.key_down(KeyPress::Q);
    wait_for("the robot to walk in an arc", WALK_LIMIT, || (number(page, "Distance")? >= goal).then_some(()));
    page.key_up(KeyPress::Q);
    page.key_up(KeyPress::W);
}
