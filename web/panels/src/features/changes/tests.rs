//! Changes by their panel.

use crate::screens;
use crate::test_support::{TestClient, click};
use api::{Event, SiteParts, SiteState};
use client_model::ClientCommand;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use site_model::{
    EarlierVisit, EditId, Object, OrientedBox, ReviewState, RunId, SceneChange, SceneChangeId,
    SceneChangeKind, Utc,
};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{MapId, Vec3};

fn change(number: u128, kind: SceneChangeKind, size_m: [f64; 3]) -> SceneChange {
    let map = MapId(Uuid::from_u128(1));
    SceneChange {
        id: SceneChangeId(Uuid::from_u128(number)),
        map,
        kind,
        place: OrientedBox { centre_m: Vec3::new(4.0, 1.0, 0.5), size_m, yaw_rad: 0.3 },
        points: 150,
        confidence: 0.98,
        before: EarlierVisit::Map(map),
        after: RunId(Uuid::from_u128(5)),
        first_seen: Utc(5),
        last_seen: Utc(number as i64),
        times_seen: 1,
        review: ReviewState::New,
        comment: String::new(),
        clouds: None,
    }
}

/// The Runs screen of a robot that has found two changes, with their tab open.
fn shown<'a>() -> Harness<'a, TestClient> {
    let mut state = SiteState::default();
    for change in [
        change(1, SceneChangeKind::Appeared, [0.6, 0.4, 1.0]),
        change(2, SceneChangeKind::Removed, [0.2, 0.2, 0.2]),
    ] {
        let edit = state.site.put(EditId(Uuid::nil()), Object::SceneChange(change));
        state.site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
    }
    let part = SiteParts::new(Arc::new(state)).next_part();
    let client = TestClient::connected().event(Event::SitePart(part)).on(screens::RUNS);
    let mut harness = client.shown(1440.0, 2000.0);
    click(&mut harness, super::texts::TAB);
    harness.run_steps(2);
    harness
}

fn press(harness: &mut Harness<'_, TestClient>, name: &str) {
    click(harness, name);
    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        let event = client_model::ClientEvent::Command(command);
        client.model.handle_event(client_model::ClientTime(1.0), event, &mut Vec::new());
    }
    harness.run_steps(2);
}

fn reviews(harness: &Harness<'_, TestClient>) -> Vec<ReviewState> {
    let site = harness.state().model.site.site().expect("a site");
    site.scene_changes().map(|change| change.review.clone()).collect()
}

const APPEARED: &str = "Appeared · 0.6 x 0.4 x 1.0 m";
const REMOVED: &str = "Removed · 0.2 x 0.2 x 0.2 m";

#[test]
fn a_change_is_acknowledged_and_that_is_undone() {
    let mut harness = shown();
    press(&mut harness, APPEARED);
    press(&mut harness, "Acknowledge");
    assert_eq!(reviews(&harness), [ReviewState::Acknowledged, ReviewState::New]);
    let client = harness.state_mut();
    let undo = client_model::ClientEvent::Command(ClientCommand::Undo);
    client.model.handle_event(client_model::ClientTime(2.0), undo, &mut Vec::new());
    assert_eq!(reviews(&harness), [ReviewState::New, ReviewState::New]);
}

#[test]
fn the_list_is_filtered_by_state_kind_and_size() {
    let mut harness = shown();
    let listed = |harness: &Harness<'_, TestClient>| {
        [APPEARED, REMOVED].map(|row| harness.query_by_label(row).is_some())
    };
    assert_eq!(listed(&harness), [true, true]);
    press(&mut harness, "From 0.3 m");
    assert_eq!(listed(&harness), [true, false]);
    press(&mut harness, "Any size");
    press(&mut harness, "Moved");
    assert_eq!(listed(&harness), [false, false]);
    press(&mut harness, "Any kind");
    press(&mut harness, "Watched");
    assert_eq!(listed(&harness), [false, false]);
}
