//! Tests of changes at simulated sites: scripts, random ones and their truth.

use crate::program::{json, refused, text};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Records a moment of a walk in the test hall with these arguments besides.
fn record(out: &Path, arguments: &[&str]) {
    let fixed = ["sim", "record", "--site", "b1", "--route", "short", "--columns", "50", "--minutes", "0.02"];
    json(&[&fixed[..], &["--out", text(out)], arguments].concat());
}

fn read(file: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(file).expect("a file")).expect("JSON")
}

#[test]
fn a_script_of_changes_is_made_and_its_truth_is_told() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let file = |name: &str| dir.path().join(name);
    let listed = json(&["sim", "list", "--site", "b1"]);
    let lamp = &listed["lamps"][3];
    let script = serde_json::json!({ "version": 1, "changes": [
        { "kind": "lamp-out", "at_m": lamp },
        { "kind": "door", "hinge_m": listed["doors"][0], "turn_deg": 20.0 },
        { "kind": "gauge-stuck", "tag": listed["gauges"][0]["tag"], "value": 2.0 },
        { "kind": "leak", "at_m": [5.0, 5.0, 0.0], "radius_m": 0.3, "liquid": "oil" },
    ]});
    fs::write(file("script.json"), script.to_string()).expect("writable");
    let (script, truth) = (file("script.json"), file("truth.json"));
    record(&file("walk.mcap"), &["--changes", text(&script), "--truth-changes", text(&truth)]);
    let told = read(&truth);
    assert_eq!(told["version"], 1);
    let changes = told["changes"].as_array().expect("a list");
    let kinds: Vec<_> = changes.iter().map(|change| change["kind"].as_str().expect("a kind")).collect();
    assert_eq!(kinds, ["lamp-out", "door", "gauge-stuck", "leak"]);
    assert_eq!(&changes[0]["at_m"], lamp);
    assert_eq!(changes[3]["warmer_k"], 0.0);
}

#[test]
fn random_changes_of_a_day_are_the_same_and_can_be_given_as_a_script() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let file = |name: &str| dir.path().join(name);
    let walk = file("walk.mcap");
    let truth = |name: &str, arguments: &[&str]| {
        let out = file(name);
        record(&walk, &[arguments, &["--truth-changes", text(&out)]].concat());
        read(&out)
    };
    let tuesday = truth("a.json", &["--day", "2", "--random-changes", "6"]);
    assert_eq!(tuesday["changes"].as_array().map(Vec::len), Some(6));
    assert_eq!(tuesday, truth("b.json", &["--day", "2", "--random-changes", "6", "--seed", "9"]));
    assert_ne!(tuesday, truth("c.json", &["--day", "3", "--random-changes", "6"]));
    let again = truth("d.json", &["--day", "2", "--changes", text(&file("a.json"))]);
    assert_eq!(again["changes"].as_array().map(Vec::len), Some(6));
    // Nothing was asked for, and nothing was changed.
    assert_eq!(truth("e.json", &[])["changes"], Value::Array(Vec::new()));
}

#[test]
fn changes_that_cannot_be_made_are_refused_with_one_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let out = dir.path().join("walk.mcap");
    let script = dir.path().join("script.json");
    let fixed = ["sim", "record", "--site", "b1", "--minutes", "0.02", "--out", text(&out)];
    let complaint = |content: &str| {
        fs::write(&script, content).expect("writable");
        refused(&[&fixed[..], &["--changes", text(&script)]].concat())
    };
    for (content, expected) in [
        ("{", "script.json: it cannot be understood"),
        (r#"{"version": 2, "changes": []}"#, "this program reads version 1"),
        (r#"{"version": 1, "changes": [{"kind": "flood"}]}"#, "unknown variant `flood`"),
        (
            r#"{"version": 1, "changes": [{"kind": "gauge-stuck", "tag": "PI-7", "value": 1}]}"#,
            "no gauge has the tag \"PI-7\": take one of PI-101",
        ),
    ] {
        let told = complaint(content);
        assert!(told.contains(expected), "{told}");
        assert_eq!(told.lines().filter(|line| line.starts_with("error:")).count(), 1, "{told}");
    }
    assert!(!out.exists(), "nothing is recorded");
    let told = refused(&["up", "--robot", "socket:none", "--random-changes", "3"]);
    assert!(told.contains("are for a simulated site"), "{told}");
    // The process of the simulated robot makes them too.
    let socket = dir.path().join("robot.sock");
    let told =
        refused(&["simulated-robot", "--robot", "sim:b1", "--socket", text(&socket), "--changes", "no.json"]);
    assert!(told.contains("no.json: it cannot be read"), "{told}");
}
