//! Changes by their panel.

use crate::page_clock::PageClock;
use crate::screens;
use crate::test_support::{TestClient, click};
use api::{Event, SiteParts, SiteState};
use client_model::{ClientCommand, ShownChanges};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use site_model::{
    EarlierVisit, EditId, Object, OrientedBox, PhysicalObject, PhysicalObjectId, ReviewState, RunId,
    SceneChange, SceneChangeId, SceneChangeKind, Utc, Zone, ZoneEffect, ZoneId,
};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{MapId, Vec3};

const HOUR_NS: i64 = 3_600_000_000_000;
/// When the list is looked at.
const NOW: Utc = Utc(1_000 * HOUR_NS);

/// A change that was last seen this number of hours ago.
fn change(number: u128, kind: SceneChangeKind, size_m: [f64; 3], age_h: i64, x: f64) -> SceneChange {
    let seen = Utc(NOW.0 - age_h * HOUR_NS);
    let map = MapId(Uuid::from_u128(1));
    SceneChange {
        id: SceneChangeId(Uuid::from_u128(number)),
        map,
        kind,
        place: OrientedBox { centre_m: Vec3::new(x, 1.0, 0.5), size_m, yaw_rad: 0.3 },
        points: 150,
        confidence: 0.998,
        before: EarlierVisit::Map(map),
        after: RunId(Uuid::from_u128(5)),
        first_seen: seen,
        last_seen: seen,
        times_seen: 1,
        review: ReviewState::New,
        comment: String::new(),
        clouds: None,
        physical_object: None,
        descriptor: None,
    }
}

/// The Runs screen of a robot that has found two changes, with their tab open.
fn shown<'a>() -> Harness<'a, TestClient> {
    shown_with(|_| {})
}

/// The same with changes that were changed.
fn shown_with<'a>(mut prepare: impl FnMut(&mut SceneChange)) -> Harness<'a, TestClient> {
    let mut state = SiteState::default();
    let zone = Zone {
        id: ZoneId(Uuid::from_u128(7)),
        name: "Pump hall".to_owned(),
        corners_m: vec![[0.0, 0.0], [6.0, 0.0], [6.0, 2.0], [0.0, 2.0]],
        height_m: Some([0.0, 3.0]),
        effect: ZoneEffect::Penalty(1.0),
        daily: None,
    };
    let mut changes = [
        change(1, SceneChangeKind::Appeared, [0.6, 0.4, 1.0], 2, 4.0),
        change(2, SceneChangeKind::Removed, [0.2, 0.2, 0.2], 48, 9.0),
    ];
    changes.iter_mut().for_each(&mut prepare);
    for object in changes.into_iter().map(Object::SceneChange).chain([Object::Zone(zone)]) {
        let edit = state.site.put(EditId(Uuid::nil()), object);
        state.site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
    }
    let part = SiteParts::new(Arc::new(state)).next_part();
    let mut client = TestClient::connected().event(Event::SitePart(part)).on(screens::RUNS);
    client.panels.clock = PageClock { utc: NOW, ..PageClock::default() };
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

const APPEARED: &str = "Appeared · 0.6 x 0.4 x 1.0 m · 2 h 00 old";
const REMOVED: &str = "Removed · 0.2 x 0.2 x 0.2 m · 2 days old";

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
fn a_thing_that_was_turned_where_it_stands_says_so_and_is_among_those_that_were_moved() {
    let mut harness = shown_with(|change| {
        if change.kind == SceneChangeKind::Appeared {
            let turn_rad = 0.6;
            let from = OrientedBox { yaw_rad: change.place.yaw_rad - turn_rad, ..change.place };
            change.kind = SceneChangeKind::Moved { from };
        } else {
            let mut from = change.place;
            from.centre_m.y -= 1.5;
            change.kind = SceneChangeKind::Moved { from };
        }
    });
    press(&mut harness, "Filters");
    press(&mut harness, "Moved");
    for row in ["Turned 34° · 0.6 x 0.4 x 1.0 m · 2 h 00 old", "Moved 1.5 m · 0.2 x 0.2 x 0.2 m · 2 days old"]
    {
        assert!(harness.query_by_label(row).is_some(), "{row}");
    }
}

#[test]
fn what_comes_and_goes_is_listed_apart() {
    let mut harness = shown_with(|change| {
        if change.kind == SceneChangeKind::Removed {
            change.review = ReviewState::Routine;
        }
    });
    let is_listed = |harness: &Harness<'_, TestClient>| harness.query_by_label(REMOVED).is_some();
    assert!(!is_listed(&harness), "not new");
    press(&mut harness, "Filters");
    press(&mut harness, "Comes and goes");
    assert!(is_listed(&harness) && harness.query_by_label(APPEARED).is_none());
    press(&mut harness, "Any state");
    assert!(is_listed(&harness) && harness.query_by_label(APPEARED).is_some());
}

#[test]
fn the_list_is_filtered_by_state_kind_size_age_and_zone() {
    let mut harness = shown();
    let listed = |harness: &Harness<'_, TestClient>| {
        [APPEARED, REMOVED].map(|row| harness.query_by_label(row).is_some())
    };
    assert_eq!(listed(&harness), [true, true]);
    assert!(harness.query_by_label("From 0.3 m").is_none(), "the filters are folded");
    press(&mut harness, "Filters");
    press(&mut harness, "From 0.3 m");
    assert_eq!(listed(&harness), [true, false]);
    press(&mut harness, "Any size");
    press(&mut harness, "Moved");
    assert_eq!(listed(&harness), [false, false]);
    press(&mut harness, "Any kind");
    press(&mut harness, "Last day");
    assert_eq!(listed(&harness), [true, false]);
    press(&mut harness, "Last week");
    assert_eq!(listed(&harness), [true, true]);
    press(&mut harness, "Zone");
    press(&mut harness, "Pump hall");
    assert_eq!(listed(&harness), [true, false]);
    press(&mut harness, "Zone");
    press(&mut harness, "Whole site");
    press(&mut harness, "Watched");
    assert_eq!(listed(&harness), [false, false]);
    // None is wider than the card.
    let right = |name: &str| harness.get_by_label(name).rect().right();
    let most = ["Any state", "Comes and goes", "Moved", "From 1 m", "Last week", "Zone"].map(right);
    let of_card = right("Filters");
    assert!(most.iter().all(|right| *right <= of_card + 0.5), "{most:?} {of_card}");
    press(&mut harness, "Clear the filters");
    assert_eq!(listed(&harness), [true, true]);
    press(&mut harness, "Filters");
    assert!(harness.query_by_label("From 0.3 m").is_none(), "folded again");
}

#[test]
fn how_many_are_listed_and_by_which_filters_is_said() {
    use super::texts::{filters, shown};
    assert_eq!(filters(&["New", "From 0.3 m"]), "Filter: New · From 0.3 m");
    assert_eq!(
        [shown(1, 1), shown(2, 2), shown(3, 1_600)],
        ["1 change", "2 changes", "3 of 1\u{a0}600 changes"]
    );
    assert_eq!(shown(0, 3), "None of 3 changes is shown: see the filters.");
    let mut harness = shown_with(|_| {});
    press(&mut harness, "Filters");
    press(&mut harness, "Appeared");
    assert!(harness.query_by_label("1 of 2 changes").is_some());
}

#[test]
fn what_is_not_certain_never_reads_as_certain() {
    assert_eq!([0.5, 0.99, 0.998].map(super::texts::confidence), ["50 %", "99 %", "over 99 %"]);
}

#[test]
fn one_change_or_all_acknowledged_ones_are_made_normal() {
    let mut harness = shown();
    press(&mut harness, APPEARED);
    click(&mut harness, "Make normal");
    let [appeared, removed] = [1, 2].map(|number| SceneChangeId(Uuid::from_u128(number)));
    assert!(harness.state().emitted(&ClientCommand::MakeNormal(vec![appeared])));
    // Only one version is made at a time.
    press(&mut harness, "Acknowledge");
    click(&mut harness, "Make normal");
    assert!(!harness.state().emitted(&ClientCommand::MakeNormal(vec![appeared])));

    let mut harness = shown();
    press(&mut harness, APPEARED);
    press(&mut harness, "Acknowledge");
    press(&mut harness, REMOVED);
    press(&mut harness, "Acknowledge");
    press(&mut harness, "Filters");
    press(&mut harness, "Acknowledged");
    click(&mut harness, "Make 2 acknowledged changes normal");
    assert!(harness.state().emitted(&ClientCommand::MakeNormal(vec![appeared, removed])));
}

#[test]
fn the_scene_shows_one_visit_both_or_a_wipe() {
    let mut harness = shown();
    assert!(harness.query_by_label(super::texts::WIPE).is_none());
    for (name, shown) in [
        ("Before", ShownChanges::Before),
        ("After", ShownChanges::After),
        ("Wipe", ShownChanges::Wipe(0.5)),
        ("Both", ShownChanges::Both),
    ] {
        press(&mut harness, name);
        assert_eq!(harness.state().model.changes_view.shown(), shown);
        assert_eq!(harness.query_by_label(super::texts::WIPE).is_some(), shown.wipe().is_some());
    }
}

#[test]
fn a_thing_that_was_elsewhere_shows_where_and_when_and_how_sure_that_is() {
    let mut harness = shown();
    press(&mut harness, APPEARED);
    assert!(harness.query_by_label("Show the place 1").is_none(), "nothing more is known");

    let mut harness = shown_with(|change| {
        let probability = if change.kind == SceneChangeKind::Removed { 1.0 } else { 0.81 };
        let id = PhysicalObjectId(Uuid::from_u128(8));
        change.physical_object = Some(PhysicalObject { id, probability });
    });
    press(&mut harness, APPEARED);
    let shown = |harness: &Harness<'_, TestClient>, text: &str| {
        harness.query_all_by(|node| node.value().is_some_and(|value| value.contains(text))).next().is_some()
    };
    assert!(shown(&harness, "81 %"));
    assert!(shown(&harness, "until ") && shown(&harness, "since "));
    for (number, x) in [(1, 9.0), (2, 4.0)] {
        click(&mut harness, &format!("Show the place {number}"));
        let there = client_model::CameraMove::Point(Vec3::new(x, 1.0, 0.5));
        assert!(harness.state().emitted(&ClientCommand::MoveCamera(there)));
    }
}
