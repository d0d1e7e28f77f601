//! Tests of `autoinspect optimise`: published graphs reach their optima, and invalid ones are rejected.

use crate::program::{data, json, refused, text};
use std::fs;

const SQUARE: &str = "VERTEX_SE2 1 0 0 0
VERTEX_SE2 2 1.1 0 1.5
VERTEX_SE2 5 1 1.2 3.0

EDGE_SE2 1 2 1 0 1.5707963 100 0 0 100 0 1000
EDGE_SE2 2 5 1 0 1.5707963 100 0 0 100 0 1000
EDGE_SE2 1 5 1 1 3.1415927 100 0 0 100 0 1000
FIX 1
";

#[test]
fn a_small_graph_is_solved_by_every_method_and_written_with_its_edges() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (input, out) = (dir.path().join("square.g2o"), dir.path().join("out.g2o"));
    fs::write(&input, SQUARE).expect("writable");
    for options in [
        &["--method", "gauss-newton"][..],
        &["--method", "dogleg", "--start", "chordal"],
        &["--incremental"],
        &["--robust"],
        &["--information", "half-angle", "--repeats", "3"],
    ] {
        let result = json(&[&["optimise", text(&input), "--out", text(&out)], options].concat());
        assert!(result["chi2"].as_f64().expect("a number") < 1e-6, "{options:?}: {result}");
        assert_eq!((result["poses"].as_u64(), result["edges"].as_u64()), (Some(3), Some(3)));
        let written = fs::read_to_string(&out).expect("readable");
        assert_eq!(written.matches("EDGE_SE2").count(), 3);
        assert!(written.contains("VERTEX_SE2 5 ") && written.contains("FIX 1"), "{written}");
    }
}

#[test]
fn a_published_graph_reaches_its_optimum() {
    let Some(graph) = data("pose-graphs/intel.g2o") else { return };
    let dir = tempfile::tempdir().expect("temporary directory");
    let out = dir.path().join("out.g2o");
    for options in [&[][..], &["--start", "chordal"], &["--incremental"]] {
        let result = json(&[&["optimise", text(&graph), "--out", text(&out)], options].concat());
        let chi2 = result["chi2"].as_f64().expect("a number");
        assert!((chi2 / 45.004 - 1.0).abs() < 0.01, "{options:?}: {chi2}");
    }
    // The written poses are those of the optimum.
    let again = json(&["optimise", text(&out), "--out", text(&dir.path().join("again.g2o"))]);
    let initial = again["chi2_initial"].as_f64().expect("a number");
    assert!((initial / 45.004 - 1.0).abs() < 0.01, "{initial}");
}

#[test]
fn a_wrong_loop_is_reported_and_left_out() {
    let Some(graph) = data("pose-graphs/CSAIL.g2o") else { return };
    let dir = tempfile::tempdir().expect("temporary directory");
    let (input, out) = (dir.path().join("wrong.g2o"), dir.path().join("out.g2o"));
    let mut lines = fs::read_to_string(graph).expect("readable");
    lines.push_str("\nEDGE_SE2 20 700 30 -20 1 500 0 0 500 0 5000\n");
    fs::write(&input, lines).expect("writable");
    let result = json(&["optimise", text(&input), "--out", text(&out), "--robust"]);
    let rejected = result["rejected"].as_array().expect("a list");
    assert!(rejected.contains(&serde_json::json!([20, 700])), "{result}");
    assert!(!fs::read_to_string(&out).expect("readable").contains("EDGE_SE2 20 700 "));
}

#[test]
fn invalid_graphs_are_rejected_with_one_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let out = dir.path().join("out.g2o");
    let edge = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
    let odd = [
        ("empty", String::new(), "no poses"),
        ("text", "this is no graph\n".to_owned(), "line 1"),
        ("cut", "VERTEX_SE2 0 1 2\n".to_owned(), "line 1"),
        ("landmark", "VERTEX_XY 0 1 2\n".to_owned(), "VERTEX_XY"),
        ("missing", format!("VERTEX_SE2 0 0 0 0\n{edge}"), "vertex 1"),
        ("twice", "VERTEX_SE2 3 0 0 0\nVERTEX_SE2 3 0 0 0\n".to_owned(), "twice"),
        ("nan", "VERTEX_SE2 0 nan 0 0\n".to_owned(), "not finite"),
        ("information", "EDGE_SE2 0 1 1 0 0 1 0 0 -1 0 1\n".to_owned(), "negative"),
        ("self", "EDGE_SE2 4 4 1 0 0 1 0 0 1 0 1\n".to_owned(), "twice"),
        ("islands", format!("{edge}EDGE_SE2 8 9 1 0 0 1 0 0 1 0 1\n"), "vertex 8"),
        ("lonely", "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 7 0 0 0\n".to_owned(), "vertex 7"),
        ("quaternion", "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0\n".to_owned(), "vertex 0"),
        ("nothing known", "EDGE_SE2 0 1 1 0 0 0 0 0 0 0 0\n".to_owned(), "vertex"),
    ];
    for (name, content, expected) in odd {
        let input = dir.path().join(format!("{name}.g2o"));
        fs::write(&input, content).expect("writable");
        let complaint = refused(&["optimise", text(&input), "--out", text(&out)]);
        assert!(complaint.contains(expected), "{name}: {complaint}");
        assert_eq!(
            complaint.lines().filter(|line| line.starts_with("error:")).count(),
            1,
            "{name}: {complaint}"
        );
    }
    refused(&["optimise", text(&dir.path().join("not there.g2o")), "--out", text(&out)]);
    refused(&["optimise", "x.g2o", "--out", text(&out), "--robust", "--incremental"]);
    assert!(!out.exists());
}
