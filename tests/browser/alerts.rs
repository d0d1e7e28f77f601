//! An alert that a person raises, in a real browser, on a page on which its form has to be scrolled.

use crate::support::chromium::Chromium;
use crate::support::page::{At, Page};
use crate::support::server::Server;
use crate::support::wait_for;
use serde_json::Value;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(30);

#[test]
fn an_alert_is_raised_and_closed_and_a_wheel_over_its_fields_scrolls_its_form() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    let server = Server::start("b1", data.path());
    let mut page = browser.open(1440, 860);
    page.go(&server.url());
    page.click("button", "Runs");
    page.click("button", "Alerts");
    page.click("button", "Raise an alert");
    wait_for("the alert", LIMIT, || (alert(&mut page)["state"] == "open").then_some(()));

    let owner = middle(&mut page, "textbox", "Owner");
    assert!(owner.y < 860.0, "it is visible");
    page.move_to(owner);
    page.wheel(owner, 2_000.0);
    wait_for("the form to scroll", LIMIT, || {
        (middle(&mut page, "textbox", "Owner").y < owner.y - 50.0).then_some(())
    });

    page.click("textbox", "Closing remark");
    page.type_text("It was nothing.");
    page.control("button", "Close the alert");
    let remark = middle(&mut page, "textbox", "Closing remark");
    page.move_to(remark);
    page.wheel(remark, 2_000.0);
    wait_for("the end of the form", LIMIT, || {
        let close = middle(&mut page, "button", "Close the alert");
        (close.y < 860.0).then_some(())
    });
    page.click("button", "Close the alert");
    wait_for("the end of the alert", LIMIT, || {
        (alert(&mut page)["state"]["closed"]["remark"] == "It was nothing.").then_some(())
    });
    assert_eq!(page.errors(), Vec::<String>::new());
    server.stop();
}

fn middle(page: &mut Page, role: &str, name: &str) -> At {
    let control = page.control(role, name);
    wait_for(name, LIMIT, || page.middle(&control))
}

fn alert(page: &mut Page) -> Value {
    let alerts: Value = page.evaluate("fetch('/api/v1/alerts').then(answer => answer.json())");
    alerts["items"][0]["object"].clone()
}
