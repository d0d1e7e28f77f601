//! A file is written from a core that answers from a list, and read again by the library of the format.

use super::super::archive::Archive;
use super::super::fake_core::{FakeCore, SilentCore, run_in_state};
use super::*;
use mcap::{MessageStream, Summary};
use serde_json::json;
use site_model::{
    Alert, AlertCause, AlertId, AlertSeverity, AlertState, EditId, InspectionPointId, MissionId, RunId, Utc,
};
use std::collections::BTreeSet;
use std::io::Cursor;
use uuid::Uuid;
use vocab::Stamp;

const RUN: RunId = RunId(Uuid::from_u128(1));
const AT_NS: i64 = 1_795_000_000_250_000_000;
const PHOTO: &[u8] = b"\xff\xd8 a photo";
const SPECTRUM: &[u8] =
    br#"{"live_time_s": 60.0, "first_kev": 0.0, "channel_kev": 3.0, "counts": [1, 2, 3]}"#;

fn result(number: u64, files: &[Value]) -> StoredResult {
    let pose = json!({ "position": { "x": 1.5, "y": 0.0, "z": 0.0 }, "orientation": { "w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0 } });
    let place = json!({ "map": Uuid::from_u128(8), "map_from_base": pose, "covariance": vocab::Covariance6::default(), "quality": "good" });
    let value = json!({
        "at": { "robot_time": 0, "utc_ns": AT_NS + number as i64, "is_synchronised": true }, "place": place, "files": files,
        "readings": [{ "name": "temperature", "value": 21.5, "unit": "°C" }],
    });
    StoredResult {
        number,
        run: RUN,
        step: 0,
        attempt: 1,
        kind: "photo".into(),
        blob: None,
        body: json!({ "value": value }).to_string(),
        at: Stamp::from_nanos(AT_NS),
        comparison: None,
    }
}

/// A file whose name is 64 times this digit.
fn file(digit: char, name: &str, media_type: &str) -> Value {
    json!({ "name": name, "media_type": media_type, "blob": digit.to_string().repeat(64), "bytes": 3 })
}

#[test]
fn every_message_decodes_and_there_are_as_many_files_as_in_the_archive() {
    let data = tempfile::tempdir().unwrap();
    for (digit, content) in [('a', PHOTO), ('b', SPECTRUM), ('c', b"ply".as_slice())] {
        let path = blob_path(data.path(), &digit.to_string().repeat(64));
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }
    let core = FakeCore(vec![
        result(1, &[file('a', "photo.jpg", "image/jpeg"), file('b', "spectrum.json", "application/json")]),
        result(2, &[file('c', "cloud.ply", "model/ply"), file('d', "gone.jpg", "image/jpeg")]),
        StoredResult { body: "no JSON".into(), ..result(3, &[]) },
    ]);
    let mut state = SiteState::default();
    let alert = Alert {
        id: AlertId(Uuid::from_u128(5)),
        severity: AlertSeverity::Warning,
        cause: AlertCause::GaugeNotRead {
            point: InspectionPointId(Uuid::from_u128(6)),
            run: RUN,
            result: 2,
            reason: "Dark.".to_owned(),
        },
        state: AlertState::Open,
        owner: String::new(),
        work_order: String::new(),
        comment: String::new(),
        first_raised: Utc(AT_NS),
        last_raised: Utc(AT_NS),
        times_raised: 1,
        recovered: None,
    };
    let of_another_run =
        Alert { id: AlertId(Uuid::from_u128(7)), cause: AlertCause::ByHand { point: None }, ..alert.clone() };
    for alert in [alert, of_another_run] {
        let edit = state.site.put(EditId(Uuid::nil()), Object::Alert(alert));
        state.site.apply(&edit, EditId(Uuid::nil())).unwrap();
    }
    let run = StoredRun {
        run: RUN,
        mission: MissionId(Uuid::from_u128(2)),
        state: "succeeded".into(),
        is_ended: true,
        body: "{}".into(),
        began: Stamp::from_nanos(AT_NS),
        changed: Stamp::from_nanos(AT_NS),
    };
    let state = Some(Arc::new(state));
    let (mut bytes, mut zipped) = (Vec::new(), Vec::new());
    McapExport::new(run.clone(), state.clone(), data.path()).write(&core, &mut bytes).unwrap();
    Archive::new(run, state, data.path()).write(&core, &mut zipped).unwrap();

    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut schemas = BTreeSet::new();
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(
            (message.channel.message_encoding.as_str(), schema.encoding.as_str()),
            ("json", "jsonschema")
        );
        let described: Value = serde_json::from_slice(&schema.data).unwrap();
        let content: Value = serde_json::from_slice(&message.data).unwrap();
        let validator = jsonschema::validator_for(&described).unwrap();
        assert!(validator.is_valid(&content), "{content}");
        // Each field is described, and no other one is.
        let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<BTreeSet<_>>();
        assert_eq!(keys(&described["properties"]), keys(&content), "{}", schema.name);
        let time = &content["timestamp"];
        let stamp = time["sec"].as_u64().unwrap() * 1_000_000_000 + time["nsec"].as_u64().unwrap();
        assert_eq!(message.log_time, stamp);
        assert!(message.log_time.abs_diff(AT_NS as u64) <= 3);
        if schema.name == "foxglove.CompressedImage" {
            assert_eq!(STANDARD.decode(content["data"].as_str().unwrap()).unwrap(), PHOTO);
            assert_eq!(content["format"], "jpeg");
        }
        if schema.name == "foxglove.PoseInFrame" {
            assert_eq!(
                (&content["frame_id"], &content["pose"]["position"]["x"]),
                (&json!("map"), &json!(1.5))
            );
        }
        schemas.insert(schema.name.clone());
        *counts.entry(message.channel.topic.clone()).or_default() += 1;
    }
    let place = file_name(texts::UNNAMED_PLACE);
    let expected = [
        ("/alerts".to_owned(), 1),
        (format!("/pictures/{place}/photo"), 1),
        ("/pose".to_owned(), 2),
        (format!("/readings/{place}/temperature"), 2),
        ("/results".to_owned(), 3),
        (format!("/spectra/{place}"), 1),
    ];
    assert_eq!(counts, expected.into());
    assert_eq!(schemas.len(), 6);
    let summary = Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.stats.unwrap().message_count, 10);
    let attached: Vec<_> =
        summary.attachment_indexes.iter().map(|it| it.name.rsplit('/').next().unwrap()).collect();
    assert_eq!(attached, ["cloud.ply"]);
    let about = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
    assert!(about.metadata["missing_files"].starts_with("gone.jpg"));

    let archive = zip::ZipArchive::new(Cursor::new(zipped)).unwrap();
    let files = archive.file_names().filter(|name| name.contains("/files/")).count();
    assert_eq!(files, 3, "a picture, a spectrum and an attachment");
}

#[test]
fn a_core_or_a_reader_that_fails_ends_the_file_with_an_error() {
    let run = run_in_state(RUN, "running");
    let export = McapExport::new(run, None, Path::new("/nowhere"));
    assert!(export.write(&SilentCore, &mut Vec::new()).is_err());
    let mut room = [0_u8; 20];
    assert!(export.write(&FakeCore(vec![result(1, &[])]), &mut room[..]).is_err());
}
