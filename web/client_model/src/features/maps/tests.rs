//! Saved and damaged maps, as the server listed them last.

use crate::testing::TestClient;
use api::{DamagedMap, Event};

#[test]
fn damaged_maps_are_kept_until_the_server_lists_others() {
    let mut client = TestClient::connected();
    assert!(client.model.maps().damaged().is_empty());
    let damaged = DamagedMap {
        folder: "0a".into(),
        problem: "It cannot be read: map.json is empty.".into(),
        remedy: "Copy it back from a backup.".into(),
    };
    client.event(Event::DamagedMaps(vec![damaged.clone()]));
    client.event(Event::Maps(Vec::new()));
    assert_eq!(client.model.maps().damaged(), [damaged]);
    client.event(Event::DamagedMaps(Vec::new()));
    assert!(client.model.maps().damaged().is_empty());
}
