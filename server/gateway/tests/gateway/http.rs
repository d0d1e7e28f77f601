//! Documents, tiles, problems.

use crate::support::Gateway;
use api::paths::{DAMAGED_MAPS_PATH, HEALTH_PATH, MAPS_PATH};
use api::{DamagedMap, Event, MapSummary};
use vocab::{MapId, Stamp};

const MAP: &str = "00000000-0000-0000-0000-00000000000a";

fn tile_path(hash: &str) -> String {
    api::paths::TILE_PATH.replace("{hash}", hash)
}

#[tokio::test]
async fn maps_are_those_of_the_last_event() {
    let gateway = Gateway::start().await;
    gateway.get(MAPS_PATH, &[]).await.expect_problem(503);
    let mut core = gateway.core().await;
    let map = MapSummary {
        id: MapId(uuid::Uuid::from_u128(10)),
        name: "hall".into(),
        created: Stamp::from_nanos(1),
        distance_m: 2.0,
        keyframes: 3,
        points: 4,
        bytes: 5,
        has_pose_graph: false,
    };
    core.publish(Event::Maps(vec![map.clone()])).await;
    let mut client = gateway.client(1).await;
    client.find(|event| matches!(event, Event::Maps(_)).then_some(())).await;
    let reply = gateway.get(MAPS_PATH, &[]).await;
    assert_eq!((reply.status, reply.header("content-type")), (200, "application/json"));
    assert_eq!(serde_json::from_slice::<Vec<MapSummary>>(&reply.body).expect("maps"), [map]);
}

#[tokio::test]
async fn damaged_maps_are_those_of_the_last_event_for_clients_and_over_http() {
    let gateway = Gateway::start().await;
    gateway.get(DAMAGED_MAPS_PATH, &[]).await.expect_problem(503);
    let mut core = gateway.core().await;
    let damaged = vec![DamagedMap {
        folder: MAP.into(),
        problem: "It cannot be read: map.json is empty.".into(),
        remedy: "Copy it back from a backup.".into(),
    }];
    core.publish(Event::DamagedMaps(damaged.clone())).await;
    let mut client = gateway.client(1).await;
    let sent = client.find(|event| match event {
        Event::DamagedMaps(maps) => Some(maps.clone()),
        _ => None,
    });
    assert_eq!(sent.await, damaged);
    let reply = gateway.get(DAMAGED_MAPS_PATH, &[]).await;
    assert_eq!((reply.status, reply.header("content-type")), (200, "application/json"));
    assert_eq!(serde_json::from_slice::<Vec<DamagedMap>>(&reply.body).expect("maps"), damaged);
}

#[tokio::test]
async fn files_of_actions_are_immutable_have_their_type_and_come_in_parts() {
    let gateway = Gateway::start().await;
    let path = |digit: &str| api::paths::BLOB_PATH.replace("{hash}", &digit.repeat(64));
    let files: [(&str, &[u8], &str); 5] = [
        ("a", b"\xff\xd8\xff\xe0picture", "image/jpeg"),
        ("b", b"\x89PNG\r\n\x1a\npicture", "image/png"),
        ("c", b"# .PCD v0.7 - Point Cloud Data file format", "application/vnd.pcd"),
        ("d", b"{\"counts\":[]}", "application/json"),
        ("e", b"<html><script>", "application/octet-stream"),
    ];
    for (digit, content, kind) in files {
        let name = digit.repeat(64);
        gateway.write(&format!("data/blobs/{}/{name}", digit.repeat(2)), content);
        let reply = gateway.get(&path(digit), &[]).await;
        assert_eq!((reply.status, &reply.body[..], reply.header("content-type")), (200, content, kind));
        assert_eq!(reply.header("cache-control"), "public, max-age=31536000, immutable");
        assert_eq!(
            (reply.header("accept-ranges"), reply.header("x-content-type-options")),
            ("bytes", "nosniff")
        );
        let again = gateway.get(&path(digit), &[&format!("if-none-match: {}", reply.header("etag"))]).await;
        assert_eq!((again.status, again.body.len()), (304, 0));
        let part = gateway.get(&path(digit), &["range: bytes=2-5"]).await;
        assert_eq!((part.status, &part.body[..], part.header("content-length")), (206, &content[2..6], "4"));
        assert_eq!(part.header("content-range"), format!("bytes 2-5/{}", content.len()));
        let end = gateway.get(&path(digit), &["range: bytes=-3"]).await;
        assert_eq!((end.status, &end.body[..]), (206, &content[content.len() - 3..]));
    }
    let beyond = gateway.get(&path("a"), &["range: bytes=100-"]).await;
    assert_eq!((beyond.header("content-range"), beyond.status), ("bytes */11", 416));
    beyond.expect_problem(416);
    gateway.get(&path("f"), &[]).await.expect_problem(404);
    gateway.get("/api/v1/blobs/..%2f..%2fledger.db", &[]).await.expect_problem(400);
    // A directory in its place is no file.
    gateway.write(&format!("data/blobs/77/{}/file", "7".repeat(64)), b"x");
    gateway.get(&path("7"), &[]).await.expect_problem(404);
}

#[tokio::test]
async fn documents_of_a_map_are_files_with_validators() {
    let gateway = Gateway::start().await;
    gateway.write(&format!("data/maps/{MAP}/tiles.json"), b"{\"tiles\":[]}");
    gateway.write(&format!("data/maps/{MAP}/graph.json"), b"{\"nodes\":[]}");
    gateway.write("data/maps/secret/tiles.json", b"secret");
    for (kind, content) in [("tiles", "{\"tiles\":[]}"), ("graph", "{\"nodes\":[]}")] {
        let path = format!("/api/v1/maps/{MAP}/{kind}");
        let reply = gateway.get(&path, &[]).await;
        assert_eq!((reply.status, &reply.body[..]), (200, content.as_bytes()));
        let condition = format!("if-none-match: {}", reply.header("etag"));
        let again = gateway.get(&path, &[&condition]).await;
        assert_eq!((again.status, again.body.len()), (304, 0));
        gateway.get(&path.replace('a', "b"), &[]).await.expect_problem(404);
        let head = gateway.request("HEAD", &path, &[]).await;
        assert_eq!((head.status, head.header("content-length"), head.body.len()), (200, "12", 0));
    }
    gateway.get("/api/v1/maps/secret/tiles", &[]).await.expect_problem(400);
    gateway.get("/api/v1/maps/..%2fsecret/tiles", &[]).await.expect_problem(400);
    gateway.get("/api/v1/maps/%ff/tiles", &[]).await.expect_problem(400);
}

#[tokio::test]
async fn tiles_are_for_ever() {
    let gateway = Gateway::start().await;
    let hash = "ab".repeat(32);
    let bytes: Vec<u8> = (0..200_000_u32).map(|i| (i * 7) as u8).collect();
    gateway.write(&format!("data/tiles/ab/{hash}"), &bytes);
    let reply = gateway.get(&tile_path(&hash), &["accept-encoding: gzip, br"]).await;
    assert_eq!(reply.status, 200);
    assert!(reply.body == bytes, "the very bytes");
    assert_eq!(reply.header("content-type"), "application/octet-stream");
    assert_eq!(reply.header("cache-control"), "public, max-age=31536000, immutable");
    assert_eq!(reply.header("etag"), format!("\"{hash}\""));
    let condition = format!("if-none-match: \"{hash}\"");
    assert_eq!(gateway.get(&tile_path(&hash), &[&condition]).await.status, 304);
    assert_eq!(gateway.get(&tile_path(&hash.to_uppercase()), &[]).await.status, 200);

    let missing = gateway.get(&tile_path(&"cd".repeat(32)), &[]).await;
    missing.expect_problem(404);
    assert_eq!(missing.header("cache-control"), "no-store", "a tile may come later");
    for malformed in ["ab", &"g".repeat(64), &format!("..%2f{hash}"), "%00"] {
        gateway.get(&tile_path(malformed), &[]).await.expect_problem(400);
    }
}

#[tokio::test]
async fn scans_of_keyframes_are_served_by_session_and_number() {
    let gateway = Gateway::start().await;
    gateway.write(&format!("data/sessions/{MAP}/000012.scan"), b"points");
    gateway.write("data/sessions/secret/000012.scan", b"secret");
    let path = |session: &str, keyframe: &str| {
        api::paths::CLOUD_PATH.replace("{session}", session).replace("{keyframe}", keyframe)
    };
    let reply = gateway.get(&path(MAP, "12"), &[]).await;
    assert_eq!((reply.status, &reply.body[..]), (200, &b"points"[..]));
    assert_eq!(reply.header("cache-control"), "public, max-age=31536000, immutable");
    let condition = format!("if-none-match: {}", reply.header("etag"));
    assert_eq!(gateway.get(&path(MAP, "12"), &[&condition]).await.status, 304);
    gateway.get(&path(MAP, "13"), &[]).await.expect_problem(404);
    for (session, keyframe) in
        [("secret", "12"), ("..%2fsecret", "12"), (MAP, "x"), (MAP, "..%2f12"), (MAP, "-1")]
    {
        gateway.get(&path(session, keyframe), &[]).await.expect_problem(400);
    }
}

#[tokio::test]
async fn every_error_is_a_problem_document_with_the_security_headers() {
    let gateway = Gateway::start().await;
    for (method, path, status) in [
        ("GET", "/api", 404),
        ("GET", "/api/v1/nothing", 404),
        ("GET", "/api/v2/maps", 404),
        ("POST", MAPS_PATH, 405),
        ("DELETE", HEALTH_PATH, 405),
        ("BREW", HEALTH_PATH, 405),
        ("POST", "/index.html", 405),
        ("GET", "/", 404),
        ("GET", api::CONTROL_PATH, 400),
        ("GET", api::STREAM_PATH, 400),
    ] {
        let reply = gateway.request(method, path, &[]).await;
        reply.expect_problem(status);
        assert_eq!(reply.header("x-content-type-options"), "nosniff", "{method} {path}");
        assert!(reply.header("content-security-policy").contains("'wasm-unsafe-eval'"), "{method} {path}");
        if status == 405 {
            assert!(reply.header("allow").contains("GET"), "{method} {path}");
        }
    }
}

#[tokio::test]
async fn the_description_is_served() {
    let gateway = Gateway::start().await;
    let reply = gateway.get("/api/v1/openapi.json", &[]).await;
    assert_eq!((reply.status, reply.header("content-type")), (200, "application/json"));
    assert_eq!(String::from_utf8(reply.body).expect("text"), gateway::description());
}
