use crate::testing::{OTHER, TestClient};
use crate::{ClientCommand, ClientEffect, Selection, SiteEdit};
use api::{
    ClientMessage, EditDone, EditOutcome, EditRefusal, Event, SiteChanged, SitePart, SiteState,
    TopomapGeneration, TopomapStage, TopomapSummary,
};
use site_model::{Asset, AssetId, Change, Edit, EditError, Object, ObjectId};
use std::collections::BTreeMap;
use std::sync::Arc;
use uuid::Uuid;

pub(super) fn id(number: u128) -> ObjectId {
    ObjectId::Asset(AssetId(Uuid::from_u128(number)))
}

pub(super) fn asset(number: u128, name: &str) -> Object {
    Object::Asset(Asset {
        id: AssetId(Uuid::from_u128(number)),
        name: name.to_owned(),
        tags: Default::default(),
    })
}

/// What the robot does with edits.
#[derive(Default)]
pub(super) struct Robot {
    pub(super) state: SiteState,
    applied: BTreeMap<site_model::EditId, u64>,
}

impl Robot {
    /// Applies an edit; returns the events for all and for its client.
    pub(super) fn apply(&mut self, edit: &Edit, by: vocab::ClientId) -> (Option<Event>, Event) {
        let done = |outcome| Event::EditDone(EditDone { id: edit.id, outcome });
        if let Some(revision) = self.applied.get(&edit.id) {
            return (None, done(EditOutcome::Applied { revision: *revision, changes: Vec::new() }));
        }
        match self.state.site.apply(edit, edit.id) {
            Err(error) => (None, done(EditOutcome::Refused(EditRefusal::Invalid(vec![error])))),
            Ok(applied) => {
                self.state.revision += 1;
                let revision = self.state.revision;
                self.applied.insert(edit.id, revision);
                let changed = SiteChanged { revision, by: Some(by), edit: edit.clone() };
                let outcome = EditOutcome::Applied { revision, changes: applied.revisions };
                (Some(Event::SiteChanged(changed)), done(outcome))
            }
        }
    }

    /// Somebody else's edit.
    pub(super) fn put(&mut self, number: u128, object: Object) -> Event {
        let edit = self.state.site.put(site_model::EditId(Uuid::from_u128(number)), object);
        self.apply(&edit, OTHER).0.expect("of this state")
    }

    fn parts(&self) -> Vec<SitePart> {
        let mut parts = api::SiteParts::new(Arc::new(self.state.clone()));
        let mut all = vec![parts.next_part()];
        while !all[all.len() - 1].is_last {
            all.push(parts.next_part());
        }
        all
    }
}

impl TestClient {
    pub(super) fn with_site(robot: &Robot) -> Self {
        let mut client = Self::connected();
        client.load(robot);
        client
    }

    pub(super) fn load(&mut self, robot: &Robot) {
        robot.parts().into_iter().for_each(|part| self.event(Event::SitePart(part)));
    }

    pub(super) fn put(&mut self, number: u128, name: &str) {
        self.command(ClientCommand::EditSite(SiteEdit {
            put: vec![asset(number, name)],
            removed: Vec::new(),
        }));
    }

    pub(super) fn take_edits(&mut self) -> Vec<Edit> {
        let edit = |effect| match effect {
            ClientEffect::Send(ClientMessage::Edit(edit)) => Some(edit),
            _ => None,
        };
        self.take_effects().into_iter().filter_map(edit).collect()
    }

    pub(super) fn name(&self, number: u128) -> Option<&str> {
        self.model.site.site()?.get(id(number))?.object.name()
    }

    /// The robot gets what was sent and answers, until nothing is sent any more.
    pub(super) fn settle(&mut self, robot: &mut Robot) {
        loop {
            let edits = self.take_edits();
            if edits.is_empty() {
                return;
            }
            for edit in edits {
                let (changed, done) = robot.apply(&edit, crate::testing::ME);
                changed.into_iter().chain([done]).for_each(|event| self.event(event));
            }
        }
    }

    pub(super) fn notices(&self) -> String {
        let texts: Vec<_> = self.model.notices().visible().iter().map(|shown| shown.text.clone()).collect();
        texts.join(" ")
    }
}

#[test]
fn own_edits_show_at_once_and_are_confirmed_undone_and_redone() {
    let mut robot = Robot::default();
    let mut client = TestClient::with_site(&robot);
    client.put(1, "a");
    assert_eq!(client.name(1), Some("a"));
    assert_eq!(client.model.site.unconfirmed(), 1);
    // The second of the same object waits for the first; one of another object does not.
    client.put(1, "b");
    client.put(2, "x");
    let edits = client.take_edits();
    assert_eq!(edits.len(), 2, "{edits:?}");
    for edit in edits {
        let (changed, done) = robot.apply(&edit, crate::testing::ME);
        // The answer may overtake the change.
        client.event(done);
        client.event(changed.expect("applied"));
    }
    client.settle(&mut robot);
    assert_eq!((client.name(1), client.model.site.unconfirmed()), (Some("b"), 0));
    assert_eq!(client.model.site.confirmed(), Some(&robot.state));

    client.command(ClientCommand::Undo);
    assert_eq!((client.name(1), client.name(2)), (Some("b"), None));
    client.command(ClientCommand::Undo);
    assert_eq!(client.name(1), Some("a"));
    client.settle(&mut robot);
    client.command(ClientCommand::Undo);
    assert_eq!(client.name(1), None);
    client.command(ClientCommand::Redo);
    client.command(ClientCommand::Redo);
    client.command(ClientCommand::Redo);
    client.settle(&mut robot);
    assert_eq!((client.name(1), client.name(2)), (Some("b"), Some("x")));
    assert_eq!(client.model.site.site(), Some(&robot.state.site));
    assert!(!client.model.site.can_redo());
}

#[test]
fn edits_of_others_are_merged_and_the_later_one_of_the_same_object_is_taken_back() {
    let mut robot = Robot::default();
    robot.put(100, asset(1, "first"));
    let mut client = TestClient::with_site(&robot);
    client.put(1, "mine");
    client.put(1, "mine again");
    client.put(2, "mine too");
    // Somebody else was faster.
    let theirs = robot.put(101, asset(1, "theirs"));
    let other = robot.put(102, asset(3, "another"));
    client.event(theirs);
    assert_eq!(client.name(1), Some("theirs"), "no one's change is hidden");
    client.event(other);
    client.settle(&mut robot);
    assert_eq!(
        (client.name(1), client.name(2), client.name(3)),
        (Some("theirs"), Some("mine too"), Some("another"))
    );
    assert_eq!(client.model.site.site(), Some(&robot.state.site));
    assert_eq!(client.model.site.unconfirmed(), 0);
    assert!(client.notices().contains("taken back"), "{}", client.notices());
    // What was taken back cannot be undone, and undoing leaves theirs alone.
    client.command(ClientCommand::Undo);
    client.command(ClientCommand::Undo);
    client.settle(&mut robot);
    assert_eq!((client.name(1), client.name(2)), (Some("theirs"), None));
    assert_eq!(client.model.site.site(), Some(&robot.state.site));
}

/// The revisions that a refused edit would have made belong to others: what refers to them must not be applied to theirs.
#[test]
fn nothing_that_was_built_on_a_refused_edit_overwrites_others() {
    let mut robot = Robot::default();
    let mut client = TestClient::with_site(&robot);
    // Once the second is undone, undoing the first refers to the revision that the undo makes.
    for name in ["first", "mine"] {
        client.put(1, name);
        client.settle(&mut robot);
    }
    // The undo is on its way when somebody else changes the object.
    client.command(ClientCommand::Undo);
    client.put(1, "after the undo");
    let theirs = robot.put(101, asset(1, "theirs"));
    client.event(theirs);
    client.settle(&mut robot);
    assert_eq!(client.name(1), Some("theirs"));
    // An edit that was made on top of theirs stands on its own.
    client.put(1, "mine on theirs");
    client.settle(&mut robot);
    assert_eq!(client.name(1), Some("mine on theirs"));
    for _ in 0..3 {
        client.command(ClientCommand::Undo);
        client.settle(&mut robot);
    }
    assert_eq!((client.name(1), robot.state.site.objects().len()), (Some("theirs"), 1));
    assert_eq!(client.model.site.site(), Some(&robot.state.site));
}

#[test]
fn an_edit_on_top_of_theirs_survives_the_refusal_of_an_earlier_one() {
    let mut robot = Robot::default();
    robot.put(100, asset(1, "first"));
    let mut client = TestClient::with_site(&robot);
    client.put(1, "mine");
    let theirs = robot.put(101, asset(1, "theirs"));
    client.event(theirs);
    client.put(1, "mine on theirs");
    assert_eq!(client.name(1), Some("mine on theirs"));
    client.settle(&mut robot);
    assert_eq!(client.name(1), Some("mine on theirs"));
    assert_eq!(client.model.site.site(), Some(&robot.state.site));
}

#[test]
fn edits_survive_a_lost_connection_whether_or_not_they_had_arrived() {
    let mut robot = Robot::default();
    robot.put(100, asset(1, "first"));
    let mut client = TestClient::with_site(&robot);
    client.put(1, "arrived");
    client.put(2, "lost");
    let edits = client.take_edits();
    robot.apply(&edits[0], crate::testing::ME);
    client.lose_connection();
    client.put(3, "made meanwhile");
    client.put(1, "built on it");
    assert!(client.take_edits().is_empty(), "not connected");
    assert_eq!(client.name(1), Some("built on it"));
    client.connect();
    client.load(&robot);
    client.settle(&mut robot);
    let names = [1, 2, 3].map(|number| client.name(number).map(str::to_owned));
    assert_eq!(names, ["built on it", "lost", "made meanwhile"].map(|name| Some(name.to_owned())));
    assert_eq!(client.model.site.site(), Some(&robot.state.site));
    assert_eq!(client.model.site.unconfirmed(), 0);
}

#[test]
fn an_edit_that_could_not_be_written_is_sent_again() {
    let mut robot = Robot::default();
    let mut client = TestClient::with_site(&robot);
    client.put(1, "a");
    let edit = client.take_edits().remove(0);
    let outcome = EditOutcome::Refused(EditRefusal::Unavailable("The disk is full.".to_owned()));
    client.event(Event::EditDone(EditDone { id: edit.id, outcome }));
    assert_eq!(client.take_edits(), []);
    client.wait(2.0);
    client.settle(&mut robot);
    assert_eq!(client.model.site.site(), Some(&robot.state.site));
    let outcome = EditOutcome::Refused(EditRefusal::Rejected("It is too large.".to_owned()));
    client.put(2, "large");
    let edit = client.take_edits().remove(0);
    client.event(Event::EditDone(EditDone { id: edit.id, outcome }));
    assert_eq!((client.name(2), client.model.site.unconfirmed()), (None, 0));
    assert!(client.notices().contains("It is too large."));
}

#[test]
fn a_missing_change_is_noticed_and_the_whole_site_asked_for_once() {
    let mut robot = Robot::default();
    let mut client = TestClient::with_site(&robot);
    let requests = |client: &mut TestClient| {
        let effects = client.take_effects();
        effects.iter().filter(|effect| **effect == ClientEffect::Send(ClientMessage::RequestSite)).count()
    };
    robot.put(100, asset(1, "missed"));
    for number in 2..5 {
        let event = robot.put(100 + number, asset(number, "later"));
        client.event(event);
    }
    assert_eq!(requests(&mut client), 1);
    client.load(&robot);
    assert_eq!(client.model.site.site(), Some(&robot.state.site));
    let event = robot.put(200, asset(9, "next"));
    client.event(event);
    assert_eq!((requests(&mut client), client.name(9)), (0, Some("next")));
}

#[test]
fn nothing_is_edited_before_the_site_has_come_and_new_ids_are_new() {
    let mut client = TestClient::connected();
    client.put(1, "a");
    assert!(client.model.site.site().is_none() && client.take_edits().is_empty());
    assert!(client.notices().contains("has not sent"));
    let robot = Robot::default();
    client.load(&robot);
    let ids: Vec<_> = (0..1_000).map(|number| client.model.site.new_id(number)).collect();
    client.put(1, "a");
    let all = ids.iter().copied().chain((0..1_000).map(|number| client.model.site.new_id(number)));
    assert_eq!(all.collect::<std::collections::BTreeSet<_>>().len(), 2_000);
    let missing = EditError::Conflict { object: id(1), revision: None };
    assert!(missing.to_string().contains("somebody else"));
}

#[test]
fn a_topological_map_that_the_robot_made_for_this_operator_is_one_step_of_undo() {
    let mut robot = Robot::default();
    let mut client = TestClient::with_site(&robot);
    let map = vocab::MapId(Uuid::from_u128(3));
    client.command(ClientCommand::GenerateTopomap(map));
    let asked = client.take_commands();
    let [api::Command::GenerateTopomap { map: of, edit: id }] = asked[..] else { panic!("{asked:?}") };
    assert_eq!(of, map);
    let running = TopomapGeneration::Running { map, stage: TopomapStage::Reading };
    client.event(Event::TopomapGeneration(running.clone()));
    assert_eq!(*client.model.site.topomap_generation(), running);

    let changes = [(1, "A"), (2, "B")].map(|(n, name)| Change::Put { base: None, object: asset(n, name) });
    let edit = Edit { id, changes: changes.into() };
    let (changed, _) = robot.apply(&edit, crate::testing::ME);
    client.event(changed.expect("applied"));
    let done = TopomapGeneration::Done { map, edit: id, summary: TopomapSummary::default() };
    client.event(Event::TopomapGeneration(done.clone()));
    assert_eq!(*client.model.site.topomap_generation(), done);
    client.command(ClientCommand::DismissTopomapResult);
    assert_eq!(*client.model.site.topomap_generation(), TopomapGeneration::None);

    client.command(ClientCommand::Undo);
    assert_eq!((client.name(1), client.name(2)), (None, None));
    client.settle(&mut robot);
    assert_eq!(robot.state.site.objects().len(), 0);
    client.command(ClientCommand::Redo);
    assert_eq!(client.name(2), Some("B"));
}

#[test]
fn a_result_from_before_is_not_shown_and_nothing_of_others_is_undone() {
    let mut robot = Robot::default();
    let mut client = TestClient::with_site(&robot);
    let done = TopomapGeneration::Done {
        map: vocab::MapId(Uuid::from_u128(3)),
        edit: site_model::EditId(Uuid::from_u128(4)),
        summary: TopomapSummary::default(),
    };
    client.event(Event::TopomapGeneration(done));
    assert_eq!(*client.model.site.topomap_generation(), TopomapGeneration::None);
    let changed = robot.put(4, asset(1, "Theirs"));
    client.event(changed);
    assert!(!client.model.site.can_undo());
}

#[test]
fn an_edit_of_the_platform_itself_can_be_undone_by_every_operator() {
    let mut robot = Robot::default();
    let mut client = TestClient::with_site(&robot);
    let changes = vec![Change::Put { base: None, object: asset(1, "Moved with the map") }];
    let edit = Edit { id: site_model::EditId(Uuid::from_u128(40)), changes };
    let (changed, _) = robot.apply(&edit, vocab::ClientId(Uuid::nil()));
    client.event(changed.expect("applied"));
    assert_eq!(client.name(1), Some("Moved with the map"));
    client.command(ClientCommand::Undo);
    client.settle(&mut robot);
    assert_eq!(robot.state.site.objects().len(), 0);
}

#[test]
fn an_inspection_point_is_looked_at_from_the_best_node_and_its_target_is_moved() {
    let robot = Robot::default();
    let mut client = TestClient::with_site(&robot);
    let map = vocab::MapId(Uuid::from_u128(3));
    let target = vocab::Vec3::new(3.0, 0.0, 1.0);
    // Far, too near, on a dock, and in a good distance.
    let nodes = [0.0, 2.9, 1.0, 1.5].map(|x| {
        let at = vocab::Vec3::new(x, 0.0, 0.6);
        let (node, edit) = client.model.site.adding_node(at, map, None);
        client.command(ClientCommand::EditSite(edit));
        node
    });
    let dock = |node: &mut site_model::Node| node.kind = site_model::NodeKind::Dock;
    client.command(ClientCommand::EditSite(client.model.site.changing_node(nodes[2], dock)));
    assert_eq!(client.model.site.viewpoints(target), [nodes[3], nodes[0], nodes[1]]);

    let (point, edit) = client.model.site.adding_inspection_point(nodes[3], target);
    client.command(ClientCommand::EditSite(edit));
    let moved = vocab::Vec3::new(3.0, 0.0, 1.8);
    assert!(client.model.site.retargeting(Some(Selection::Node(nodes[0])), moved).is_none());
    let edit = client.model.site.retargeting(Some(Selection::InspectionPoint(point)), moved);
    client.command(ClientCommand::EditSite(edit.expect("of a point")));
    let shown = |client: &TestClient| {
        let points = client.model.site.inspection_points();
        points.iter().map(|point| (point.name.clone(), point.node, point.target_m)).collect::<Vec<_>>()
    };
    assert_eq!(shown(&client), [("P1".to_owned(), nodes[3], moved)]);
    client.command(ClientCommand::Undo);
    assert_eq!(shown(&client), [("P1".to_owned(), nodes[3], target)]);
    client.command(ClientCommand::Undo);
    assert!(shown(&client).is_empty());
}

#[test]
fn changes_of_one_map_are_asked_to_be_normal_in_a_version_of_it() {
    let mut robot = Robot::default();
    let maps = [3, 4].map(|number| vocab::MapId(Uuid::from_u128(number)));
    for (number, map) in [(1, maps[0]), (2, maps[0]), (3, maps[1])] {
        let change = site_model::SceneChange {
            id: site_model::SceneChangeId(Uuid::from_u128(number)),
            map,
            kind: site_model::SceneChangeKind::Removed,
            place: site_model::OrientedBox {
                centre_m: vocab::Vec3::default(),
                size_m: [1.0; 3],
                yaw_rad: 0.0,
            },
            points: 100,
            confidence: 0.9,
            before: site_model::EarlierVisit::Map(map),
            after: site_model::RunId(Uuid::from_u128(9)),
            first_seen: site_model::Utc(0),
            last_seen: site_model::Utc(0),
            times_seen: 1,
            review: site_model::ReviewState::New,
            comment: String::new(),
            clouds: None,
            physical_object: None,
            descriptor: None,
        };
        let put = Change::Put { base: None, object: Object::SceneChange(change) };
        robot.apply(
            &Edit { id: site_model::EditId(Uuid::from_u128(50 + number)), changes: vec![put] },
            crate::testing::ME,
        );
    }
    let mut client = TestClient::with_site(&robot);
    let ids = [1, 2, 3].map(|number| site_model::SceneChangeId(Uuid::from_u128(number)));
    client.command(ClientCommand::MakeNormal(ids.to_vec()));
    let asked = client.take_commands();
    let [api::Command::MakeNormal { name, changes, .. }] = &asked[..] else { panic!("{asked:?}") };
    assert_eq!(changes[..], ids[..2], "only those of one map");
    assert!(name.ends_with(", new normal"), "{name}");
    assert_eq!(crate::texts::normal_map_name("Hall, new normal"), "Hall, new normal");
}
