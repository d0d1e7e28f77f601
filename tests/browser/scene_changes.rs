//! What has changed, in a real browser: a mission finds that furniture was moved since the site was mapped, an operator acknowledges a change and makes it normal, and the robot goes on in
//! the new version of the map. Then the history of a gauge.

mod nightly {
    use crate::support::chromium::Chromium;
    use crate::support::page::{At, KeyPress, Page};
    use crate::support::server::Server;
    use crate::support::{wait_for, workspace_root};
    use serde_json::Value;
    use std::time::Duration;

    /// Longest wait for the example, and for a run of its mission.
    const LONG_LIMIT: Duration = Duration::from_secs(300);
    const LIMIT: Duration = Duration::from_secs(180);
    /// A part of the walk: enough for some inspection points and their mission.
    const SHORT: &str = "--example-minutes=2";
    /// A gauge of the example, whose pressure swings.
    const GAUGE: &str = "Pressure gauge PI-101";
    /// The gauge in its photo, pixels.
    const CENTRE_PX: [f64; 2] = [320.5, 205.0];
    const LOWER_END_PX: [f64; 2] = [275.0, 256.0];
    const MIDDLE_PX: [f64; 2] = [321.0, 133.0];
    const UPPER_END_PX: [f64; 2] = [366.0, 256.0];

    #[test]
    fn a_change_that_a_mission_finds_is_acknowledged_and_made_normal() {
        let Some(browser) = Chromium::start() else { return };
        let data = tempfile::tempdir().unwrap();
        let server = Server::start_with("b1", data.path(), &[SHORT]);
        let mut page = browser.open(1440, 900);
        page.go(&server.url());
        page.click("button", "Explore the example");
        wait_for("the mission of the example", LONG_LIMIT, || page.find("button", "Run now"));
        wait_until_localised(&mut page);
        let old_map = map_of_site(&mut page);
        server.stop();

        // The next day some of the furniture stands elsewhere.
        let server = Server::start_with("b1", data.path(), &[SHORT, "--day=2"]);
        page.go(&server.url());
        page.click("button", "Missions");
        wait_until_localised(&mut page);
        assert_eq!(map_of_site(&mut page), old_map);
        page.click("button", "Mission Daily round");
        page.click("button", "Run now");
        let run = wait_for("the end of the run", LONG_LIMIT, || {
            let run = get(&mut page, "/api/v1/runs")["items"][0].clone();
            (run["is_ended"] == true).then_some(run)
        });
        assert_eq!(run["state"], "succeeded", "{run}");
        let found = wait_for("what has changed", LIMIT, || {
            let changes = get(&mut page, "/api/v1/scene-changes");
            changes["items"].as_array().filter(|items| !items.is_empty()).cloned()
        });

        page.click("button", "Runs");
        page.click("button", "Changes");
        look_at_what_was_moved(&mut page);
        // Its name has its age, which changes.
        press_row(&mut page, " m · ");
        page.click("button", "Show the place");
        page.screenshot().save("changes-found-1440x900");
        save_for_guide(&mut page, "changes-found");
        page.click("button", "Wipe");
        page.control("slider", "Wipe between before and after");
        page.wait_for_pictures();
        page.screenshot().save("changes-wipe-1440x900");
        save_for_guide(&mut page, "changes-wipe");
        page.click("button", "Both");
        page.click("button", "Acknowledge");
        page.click("button", "Filters");
        page.click("button", "Acknowledged");
        page.click("button", "Make the acknowledged change normal");
        let normal = wait_for("the new version of the map", LONG_LIMIT, || {
            let changes = get(&mut page, "/api/v1/scene-changes?review=normal");
            changes["items"][0]["object"]["review"]["normal"]["map"].as_str().map(str::to_owned)
        });
        assert_ne!(normal, old_map);
        wait_for("the robot to go on in the new version", LIMIT, || {
            (map_of_site(&mut page) == normal).then_some(())
        });
        page.click("button", "Any state");
        page.screenshot().save("changes-normal-1440x900");
        // What is still open is a change of the new version.
        let open = get(&mut page, &format!("/api/v1/scene-changes?map={normal}"));
        assert_eq!(open["items"].as_array().map(Vec::len), Some(found.len() - 1), "{open}");
        page.click("button", "Points");
        page.click("button", "Inspection point");
        page.click("button", GAUGE);
        page.control("slider", "Time line");
        page.wait_for_pictures();
        page.screenshot().save("changes-gauge-1440x900");

        // The gauge is described once, and read in the photo of the next run.
        page.click("button", "Describe the gauge");
        describe_gauge(&mut page);
        page.screenshot().save("gauge-described-1440x900");
        save_for_guide(&mut page, "gauge-described");
        page.resize(1024, 768);
        page.wait_for_pictures();
        page.screenshot().save("gauge-described-1024x768");
        page.resize(1440, 900);
        page.wait_for_pictures();
        page.click("button", "Save the gauge");
        limit_the_gauge(&mut page);
        // The mission is still open there.
        page.click("button", "Missions");
        page.click("button", "Run now");
        let read = wait_for("the reading of the gauge", LONG_LIMIT, || {
            let points = get(&mut page, "/api/v1/site/inspection-points");
            let described =
                points["items"].as_array()?.iter().find(|item| item["object"]["gauge"].is_object())?;
            let id = described["object"]["id"].as_str()?;
            let results = get(&mut page, &format!("/api/v1/inspection-points/{id}/results?limit=1"));
            let report = results["items"][0]["details"]["value"].clone();
            report["gauge"].is_object().then_some(report)
        });
        assert!(read["gauge"]["problem"].is_null(), "{read}");
        let reading = &read["readings"][0];
        let value = reading["value"].as_f64().unwrap();
        // The simulated pressure is 3.0 bar, give or take 0.4 over 15 minutes.
        assert!((2.5..=3.5).contains(&value) && reading["unit"] == "bar", "{reading}");
        page.click("button", "Runs");
        page.click("button", "Points");
        page.control("slider", "Time line");
        page.wait_for_pictures();
        page.click("button", "Compare large");
        page.wait_for_pictures();
        page.screenshot().save("gauge-read-1440x900");
        save_for_guide(&mut page, "gauge-read");
        // Both photos of the gauge are aligned: the divider of a wipe shows one thing.
        let aligned = wait_for("the alignment", LIMIT, || {
            page.status("Alignment").filter(|said| !said.contains("aligns"))
        });
        assert!(aligned.starts_with("Aligned, within "), "{aligned}");
        page.click("button", "Wipe");
        page.control("slider", "Divider");
        page.wait_for_pictures();
        page.screenshot().save("gauge-wipe-1440x900");
        page.key_in_form(KeyPress::ESCAPE);
        decide_on_the_alert(&mut page);
        // While the platform starts again, the page finds nobody.
        let mut errors = page.errors();
        errors.retain(|error| !error.contains("ERR_CONNECTION_REFUSED"));
        assert_eq!(errors, Vec::<String>::new());
        server.stop();
    }

    /// Lists the things that were moved alone, and then all again.
    fn look_at_what_was_moved(page: &mut Page) {
        page.click("button", "Filters");
        page.click("button", "Moved");
        page.click("button", "Filters");
        press_row(page, " m · ");
        page.click("button", "Show the place");
        page.wait_for_pictures();
        page.screenshot().save("changes-moved-1440x900");
        page.click("button", "Filters");
        page.click("button", "Any kind");
        page.click("button", "Filters");
    }

    /// Says that the gauge has to show less than it does: it is farther above the limits than they are apart.
    fn limit_the_gauge(page: &mut Page) {
        let gauge = wait_for("the description of the gauge", LIMIT, || {
            let points = get(page, "/api/v1/site/inspection-points");
            points["items"].as_array()?.iter().find(|item| item["object"]["gauge"].is_object()).cloned()
        });
        let id = gauge["object"]["id"].as_str().unwrap();
        let status = page.evaluate(&format!(
            "fetch('/api/v1/site/inspection-points/{id}', {{ method: 'PATCH', headers: {{ 'content-type': 'application/json', 'if-match': '\"{}\"' }}, \
             body: JSON.stringify({{ limits: {{ min: 1.5, max: 2.0, unit: 'bar' }} }}) }}).then(answer => answer.status)",
            gauge["revision"]
        ));
        assert_eq!(status, 200);
    }

    /// The reading above the limit has raised an alert, which is looked at, acknowledged, and given an owner and a work order.
    fn decide_on_the_alert(page: &mut Page) {
        page.click("button", "Alerts");
        let alert =
            |page: &mut Page| get(page, "/api/v1/alerts?cause=outside_limits")["items"][0]["object"].clone();
        assert_eq!(alert(page)["state"], "open");
        page.wait_for_pictures();
        page.screenshot().save("alerts-1440x900");
        press_row(page, &format!("Critical · {GAUGE}"));
        page.click("button", "Acknowledge");
        page.click("button", "I look after it");
        page.control("button", "Open again");
        // The rest of the form is below the edge of the card.
        page.wheel(At { x: 1250.0, y: 700.0 }, 2_000.0);
        page.click("textbox", "Work order");
        page.wait_for_pictures();
        page.type_text("WO-1042: check the reducing valve");
        page.wait_for_pictures();
        page.click("button", "Keep the work order");
        wait_for("the work order", LIMIT, || {
            let alert = alert(page);
            (alert["work_order"] == "WO-1042: check the reducing valve" && alert["owner"] != "").then_some(())
        });
        page.wait_for_pictures();
        page.screenshot().save("alert-1440x900");
        save_for_guide(page, "alert");
        page.resize(1024, 768);
        page.wait_for_pictures();
        page.screenshot().save("alert-1024x768");
        page.resize(1440, 900);
        page.wait_for_pictures();
    }

    fn wait_until_localised(page: &mut Page) {
        wait_for("the robot to be localised", LIMIT, || {
            get(page, "/api/v1/runs/current")["route"]["at"].is_string().then_some(())
        });
    }

    /// The map that the site follows: that in which the robot was localised last.
    fn map_of_site(page: &mut Page) -> String {
        wait_for("the map of the site", LIMIT, || {
            get(page, "/api/v1/site/settings/main")["map"].as_str().map(str::to_owned)
        })
    }

    /// The gauge's pressure swings over 15 minutes, so after some runs its needle has moved. Then people are told, a mark is on the time line, and a wipe of the aligned photos shows it.
    #[test]
    fn a_photo_that_differs_from_the_one_before_is_marked_and_wiped() {
        let Some(browser) = Chromium::start() else { return };
        let data = tempfile::tempdir().unwrap();
        let server = Server::start_with("b1", data.path(), &[SHORT]);
        let mut page = browser.open(1440, 900);
        page.go(&server.url());
        page.click("button", "Explore the example");
        wait_for("the mission of the example", LONG_LIMIT, || page.find("button", "Run now"));
        wait_until_localised(&mut page);
        let mut runs = 0;
        // The notice is on show for some seconds, soon after the photo and long before the end of the run.
        let mut is_told = false;
        while !has_changed_photo(&mut page, &mut is_told) {
            runs += 1;
            assert!(runs < 8, "the needle has not moved");
            // The mission is open there.
            page.click("button", "Missions");
            page.click("button", "Run now");
            wait_for("the end of the run", LONG_LIMIT, || {
                is_told |= is_told_of_change(&mut page);
                let listed = get(&mut page, "/api/v1/runs");
                let listed = listed["items"].as_array()?;
                (listed.len() == runs && listed[0]["is_ended"] == true).then_some(())
            });
        }
        assert!(is_told, "no notice of the photo that has changed");
        page.click("button", "Runs");
        page.click("button", "Points");
        page.click("button", "Inspection point");
        page.click("button", GAUGE);
        page.control("slider", "Time line");
        page.wait_for_pictures();
        page.screenshot().save("photo-changed-1440x900");
        page.click("button", "Compare large");
        let aligned = wait_for("the alignment", LIMIT, || page.status("Alignment"));
        assert!(
            aligned.starts_with("Aligned, within ") && aligned.contains(" px · changed in "),
            "{aligned}"
        );
        page.wait_for_pictures();
        page.screenshot().save("photo-beside-1440x900");
        page.click("button", "Wipe");
        page.control("slider", "Divider");
        page.wait_for_pictures();
        page.screenshot().save("photo-wipe-1440x900");
        save_for_guide(&mut page, "photo-wipe");
        page.resize(1024, 768);
        page.wait_for_pictures();
        page.screenshot().save("photo-wipe-1024x768");
        page.click("button", "Side by side");
        page.wait_for_pictures();
        page.screenshot().save("photo-beside-1024x768");
        assert_eq!(page.errors(), Vec::<String>::new());
        server.stop();
    }

    /// Whether a notice says now that a photo has changed.
    fn is_told_of_change(page: &mut Page) -> bool {
        let shown = page.all("alert");
        shown
            .into_iter()
            .any(|(name, notice)| page.text(&notice).unwrap_or(name).contains("differs from the one before"))
    }

    /// Whether the newest photo of the gauge has changed. Waits until it was compared, if there is one before it, and notes whether people are told of a change meanwhile.
    fn has_changed_photo(page: &mut Page, is_told: &mut bool) -> bool {
        wait_for("the comparison of the newest photo", LIMIT, || {
            *is_told |= is_told_of_change(page);
            let points = get(page, "/api/v1/site/inspection-points");
            let gauge = points["items"].as_array()?.iter().find(|item| item["object"]["name"] == GAUGE)?;
            let id = gauge["object"]["id"].as_str()?;
            let results = get(page, &format!("/api/v1/inspection-points/{id}/results?limit=2"));
            let results = results["items"].as_array()?;
            if results.len() < 2 {
                return Some(false);
            }
            let aligned = &results[0]["comparison"]["outcome"]["aligned"];
            aligned["changes"].as_array().map(|changes| !changes.is_empty())
        })
    }

    /// Presses the first row whose name contains this text.
    fn press_row(page: &mut Page, part: &str) {
        let at = wait_for("a row of the list", LIMIT, || {
            let (_, row) = page.all("button").into_iter().find(|(name, _)| name.contains(part))?;
            page.middle(&row)
        });
        page.press(at);
        page.release(at);
    }

    /// Marks the dial in the photo and enters what its ends mean. The gauge is in the middle of the picture, 1,600 pixels are a metre, and its scale spans 270 degrees.
    fn describe_gauge(page: &mut Page) {
        const SIZE_PX: [f64; 2] = [640.0, 480.0];
        let photo = page.control("image", "Photo of the gauge");
        page.wait_for_pictures();
        let [min, max] = page.corners(&photo).unwrap();
        let (width, height) = (max.x - min.x, max.y - min.y);
        let scale = (width / SIZE_PX[0]).min(height / SIZE_PX[1]);
        for [x, y] in [CENTRE_PX, LOWER_END_PX, MIDDLE_PX, UPPER_END_PX] {
            let at = At {
                x: min.x + 0.5 * width + scale * (x - 0.5 * SIZE_PX[0]),
                y: min.y + 0.5 * height + scale * (y - 0.5 * SIZE_PX[1]),
            };
            page.move_to(at);
            page.press(at);
            page.release(at);
            page.wait_for_pictures();
        }
        for (name, value) in [("At lower end", "0"), ("At upper end", "10")] {
            page.click("textbox", name);
            page.wait_for_pictures();
            page.type_text(value);
            page.wait_for_pictures();
        }
        page.click("button", "Unit");
        page.click("button", "bar");
    }

    /// With `AUTOINSPECT_GUIDE=1`, saves a picture of `docs/guide/changes.md`.
    fn save_for_guide(page: &mut Page, name: &str) {
        if std::env::var_os("AUTOINSPECT_GUIDE").is_some() {
            let path = workspace_root().join(format!("docs/guide/images/{name}.webp"));
            std::fs::write(path, page.guide_picture()).unwrap();
        }
    }

    fn get(page: &mut Page, path: &str) -> Value {
        page.evaluate(&format!("fetch('{path}').then(answer => answer.json())"))
    }
}
