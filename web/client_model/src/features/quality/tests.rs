//! The quality of the map under construction is what the robot last reported.

use crate::testing::*;
use api::Quality;
use vocab::KeyframeId;

#[test]
fn the_last_report_replaces_the_one_before() {
    let mut client = TestClient::connected();
    assert_eq!(client.model.quality(), &Quality::default());
    client.event(api::Event::Quality(Quality {
        covered_m2: 120.0,
        deviations_m: vec![0.0, 0.02],
        ..Quality::default()
    }));
    assert_eq!(client.model.quality().covered_m2, 120.0);
    assert_eq!(client.model.quality().deviation_of(KeyframeId(1)), Some(0.02));
    client.event(api::Event::Quality(Quality { covered_m2: 140.0, ..Quality::default() }));
    assert_eq!(client.model.quality().covered_m2, 140.0);
    assert_eq!(client.model.quality().deviation_of(KeyframeId(1)), None, "of the report before");
}
