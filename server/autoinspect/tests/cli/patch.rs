//! Tests of `autoinspect patch`: a new version of a map of a hall in which furniture was moved.

use crate::program::{json, refused, run, text};
use std::fs;
use std::path::Path;

/// Records a simulated walk, with coarse scans to save time.
fn walk(out: &Path, site: &str, seed: &str, day: &[&str]) {
    let fixed = ["sim", "record", "--site", site, "--route", "short", "--columns", "200", "--people", "1"];
    json(&[&fixed[..], &["--minutes", "0.4", "--seed", seed, "--out", text(out)], day].concat());
}

#[test]
fn moved_furniture_is_moved_in_the_map_and_the_robot_is_localised_better() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = |name: &str| dir.path().join(name);
    let [first, second, third, other] = ["1.mcap", "2.mcap", "3.mcap", "else.mcap"].map(path);
    let [map, version, none] = ["m", "m2", "none"].map(path);
    walk(&first, "b1", "3", &[]);
    walk(&second, "b1", "4", &["--day", "2"]);
    walk(&third, "b1", "5", &["--day", "2"]);
    walk(&other, "torus", "6", &[]);
    json(&["map", text(&first), "--out", text(&map)]);

    let patch = ["patch", text(&second), "--check", text(&third), "--map", text(&map), "--out"];
    let report = json(&[&patch[..], &[text(&version), "--name", "Hall"]].concat());
    let count = |name: &str| report[name].as_u64().expect("a count");
    assert!(count("gone") > 1_000 && count("come") > 500, "{report}");
    let fit = |version: &str| report[version]["fit"].as_f64().expect("a share");
    assert!(fit("after") > fit("before") + 0.005, "{report}");
    // The keyframes have not moved, so everything with a pose relative to them stays valid.
    let graph = |map: &Path| {
        let graph = fs::read(map.join("graph.json")).expect("readable");
        serde_json::from_slice::<api::Graph>(&graph).expect("a graph")
    };
    let (old, new) = (graph(&map), graph(&version));
    assert_eq!((&old.edges, &old.loops), (&new.edges, &new.loops));
    assert_eq!(old.nodes.len(), new.nodes.len());
    for (old, new) in old.nodes.iter().zip(&new.nodes) {
        let [a, b] = [old, new].map(|node| node.map_from_keyframe.position);
        assert!((a.x - b.x).abs() + (a.y - b.y).abs() + (a.z - b.z).abs() < 1e-9, "{a:?} {b:?}");
    }
    let localised =
        json(&["localise", text(&third), "--map", text(&version), "--out", text(&path("found.tum"))]);
    assert!(localised["found_after"].as_f64() < Some(3.0), "{localised}");

    // A recording of another site cannot change this map.
    let patched = run(&["patch", text(&other), "--map", text(&map), "--out", text(&none)]);
    assert_eq!(patched.status.code(), Some(1));
    assert!(!none.exists());
    let complaint = refused(&["patch", text(&second), "--map", text(&map), "--out", text(&map)]);
    assert!(complaint.contains("is one of the maps"), "{complaint}");
    refused(&["patch", text(&second), "--map", text(&none), "--out", text(&path("x"))]);
    refused(&["patch", text(&second), "--check", text(&none), "--map", text(&map), "--out", text(&none)]);
    assert!(!none.exists());
}
