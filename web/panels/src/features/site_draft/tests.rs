//! The draft by its panel.

use crate::screens;
use crate::test_support::{OTHER, TestClient, click, map, value};
use api::{Event, SiteChanged, SiteParts, SiteState};
use client_model::{ClientCommand, DraftCommand};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use site_model::{EditId, NodeId, Object, Site};
use std::sync::Arc;
use vocab::Vec3;

/// A client on the Site screen whose robot has a node `N1`, and that node.
fn with_node() -> (TestClient, NodeId, Site) {
    let hall = map(9, "Hall");
    let id = hall.id;
    // The node comes from a client of its own, so that it is the robot's.
    let empty = SiteParts::new(Arc::new(SiteState::default())).next_part();
    let maker = TestClient::connected().event(Event::SitePart(empty));
    let (node, edit) = maker.model.site.adding_node(Vec3::new(1.0, 2.0, 0.5), id, None);
    let mut site = Site::default();
    for object in edit.put {
        let edit = site.put(EditId(uuid::Uuid::from_u128(1)), object);
        site.apply(&edit, edit.id).expect("of this site");
    }
    let part = SiteParts::new(Arc::new(SiteState { revision: 2, site: site.clone() })).next_part();
    let client = TestClient::connected()
        .event(Event::Maps(vec![hall]))
        .event(Event::SitePart(part))
        .command(ClientCommand::ViewMap(Some(id)))
        .on(screens::SITE);
    (client, node, site)
}

fn carry_out(harness: &mut Harness<'_, TestClient>) {
    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        let event = client_model::ClientEvent::Command(command);
        client.model.handle_event(client_model::ClientTime(1.0), event, &mut Vec::new());
    }
    harness.run_steps(2);
}

fn rename(client: TestClient, node: NodeId, name: &str) -> TestClient {
    let edit = client.model.site.changing_node(node, |node| node.name = name.to_owned());
    client.command(ClientCommand::EditSite(edit))
}

#[test]
fn a_draft_is_begun_lists_what_it_changes_and_is_published() {
    let (client, node, _) = with_node();
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Draft");
    click(&mut harness, "Edit as draft");
    carry_out(&mut harness);
    assert_eq!(value(&harness, "Changes"), "0");
    let edit = harness.state().model.site.changing_node(node, |node| node.name = "Pump".to_owned());
    harness.state_mut().commands.push(ClientCommand::EditSite(edit));
    carry_out(&mut harness);
    assert_eq!(value(&harness, "Changes"), "1");
    harness.get_by_label("Node Pump: changed");
    harness.get_by_label_contains("name: N1 → Pump");
    click(&mut harness, "Publish");
    assert!(harness.state().emitted(&ClientCommand::Draft(DraftCommand::Publish)));
    carry_out(&mut harness);
    assert!(harness.query_by_label("Edit as draft").is_some());
    assert_eq!(harness.state().model.site.unconfirmed(), 1);
}

#[test]
fn other_screens_say_that_a_draft_is_edited_and_lead_to_it() {
    let (client, node, _) = with_node();
    let client = rename(client.command(ClientCommand::Draft(DraftCommand::Begin)), node, "Pump");
    let mut harness = client.on(screens::MISSIONS).shown(1440.0, 900.0);
    let is_said = |text: Option<String>| text.is_some_and(|text| text.starts_with("Draft: 1 change"));
    assert!(harness.query_all_by(|node| is_said(node.value())).next().is_some());
    click(&mut harness, "Show the draft");
    carry_out(&mut harness);
    assert_eq!(value(&harness, "Changes"), "1");
    click(&mut harness, "Discard the draft");
    carry_out(&mut harness);
    assert!(!harness.state().model.site.is_draft());
}

#[test]
fn a_conflict_shows_both_and_is_decided_before_publishing() {
    let (client, node, mut site) = with_node();
    let client = rename(client.command(ClientCommand::Draft(DraftCommand::Begin)), node, "Mine");
    let mut theirs = site.node(node).expect("a node").clone();
    theirs.name = "Theirs".to_owned();
    let edit = site.put(EditId(uuid::Uuid::from_u128(7)), Object::Node(theirs));
    site.apply(&edit, edit.id).expect("of this site");
    let client = client.event(Event::SiteChanged(SiteChanged { revision: 3, by: Some(OTHER), edit }));
    let mut harness = client.shown(1440.0, 1200.0);
    click(&mut harness, "Draft");
    harness.get_by_label_contains("1 object was changed by somebody else too");
    harness.get_by_label_contains("name: N1 → Theirs");
    click(&mut harness, "Publish");
    assert!(!harness.state().emitted(&ClientCommand::Draft(DraftCommand::Publish)));
    click(&mut harness, "Keep mine: Node Mine");
    carry_out(&mut harness);
    click(&mut harness, "Publish");
    assert!(harness.state().emitted(&ClientCommand::Draft(DraftCommand::Publish)));
}
