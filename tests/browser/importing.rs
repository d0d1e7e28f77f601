//! A map of somebody else's, brought by the browser.

use crate::support::chromium::Chromium;
use crate::support::server::Server;
use crate::support::wait_for;
use std::fmt::Write as _;
use std::time::Duration;

const IMPORT_LIMIT: Duration = Duration::from_secs(120);

/// A room of 8 by 6 metres as a PLY file: floor, ceiling and walls.
fn room() -> String {
    let mut points: Vec<[f32; 3]> = Vec::new();
    for x in 0..=160_u8 {
        for y in 0..=120_u8 {
            let [x, y] = [0.05 * f32::from(x), 0.05 * f32::from(y)];
            points.extend([[x, y, 0.0], [x, y, 3.0]]);
        }
    }
    for z in 0..=60_u8 {
        let z = 0.05 * f32::from(z);
        points.extend(
            (0..=160_u8).flat_map(|x| [[0.05 * f32::from(x), 0.0, z], [0.05 * f32::from(x), 6.0, z]]),
        );
        points.extend(
            (0..=120_u8).flat_map(|y| [[0.0, 0.05 * f32::from(y), z], [8.0, 0.05 * f32::from(y), z]]),
        );
    }
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        points.len()
    );
    for [x, y, z] in points {
        writeln!(text, "{x} {y} {z}").unwrap();
    }
    text
}

#[test]
fn a_cloud_of_somebody_else_s_is_sent_and_becomes_a_map_and_what_is_none_is_said() {
    let Some(browser) = Chromium::start() else { return };
    let (data, files) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (survey, letter) = (files.path().join("North room.ply"), files.path().join("letter.ply"));
    std::fs::write(&survey, room()).unwrap();
    std::fs::write(&letter, "Dear Sir or Madam").unwrap();
    let server = Server::start("b1", data.path());
    let mut page = browser.open(1440, 900);
    page.go(&server.url());

    page.click("button", "Map");
    page.choose_file("Import a map", &survey);
    wait_for("the map", IMPORT_LIMIT, || page.find("status", "Saved map North room"));
    page.click("button", "View North room");
    wait_for("its points", IMPORT_LIMIT, || page.find("button", "Use North room"));
    page.screenshot().keep("imported-1440x900");
    page.choose_file("Import a map", &letter);
    let told = wait_for("the refusal", IMPORT_LIMIT, || {
        page.all("status").into_iter().chain(page.all("alert")).find_map(|(name, control)| {
            let text = page.text(&control).unwrap_or(name);
            text.contains("letter was not imported").then_some(text)
        })
    });
    assert!(!told.contains(&*data.path().to_string_lossy()), "{told}");
    // A bare room looks the same from both ends, and is too small to be sure of.
    let again = files.path().join("Again.ply");
    std::fs::copy(&survey, &again).unwrap();
    page.choose_file("Import and align", &again);
    let told = wait_for("the other refusal", IMPORT_LIMIT, || {
        page.all("status").into_iter().chain(page.all("alert")).find_map(|(name, control)| {
            let text = page.text(&control).unwrap_or(name);
            text.contains("Again was not imported").then_some(text)
        })
    });
    assert!(told.contains("that map") && !told.contains(&*data.path().to_string_lossy()), "{told}");
    assert_eq!(std::fs::read_dir(data.path().join("uploads")).unwrap().count(), 0);
    assert_eq!(page.complaints(), Vec::<String>::new());
    server.stop();
}
