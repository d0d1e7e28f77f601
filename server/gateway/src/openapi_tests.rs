use super::*;
use crate::schemas::HealthDocument;
use api::{
    BinnedMap, DamagedMap, Graph, GraphNode, MapSummary, Problem, StoredUpload, TileAnchor, TileEntry,
    TileHash, TileList,
};
use serde_json::{Value, json};
use std::path::Path;
use vocab::{Aabb, KeyframeId, MapId, Pose, SessionId, Span, Stamp, UploadId};

fn parsed() -> Value {
    serde_json::from_str(&description()).expect("the description is JSON")
}

#[test]
fn the_committed_description_is_the_served_one() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/api/openapi.json");
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(&path, description()).expect("docs/api can be written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(
        committed,
        description(),
        "run this test with UPDATE_EXPECT=1 and commit docs/api/openapi.json"
    );
}

#[test]
fn every_document_of_the_contract_is_described() {
    let paths = parsed()["paths"].clone();
    use api::paths::{
        BIN_PATH, BINNED_MAP_PATH, CLOUD_PATH, DAMAGED_MAPS_PATH, HEALTH_PATH, MAP_GRAPH_PATH, MAP_PATH,
        MAP_TILES_PATH, MAPS_PATH, RESTORE_MAP_PATH, TILE_PATH, UPLOAD_PATH, UPLOADS_PATH,
    };
    let changes = [
        (MAP_PATH, "patch"),
        (MAP_PATH, "delete"),
        (RESTORE_MAP_PATH, "post"),
        (BINNED_MAP_PATH, "delete"),
        (UPLOAD_PATH, "put"),
        (UPLOAD_PATH, "delete"),
    ];
    for (path, method) in changes {
        assert!(paths[path][method].is_object(), "{method} {path}");
    }
    let maps =
        [MAPS_PATH, MAP_PATH, BIN_PATH, UPLOADS_PATH, DAMAGED_MAPS_PATH, MAP_TILES_PATH, MAP_GRAPH_PATH];
    for path in maps.into_iter().chain([TILE_PATH, CLOUD_PATH, HEALTH_PATH]) {
        assert!(paths[path]["get"].is_object(), "{path}");
    }
}

#[test]
fn schemas_say_what_the_types_become() {
    let schemas = parsed()["components"]["schemas"].clone();
    let bounds = Aabb { min: [0.0; 3], max: [1.0; 3] };
    let tile = TileEntry {
        hash: TileHash([7; 32]),
        anchor: TileAnchor::Keyframe(KeyframeId(3)),
        level: 1,
        spacing_m: 0.5,
        bounds,
        points: 2,
        bytes: 3,
    };
    let in_map = TileEntry { anchor: TileAnchor::Map, ..tile };
    let node =
        GraphNode { id: KeyframeId(1), stamp: Stamp::from_nanos(2), map_from_keyframe: Pose::IDENTITY };
    let id = uuid::Uuid::from_u128(5);
    let edges = vec![(KeyframeId(0), KeyframeId(1))];
    let loops = vec![(KeyframeId(0), KeyframeId(9))];
    let graph = Graph { session: Some(SessionId(id)), revision: 7, nodes: vec![node], edges, loops };
    let summary = MapSummary {
        id: MapId(id),
        name: "hall".into(),
        created: Stamp::from_nanos(1),
        distance_m: 1.5,
        keyframes: 1,
        points: 2,
        bytes: 3,
        has_pose_graph: true,
    };
    let damaged = DamagedMap { folder: "f".into(), problem: "p".into(), remedy: "r".into() };
    let binned = BinnedMap {
        id: MapId(id),
        name: "hall".into(),
        bytes: 3,
        kept_until: Some(Stamp::from_nanos(5)),
        time_left: Some(Span::from_nanos(4)),
        problem: Some("p".into()),
    };
    let unknown = BinnedMap { kept_until: None, time_left: None, problem: None, ..binned.clone() };
    let upload = StoredUpload {
        upload: UploadId(id),
        name: Some("hall".into()),
        frame: Some(MapId(id)),
        bytes: 3,
        problem: Some("p".into()),
        kept_until: Some(Stamp::from_nanos(5)),
    };
    let problem = Problem { status: 404, title: "t".into(), detail: "d".into() };
    let restart = api::ProcessRestart { process: api::ProcessRole::Core, cause: "c".into(), count: 1 };
    let samples = [
        ("TileList", json!(TileList { bounds, tiles: vec![tile, in_map], robust_bounds: Some(bounds) })),
        ("Graph", json!(graph)),
        ("Graph", json!(Graph { session: None, ..graph.clone() })),
        ("MapSummary", json!(summary)),
        ("DamagedMap", json!(damaged)),
        ("BinnedMap", json!(binned)),
        ("BinnedMap", json!(unknown)),
        ("StoredUpload", json!(upload)),
        ("Problem", json!(problem)),
        ("Health", json!(HealthDocument { core_connected: true, clients: 1, restarts: vec![restart] })),
    ];
    for (name, sample) in samples {
        check(&sample, &schemas[name], &schemas, name);
    }
}

/// Fails unless `value` has exactly the form that `schema` describes. Knows as much of JSON Schema as utoipa writes here.
fn check(value: &Value, schema: &Value, schemas: &Value, place: &str) {
    if let Some(reference) = schema["$ref"].as_str() {
        let name = reference.rsplit('/').next().unwrap_or_default();
        return check(value, &schemas[name], schemas, name);
    }
    if let Some(choices) = schema["oneOf"].as_array() {
        // Of a choice between null and another schema, the latter is an object here.
        let fits = |choice: &&Value| is_of(value, choice) || choice["$ref"].is_string() && value.is_object();
        let choice = choices.iter().find(fits).unwrap_or_else(|| panic!("{place}: {value} fits no choice"));
        return check(value, choice, schemas, place);
    }
    assert!(is_of(value, schema), "{place}: {value} is no {schema}");
    match value {
        Value::Object(fields) => {
            let described =
                schema["properties"].as_object().unwrap_or_else(|| panic!("{place} has no fields"));
            let names = |map: &serde_json::Map<String, Value>| map.keys().cloned().collect::<Vec<_>>();
            assert_eq!(names(fields), names(described), "{place}");
            for (name, field) in fields {
                check(field, &described[name], schemas, &format!("{place}.{name}"));
            }
        }
        Value::Array(items) => items.iter().for_each(|item| check(item, &schema["items"], schemas, place)),
        _ => {}
    }
}

fn is_of(value: &Value, schema: &Value) -> bool {
    let kind = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(number) if number.is_f64() => "number",
        Value::Number(_) => "integer",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    match &schema["type"] {
        Value::String(named) => named == kind,
        Value::Array(named) => named.iter().any(|name| name == kind),
        _ => false,
    }
}
