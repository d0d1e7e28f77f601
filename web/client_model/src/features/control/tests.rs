//! Who holds the control lease, as the server says it.

use crate::testing::*;
use api::Control;

#[test]
fn the_last_report_of_the_server_says_who_holds_the_lease() {
    let mut client = TestClient::connected();
    assert_eq!(client.model.control().owner(), None);
    assert!(!client.model.has_control());
    client.event(api::Event::Control(Control { owner: Some(OTHER), name: "Tablet".into(), request: None }));
    assert_eq!(client.model.control().owner(), Some(OTHER));
    assert_eq!(client.model.control().holder_name(), "Tablet");
    assert!(!client.model.has_control(), "another client holds it");
    client.event(api::Event::Control(Control { owner: Some(ME), name: "Desk".into(), request: None }));
    assert!(client.model.has_control());
    client.event(api::Event::Control(Control::default()));
    assert!(!client.model.has_control(), "it was given back");
}
