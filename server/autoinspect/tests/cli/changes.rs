//! Tests of `autoinspect changes`: objects that differ between two visits.

use crate::program::{data, json, refused, text};
use serde_json::Value;
use std::fs;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

/// Whether an object is where a box of the truth is: its centre within 0.2 m, its extent along each axis within 20 %.
fn is_at(found: &Value, truth: &Value) -> bool {
    let (found_m, truth_m) = (numbers(&found["centre_m"]), numbers(&truth["centre_m"]));
    let distance_m = found_m.iter().zip(&truth_m).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    // The length of a found box is its longer side.
    let mut size_m = numbers(&truth["size_m"]);
    size_m[..2].sort_by(|a, b| b.total_cmp(a));
    let sizes = numbers(&found["size_m"]).into_iter().zip(size_m);
    distance_m <= 0.2 && sizes.into_iter().all(|(found, truth)| (found - truth).abs() <= 0.2 * truth)
}

fn of_kind<'a>(document: &'a Value, kind: &str) -> Vec<&'a Value> {
    document["objects"].as_array().expect("objects").iter().filter(|object| object["kind"] == kind).collect()
}

#[test]
fn boxes_that_were_put_into_recorded_walks_are_found_and_nothing_else_is() {
    let Some(sessions) = data("change-lidar-inserted") else { return };
    let dir = tempfile::tempdir().expect("temporary directory");
    let session = |name: &str| sessions.join(name);
    let (before, after) = (session("session_a"), session("session_b"));
    let printed = json(&["changes", text(&before), text(&after), "--out", text(dir.path())]);
    let written = fs::read_to_string(dir.path().join("changes.json")).expect("written");
    assert_eq!(printed, serde_json::from_str::<Value>(&written).expect("JSON"));
    let truth: Value =
        serde_json::from_str(&fs::read_to_string(session("truth.json")).expect("truth")).expect("JSON");
    let mut matched = 0;
    for kind in ["appeared", "removed"] {
        for expected in truth[kind].as_array().expect("a list") {
            let is_found = of_kind(&printed, kind).into_iter().any(|object| is_at(object, expected));
            // Of a box with fewer points not enough is seen.
            assert!(is_found || expected["points"].as_u64() < Some(150), "{kind}: {expected}\n{printed:#}");
            matched += usize::from(is_found);
        }
    }
    for expected in truth["moved"].as_array().expect("a list") {
        let is_same =
            |object: &&Value| is_at(object, &expected["to"]) && is_at(&object["from"], &expected["from"]);
        assert!(of_kind(&printed, "moved").iter().any(is_same), "{expected}\n{printed:#}");
        matched += 1;
    }
    assert_eq!(printed["objects"].as_array().expect("objects").len(), matched, "something else: {printed:#}");
    for number in 1..=matched {
        assert!(dir.path().join(format!("object-{number}.ply")).is_file());
    }
    let again = json(&["changes", text(&before), text(&before)]);
    assert_eq!(again["objects"].as_array().map(Vec::len), Some(0), "a visit compared with itself");
}

#[test]
fn visits_that_cannot_be_compared_are_refused_with_a_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let walk = dir.path().join("walk.mcap");
    let fixed = ["sim", "record", "--site", "b1", "--route", "short", "--columns", "50", "--minutes", "0.05"];
    json(&[&fixed[..], &["--out", text(&walk)]].concat());
    let sentence = refused(&["changes", text(&walk), text(&walk)]);
    assert!(sentence.contains("holds no poses"), "{sentence}");
    let nothing = dir.path().join("nothing.mcap");
    assert!(refused(&["changes", text(&nothing), text(&walk)]).contains("nothing.mcap"));
}
