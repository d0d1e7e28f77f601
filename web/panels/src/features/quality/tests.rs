//! Quality of the map under construction: figures, and places to survey.

use crate::screens;
use crate::test_support::{TestClient, click, running, value};
use api::{Event, Quality, SurveyReason, SurveyTarget};
use client_model::ClientCommand;
use vocab::Vec3;

#[test]
fn survey_targets_are_listed_and_can_be_walked_to() {
    let at = Vec3::new(4.0, 2.0, 0.0);
    let places = vec![
        SurveyTarget { at, why: SurveyReason::FromAfar { area_m2: 34.0 } },
        SurveyTarget { at: Vec3::default(), why: SurveyReason::Uncertain { deviation_m: 0.42 } },
    ];
    let quality = Quality {
        covered_m2: 412.3,
        from_afar_m2: 40.0,
        deviations_m: vec![0.0, 0.42, 0.1],
        targets: places,
    };
    let client = TestClient::connected().event(Event::Mapping(running())).event(Event::Quality(quality));
    let mut harness = client.on(screens::MAP).shown(1440.0, 1200.0);
    assert_eq!(value(&harness, "Floor covered"), "412 m²");
    assert_eq!(value(&harness, "Known to"), "0.42 m");
    assert_eq!(value(&harness, "Suggested walk 1"), "34 m² seen from afar only");
    assert!(value(&harness, "Suggested walk 2").contains("0.42 m only"));
    click(&mut harness, "Walk to position 1");
    assert!(harness.state().emitted(&ClientCommand::WalkTo(at)));
}
