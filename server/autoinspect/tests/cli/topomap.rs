//! Tests of `autoinspect topomap`: a topological map from a saved map.

use crate::import::room_with_table_at;
use crate::program::{json, refused, run, text};
use serde_json::Value;
use std::fs;

/// Objects of a kind in a document.
fn objects<'a>(document: &'a Value, kind: &'a str) -> impl Iterator<Item = &'a Value> {
    document["objects"].as_array().expect("objects").iter().filter_map(move |object| object.get(kind))
}

#[test]
fn a_walked_map_gets_a_topological_map_with_its_dock_in_every_format() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = |name: &str| dir.path().join(name);
    let (walked, map) = (path("walk.mcap"), path("m"));
    let fixed = ["sim", "record", "--site", "b1", "--route", "short", "--columns", "200", "--people", "1"];
    json(&[&fixed[..], &["--minutes", "0.5", "--out", text(&walked)]].concat());
    json(&["map", text(&walked), "--out", text(&map)]);

    let make = |name: &str, more: &[&str]| {
        let out = path(name);
        let report = json(&[&["topomap", text(&map), "--out", text(&out)], more].concat());
        (report, fs::read_to_string(out).expect("written"))
    };
    // The walk begins on the dock.
    let dock = ["--dock", "0,0,0,0"];
    let (report, document) = make("t.json", &dock);
    let count = |name: &str| report[name].as_u64().expect("a count");
    assert!(count("nodes") >= 4 && count("docks") == 1 && count("pieces") == 1, "{report}");
    assert!(report["length_m"].as_f64() > Some(8.0), "{report}");
    let document: Value = serde_json::from_str(&document).expect("JSON");
    assert_eq!(objects(&document, "node").count() as u64, count("nodes"));
    assert_eq!(objects(&document, "edge").count() as u64, count("edges"));
    for edge in objects(&document, "edge") {
        let is_reverse = |other: &&Value| other["from"] == edge["to"] && other["to"] == edge["from"];
        assert_eq!(objects(&document, "edge").filter(is_reverse).count(), 1, "{edge}");
    }
    assert!(objects(&document, "node").all(|node| node["anchor"]["keyframe"].is_u64()));

    // Another process makes the same, bit for bit.
    let again = make("again.json", &dock).1;
    assert_eq!(again, fs::read_to_string(path("t.json")).expect("written"));

    let yaml = make("t.yaml", &[]).1;
    assert!(yaml.starts_with("format_version: 1\n") && yaml.contains("\n  -\n    node:\n"), "{yaml}");
    let (report, route) = make("t.geojson", &[]);
    let route: Value = serde_json::from_str(&route).expect("JSON");
    let features = route["features"].as_array().expect("features").len() as u64;
    assert_eq!(features, report["nodes"].as_u64().unwrap_or(0) + report["edges"].as_u64().unwrap_or(0));
    let drawing = path("t.svg");
    json(&["topomap", text(&map), "--svg", text(&drawing)]);
    let drawing = fs::read_to_string(drawing).expect("drawn");
    assert!(drawing.contains("<image") && drawing.contains("<line") && drawing.ends_with("</svg>\n"));
}

#[test]
fn a_survey_that_nobody_walked_gets_one_too() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let [file, map] = ["room.ply", "m"].map(|name| dir.path().join(name));
    fs::write(&file, room_with_table_at(2.0)).expect("writable");
    json(&["import", text(&file), "--out", text(&map)]);
    let report = json(&["topomap", text(&map)]);
    let count = |name: &str| report[name].as_u64().expect("a count");
    assert!(count("nodes") >= 2 && count("pieces") == 1 && count("blocked") == 0, "{report}");
}

#[test]
fn what_cannot_be_done_is_said() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let empty = text(dir.path());
    assert!(refused(&["topomap", empty]).contains("holds no map"));
    assert!(refused(&["topomap", empty, "--out", "t.dwg"]).contains(".geojson"));
    let wrong = run(&["topomap", empty, "--dock", "1,2"]);
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("X,Y,Z,HEADING"));
}
