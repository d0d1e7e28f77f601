//! Pictures of every screen with the example in it, at the sizes of desktop, tablets and phone and in all themes, for people who look at the design:
//! `artifacts/look-THEME-WIDTHxHEIGHT-SCREEN.png`.
//!
//! They take some minutes, so they are made in the nightly tier. `AUTOINSPECT_LOOK_DATA` names a data directory that is kept; without it the example is made anew each
//! time. `AUTOINSPECT_LOOK_THEMES` names the themes, all without it.

mod nightly {
    use crate::browser::mapping::wait_for_drawn_map;
    use crate::support::chromium::Chromium;
    use crate::support::operator::Operator;
    use crate::support::page::{KeyPress, Page};
    use crate::support::server::Server;
    use crate::support::wait_for;
    use serde_json::Value;
    use std::path::PathBuf;
    use std::time::Duration;

    const LIMIT: Duration = Duration::from_secs(900);
    const SIZES: [[u32; 2]; 4] = [[1440, 900], [1024, 768], [820, 1180], [390, 844]];
    const THEMES: [&str; 3] = ["Dark", "Light", "Sunlight"];
    const SCREENS: [&str; 7] = ["Live", "Map", "Site", "Missions", "Schedule", "Runs", "Settings"];

    #[test]
    fn every_screen_is_shown_at_every_size_in_every_theme() {
        let Some(browser) = Chromium::start() else { return };
        let made = tempfile::tempdir().unwrap();
        let data = std::env::var_os("AUTOINSPECT_LOOK_DATA").map_or(made.path().to_owned(), PathBuf::from);
        let server = Server::start_with("b1", &data, &["--example-minutes=4"]);
        let mut page = browser.open(1440, 900);
        page.go(&server.url());
        fill(&mut page);
        let mut operator = Operator::at(page);
        let wanted = std::env::var("AUTOINSPECT_LOOK_THEMES").unwrap_or_else(|_| THEMES.join(","));
        for theme in THEMES.into_iter().filter(|theme| wanted.contains(theme)) {
            operator.page.resize(1440, 900);
            operator.click("button", "Live");
            operator.click("button", "Theme");
            operator.click("button", &format!("{theme} theme"));
            operator.press(KeyPress::ESCAPE);
            show_details(&mut operator, &theme.to_lowercase());
            for [width, height] in SIZES {
                operator.page.resize(width, height);
                for screen in SCREENS {
                    operator.click("button", screen);
                    let open = operator.page.find("button", "Open panel");
                    if (700..1100).contains(&width) && open.is_some() {
                        operator.click("button", "Open panel");
                    }
                    save(&mut operator.page, &theme.to_lowercase(), &screen.to_lowercase());
                }
            }
        }
        assert_eq!(operator.page.errors(), Vec::<String>::new());
        server.stop();
    }

    /// Makes the example and lets its mission run once, unless that was done.
    fn fill(page: &mut Page) {
        page.control("button", "Live");
        if get(page, "/api/v1/site")["objects"]["nodes"].as_u64().unwrap_or(0) == 0 {
            page.click("button", "Explore the example");
            wait_for("the mission of the example", LIMIT, || page.find("button", "Run now"));
        }
        wait_for("the robot to be localised", LIMIT, || {
            page.status("Position")?.starts_with("Localised").then_some(())
        });
        if get(page, "/api/v1/runs")["items"][0].is_null() {
            page.click("button", "Run now");
        }
        wait_for("the end of the run", LIMIT, || {
            (get(page, "/api/v1/runs")["items"][0]["is_ended"] == true).then_some(())
        });
        page.click("button", "Live");
        wait_for_drawn_map(page);
    }

    /// What unfolds on the screens, at the size of a desktop.
    fn show_details(operator: &mut Operator, theme: &str) {
        operator.click("button", "Site");
        operator.click("button", "Inspection points");
        click_first(operator, "Inspection point ");
        save(&mut operator.page, theme, "site-point");
        operator.click("button", "Draft");
        operator.click("button", "Edit as draft");
        operator.click("button", "Inspection points");
        operator.click("button", "Action");
        operator.click("button", "Point cloud");
        operator.click("button", "Draft");
        save(&mut operator.page, theme, "site-draft");
        operator.click("button", "Discard the draft");
        operator.click("button", "Inspection points");
        click_first(operator, "Inspection point ");
        operator.click("button", "Missions");
        if operator.page.find("button", "All missions").is_none() {
            click_first(operator, "Mission ");
        }
        click_first(operator, "Task 1 ");
        save(&mut operator.page, theme, "missions-task");
        operator.click("button", "Schedule");
        click_first(operator, "Open schedule ");
        save(&mut operator.page, theme, "schedule-form");
        operator.click("button", "Runs");
        operator.click("button", "History");
        click_first(operator, "Daily round, ");
        save(&mut operator.page, theme, "runs-history");
        click_first(operator, "Show ");
        save(&mut operator.page, theme, "runs-picture");
        operator.click("button", "With the last one");
        save(&mut operator.page, theme, "runs-compared");
        operator.click("button", "With the last one");
        operator.click("button", "Close the pictures");
        click_first(operator, "History of this point: ");
        save(&mut operator.page, theme, "runs-point");
        operator.click("button", "Compare large");
        for view in ["Side by side", "Wipe", "Blink"] {
            operator.click("button", view);
            save(&mut operator.page, theme, &format!("runs-point-{}", view.to_lowercase().replace(' ', "-")));
        }
        operator.click("button", "Close the comparison");
        operator.click("button", "History");
        if !named(&mut operator.page, "Show spectrum").is_empty() {
            click_first(operator, "Show spectrum");
            save(&mut operator.page, theme, "runs-spectrum");
            operator.click("button", "Close the pictures");
        }
        click_first(operator, "Daily round, ");
        operator.click("button", "Settings");
        operator.click("button", "Choose a time zone");
        save(&mut operator.page, theme, "settings-zone");
        operator.click("button", "Choose a time zone");
    }

    fn click_first(operator: &mut Operator, beginning: &str) {
        let name = wait_for(beginning, LIMIT, || named(&mut operator.page, beginning).into_iter().next());
        operator.click("button", &name);
    }

    fn named(page: &mut Page, beginning: &str) -> Vec<String> {
        let is_meant = |name: &String| name.starts_with(beginning) && !name.ends_with(" in the scene");
        page.all("button").into_iter().map(|(name, _)| name).filter(is_meant).collect()
    }

    /// Saves a picture once menus and drawers have come to rest.
    fn save(page: &mut Page, theme: &str, what: &str) {
        for _ in 0..3 {
            page.wait_for_pictures();
        }
        let [width, height] = page.size();
        page.screenshot().save(&format!("look-{theme}-{width}x{height}-{what}"));
    }

    fn get(page: &mut Page, path: &str) -> Value {
        page.evaluate(&format!("fetch('{path}').then(answer => answer.json())"))
    }
}
