//! Tests of `autoinspect make-normal`: changes that a later visit has found are normal in a new version of the map.

use crate::program::{json, refused, text};
use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn what_cannot_be_made_normal_is_refused_with_a_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = |name: &str| dir.path().join(name);
    let [file, none, out] = ["changes.json", "none", "out"].map(path);
    let complaint = refused(&[
        "make-normal",
        text(&none),
        "--changes",
        text(&file),
        "--map",
        text(&none),
        "--out",
        text(&out),
    ]);
    assert!(complaint.contains("none"), "{complaint}");
    let limits = ["--max-memory=8"];
    let complaint = refused(
        &[
            &[
                "make-normal",
                text(&none),
                "--changes",
                text(&file),
                "--map",
                text(&none),
                "--out",
                text(&out),
            ][..],
            &limits,
        ]
        .concat(),
    );
    assert!(complaint.contains("--max-memory"), "{complaint}");
    assert!(!out.exists());
}

/// Records a simulated walk, with coarse scans to save time, and maps it.
fn mapped(dir: &Path, name: &str, seed: &str, day: &[&str]) -> PathBuf {
    let (recording, map) = (dir.join(format!("{name}.mcap")), dir.join(name));
    let fixed = ["sim", "record", "--site", "b1", "--route", "short", "--columns", "400", "--people", "1"];
    json(&[&fixed[..], &["--minutes", "0.6", "--seed", seed, "--out", text(&recording)], day].concat());
    json(&["map", text(&recording), "--out", text(&map)]);
    map
}

#[test]
fn changes_are_found_once_and_are_gone_in_the_version_in_which_they_are_normal() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = |name: &str| dir.path().join(name);
    let before = mapped(dir.path(), "monday", "3", &[]);
    let other_frame = mapped(dir.path(), "tuesday", "4", &["--day", "2"]);
    let [after, changed, normal, again] = ["aligned", "changed", "normal", "again"].map(path);
    json(&["align", text(&other_frame), "--onto", text(&before), "--out", text(&after)]);
    let found = json(&["changes", text(&before), text(&after), "--out", text(&changed)]);
    let count = found["objects"].as_array().expect("objects").len();
    assert!(count >= 2, "{found}");

    let changes = changed.join("changes.json");
    let report = json(&[
        "make-normal",
        text(&after),
        "--changes",
        text(&changes),
        "--map",
        text(&before),
        "--out",
        text(&normal),
    ]);
    assert_eq!(report["accepted"].as_u64(), Some(count as u64), "{report}");
    assert!(report["gone"].as_u64() > Some(0) && report["come"].as_u64() > Some(0), "{report}");
    let fit = |version: &str| report[version]["fit"].as_f64().expect("a share");
    assert!(fit("after") >= fit("before"), "{report}");
    // Keyframes keep their poses.
    let graph = |map: &Path| {
        let graph = fs::read(map.join("graph.json")).expect("readable");
        serde_json::from_slice::<api::Graph>(&graph).expect("a graph")
    };
    for (old, new) in graph(&before).nodes.iter().zip(&graph(&normal).nodes) {
        let [a, b] = [old, new].map(|node| node.map_from_keyframe.position);
        assert!((a.x - b.x).abs() + (a.y - b.y).abs() + (a.z - b.z).abs() < 1e-9, "{a:?} {b:?}");
    }

    let left = json(&["changes", text(&normal), text(&after), "--out", text(&again)]);
    let left = left["objects"].as_array().expect("objects").len();
    println!("{count} changes before, {left} after");
    assert!(left * 4 <= count, "{left} of {count} changes are found again");

    // A file without changes, and the map itself as the result, are refused.
    fs::write(&changes, "{\"objects\": []}").expect("written");
    let args = ["make-normal", text(&after), "--changes", text(&changes), "--map", text(&before), "--out"];
    assert!(refused(&[&args[..], &[text(&again)]].concat()).contains("has no changes"));
    assert!(refused(&[&args[..], &[text(&before)]].concat()).contains("is one of"));
}
