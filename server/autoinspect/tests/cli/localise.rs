//! Tests of `autoinspect localise`: another walk in a known map.

use crate::program::{json, refused, run, text};
use std::path::Path;

/// Records a simulated walk in the test hall, with coarse scans to save time.
fn walk(out: &Path, seed: &str) {
    let fixed = ["sim", "record", "--site", "b1", "--columns", "200", "--people", "1", "--minutes", "0.3"];
    json(&[&fixed[..], &["--seed", seed, "--out", text(out)]].concat());
}

#[test]
fn another_walk_is_localised_in_the_map_of_the_first() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = |name: &str| dir.path().join(name);
    let [first, second, map, found] = ["first.mcap", "second.mcap", "m", "found.tum"].map(path);
    walk(&first, "3");
    walk(&second, "4");
    json(&["map", text(&first), "--out", text(&map)]);
    let report = json(&["localise", text(&second), "--map", text(&map), "--out", text(&found)]);
    let count = |name: &str| report[name].as_u64().expect("a count");
    assert!(count("localised") * 10 > count("scans") * 8 && count("lost") == 0, "{report}");
    assert!(report["found_after"].as_f64() < Some(3.0), "{report}");
    let error = json(&["trajectory", "compare", text(&second), text(&found)]);
    assert!(error["ape_m"]["rmse"].as_f64() < Some(0.03), "{error}");

    // The other walk began at the same pose.
    let report = json(&[
        "localise",
        text(&second),
        "--map",
        text(&map),
        "--out",
        text(&found),
        "--initial",
        "0.2,-0.1,0,3",
    ]);
    assert!(report["found_after"].as_f64() < Some(2.0), "{report}");
    refused(&["localise", text(&second), "--map", text(&path("none")), "--out", text(&found)]);
    refused(&["localise", text(&second), "--map", text(&map), "--out", text(&found), "--initial", "1,2"]);
    let nowhere = run(&["localise", text(&second), "--map", text(&map), "--out", text(&path("a/b.tum"))]);
    assert_eq!(nowhere.status.code(), Some(1));
}

mod nightly {
    use crate::program::{data, json, text};

    #[test]
    fn a_recorded_robot_is_localised_in_a_survey_of_its_hall() {
        let Some(hilti) = data("hilti-uzh-run2") else { return };
        let Some(survey) = data("map-import/hilti-uzh-prior-map.laz") else { return };
        let dir = tempfile::tempdir().expect("temporary directory");
        let [map, found, walked, laid] =
            ["m", "found.tum", "walked", "laid"].map(|name| dir.path().join(name));
        json(&["import", text(&survey), "--out", text(&map), "--spacing", "3"]);
        let bag = hilti.join("bag");
        let (truth, extrinsic) =
            (hilti.join("gt_mocap_imu_clean.tum"), hilti.join("extrinsic_estimate.json"));
        // With and without the initial pose. The LiDAR was carried by hand, above the height of the map's viewpoints.
        for initial in [&["--initial", "0,0,0,0"][..], &[]] {
            let mut localise = vec!["localise", text(&bag), "--map", text(&map), "--out", text(&found)];
            localise.extend(initial);
            let report = json(&localise);
            assert!(report["localised"].as_u64() >= Some(80), "{report}");
            let error =
                json(&["trajectory", "compare", text(&truth), text(&found), "--extrinsic", text(&extrinsic)]);
            assert!(error["ape_m"]["rmse"].as_f64() < Some(0.15), "{error}");
        }
        let report = json(&["map", text(&bag), "--out", text(&walked)]);
        assert!(report["keyframes"].as_u64() >= Some(20), "{report}");
        // Both begin at the same pose.
        let report = json(&[
            "import",
            text(&survey),
            "--out",
            text(&laid),
            "--spacing",
            "3",
            "--align-to",
            text(&walked),
        ]);
        assert!(report["aligned"]["agreed"].as_u64() >= Some(8), "{report}");
        for axis in ["x", "y", "z"] {
            let off = report["aligned"]["map_from_cloud"]["position"][axis].as_f64().expect("a number");
            assert!(off.abs() < 0.1, "{report}");
        }
    }
}
