//! Pictures of every screen with the example in it, at the sizes of desktop, tablets and phone and in all themes, for people who look at the design:
//! `artifacts/look-THEME-WIDTHxHEIGHT-SCREEN.png`.
//!
//! They take some minutes, so they are made in the nightly tier. `AUTOINSPECT_LOOK_DATA` names a data directory to look at that is kept; without it the example is made anew.

mod nightly {
    use crate::browser::mapping::wait_for_drawn_map;
    use crate::support::chromium::Chromium;
    use crate::support::operator::Operator;
    use crate::support::page::{Key, Page};
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
        for theme in THEMES {
            operator.page.resize(1440, 900);
            operator.click("button", "Live");
            operator.click("button", "Theme");
            operator.click("button", &format!("{theme} theme"));
            operator.press(Key::ESCAPE);
            for [width, height] in SIZES {
                operator.page.resize(width, height);
                for screen in SCREENS {
                    operator.click("button", screen);
                    let open = operator.page.find("button", "Open panel");
                    if width < 1100 && width >= 700 && open.is_some() {
                        operator.click("button", "Open panel");
                    }
                    settle(&mut operator.page);
                    let name =
                        format!("look-{}-{width}x{height}-{}", theme.to_lowercase(), screen.to_lowercase());
                    operator.page.screenshot().save(&name);
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

    /// Waits until menus and drawers have come to rest.
    fn settle(page: &mut Page) {
        for _ in 0..6 {
            page.wait_for_pictures();
        }
    }

    fn get(page: &mut Page, path: &str) -> Value {
        page.evaluate(&format!("fetch('{path}').then(answer => answer.json())"))
    }
}
