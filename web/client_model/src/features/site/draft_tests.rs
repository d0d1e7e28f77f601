//! Drafts: edits gather, are compared, published as one, and conflicts are decided by the operator.

use super::tests::{Robot, asset, id};
use super::{DraftCommand, field_changes};
use crate::testing::TestClient;
use crate::{ClientCommand, ClientEffect, SiteEdit, StoredDraft};
use api::{EditDone, EditOutcome, EditRefusal, Event};
use site_model::{Change, EdgeId, NodeId, Object, Site};
use vocab::{MapId, Vec3};

fn draft(client: &mut TestClient, command: DraftCommand) {
    client.command(ClientCommand::Draft(command));
}

/// A robot with assets 1 `a` and 2 `b`, and a client that has begun a draft.
fn begun() -> (Robot, TestClient) {
    let mut robot = Robot::default();
    robot.put(1, asset(1, "a"));
    robot.put(2, asset(2, "b"));
    let mut client = TestClient::with_site(&robot);
    draft(&mut client, DraftCommand::Begin);
    (robot, client)
}

/// What the draft has of an asset beside what the site has, by name, and whether that is a conflict.
fn entries(client: &TestClient) -> Vec<(Option<String>, Option<String>, bool)> {
    let name = |object: Option<&Object>| object.and_then(|object| object.name().map(str::to_owned));
    client.model.site.draft_entries().map(|it| (name(it.theirs), name(it.mine), it.is_conflict)).collect()
}

fn stored(client: &mut TestClient) -> Option<StoredDraft> {
    let saved = |effect| match effect {
        ClientEffect::SaveDraft(draft) => Some(draft),
        _ => None,
    };
    client.take_effects().into_iter().filter_map(saved).next_back()
}

#[test]
fn edits_gather_until_they_are_published_as_one_step_of_undo() {
    let (mut robot, mut client) = begun();
    client.put(1, "a2");
    client.put(3, "new");
    client.command(ClientCommand::EditSite(SiteEdit { put: Vec::new(), removed: vec![id(2)] }));
    assert!(client.take_edits().is_empty(), "nothing is sent");
    assert_eq!((client.name(1), client.name(2), client.name(3)), (Some("a2"), None, Some("new")));
    let text = |text: &str| Some(text.to_owned());
    let wanted = [(text("a"), text("a2"), false), (text("b"), None, false), (None, text("new"), false)];
    assert_eq!(entries(&client), wanted);

    draft(&mut client, DraftCommand::Publish);
    let edits = client.take_edits();
    assert_eq!((edits.len(), edits[0].changes.len()), (1, 3));
    assert!(!client.model.site.is_draft() && entries(&client).is_empty());
    let (changed, done) = robot.apply(&edits[0], crate::testing::ME);
    changed.into_iter().chain([done]).for_each(|event| client.event(event));
    assert_eq!(stored(&mut client), Some(StoredDraft::default()));
    assert_eq!((client.name(1), client.name(2)), (Some("a2"), None));
    client.command(ClientCommand::Undo);
    client.settle(&mut robot);
    assert_eq!((client.name(1), client.name(2), client.name(3)), (Some("a"), Some("b"), None));
    assert_eq!(robot.state.site.objects().len(), 2);
}

#[test]
fn each_edit_of_a_draft_and_its_end_are_undone_and_redone() {
    let (_, mut client) = begun();
    client.put(1, "a2");
    client.put(1, "a3");
    client.command(ClientCommand::Undo);
    assert_eq!(client.name(1), Some("a2"));
    client.command(ClientCommand::Redo);
    assert_eq!(client.name(1), Some("a3"));
    draft(&mut client, DraftCommand::Discard);
    assert_eq!((client.name(1), client.model.site.is_draft()), (Some("a"), false));
    client.command(ClientCommand::Undo);
    assert_eq!((client.name(1), client.model.site.is_draft()), (Some("a3"), true));
    // Back to what it was: the draft has no changes left.
    client.put(1, "a");
    assert!(entries(&client).is_empty());
}

#[test]
fn a_draft_goes_on_after_a_reload_and_over_the_edits_of_others() {
    let (mut robot, mut client) = begun();
    client.put(1, "mine");
    let kept = stored(&mut client).expect("stored");
    let text = serde_json::to_string(&kept).expect("JSON");
    let changed = robot.put(9, asset(2, "theirs"));

    let mut again = TestClient::connected();
    again.model.restore_draft(serde_json::from_str(&text).expect("the same"));
    again.load(&robot);
    assert_eq!((again.name(1), again.name(2)), (Some("mine"), Some("theirs")));
    assert!(again.model.site.is_draft());
    client.event(changed);
    assert_eq!((client.name(1), client.name(2)), (Some("mine"), Some("theirs")));
}

#[test]
fn of_an_object_that_both_have_changed_the_operator_chooses_one() {
    for keep_mine in [true, false] {
        let (mut robot, mut client) = begun();
        client.put(1, "mine");
        let changed = robot.put(9, asset(1, "theirs"));
        client.event(changed);
        assert_eq!(entries(&client), [(Some("theirs".to_owned()), Some("mine".to_owned()), true)]);
        draft(&mut client, DraftCommand::Publish);
        assert!(client.take_edits().is_empty() && client.notices().contains("Somebody else"));
        draft(&mut client, DraftCommand::Resolve { object: id(1), keep_mine });
        assert_eq!(client.name(1), Some(if keep_mine { "mine" } else { "theirs" }));
        client.command(ClientCommand::Undo);
        assert!(entries(&client)[0].2, "undone, it is a conflict again");
        client.command(ClientCommand::Redo);
        draft(&mut client, DraftCommand::Publish);
        client.settle(&mut robot);
        let name = robot.state.site.get(id(1)).and_then(|it| it.object.name().map(str::to_owned));
        assert_eq!(name.as_deref(), Some(if keep_mine { "mine" } else { "theirs" }));
    }
}

#[test]
fn a_draft_that_the_robot_refuses_is_there_again() {
    let (_, mut client) = begun();
    client.put(1, "mine");
    draft(&mut client, DraftCommand::Publish);
    let edit = client.take_edits().remove(0);
    let outcome = EditOutcome::Refused(EditRefusal::Rejected("The disk is full.".to_owned()));
    client.event(Event::EditDone(EditDone { id: edit.id, outcome }));
    assert!(client.model.site.is_draft() && client.name(1) == Some("mine"));
    assert_eq!(entries(&client).len(), 1);
    draft(&mut client, DraftCommand::Publish);
    assert!(matches!(client.take_edits()[0].changes[0], Change::Put { .. }));
}

#[test]
fn fields_that_differ_are_named_with_values_that_people_read() {
    let robot = Robot::default();
    let client = TestClient::with_site(&robot);
    let (node, edit) =
        client.model.site.adding_node(Vec3::new(1.0, 2.0, 0.5), MapId(uuid::Uuid::from_u128(3)), None);
    let before = edit.put.last().expect("the node").clone();
    let Object::Node(mut moved) = before.clone() else { panic!("a node") };
    moved.map_from_node.position.x = 1.25;
    moved.map_from_node.orientation = vocab::Quat { x: 0.0, y: 0.0, z: 0.5_f64.sqrt(), w: 0.5_f64.sqrt() };
    moved.tolerance.along_m = 0.2;
    let changes = field_changes(&before, &Object::Node(moved), &|_| None);
    let shown: Vec<String> =
        changes.iter().map(|it| format!("{}: {} → {}", it.field, it.before, it.after)).collect();
    let wanted =
        ["orientation: 0° → 90°", "position: 1, 2, 0.5 → 1.25, 2, 0.5", "tolerance along (m): 0.1 → 0.2"];
    assert_eq!(shown, wanted);

    let other = NodeId(uuid::Uuid::from_u128(9));
    let edge = site_model::Edge::walk(EdgeId(uuid::Uuid::from_u128(5)), node, other);
    let to_itself = Object::Edge(site_model::Edge { to: node, ..edge.clone() });
    let name = |uuid| (uuid == node.0).then(|| "N1".to_owned());
    let changes = field_changes(&Object::Edge(edge), &to_itself, &name);
    assert_eq!((changes.len(), changes[0].field.as_str(), changes[0].after.as_str()), (1, "to", "N1"));
    assert_eq!(Site::default().objects().len(), 0);
}

#[test]
fn an_edit_in_the_middle_outlives_a_session_that_ends() {
    let (mut robot, mut client) = begun();
    client.put(1, "half");
    client.lose_connection();
    // The page asks to sign in again meanwhile, over the client. Work goes on below it, and nothing is sent.
    client.put(1, "half typed");
    client.wait(600.0);
    assert!(client.take_edits().is_empty());
    // The same person in a new session: another client for the robot.
    client.apply(crate::ClientEvent::SocketOpened(crate::Socket::Control));
    client.welcome_as(crate::testing::OTHER);
    client.load(&robot);
    assert!(client.model.site.is_draft());
    assert_eq!(client.name(1), Some("half typed"));
    draft(&mut client, DraftCommand::Publish);
    client.settle(&mut robot);
    assert_eq!(client.name(1), Some("half typed"));
    assert_eq!(client.model.site.site(), Some(&robot.state.site));
}
