//! Tests of `autoinspect merge`: maps of several walks become one.

use crate::program::{json, refused, run, text};
use std::fs;
use std::path::Path;

/// Makes a map of a simulated walk, with coarse scans to save time.
fn walk(dir: &Path, name: &str, site: &str, seed: &str, minutes: &str) {
    let recording = dir.join(format!("{name}.mcap"));
    let path = text(&recording);
    json(&[
        "sim",
        "record",
        "--site",
        site,
        "--out",
        path,
        "--columns",
        "200",
        "--people",
        "1",
        "--seed",
        seed,
        "--minutes",
        minutes,
    ]);
    json(&["map", path, "--out", text(&dir.join(name))]);
}

#[test]
fn maps_of_two_walks_are_merged_and_a_map_of_another_site_is_rejected() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = |name: &str| dir.path().join(name);
    walk(dir.path(), "one", "b1", "3", "0.75");
    walk(dir.path(), "two", "b1", "4", "0.5");
    walk(dir.path(), "else", "torus", "5", "0.4");
    let [one, two, other, out] = ["one", "two", "else", "both"].map(path);

    let report = json(&["merge", text(&one), text(&two), "--out", text(&out)]);
    let join = &report["joins"][0];
    assert!(join["recognised"].as_u64() >= Some(6) && join["loops"].as_u64() >= Some(6), "{report}");
    // Both walks begin at the same pose.
    for axis in ["x", "y", "z"] {
        let off = join["first_from_map"]["position"][axis].as_f64().expect("a number");
        assert!(off.abs() < 0.15, "{report}");
    }
    let keyframes = |map: &Path| {
        let graph = fs::read(map.join("graph.json")).expect("readable");
        serde_json::from_slice::<api::Graph>(&graph).expect("a graph").nodes.len()
    };
    assert_eq!(keyframes(&out), keyframes(&one) + keyframes(&two));
    assert_eq!(report["keyframes"].as_u64(), Some(keyframes(&out) as u64));
    let clouds = fs::read_dir(out.join("clouds")).expect("readable").count();
    assert_eq!(clouds, keyframes(&out));
    // It is a map like any other.
    json(&["export", text(&out), "--out", text(&path("both.ply"))]);
    json(&["merge", text(&out), text(&two), "--out", text(&path("again"))]);

    // Another program's cloud of the same hall is aligned with the robot's map, by picked points or by place recognition.
    let (cloud, moved) = (path("one.ply"), path("moved"));
    json(&["export", text(&one), "--out", text(&cloud)]);
    let pairs = ["0,0,0=10,20,1", "5,0,0=10,25,1"];
    let report =
        json(&["import", text(&cloud), "--out", text(&moved), "--pair", pairs[0], "--pair", pairs[1]]);
    assert!(report["aligned"]["apart"].as_f64() < Some(1e-3), "{report}");
    let bounds = |report: &serde_json::Value, corner: usize, axis: usize| {
        report["bounds"][corner][axis].as_f64().expect("a number")
    };
    json(&["export", text(&moved), "--out", text(&path("moved.ply"))]);
    let back =
        json(&["import", text(&path("moved.ply")), "--align-to", text(&one), "--out", text(&path("back"))]);
    assert!(back["aligned"]["agreed"].as_u64() >= Some(6), "{back}");
    let plain = json(&["import", text(&cloud), "--out", text(&path("plain"))]);
    for (corner, axis) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)] {
        let off = bounds(&back, corner, axis) - bounds(&plain, corner, axis);
        assert!(off.abs() < 0.1, "{back} {plain}");
        // The cloud is turned by a right angle.
        let [turned, sign] = [[1, -1], [0, 1], [2, 1]][axis];
        let turned = usize::try_from(turned).expect("an axis");
        let across = if sign < 0 { 1 - corner } else { corner };
        let wanted = f64::from(sign) * bounds(&plain, across, turned) + [10.0, 20.0, 1.0][axis];
        assert!((bounds(&report, corner, axis) - wanted).abs() < 0.01, "{report} {plain}");
    }
    // The moved map is also aligned back, by both methods.
    let laid = path("laid");
    let back = |more: &[&str]| {
        let report =
            json(&[&["align", text(&moved), "--onto", text(&one), "--out", text(&laid)], more].concat());
        for (axis, wanted) in [("x", -20.0), ("y", 10.0), ("z", -1.0)] {
            let lies = report["aligned"]["map_from_cloud"]["position"][axis].as_f64().expect("a number");
            assert!((lies - wanted).abs() < 0.1, "{report}");
        }
        report
    };
    let picked = back(&["--pair", "10,20,1=0,0,0", "--pair", "10,25,1=5,0,0"]);
    assert_eq!((picked["aligned"]["agreed"].as_u64(), keyframes(&laid)), (Some(2), keyframes(&moved)));
    assert!(back(&[])["aligned"]["agreed"].as_u64() >= Some(6));
    json(&["export", text(&laid), "--out", text(&path("laid.ply"))]);
    let again = json(&["import", text(&path("laid.ply")), "--out", text(&path("again"))]);
    for (corner, axis) in [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)] {
        let off = bounds(&again, corner, axis) - bounds(&plain, corner, axis);
        assert!(off.abs() < 0.15, "{again} {plain}");
    }
    let far = ["--pair", "0,0,1e300=0,0,0", "--pair", "5,0,1e300=5,0,0"];
    let complaint = refused(
        &[&["align", text(&one), "--onto", text(&two), "--out", text(&path("far"))], &far[..]].concat(),
    );
    assert!(complaint.contains("farther away than 100 km") && !path("far").exists(), "{complaint}");
    let complaint = refused(&["align", text(&one), "--onto", text(&two), "--out", text(&two)]);
    assert!(complaint.contains("is one of the maps"), "{complaint}");
    let complaint = refused(&[
        "import",
        text(&cloud),
        "--out",
        text(&path("no")),
        "--pair",
        pairs[0],
        "--pair",
        "5,0,0=10,45,1",
    ]);
    assert!(complaint.contains("contradict each other"), "{complaint}");
    let elsewhere = run(&["import", text(&cloud), "--out", text(&path("no")), "--align-to", text(&other)]);
    let complaint = String::from_utf8_lossy(&elsewhere.stderr).into_owned();
    assert_eq!(elsewhere.status.code(), Some(1), "{complaint}");
    assert!(complaint.contains("recognised in") && !path("no").exists(), "{complaint}");

    let unrelated = run(&["merge", text(&one), text(&other), "--out", text(&path("none"))]);
    let complaint = String::from_utf8_lossy(&unrelated.stderr).into_owned();
    assert_eq!(unrelated.status.code(), Some(1), "{complaint}");
    assert!(complaint.contains("recognised in") && !path("none").exists(), "{complaint}");

    let complaint = refused(&["merge", text(&one), text(&two), "--out", text(&one)]);
    assert!(complaint.contains("is one of the maps"), "{complaint}");
    fs::remove_file(two.join("clouds/000001.pcd")).expect("the file exists");
    let complaint = refused(&["merge", text(&one), text(&two), "--out", text(&out)]);
    assert!(complaint.contains("make the map again"), "{complaint}");
    fs::write(two.join("graph.g2o"), "VERTEX_SE3:QUAT 0 0 0").expect("writable");
    let complaint = refused(&["merge", text(&one), text(&two), "--out", text(&out)]);
    assert!(complaint.contains("graph.g2o"), "{complaint}");
    assert!(keyframes(&out) > 0, "the earlier result is unchanged");
}
