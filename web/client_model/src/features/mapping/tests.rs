//! Which map is viewed when mapping begins and ends.

use crate::testing::*;
use api::Mapping;

#[test]
fn a_snapshot_that_is_idle_shows_the_live_map() {
    let mut client = TestClient::connected();
    client.event(api::Event::Mapping(Mapping::Idle));
    assert_eq!(client.model.viewed_map(), None);
}
