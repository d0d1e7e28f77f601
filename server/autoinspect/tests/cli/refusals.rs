//! Tests of invalid input and usage: one sentence, exit code 2 and no panic.

use crate::program::{data, refused, text};
use std::fs;

#[test]
fn invalid_input_is_rejected_with_one_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let write = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        fs::write(&path, bytes).expect("writable");
        path
    };
    fs::create_dir(dir.path().join("empty")).expect("made");
    let pcd_of = |points: &str, rows: &str| {
        format!(
            "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {points}\nHEIGHT 1\n\
             VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA ascii\n{rows}"
        )
    };
    let inputs = [
        dir.path().join("missing.mcap"),
        dir.path().join("empty"),
        write("empty.mcap", b""),
        write("empty.bag", b""),
        write("text.mcap", b"this is no recording"),
        write("magic.mcap", b"\x89MCAP0\r\n"),
        write("magic.bag", b"#ROSBAG V2.0\n"),
        write("cut.bag", b"#ROSBAG V2.0\n\x45\x00\x00\x00\x0a"),
        write("absurd.bag", b"#ROSBAG V2.0\n\xff\xff\xff\x7f\x00\x00\x00\x00"),
        write("no.db3", b"SQLite format 3\0"),
        write("picture.png", b"\x89PNG\r\n\x1a\n"),
        write("none.pcd", pcd_of("0", "").as_bytes()),
        write("nan.pcd", pcd_of("1", "nan nan nan\n").as_bytes()),
        write("few.pcd", pcd_of("1000000000", "1 2 3\n").as_bytes()),
        write("words.pcd", pcd_of("1", "one two three\n").as_bytes()),
        write(
            "fields.pcd",
            b"VERSION 0.7\nFIELDS a b\nSIZE 4 4\nTYPE F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2\n",
        ),
        write(
            "cut.ply",
            b"ply\nformat binary_little_endian 1.0\nelement vertex 10\nproperty float x\nend_header\n",
        ),
        write("absurd.ply", b"ply\nformat ascii 1.0\nelement vertex 99999999999999\nend_header\n"),
        write("odd.bin", &[0; 17]),
    ];
    let out = dir.path().join("out");
    for input in &inputs {
        let complaint = refused(&["map", text(input), "--out", text(&out)]);
        let sentences = complaint.lines().filter(|line| line.starts_with("error:")).count();
        assert_eq!(sentences, 1, "{}: {complaint}", input.display());
    }
}

#[test]
fn real_malformed_files_are_rejected_with_one_sentence() {
    let Some(folder) = data("map-import/malformed") else { return };
    let dir = tempfile::tempdir().expect("temporary directory");
    for entry in fs::read_dir(folder).expect("readable") {
        let path = entry.expect("readable").path();
        refused(&["map", text(&path), "--out", text(&dir.path().join("out"))]);
    }
}

#[test]
fn truncated_recordings_are_rejected_or_read_to_their_end() {
    let Some(bag) = data("bags/ouster_ros1_in_mcap.mcap") else { return };
    let bytes = fs::read(bag).expect("readable");
    let dir = tempfile::tempdir().expect("temporary directory");
    for part in [1, 2, 5, 9] {
        let path = dir.path().join(format!("cut{part}.mcap"));
        fs::write(&path, &bytes[..bytes.len() * part / 10]).expect("writable");
        let output = crate::program::run(&["info", text(&path)]);
        assert!(matches!(output.status.code(), Some(0 | 2)), "{output:?}");
    }
}

#[test]
fn bad_usage_is_rejected_with_a_remedy() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let out = dir.path().join("x");
    let cases: [(&[&str], &str); 10] = [
        (&["up", "--robot", "sim:moon"], "torus"),
        (&["up", "--robot", "fred"], "sim:SITE"),
        (&["up", "--robot", "socket:none", "--day", "2"], "--day changes a simulated site"),
        (&["sim", "record", "--site", "no.glb", "--out", text(&out)], "no.glb: it cannot be read"),
        (&["up", "--speed", "0"], "greater than 0"),
        (&["sim", "record", "--site", "b1", "--out", text(&out), "--route", "long"], "short"),
        (&["sim", "record", "--site", "b1", "--out", text(&out), "--faults", "fog@1-2"], "blind-lidar"),
        (&["map", "x.mcap", "--out", text(&out), "--topic", "radar=/x"], "lidar"),
        (&["trajectory", "compare", "no.tum", "no.tum"], "no.tum"),
        (&["replay", "no.mcap"], "no.mcap"),
    ];
    for (arguments, advice) in cases {
        let complaint = refused(arguments);
        assert!(complaint.contains(advice), "{arguments:?}: {complaint}");
    }
}

#[test]
fn a_folder_with_other_files_is_not_written_to() {
    let Some(bag) = data("hilti-uzh-run2/bag") else { return };
    let dir = tempfile::tempdir().expect("temporary directory");
    fs::write(dir.path().join("thesis.tex"), "years of work").expect("writable");
    let complaint = refused(&["map", text(&bag), "--out", text(dir.path())]);
    assert!(complaint.contains("holds other things"), "{complaint}");
    assert_eq!(fs::read_dir(dir.path()).expect("readable").count(), 1);
}
