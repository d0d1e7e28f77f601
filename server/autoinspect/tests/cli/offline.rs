//! Tests of the commands that work without a robot.

use crate::program::{data, json, run, text};
use std::fs;
use std::path::Path;

/// Records a walk of 8 s in the test hall, with coarse scans to save time.
fn walk(out: &Path, seed: &str) {
    let path = text(out);
    json(&[
        "sim",
        "record",
        "--site",
        "b1",
        "--out",
        path,
        "--columns",
        "200",
        "--minutes",
        "0.13",
        "--seed",
        seed,
    ]);
}

#[test]
fn info_lists_topics_and_missing_inputs_of_a_recording() {
    let Some(bag) = data("hilti-uzh-run2/bag") else { return };
    let info = json(&["info", text(&bag)]);
    let topics = info["topics"].as_array().expect("topics");
    let count =
        |name: &str| topics.iter().find(|topic| topic["name"] == name).map(|topic| topic["count"].clone());
    assert_eq!(count("/lidar/points"), Some(100.into()));
    assert_eq!(count("/vo/odometry"), Some(482.into()));
    let missing = info["missing"].to_string();
    assert!(missing.contains("IMU") && missing.contains("Points carry no time"), "{missing}");
}

#[test]
fn a_simulated_walk_is_recorded_mapped_compared_and_replayed_bit_for_bit() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = |name: &str| dir.path().join(name);
    let (walked, out, log) = (path("walk.mcap"), path("m"), path("journal.mcap"));
    walk(&walked, "3");

    let summary = json(&["map", text(&walked), "--out", text(&out), "--journal", text(&log)]);
    assert!(summary["scans"].as_u64().expect("scans") > 70, "{summary}");
    assert!(summary["keyframes"].as_u64().expect("keyframes") >= 1, "{summary}");
    for name in ["trajectory.tum", "graph.g2o", "map.ply", "tiles.json", "summary.json", "clouds/000000.pcd"]
    {
        assert!(out.join(name).exists(), "{name}");
    }
    let list: api::TileList =
        serde_json::from_slice(&fs::read(out.join("tiles.json")).expect("readable")).expect("tiles");
    let tile = list.tiles.first().expect("a tile").hash.to_string();
    assert!(out.join("tiles").join(&tile[..2]).join(&tile).exists());

    let truth = json(&[
        "trajectory",
        "compare",
        text(&walked),
        text(&out.join("trajectory.tum")),
        "--align",
        "first",
    ]);
    let error = truth["ape_m"]["rmse"].as_f64().expect("a number");
    assert!(error < 0.1, "an error of {error} m after 8 s");

    // Another process gives the same fingerprint for the same journal.
    let fingerprint = summary["fingerprint"].as_str().expect("a fingerprint").to_owned();
    for _ in 0..2 {
        assert_eq!(json(&["replay", text(&log)])["fingerprint"], fingerprint.as_str());
    }

    // The effects as lines of JSON, in the order of the robot's clock.
    let effects = path("effects.jsonl");
    let replayed = json(&["replay", text(&log), "--effects", text(&effects)]);
    assert_eq!(replayed["fingerprint"], fingerprint.as_str());
    let lines = fs::read_to_string(&effects).expect("written");
    let lines: Vec<serde_json::Value> =
        lines.lines().map(|line| serde_json::from_str(line).expect("a line is an object")).collect();
    assert!(lines.iter().any(|line| line["effect"]["Publish"]["Estimate"].is_object()));
    assert!(lines.iter().all(|line| line["effect"]["Publish"]["Scan"].is_null()), "clouds are left out");
    assert!(lines.is_sorted_by_key(|line| line["at_ns"].as_i64()));
    let nowhere = path("missing").join("effects.jsonl");
    let complaint = run(&["replay", text(&log), "--effects", text(&nowhere)]).stderr;
    assert!(String::from_utf8_lossy(&complaint).contains(text(&nowhere)), "it names the file");

    // A journal of another walk has another fingerprint, so the check can fail.
    let (other, other_log) = (path("other.mcap"), path("other_journal.mcap"));
    walk(&other, "4");
    json(&["map", text(&other), "--out", text(&path("o")), "--journal", text(&other_log)]);
    assert_ne!(json(&["replay", text(&other_log)])["fingerprint"], fingerprint.as_str());
}

#[test]
fn a_map_is_exported_in_every_format() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = |name: &str| dir.path().join(name);
    let (walked, out) = (path("walk.mcap"), path("m"));
    walk(&walked, "3");
    json(&["map", text(&walked), "--out", text(&out)]);

    let points = |name: &str, more: &[&str]| {
        let file = path(name);
        let report = json(&[&["export", text(&out), "--out", text(&file)], more].concat());
        assert_eq!(report["bytes"].as_u64(), Some(fs::metadata(&file).expect("a file").len()), "{name}");
        report["points"].as_u64().expect("points")
    };
    let all = ["a.ply", "a.pcd", "a.las", "a.laz", "a.e57"].map(|name| points(name, &[]));
    assert!(all[0] > 1000 && all.iter().all(|count| *count == all[0]), "{all:?}");
    assert!(points("every.e57", &["--spacing", "0"]) > all[0]);
    assert!(points("coarse.laz", &["--spacing", "0.5"]) < all[0] / 4);
    let size = |name: &str| fs::metadata(path(name)).expect("a file").len();
    assert!(size("a.laz") < size("a.las"));

    let drawn = points("a.png", &["--pixel", "0.1"]);
    assert!(drawn > all[0] / 4, "{drawn} of {}", all[0]);
    assert!(fs::read_to_string(path("a.pgw")).expect("a world file").starts_with("0.1\n"));
    assert!(points("floor.png", &["--heights", "-1,0.3"]) < drawn);
    assert!(!path(".a.png.unfinished").exists());
}

/// At the end of a short round loops are closed. They are in the summary and in the map, and a replay repeats them without verifying again.
#[test]
fn loops_of_a_round_are_closed_unless_they_are_left_open() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = |name: &str| dir.path().join(name);
    let (walked, out, log) = (path("round.mcap"), path("m"), path("journal.mcap"));
    json(&[
        "sim",
        "record",
        "--site",
        "b1",
        "--route",
        "short",
        "--people",
        "0",
        "--columns",
        "100",
        "--out",
        text(&walked),
    ]);
    let summary = json(&["map", text(&walked), "--out", text(&out), "--journal", text(&log)]);
    let accepted = summary["loops"]["accepted"].as_u64().expect("a number");
    assert!(accepted > 0 && summary["loops"]["proposed"].as_u64() >= Some(accepted), "{summary}");
    let stages = summary["stages"].as_array().expect("stages");
    let took = stages.iter().find(|stage| stage["name"] == "loops").map(|stage| stage["seconds"].as_f64());
    assert!(took.flatten() > Some(0.0), "{summary}");
    let graph: api::Graph =
        serde_json::from_slice(&fs::read(out.join("graph.json")).expect("readable")).expect("a graph");
    assert_eq!(graph.loops.len() as u64, accepted);
    let decisions = fs::read_to_string(out.join("loops.json")).expect("readable");
    assert!(decisions.contains("\"Accepted\"") && decisions.contains("\"reason\""), "{decisions}");
    assert_eq!(json(&["replay", text(&log)])["fingerprint"], summary["fingerprint"]);

    let open = json(&["map", text(&walked), "--out", text(&path("o")), "--no-loops"]);
    assert_eq!(open["loops"]["proposed"], 0, "{open}");
}

#[test]
fn the_same_seed_records_the_same_bytes() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let [first, second, third] = ["a", "b", "c"].map(|name| dir.path().join(format!("{name}.mcap")));
    walk(&first, "3");
    walk(&second, "3");
    walk(&third, "4");
    let bytes = |path: &Path| fs::read(path).expect("readable");
    assert!(bytes(&first) == bytes(&second), "the same seed gave different recordings");
    assert!(bytes(&first) != bytes(&third), "another seed gave the same recording");
}

#[test]
fn a_simulated_recording_is_a_standard_recording_with_truth() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("walk.mcap");
    walk(&path, "5");
    let info = json(&["info", text(&path)]);
    let topics = info["topics"].as_array().expect("topics");
    let types: Vec<&str> = topics.iter().filter_map(|topic| topic["type_name"].as_str()).collect();
    for wanted in ["sensor_msgs/PointCloud2", "sensor_msgs/Imu", "nav_msgs/Odometry", "tf2_msgs/TFMessage"] {
        assert!(types.contains(&wanted), "{wanted} not in {types:?}");
    }
    assert!(topics.iter().any(|topic| topic["name"] == "/truth" && topic["count"].as_u64() > Some(100)));
}

#[test]
fn an_exported_site_is_walked_in_as_a_building_from_a_file() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let exported = json(&["site", "export", "twins", "--out", text(dir.path())]);
    let building = dir.path().join("twins.glb");
    assert_eq!(exported["file"].as_str(), Some(text(&building)));
    let record = |site: &str, name: &str| {
        let out = dir.path().join(name);
        let walk = ["--route", "short", "--minutes", "0.2", "--columns", "50", "--people", "2"];
        json(&[&["sim", "record", "--site", site, "--out", text(&out)][..], &walk].concat())
    };
    let (original, twin) = (record("twins", "a.mcap"), record(text(&building), "b.mcap"));
    assert_eq!(original["scans"], twin["scans"]);
    let [a, b] = [&original, &twin].map(|walk| walk["distance_m"].as_f64().expect("a number"));
    assert!(a > 4.0 && (a - b).abs() < 0.1, "{a} m and {b} m");
    let [a, b] = [&original, &twin].map(|walk| walk["points"].as_f64().expect("a number"));
    assert!((a / b - 1.0).abs() < 0.01, "{a} and {b} points");
}

/// Checks the accuracy on real recordings that the documentation states.
#[test]
fn real_recordings_are_mapped_with_the_documented_accuracy() {
    let Some(hilti) = data("hilti-uzh-run2") else { return };
    let dir = tempfile::tempdir().expect("temporary directory");
    let rmse = |truth: &Path, input: &Path, more: &[&str], extrinsic: &[&str]| {
        let out = dir.path().join("m");
        json(&[&["map", text(input), "--out", text(&out)], more].concat());
        let trajectory = out.join("trajectory.tum");
        let compared =
            json(&[&["trajectory", "compare", text(truth), text(&trajectory)], extrinsic].concat());
        compared["ape_m"]["rmse"].as_f64().expect("a number")
    };
    let calibration = hilti.join("extrinsic_estimate.json");
    let at_imu = ["--extrinsic", text(&calibration)];
    let (truth, bag) = (hilti.join("gt_mocap_imu_clean.tum"), hilti.join("bag"));
    let with_prior = rmse(&truth, &bag, &[], &at_imu);
    assert!(with_prior <= 0.13, "{with_prior} m with the odometry prior");
    let alone = rmse(&truth, &bag, &["--sources", "lidar"], &at_imu);
    assert!(alone <= 0.30, "{alone} m with the LiDAR alone");

    let Some(kaist) = data("kaist03-keyframes") else { return };
    let keyframes = rmse(&kaist.join("optimized_poses.txt"), &kaist.join("Scans"), &[], &[]);
    assert!(keyframes <= 0.10, "{keyframes} m over the car's keyframes");
}
