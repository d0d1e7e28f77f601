//! Accounts in a real browser: the first admin by the link of the console, a session that ends in the middle of an edit, control that goes from one person to another, and what
//! each role may do.

use super::missions::{copy, get, make_site};
use crate::support::chromium::Chromium;
use crate::support::page::{KeyPress, Page};
use crate::support::server::Server;
use crate::support::{wait_for, workspace_root};
use serde_json::Value;
use std::path::Path;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(120);
const PASSWORD: &str = "correct horse battery";
/// That of the others.
const OTHER_PASSWORD: &str = "many rivers to cross";

#[test]
fn people_sign_in_and_do_what_their_roles_allow() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    copy(&workspace_root().join("tests/fixtures/data-2026-11"), data.path());
    let server = Server::start_with_accounts("b1", data.path());
    let mut ada = browser.open(1440, 900);
    the_first_admin_signs_in(&mut ada, &server, data.path());
    an_admin_sees_people_and_what_they_did(browser.open(1440, 900), &server);
    ada.bring_to_front();
    a_session_ends_in_the_middle_of_an_edit(&mut ada);
    let mut bob = browser.open_apart(412, 915);
    an_operator_signs_in_by_touch(&mut bob, &server);
    control_goes_from_one_to_another(&mut ada, &mut bob);
    let mut errors = bob.errors();
    errors.retain(|error| !error.contains("status of 40"));
    assert_eq!(errors, Vec::<String>::new(), "but for what the server refuses on purpose");
    a_viewer_may_stop_but_not_drive(&mut ada);
    server.stop();
}

fn the_first_admin_signs_in(page: &mut Page, server: &Server, data: &Path) {
    let secret = std::fs::read_to_string(data.join("run/first-admin")).unwrap();
    page.go(&format!("{}#first-admin={}", server.url(), secret.trim()));
    page.control("dialog", "Make the first admin");
    page.screenshot().save("first-admin-1440x900");
    fill(page, &[("Account", "ada"), ("Password", PASSWORD), ("Password again", PASSWORD)]);
    assert_eq!(page.evaluate("location.hash"), "", "the secret does not stay in the address");
    page.click("button", "Make the account");
    wait_for("the client of an admin", LIMIT, || page.find("button", "Take control"));
    let again = r#"{"link":"x","account":"eve","password":"many rivers to cross"}"#;
    assert_eq!(ask(page, "POST", "first-admin", again), 403);
    for (account, role) in [("bob", "operator"), ("vic", "viewer")] {
        let body = format!(r#"{{"account":"{account}","role":"{role}","password":"{OTHER_PASSWORD}"}}"#);
        assert_eq!(ask(page, "POST", "accounts", &body), 204);
    }
    page.click("button", "Live");
    page.control("button", "People and tokens");
}

/// In a second page of the same browser, which has the session already.
fn an_admin_sees_people_and_what_they_did(mut page: Page, server: &Server) {
    page.go(&format!("{}people.html", server.url()));
    wait_for("the accounts", LIMIT, || {
        let text = page.evaluate("document.body?.innerText ?? ''");
        ["ada", "bob", "vic"]
            .iter()
            .all(|name| text.as_str().is_some_and(|text| text.contains(name)))
            .then_some(())
    });
    for (width, height) in [(1440, 900), (412, 915)] {
        page.resize(width, height);
        page.wait_for_pictures();
        page.screenshot().save(&format!("people-{width}x{height}"));
        let overflow = "document.documentElement.scrollWidth > innerWidth";
        assert_eq!(page.evaluate(overflow), false, "nothing is cut off at a width of {width}");
    }
    assert_eq!(page.errors(), Vec::<String>::new());
}

/// The session ends while half a name stands in a field: the client asks to sign in again, over what is shown, and the name can be finished.
fn a_session_ends_in_the_middle_of_an_edit(page: &mut Page) {
    make_site(page);
    page.click("button", "Map");
    page.click("button", "View Hall, first walk");
    page.click("button", "Missions");
    page.click("button", "New mission");
    page.click("button", "Add inspection point Gate valve");
    page.click("textbox", "Mission name");
    page.evaluate("document.activeElement.select()");
    page.type_text("Evening ro");
    assert_eq!(ask(page, "PATCH", "accounts/ada", r#"{"end_sessions":true}"#), 204);
    wait_for("the request to sign in again", LIMIT, || page.find("dialog", "Sign in"));
    page.screenshot().save("session-ended-1440x900");
    // By keys alone: the field that is empty has the focus, and Tab stays in the dialog.
    assert_eq!(page.evaluate("document.activeElement.name"), "password");
    page.type_text(PASSWORD);
    for _ in 0..6 {
        page.key_in_form(KeyPress::TAB);
        let inside = "document.activeElement === document.body || !!document.activeElement.closest('dialog')";
        assert_eq!(page.evaluate(inside), true, "the client below cannot be reached");
    }
    page.evaluate("document.getElementsByName('password')[0].focus()");
    page.key_in_form(KeyPress::ENTER);
    wait_for("the dialog to close", LIMIT, || page.find("dialog", "Sign in").is_none().then_some(()));
    let name = "document.querySelector('input[aria-label=\"Mission name\"]').value";
    assert_eq!(page.evaluate(name), "Evening ro", "what was typed is still there");
    page.click("textbox", "Mission name");
    page.evaluate("document.activeElement.setSelectionRange(99, 99)");
    page.type_text("und");
    page.key_in_form(KeyPress::ENTER);
    wait_for("the mission on the robot", LIMIT, || {
        let missions = get(page, "/api/v1/site/missions")["items"].clone();
        let mission = &missions[0]["object"];
        (mission["name"] == "Evening round" && mission["tasks"].as_array()?.len() == 1).then_some(())
    });
}

/// On a phone. A wrong password first.
fn an_operator_signs_in_by_touch(page: &mut Page, server: &Server) {
    page.allow_touch();
    page.go(&server.url());
    page.control("dialog", "Sign in");
    for (password, shown) in [("many rivers to crass", "the refusal"), (OTHER_PASSWORD, "the client")] {
        for (field, text) in [("Account", "bob"), ("Password", password)] {
            page.tap("textbox", field);
            page.evaluate("document.activeElement.select()");
            page.type_text(text);
        }
        page.screenshot().save("sign-in-412x915");
        page.tap("button", "Sign in");
        wait_for(shown, LIMIT, || match shown {
            "the refusal" => page.all("alert").pop().map(drop),
            _ => page.find("button", "Stop motion").map(drop),
        });
    }
    assert_eq!(ask(page, "GET", "accounts", ""), 403, "operators do not manage people");
    page.resize(1024, 768);
    wait_for("the layout of a tablet", LIMIT, || page.find("button", "Take control"));
    page.wait_for_pictures();
}

/// Both people see who asks for control, who keeps it, and who has it.
fn control_goes_from_one_to_another(ada: &mut Page, bob: &mut Page) {
    bob.tap("button", "Take control");
    wait_for("bob's control", LIMIT, || bob.find("button", "Release control"));
    // An admin need not wait.
    ada.bring_to_front();
    ada.click("button", "Take control");
    wait_for("ada's control", LIMIT, || ada.find("button", "Release control"));
    wait_for("bob to see who has it", LIMIT, || bob.status("Control").filter(|text| text.contains("ada")));
    // Nobody answers for 5 s.
    bob.tap("button", "Take control");
    wait_for("control that was not kept", LIMIT, || bob.find("button", "Release control"));
    wait_for("ada to see who has it", LIMIT, || ada.status("Control").filter(|text| text.contains("bob")));
    ada.click("button", "Take control");
    wait_for("bob to see who has it", LIMIT, || bob.status("Control").filter(|text| text.contains("ada")));
    wait_for("control that ada keeps", LIMIT, || keeps_control(ada, bob).then_some(()));
    assert!(bob.status("Control").is_some_and(|text| text.contains("ada")));
    ada.click("button", "Release control");
}

/// Whether ada is quick enough, when bob asks for control, to keep it; the question stands for 5 s, which is short for a busy machine. If she is not, she takes it back.
fn keeps_control(ada: &mut Page, bob: &mut Page) -> bool {
    bob.tap("button", "Take control");
    let mut has_answered = false;
    wait_for("an answer, or the end of the question", LIMIT, || {
        let place = ada.find("button", "Keep control").and_then(|keep| ada.middle(&keep));
        if let Some(at) = place {
            ada.press(at);
            ada.release(at);
            has_answered = true;
        }
        let is_over = has_answered || ada.find("button", "Take control").is_some();
        (is_over && place.is_none()).then_some(())
    });
    if ada.find("button", "Take control").is_some() {
        ada.click("button", "Take control");
        ada.control("button", "Release control");
        return false;
    }
    has_answered
}

fn a_viewer_may_stop_but_not_drive(page: &mut Page) {
    assert_eq!(ask(page, "PATCH", "accounts/ada", r#"{"end_sessions":true}"#), 204);
    wait_for("the request to sign in again", LIMIT, || page.find("dialog", "Sign in"));
    fill(page, &[("Account", "vic"), ("Password", OTHER_PASSWORD)]);
    page.click("button", "Sign in");
    wait_for("the client of a viewer", LIMIT, || {
        page.find("button", "Take control").filter(|button| button.disabled)
    });
    page.screenshot().save("viewer-1440x900");
    assert_eq!(ask(page, "POST", "runs", "{}"), 403);
    assert_eq!(ask(page, "GET", "accounts", ""), 403);
    page.click("button", "Stop motion");
    wait_for("motion to be stopped", LIMIT, || page.find("button", "Allow motion"));
}

/// Writes into text fields of the page, in place of what they hold.
fn fill(page: &mut Page, fields: &[(&str, &str)]) {
    for (field, text) in fields {
        page.click("textbox", field);
        page.evaluate("document.activeElement.select()");
        page.type_text(text);
    }
}

/// The status of the answer to a request of this page.
fn ask(page: &mut Page, method: &str, path: &str, body: &str) -> u64 {
    let body = if body.is_empty() { "undefined".to_owned() } else { Value::from(body).to_string() };
    let answer = page.evaluate(&format!(
        "fetch('/api/v1/{path}', {{ method: '{method}', headers: {{ 'content-type': 'application/json' }}, body: {body} }}).then(answer => answer.status)"
    ));
    answer.as_u64().unwrap_or_default()
}
