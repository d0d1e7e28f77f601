//! Who has signed in, and what the role may do.

use crate::test_support::{ME, TestClient, click, value};
use api::{ClientIdentity, Role};
use client_model::{AccountAction, ClientCommand};
use egui_kittest::kittest::Queryable;

fn signed_in(role: Role) -> TestClient {
    let you = ClientIdentity { client: ME, account: Some("ada".into()), role, is_demo: false };
    TestClient::connected_as(you)
}

#[test]
fn an_admin_manages_people_and_signs_out() {
    let mut harness = signed_in(Role::Admin).shown(1440.0, 1600.0);
    assert_eq!((value(&harness, "Signed in as"), value(&harness, "Role")), ("ada".into(), "admin".into()));
    for (button, action) in [
        ("People and tokens", AccountAction::ManagePeople),
        ("Change password", AccountAction::ChangePassword),
        ("Sign out", AccountAction::SignOut),
    ] {
        click(&mut harness, button);
        assert!(harness.state().emitted(&ClientCommand::Account(action)), "{button}");
    }
}

#[test]
fn a_viewer_is_told_what_the_role_may_do_and_cannot_take_control() {
    let mut harness = signed_in(Role::Viewer).shown(1440.0, 1600.0);
    assert!(harness.query_by_label("People and tokens").is_none());
    let says_so =
        harness.query_all_by(|node| node.value().is_some_and(|text| text.contains("as viewer"))).count();
    assert!(says_so > 0);
    click(&mut harness, "Take control");
    assert!(!harness.state().emitted(&ClientCommand::TakeControl));
    let harness = signed_in(Role::Operator).shown(1440.0, 1600.0);
    let says_so =
        harness.query_all_by(|node| node.value().is_some_and(|text| text.contains("as viewer"))).count();
    assert_eq!(says_so, 0);
}

#[test]
fn a_demonstration_says_that_nobody_signs_in() {
    let harness = TestClient::connected().shown(1440.0, 1600.0);
    assert!(harness.query_by_label("Sign out").is_none());
    let says_so = harness.query_all_by(|node| {
        [node.value(), node.label()].into_iter().flatten().any(|text| text.contains("demonstration"))
    });
    assert!(says_so.count() > 0);
}

#[test]
fn the_top_bar_says_at_once_that_this_is_a_demonstration() {
    let shows = |client: TestClient, width: f32| {
        let harness = client.shown(width, 900.0);
        harness.query_all_by(|node| node.value().is_some_and(|text| text == "Demonstration")).count()
    };
    assert_eq!(shows(TestClient::connected(), 1440.0), 1);
    assert_eq!(shows(TestClient::connected(), 820.0), 1);
    assert_eq!(shows(signed_in(Role::Admin), 1440.0), 0);
}
