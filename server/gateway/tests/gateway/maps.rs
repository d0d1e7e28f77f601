//! Saved maps over HTTP: the core is asked, and its lists are answered from.

use crate::support::{Gateway, TestCore};
use api::paths::{
    BIN_PATH, BINNED_MAP_PATH, MAP_PATH, MAP_TILES_PATH, MAPS_PATH, RESTORE_MAP_PATH, UPLOAD_PATH,
    UPLOADS_PATH,
};
use api::{
    BinnedMap, Command, CommandOutcome, CoreMessage, DamagedMap, Event, GatewayMessage, MapSummary,
    StoredUpload, TileAnchor, TileEntry, TileHash, TileList,
};
use uuid::Uuid;
use vocab::{Aabb, MapId, Span, Stamp, UploadId};

const MAP: MapId = MapId(Uuid::from_u128(10));

fn hall(name: &str) -> MapSummary {
    MapSummary {
        id: MAP,
        name: name.into(),
        created: Stamp::from_nanos(1),
        distance_m: 2.0,
        keyframes: 3,
        points: 4,
        bytes: 5,
        has_pose_graph: true,
    }
}

fn binned() -> BinnedMap {
    BinnedMap {
        id: MAP,
        name: "hall".into(),
        bytes: 5,
        kept_until: Some(Stamp::from_nanos(9)),
        time_left: Some(Span::from_nanos(8)),
        problem: None,
    }
}

fn path(of: &str) -> String {
    of.replace("{id}", &MAP.to_string())
}

/// A gateway whose core has sent its lists.
async fn with_lists(maps: Vec<MapSummary>, bin: Vec<BinnedMap>) -> (Gateway, TestCore) {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    publish(&mut core, maps, bin).await;
    core.publish(Event::Uploads(Vec::new())).await;
    let mut client = gateway.client(1).await;
    client.find(|event| matches!(event, Event::Uploads(_)).then_some(())).await;
    (gateway, core)
}

async fn publish(core: &mut TestCore, maps: Vec<MapSummary>, bin: Vec<BinnedMap>) {
    core.publish(Event::Maps(maps)).await;
    core.publish(Event::DamagedMaps(Vec::new())).await;
    core.publish(Event::BinnedMaps(bin)).await;
}

/// Plays the core for one command: publishes lists, then answers.
async fn answer(
    core: &mut TestCore,
    expected: Command,
    lists: (Vec<MapSummary>, Vec<BinnedMap>),
    outcome: CommandOutcome,
) {
    let GatewayMessage::Command { id, by, command } = core.command().await else { panic!("no command") };
    assert_eq!(command, expected);
    publish(core, lists.0, lists.1).await;
    core.send(&CoreMessage::Event { to: Some(by.client), event: Event::CommandDone { id, outcome } }).await;
}

#[tokio::test]
async fn a_map_is_renamed_and_answered_with_its_new_name() {
    let (gateway, mut core) = with_lists(vec![hall("hall")], Vec::new()).await;
    let map = path(MAP_PATH);
    assert_eq!(gateway.get(&map, &[]).await.json()["name"], "hall");
    let body = br#"{"name": "Pump hall"}"#;
    let length = format!("content-length: {}", body.len());
    let expected = Command::RenameMap { map: MAP, name: "Pump hall".into() };
    let lists = (vec![hall("Pump hall")], Vec::new());
    let headers = [length.as_str()];
    let (reply, ()) = tokio::join!(
        gateway.send("PATCH", &map, &headers, body),
        answer(&mut core, expected, lists, CommandOutcome::Accepted)
    );
    assert_eq!((reply.status, reply.json()["name"].as_str()), (200, Some("Pump hall")));
    assert_eq!(reply.header("cache-control"), "no-store");
    for bad in [&b"{}"[..], b"name", br#"{"name": 5}"#, br#"{"name": "x", "points": 4}"#] {
        let length = format!("content-length: {}", bad.len());
        gateway.send("PATCH", &map, &[&length], bad).await.expect_problem(400);
    }
    let long = [b'x'; 20_000];
    gateway.send("PATCH", &map, &["content-length: 20000"], &long).await.expect_problem(413);
    let foreign = [length.as_str(), "origin: http://evil.example"];
    gateway.send("PATCH", &map, &foreign, body).await.expect_problem(403);
    let other = map.replace("000a", "000b");
    gateway.get(&other, &[]).await.expect_problem(404);
    gateway.send("PATCH", &other, &headers, body).await.expect_problem(404);
    gateway.get("/api/v1/maps/hall", &[]).await.expect_problem(400);
}

#[tokio::test]
async fn a_map_is_deleted_restored_and_deleted_for_good() {
    let (gateway, mut core) = with_lists(vec![hall("hall")], Vec::new()).await;
    let (map, restore, in_bin) = (path(MAP_PATH), path(RESTORE_MAP_PATH), path(BINNED_MAP_PATH));
    gateway.request("POST", &restore, &["content-length: 0"]).await.expect_problem(404);
    gateway.request("DELETE", &in_bin, &[]).await.expect_problem(404);
    let lists = || (Vec::new(), vec![binned()]);
    let (reply, ()) = tokio::join!(
        gateway.request("DELETE", &map, &[]),
        answer(&mut core, Command::DeleteMap(MAP), lists(), CommandOutcome::Accepted)
    );
    assert_eq!((reply.status, reply.json()["kept_until"].as_i64()), (200, Some(9)));
    gateway.request("DELETE", &map, &[]).await.expect_problem(404);
    let bin = gateway.get(BIN_PATH, &[]).await;
    assert_eq!(serde_json::from_slice::<Vec<BinnedMap>>(&bin.body).expect("the bin"), [binned()]);
    let back = (vec![hall("hall")], Vec::new());
    let (reply, ()) = tokio::join!(
        gateway.request("POST", &restore, &["content-length: 0"]),
        answer(&mut core, Command::RestoreMap(MAP), back, CommandOutcome::Accepted)
    );
    assert_eq!((reply.status, reply.json()["name"].as_str()), (200, Some("hall")));
    publish(&mut core, Vec::new(), vec![binned()]).await;
    let mut client = gateway.client(2).await;
    client.find(|event| matches!(event, Event::BinnedMaps(maps) if !maps.is_empty()).then_some(())).await;
    let gone = (Vec::new(), Vec::new());
    let (reply, ()) = tokio::join!(
        gateway.request("DELETE", &in_bin, &[]),
        answer(&mut core, Command::DeleteMapPermanently(MAP), gone, CommandOutcome::Accepted)
    );
    assert_eq!((reply.status, reply.body.len()), (204, 0));
}

#[tokio::test]
async fn a_refusal_is_a_conflict_and_a_core_that_is_lost_is_told() {
    let (gateway, mut core) = with_lists(vec![hall("hall")], Vec::new()).await;
    let reason = "The robot uses this map. Leave the map first, then delete it.";
    let refused = CommandOutcome::Refused(reason.to_owned());
    let map = path(MAP_PATH);
    let lists = (vec![hall("hall")], Vec::new());
    let (reply, ()) = tokio::join!(
        gateway.request("DELETE", &map, &[]),
        answer(&mut core, Command::DeleteMap(MAP), lists, refused)
    );
    reply.expect_problem(409);
    assert_eq!(reply.json()["detail"], reason);
    let (reply, ()) = tokio::join!(gateway.request("DELETE", &map, &[]), async {
        core.command().await;
        drop(core);
    });
    reply.expect_problem(503);
}

#[tokio::test]
async fn a_damaged_map_can_be_deleted() {
    let (gateway, mut core) = with_lists(Vec::new(), Vec::new()).await;
    let damaged = DamagedMap { folder: MAP.to_string(), problem: "p".into(), remedy: "r".into() };
    core.publish(Event::DamagedMaps(vec![damaged])).await;
    let mut client = gateway.client(2).await;
    client.find(|event| matches!(event, Event::DamagedMaps(maps) if !maps.is_empty()).then_some(())).await;
    let lists = (Vec::new(), vec![BinnedMap { problem: Some("p".into()), ..binned() }]);
    let map = path(MAP_PATH);
    let (reply, ()) = tokio::join!(
        gateway.request("DELETE", &map, &[]),
        answer(&mut core, Command::DeleteMap(MAP), lists, CommandOutcome::Accepted)
    );
    assert_eq!((reply.status, reply.json()["problem"].as_str()), (200, Some("p")));
}

#[tokio::test]
async fn uploads_are_listed_and_deleted() {
    let (gateway, mut core) = with_lists(Vec::new(), Vec::new()).await;
    let upload = UploadId(Uuid::from_u128(3));
    let listed = StoredUpload {
        upload,
        name: Some("hall".into()),
        frame: None,
        bytes: 6,
        problem: Some("It is no cloud.".into()),
        kept_until: None,
    };
    core.publish(Event::Uploads(vec![listed.clone()])).await;
    let mut client = gateway.client(2).await;
    client.find(|event| matches!(event, Event::Uploads(all) if !all.is_empty()).then_some(())).await;
    let reply = gateway.get(UPLOADS_PATH, &[]).await;
    assert_eq!(serde_json::from_slice::<Vec<StoredUpload>>(&reply.body).expect("uploads"), [listed]);
    let file = UPLOAD_PATH.replace("{id}", &upload.to_string());
    gateway.request("DELETE", &file, &[]).await.expect_problem(404);
    gateway.write(&format!("data/uploads/{upload}"), b"points");
    let (reply, ()) = tokio::join!(
        gateway.request("DELETE", &file, &[]),
        answer(&mut core, Command::DeleteUpload(upload), Default::default(), CommandOutcome::Accepted)
    );
    assert_eq!(reply.status, 204);
}

/// The path of the next page, if the `Link` header names one.
fn next_page(link: &str) -> Option<String> {
    Some(link.strip_prefix('<')?.strip_suffix(">; rel=\"next\"")?.to_owned())
}

#[tokio::test]
async fn lists_are_read_page_by_page() {
    let maps: Vec<MapSummary> = (0..5)
        .map(|number| MapSummary { id: MapId(Uuid::from_u128(100 + number)), ..hall("hall") })
        .collect();
    let (gateway, mut core) = with_lists(maps.clone(), vec![binned()]).await;
    let whole = gateway.get(MAPS_PATH, &[]).await;
    assert_eq!(serde_json::from_slice::<Vec<MapSummary>>(&whole.body).expect("maps"), maps);
    assert_eq!(whole.header("link"), "", "there is no other page");
    let (mut read, mut next) = (Vec::new(), Some(format!("{MAPS_PATH}?limit=2")));
    while let Some(page) = next {
        let reply = gateway.get(&page, &[]).await;
        let entries: Vec<MapSummary> = serde_json::from_slice(&reply.body).expect("maps");
        assert!((1..=2).contains(&entries.len()), "{entries:?}");
        if read.is_empty() {
            // A new map does not move the entries of the next page.
            let newest = std::iter::once(hall("new")).chain(maps.iter().cloned()).collect();
            publish(&mut core, newest, Vec::new()).await;
            let mut client = gateway.client(2).await;
            let is_new = |event: &Event| matches!(event, Event::Maps(maps) if maps.len() == 6).then_some(());
            client.find(is_new).await;
        }
        read.extend(entries);
        next = next_page(reply.header("link"));
    }
    assert_eq!(read, maps);
    for wrong in ["limit=0", "limit=1001", "limit=many", "page=2"] {
        gateway.get(&format!("{MAPS_PATH}?{wrong}"), &[]).await.expect_problem(400);
    }
    let gone = format!("{MAPS_PATH}?after={}", Uuid::from_u128(1));
    gateway.get(&gone, &[]).await.expect_problem(404);
    assert_eq!(gateway.get(&format!("{BIN_PATH}?limit=1"), &[]).await.json()[0], serde_json::Value::Null);
}

#[tokio::test]
async fn tiles_of_a_map_are_read_page_by_page() {
    let gateway = Gateway::start().await;
    let bounds = Aabb { min: [0.0; 3], max: [1.0; 3] };
    let tile = |number: u8| TileEntry {
        hash: TileHash([number; 32]),
        anchor: TileAnchor::Map,
        level: 0,
        spacing_m: 0.5,
        bounds,
        points: u32::from(number),
        bytes: 3,
    };
    let list = TileList { bounds, tiles: (0..5).map(tile).collect(), robust_bounds: Some(bounds) };
    let json = serde_json::to_vec(&list).expect("JSON");
    gateway.write(&format!("data/maps/{MAP}/tiles.json"), &json);
    let tiles = path(MAP_TILES_PATH);
    assert_eq!(gateway.get(&tiles, &[]).await.body, json, "all, as they are on the disk");
    let (mut read, mut next) = (Vec::new(), Some(format!("{tiles}?limit=2")));
    while let Some(page) = next {
        let reply = gateway.get(&page, &[]).await;
        let page: TileList = serde_json::from_slice(&reply.body).expect("tiles");
        assert_eq!((page.bounds, page.robust_bounds), (bounds, Some(bounds)));
        assert!((1..=2).contains(&page.tiles.len()));
        read.extend(page.tiles);
        next = next_page(reply.header("link"));
    }
    assert_eq!(read, list.tiles);
    for (wrong, status) in [("after=ab", 400), ("limit=0", 400), (&format!("after={}", "cd".repeat(32)), 404)]
    {
        gateway.get(&format!("{tiles}?{wrong}"), &[]).await.expect_problem(status);
    }
    gateway.get(&tiles.replace("000a", "000b"), &[]).await.expect_problem(404);
    gateway.get(&format!("{}?limit=2", tiles.replace("000a", "000b")), &[]).await.expect_problem(404);
}
