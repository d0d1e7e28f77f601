//! Accounts in a real browser: the first admin by the link of the console, a session that ends, and what a viewer may do.

use crate::support::chromium::Chromium;
use crate::support::page::Page;
use crate::support::server::Server;
use crate::support::wait_for;
use serde_json::Value;
use std::time::Duration;

const LIMIT: Duration = Duration::from_secs(120);
const PASSWORD: &str = "correct horse battery";

#[test]
fn the_first_admin_signs_in_and_a_viewer_may_stop_but_not_drive() {
    let Some(browser) = Chromium::start() else { return };
    let data = tempfile::tempdir().unwrap();
    let server = Server::start_with_accounts("b1", data.path());
    let secret = std::fs::read_to_string(data.path().join("run/first-admin")).unwrap();
    let mut page = browser.open(1440, 900);
    page.go(&format!("{}#first-admin={}", server.url(), secret.trim()));
    page.control("dialog", "Make the first admin");
    page.screenshot().save("first-admin-1440x900");
    fill(&mut page, &[("Account", "ada"), ("Password", PASSWORD), ("Password again", PASSWORD)]);
    assert_eq!(page.evaluate("location.hash"), "", "the secret does not stay in the address");
    page.click("button", "Make the account");
    wait_for("the client of an admin", LIMIT, || page.find("button", "Take control"));
    assert_eq!(
        ask(
            &mut page,
            "POST",
            "first-admin",
            r#"{"link":"x","account":"eve","password":"many rivers to cross"}"#
        ),
        403
    );
    for (account, role) in [("bob", "operator"), ("vic", "viewer")] {
        let body = format!(r#"{{"account":"{account}","role":"{role}","password":"many rivers to cross"}}"#);
        assert_eq!(ask(&mut page, "POST", "accounts", &body), 204);
    }

    // The session ends while the client is open: it asks to sign in again, over what is shown.
    assert_eq!(ask(&mut page, "PATCH", "accounts/ada", r#"{"end_sessions":true}"#), 204);
    wait_for("the request to sign in again", LIMIT, || page.find("dialog", "Sign in"));
    page.screenshot().save("session-ended-1440x900");
    fill(&mut page, &[("Account", "vic"), ("Password", "many rivers to crass")]);
    page.click("button", "Sign in");
    wait_for("the refusal of a wrong password", LIMIT, || page.all("alert").pop());
    fill(&mut page, &[("Password", "many rivers to cross")]);
    page.click("button", "Sign in");
    wait_for("the client of a viewer", LIMIT, || {
        page.find("button", "Take control").filter(|button| button.disabled)
    });
    page.screenshot().save("viewer-1440x900");
    assert_eq!(ask(&mut page, "POST", "runs", "{}"), 403);
    assert_eq!(ask(&mut page, "GET", "accounts", ""), 403);
    page.click("button", "Stop motion");
    wait_for("motion to be stopped", LIMIT, || page.find("button", "Allow motion"));
    server.stop();
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
