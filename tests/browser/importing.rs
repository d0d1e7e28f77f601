//! Tests of importing point clouds of other programs in the browser.

use crate::support::chromium::Chromium;
use crate::support::page::{At, NEXT_PICTURES, Page};
use crate::support::server::Server;
use crate::support::wait_for;
use std::fmt::Write as _;
use std::time::Duration;

const IMPORT_LIMIT: Duration = Duration::from_secs(120);

/// A room of 8 by 6 metres as a PLY file: floor, ceiling and walls, moved `east` metres along x.
fn room(east: f32) -> String {
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
        writeln!(text, "{} {y} {z}", x + east).unwrap();
    }
    text
}

#[test]
fn an_uploaded_cloud_becomes_a_map_and_another_file_is_rejected() {
    let Some(browser) = Chromium::start() else { return };
    let (data, files) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (survey, letter) = (files.path().join("North room.ply"), files.path().join("letter.ply"));
    std::fs::write(&survey, room(0.0)).unwrap();
    std::fs::write(&letter, "Dear Sir or Madam").unwrap();
    let server = Server::start("b1", data.path());
    let mut page = browser.open(1440, 900);
    page.go(&server.url());

    page.click("button", "Map");
    page.choose_file("Import a map", &survey);
    wait_for("the map", IMPORT_LIMIT, || page.find("status", "Saved map North room"));
    page.click("button", "View North room");
    wait_for("its points", IMPORT_LIMIT, || page.find("button", "Use North room"));
    page.screenshot().save("imported-1440x900");
    page.choose_file("Import a map", &letter);
    let message = wait_for("the refusal", IMPORT_LIMIT, || {
        page.all("status").into_iter().chain(page.all("alert")).find_map(|(name, control)| {
            let text = page.text(&control).unwrap_or(name);
            text.contains("letter was not imported").then_some(text)
        })
    });
    assert!(!message.contains(&*data.path().to_string_lossy()), "{message}");
    // A bare room is symmetric, so its alignment is ambiguous.
    let again = files.path().join("Again.ply");
    std::fs::copy(&survey, &again).unwrap();
    page.choose_file("Import and align", &again);
    let message = wait_for("the other refusal", IMPORT_LIMIT, || {
        page.all("status").into_iter().chain(page.all("alert")).find_map(|(name, control)| {
            let text = page.text(&control).unwrap_or(name);
            text.contains("Again was not imported").then_some(text)
        })
    });
    assert!(message.contains("that map") && !message.contains(&*data.path().to_string_lossy()), "{message}");
    // Both files are kept for another attempt. They are at the end of the card, which is longer than the window.
    page.resize(1440, 1500);
    for name in ["letter", "Again"] {
        wait_for("the file", IMPORT_LIMIT, || page.find("status", &format!("Uploaded file {name}")));
        page.click("button", &format!("Delete file {name}"));
    }
    wait_for("no file to wait", IMPORT_LIMIT, || {
        (std::fs::read_dir(data.path().join("uploads")).unwrap().count() == 0).then_some(())
    });
    page.resize(1440, 900);
    rename_delete_and_restore(&mut page);
    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

/// Renames the saved map "North room", which is viewed, deletes it, undoes that, deletes it again and restores it from the bin.
#[track_caller]
fn rename_delete_and_restore(page: &mut Page) {
    page.click("button", "Rename North room");
    page.click("textbox", "New map name");
    page.type_text(" 2");
    page.screenshot().save("renaming-1440x900");
    page.click("button", "Save the name");
    wait_for("the new name", IMPORT_LIMIT, || page.find("status", "Saved map North room 2"));
    page.click("button", "Delete North room 2");
    let deleted = |page: &mut Page| {
        wait_for("the deletion", IMPORT_LIMIT, || {
            page.status("Message")?.contains("North room 2 is in the bin").then_some(())
        });
    };
    deleted(page);
    assert!(page.find("status", "Saved map North room 2").is_none());
    page.click("button", "Undo");
    page.click("button", "View North room 2");
    wait_for("its points", IMPORT_LIMIT, || page.find("button", "Use North room 2"));
    page.click("button", "Delete North room 2");
    deleted(page);
    page.click("button", "Bin");
    wait_for("the map in the bin", IMPORT_LIMIT, || page.find("status", "Deleted map North room 2"));
    page.screenshot().save("bin-1440x900");
    page.resize(1024, 768);
    page.control("button", "Restore North room 2");
    assert_eq!(page.evaluate(NEXT_PICTURES), true);
    page.screenshot().save("bin-1024x768");
    page.resize(1440, 900);
    page.click("button", "Restore North room 2");
    wait_for("the map again", IMPORT_LIMIT, || page.find("status", "Saved map North room 2"));
}

/// Waits until the picture no longer changes.
#[track_caller]
fn wait_for_still_picture(page: &mut Page) {
    let (mut last, mut same) = (None, 0);
    wait_for("the picture to rest", IMPORT_LIMIT, || {
        assert_eq!(page.evaluate(NEXT_PICTURES), true);
        let picture = page.screenshot();
        let now = (picture.lit(picture.middle(), 30), picture.colours(picture.middle()));
        same = if now.0 > 0.05 && last.replace(now) == Some(now) { same + 1 } else { 0 };
        (same == 3).then_some(())
    });
}

#[test]
fn a_map_is_aligned_with_another_by_points_that_are_clicked_in_both() {
    let Some(browser) = Chromium::start() else { return };
    let (data, files) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let server = Server::start("b1", data.path());
    let mut page = browser.open(1440, 900);
    page.go(&server.url());
    page.click("button", "Map");
    for (name, east) in [("North room", 0.0), ("South room", 30.0)] {
        let file = files.path().join(format!("{name}.ply"));
        std::fs::write(&file, room(east)).unwrap();
        page.choose_file("Import a map", &file);
        wait_for("the map", IMPORT_LIMIT, || page.find("status", &format!("Saved map {name}")));
    }
    page.click("button", "View North room");
    page.click("button", "Align North room");
    page.click("button", "Onto South room");
    // The camera shows both rooms in the same way, so the same pixel shows the same point of both.
    for at in [At { x: 640.0, y: 430.0 }, At { x: 860.0, y: 470.0 }] {
        for other in ["South room", "North room"] {
            wait_for("the map to be on show", IMPORT_LIMIT, || {
                page.find("button", &format!("Look at {other}"))
            });
            wait_for_still_picture(&mut page);
            page.press(at);
            page.release(at);
        }
    }
    wait_for("two pairs", IMPORT_LIMIT, || (page.status("Points picked in both")? == "2").then_some(()));
    wait_for_still_picture(&mut page);
    page.screenshot().save("aligning-1440x900");
    page.resize(1024, 768);
    page.screenshot().save("aligning-1024x768");
    page.click("button", "Align by the points");
    wait_for("the map", IMPORT_LIMIT, || page.find("status", "Saved map North room on South room"));
    let maps = std::fs::read_dir(data.path().join("maps")).unwrap().flatten();
    let laid: Vec<serde_json::Value> = maps
        .filter_map(|map| std::fs::read(map.path().join("align.json")).ok())
        .map(|text| serde_json::from_slice(&text).unwrap())
        .collect();
    let [laid] = laid.as_slice() else { panic!("{laid:?}") };
    let east = laid["aligned"]["map_from_cloud"]["position"]["x"].as_f64().unwrap();
    assert!((east - 30.0).abs() < 0.3, "{laid}");
    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

mod nightly {
    use super::{IMPORT_LIMIT, wait_for_still_picture};
    use crate::support::chromium::Chromium;
    use crate::support::server::Server;
    use crate::support::{wait_for, workspace_root};
    use std::path::PathBuf;

    /// A survey of a real building, of 2.8 million points, with stray points far from it.
    const SURVEY: &str = "map-import/hilti-uzh-prior-map.laz";

    #[test]
    fn a_real_survey_fills_the_view_as_it_opens() {
        let Some(browser) = Chromium::start() else { return };
        let folder = std::env::var_os("AUTOINSPECT_DATA")
            .map_or_else(|| workspace_root().join("../shared/data"), PathBuf::from);
        // The browser's dialogue takes no path with `..`.
        let Ok(survey) = folder.join(SURVEY).canonicalize() else {
            println!("skipped: test data {SURVEY} is not there; set AUTOINSPECT_DATA");
            return;
        };
        let data = tempfile::tempdir().unwrap();
        let server = Server::start("b1", data.path());
        let mut page = browser.open(1440, 900);
        page.go(&server.url());
        page.click("button", "Map");
        page.choose_file("Import a map", &survey);
        let name = "hilti-uzh-prior-map";
        wait_for("the map", 3 * IMPORT_LIMIT, || page.find("status", &format!("Saved map {name}")));
        page.click("button", &format!("View {name}"));
        wait_for("its points", IMPORT_LIMIT, || page.find("button", &format!("Use {name}")));
        wait_for_still_picture(&mut page);
        let picture = page.screenshot();
        picture.save("survey-1440x900");
        // Stray points 400 m off would leave a dot in the middle.
        let lit = picture.lit(picture.middle(), 30);
        assert!(lit > 0.3, "{lit} of the middle is lit");
        assert_eq!(page.errors(), Vec::<String>::new());
        server.stop();
    }
}
