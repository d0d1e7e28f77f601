//! The message while a saved map is viewed.

use crate::test_support::{TestClient, click, map, value};
use api::{Event, Graph, TileList};
use client_model::{ClientCommand, ClientEvent, ClientTime};
use vocab::MapId;

fn viewed(result: Option<Result<TileList, String>>) -> (TestClient, MapId) {
    let cellar = map(8, "Cellar");
    let id = cellar.id;
    let client = TestClient::connected().event(Event::Maps(vec![cellar]));
    let mut client = client.command(ClientCommand::ViewMap(Some(id)));
    if let Some(result) = result {
        for event in [
            ClientEvent::TilesListed { map: id, result },
            ClientEvent::GraphLoaded { map: id, result: Ok(Graph::default()) },
        ] {
            client.model.handle_event(ClientTime(1.0), event, &mut Vec::new());
        }
    }
    (client, id)
}

#[test]
fn the_message_names_the_map_and_how_far_it_is_loaded() {
    let opening = viewed(None).0.shown(1440.0, 900.0);
    assert_eq!(value(&opening, "Message"), "Opening Cellar…");
    let loaded = viewed(Some(Ok(TileList::default()))).0.shown(1440.0, 900.0);
    assert_eq!(value(&loaded, "Message"), "Cellar · 0 points");
    let failed = viewed(Some(Err("The map is damaged.".into()))).0.shown(1440.0, 900.0);
    assert_eq!(value(&failed, "Message"), "The map is damaged.");
}

#[test]
fn it_leads_back_to_the_live_map() {
    let mut harness = viewed(None).0.shown(1440.0, 900.0);
    click(&mut harness, "Back to live");
    assert!(harness.state().emitted(&ClientCommand::ViewMap(None)));
}
