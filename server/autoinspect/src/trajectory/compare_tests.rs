use super::*;
use clap::Parser;
use serde_json::Value;
use std::path::Path;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    args: CompareArgs,
}

fn compared(line: &[&str]) -> TrajectoryComparison {
    let args = Line::parse_from([&["compare"], line].concat()).args;
    compare(&args).expect("compares")
}

fn near(figures: ErrorStatistics, expected: &Value) {
    for (ours, name) in
        [(figures.rmse, "rmse"), (figures.mean, "mean"), (figures.median, "median"), (figures.max, "max")]
    {
        if let Some(expected) = expected.get(name).and_then(Value::as_f64) {
            assert!((ours - expected).abs() <= 2e-6, "{name}: {ours} instead of {expected}");
        }
    }
}

/// Compares with the figures of evo, an independent tool.
#[test]
fn agrees_with_evo_on_real_trajectories() {
    let Some(data) = crate::test_data::folder("trajectories") else { return };
    let text = std::fs::read_to_string(data.join("expected_evo.json")).expect("readable");
    let expected: Value = serde_json::from_str(&text).expect("JSON");
    for (name, expected) in expected["results"].as_object().expect("results") {
        let path = |name: &str| data.join(name).display().to_string();
        let (truth, estimate) = (path("freiburg1_xyz-groundtruth.txt"), path(name));
        for align in ["none", "se3", "sim3"] {
            let found = compared(&[&truth, &estimate, "--match", "nearest", "--align", align]);
            assert_eq!(found.pairs as u64, expected["pairs"].as_u64().expect("pairs"));
            near(found.ape_m, &expected[format!("ape_trans_{align}")]);
            near(found.ape_deg, &expected[format!("ape_rot_deg_{align}")]);
            if align == "none" {
                near(found.rpe_m, &expected["rpe_trans_1frame"]);
                let length = expected["ref_path_length_m"].as_f64().expect("length");
                assert!((found.truth_length_m - length).abs() < 1e-5, "{}", found.truth_length_m);
            }
        }
    }
}

/// Compares with the recording's published figures: 0.142 m and 0.125 m at the IMU, 0.072 s after each scan.
#[test]
fn the_lidar_is_compared_at_the_imu_with_the_calibration() {
    let Some(data) = crate::test_data::folder("hilti-uzh-run2") else { return };
    let path = |name: &str| data.join(name).display().to_string();
    for (name, rmse) in [("poses_fastlio_lidar.tum", 0.142), ("poses_refined_lidar.tum", 0.125)] {
        let found = compared(&[
            &path("gt_mocap_imu_clean.tum"),
            &path(name),
            "--extrinsic",
            &path("extrinsic_estimate.json"),
        ]);
        assert_eq!(found.pairs, 100);
        assert!((found.ape_m.rmse - rmse).abs() < 0.003, "{name}: {}", found.ape_m.rmse);
    }
}

#[test]
fn trajectories_of_different_runs_are_rejected_with_a_remedy() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let write = |name: &str, start: f64| -> PathBuf {
        let path = dir.path().join(name);
        let lines: Vec<String> =
            (0..5).map(|i| format!("{} {i} 0 0 0 0 0 1", start + f64::from(i))).collect();
        std::fs::write(&path, lines.join("\n")).expect("writable");
        path
    };
    let text = |path: &Path| path.display().to_string();
    let (truth, estimate) = (write("a.tum", 0.0), write("b.tum", 1000.0));
    let args = Line::parse_from(["compare", &text(&truth), &text(&estimate)]).args;
    let error = compare(&args).expect_err("nothing in common").to_string();
    assert!(error.contains("--offset"), "{error}");
}
