//! An archive is written from a core that answers from a list, and read again.

use super::super::fake_core::{FakeCore, SilentCore, run_in_state};
use super::*;
use site_model::{Edit, EditId, MissionId, Object, RunId};
use std::io::{Cursor, Read};
use uuid::Uuid;
use vocab::Stamp;

const RUN: RunId = RunId(Uuid::from_u128(1));
const HASH: &str = "abababababababababababababababababababababababababababababababab";

fn result(number: u64, missing: bool) -> StoredResult {
    let blob = if missing { HASH.replace("ab", "cd") } else { HASH.to_owned() };
    let body = serde_json::json!({
        "node": "00000000-0000-0000-0000-000000000009",
        "value": {
            "at": { "robot_time": 0, "utc_ns": 3, "is_synchronised": true },
            "files": [{ "name": "photo.jpg", "media_type": "image/jpeg", "blob": blob, "bytes": 5 }],
            "readings": [{ "name": "temperature", "value": 21.5, "unit": "°C" }],
        },
    });
    StoredResult {
        number,
        run: RUN,
        step: 2,
        attempt: 1,
        kind: "photo".into(),
        blob: None,
        body: body.to_string(),
        comparison: None,
        at: Stamp::from_nanos(1_795_000_000_000_000_000),
    }
}

fn site() -> Arc<SiteState> {
    let node = serde_json::json!({ "node": {
        "id": "00000000-0000-0000-0000-000000000009", "name": "Pump 7, \"east\"", "kind": "inspection",
        "map_from_node": { "position": { "x": 0, "y": 0, "z": 0 }, "orientation": { "w": 1, "x": 0, "y": 0, "z": 0 } },
    } });
    let node: Object = serde_json::from_value(node).unwrap();
    let edit = Edit {
        id: EditId(Uuid::from_u128(4)),
        changes: vec![site_model::Change::Put { base: None, object: node }],
    };
    let mut state = SiteState::default();
    state.site.apply(&edit, edit.id).unwrap();
    Arc::new(state)
}

#[test]
fn an_archive_holds_documents_a_table_and_files_under_readable_names() {
    let data = tempfile::tempdir().unwrap();
    let blob = data.path().join("blobs/ab").join(HASH);
    std::fs::create_dir_all(blob.parent().unwrap()).unwrap();
    std::fs::write(&blob, b"photo").unwrap();
    let run = StoredRun {
        run: RUN,
        mission: MissionId(Uuid::from_u128(2)),
        state: "succeeded".into(),
        is_ended: true,
        body: "{}".into(),
        began: Stamp::from_nanos(1_795_000_000_000_000_000),
        changed: Stamp::from_nanos(1_795_000_060_000_000_000),
    };
    let archive = Archive::new(run, Some(site()), data.path());
    let mut bytes = Vec::new();
    let core = FakeCore(vec![result(1, false), result(2, false), result(3, true)]);
    archive.write(&core, &mut bytes).unwrap();

    let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let folder = archive.name().to_owned();
    assert_eq!(folder, "run_2026-11-18T1106");
    let mut names: Vec<String> =
        zip.file_names().map(|name| name.replace(&format!("{folder}/"), "")).collect();
    names.sort();
    let photos = ["files/03_Pump_7___east_photo.jpg", "files/03_Pump_7___east_result-2_photo.jpg"];
    assert_eq!(
        names,
        [photos[0], photos[1], "missing-files.txt", "readings.csv", "results.json", "run.json", "steps.json"]
    );
    let mut read = |path: &str| {
        let mut text = String::new();
        zip.by_name(&format!("{folder}/{path}")).unwrap().read_to_string(&mut text).unwrap();
        text
    };
    assert_eq!(read(photos[0]), "photo");
    let table = read("readings.csv");
    let row = "2026-11-18T11:06:40Z,\"Pump 7, \"\"east\"\"\",\"photo\",1,\"temperature\",21.5,,\"°C\"";
    assert_eq!(table.lines().nth(1), Some(row));
    let results: Value = serde_json::from_str(&read("results.json")).unwrap();
    assert_eq!(results.as_array().map(Vec::len), Some(3));
    assert!(read("missing-files.txt").contains("cdcd"));
}

#[test]
fn a_core_that_fails_ends_the_archive_with_an_error() {
    let run = run_in_state(RUN, "running");
    let archive = Archive::new(run, None, Path::new("/nowhere"));
    assert!(archive.write(&SilentCore, &mut Vec::new()).is_err());
}
