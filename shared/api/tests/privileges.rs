//! The privilege table as people read it, in `docs/guide/security.md`. After a change of the table run this test with `UPDATE_EXPECT=1`.

#![allow(clippy::unwrap_used, reason = "a test may panic at the first error")]

#[allow(dead_code, reason = "other tests use the rest")]
mod samples;

use api::Privilege;
use api::access::{
    Endpoint, account_privilege, command_privilege, event_privilege, message_privilege, object_privilege,
    query_privilege,
};
use site_model::ObjectKind;
use std::collections::BTreeSet;
use std::fmt::{Debug, Write};
use std::fs;
use std::path::Path;

const BEGIN: &str = "<!-- privileges: written by shared/api/tests/privileges.rs -->\n";
const END: &str = "<!-- end of privileges -->\n";

/// Names of a value's variants, such as `Mission(Start`.
fn name(value: &impl Debug) -> String {
    let text = format!("{value:?}");
    let end = |text: &str| text.find(|c: char| !c.is_alphanumeric()).unwrap_or(text.len());
    let outer = &text[..end(&text)];
    match text[outer.len()..].strip_prefix('(') {
        Some(inner) if outer == "Mission" => format!("{outer}: {}", &inner[..end(inner)]),
        _ => outer.to_owned(),
    }
}

fn rows<T: Debug>(title: &str, samples: &[T], privilege: impl Fn(&T) -> Privilege, text: &mut String) {
    let rows: BTreeSet<_> =
        samples.iter().map(|sample| (privilege(sample).to_string(), name(sample))).collect();
    let _ = write!(text, "\n| {title} | least role |\n| --- | --- |\n");
    for (role, name) in rows {
        let _ = writeln!(text, "| `{name}` | {role} |");
    }
}

fn table() -> String {
    let mut text = "| HTTP | least role |\n| --- | --- |\n".to_owned();
    for endpoint in Endpoint::ALL {
        let _ = writeln!(text, "| `{} {}` | {} |", endpoint.method(), endpoint.path(), endpoint.privilege());
    }
    rows("Command", &samples::commands(), command_privilege, &mut text);
    rows("Object that is edited", &ObjectKind::ALL, |kind| object_privilege(*kind), &mut text);
    rows("Message on the control socket", &samples::client_messages(), message_privilege, &mut text);
    rows("Question", &samples::queries(), query_privilege, &mut text);
    rows("Request about accounts", &samples::access::requests(), account_privilege, &mut text);
    rows("Event", &samples::events(), event_privilege, &mut text);
    text
}

#[test]
fn the_guide_prints_the_privilege_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guide/security.md");
    let page = fs::read_to_string(&path).unwrap();
    let begin = page.find(BEGIN).unwrap() + BEGIN.len();
    let end = page.find(END).unwrap();
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&path, format!("{}{}{}", &page[..begin], table(), &page[end..])).unwrap();
        return;
    }
    assert_eq!(page[begin..end], table(), "run this test with UPDATE_EXPECT=1 and commit the page");
}

#[test]
fn no_two_rows_are_for_the_same_method_and_path() {
    let keys: BTreeSet<_> = Endpoint::ALL.iter().map(|it| (it.method(), it.path())).collect();
    assert_eq!(keys.len(), Endpoint::ALL.len());
}

#[test]
fn a_greater_role_may_do_what_a_lesser_one_may() {
    use api::Role;
    let admits = |privilege: Privilege| {
        [None, Some(Role::Viewer), Some(Role::Operator), Some(Role::Admin)].map(|role| privilege.admits(role))
    };
    assert_eq!(admits(Privilege::Anyone), [true, true, true, true]);
    assert_eq!(admits(Privilege::SignedIn(Role::Viewer)), [false, true, true, true]);
    assert_eq!(admits(Privilege::SignedIn(Role::Operator)), [false, false, true, true]);
    assert_eq!(admits(Privilege::SignedIn(Role::Admin)), [false, false, false, true]);
}
