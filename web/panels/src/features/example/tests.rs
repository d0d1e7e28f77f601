//! The card of an empty site: when it is shown, and what its buttons do.

use super::texts;
use crate::screens;
use crate::test_support::{TestClient, click, map, value};
use api::{Event, Import, ImportStage, Platform, SitePart};
use client_model::ClientCommand;
use egui_kittest::kittest::Queryable;
use uuid::Uuid;
use vocab::UploadId;

fn empty(site: &str) -> TestClient {
    let platform = Platform { site: Some(site.to_owned()), ..Platform::default() };
    TestClient::connected()
        .event(Event::Maps(Vec::new()))
        .event(Event::SitePart(SitePart { is_last: true, ..SitePart::default() }))
        .event(Event::Platform(platform))
}

#[test]
fn an_empty_site_offers_the_example_and_a_map_of_ones_own() {
    for (width, height) in [(1440.0, 900.0), (1024.0, 768.0), (390.0, 844.0)] {
        let mut harness = empty("b1").shown(width, height);
        let [example, own] = [texts::EXPLORE, texts::MAP_OWN].map(|name| harness.get_by_label(name).rect());
        let is_within = |rect: egui::Rect| rect.min.x >= 0.0 && rect.max.x <= width && rect.max.y <= height;
        assert!(is_within(example) && is_within(own), "{width}: {example} {own}");
        assert!(harness.query_by_label(texts::LOOKING_ONLY).is_none());
        click(&mut harness, texts::EXPLORE);
        let mut emitted = harness.state().commands.iter();
        let is_asked = emitted.any(|command| matches!(command, ClientCommand::MakeExample { .. }));
        assert!(is_asked, "{width}: {example}");
        click(&mut harness, texts::MAP_OWN);
        assert!(harness.state().emitted(&ClientCommand::ShowScreen(screens::MAP)));
    }
    let harness = empty("plant").shown(1440.0, 900.0);
    assert!(harness.query_by_label(texts::LOOKING_ONLY).is_some(), "the robot is elsewhere");
}

#[test]
fn it_is_not_offered_where_there_is_a_map_nor_after_not_now() {
    let harness = empty("b1").event(Event::Maps(vec![map(1, "Hall")])).shown(1440.0, 900.0);
    assert!(harness.query_by_label(texts::EXPLORE).is_none());
    let mut harness = empty("b1").shown(1440.0, 900.0);
    click(&mut harness, texts::DISMISS);
    harness.run_steps(2);
    assert!(harness.query_by_label(texts::EXPLORE).is_none());
}

#[test]
fn its_progress_is_told_in_words_and_percent_and_can_be_cancelled() {
    let upload = UploadId(Uuid::from_u128(4));
    let (name, stage) = ("Example hall".to_owned(), ImportStage::Walking);
    let running = Import::Running { upload, name, stage, share: 0.5 };
    let mut harness = empty("b1").event(Event::Import(running)).shown(1440.0, 900.0);
    assert_eq!(value(&harness, texts::STATE), "A simulated robot walks through the hall and maps it, 45 %");
    click(&mut harness, texts::CANCEL);
    assert!(harness.state().emitted(&ClientCommand::CancelExample));
}
