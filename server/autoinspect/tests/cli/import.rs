//! Tests of `autoinspect import`: a point cloud of another program becomes a map.

use crate::program::{data, json, program, refused, text};
use std::fmt::Write as _;
use std::fs;
use std::process::Stdio;

/// A room of 8 x 6 m, 2.6 m high, with a table and a point every 0.1 m, far from the origin and with y up. PLY.
fn room() -> String {
    room_with_table_at(2.0)
}

/// The same room with its table elsewhere, so that it becomes another map.
pub fn room_with_table_at(x: f64) -> String {
    let mut points = Vec::new();
    let mut plane = |corner: [f64; 3], u: [f64; 3], v: [f64; 3], long: usize, high: usize| {
        for i in 0..=long {
            for j in 0..=high {
                let (s, t) = (i as f64 / long as f64, j as f64 / high as f64);
                let [x, y, z]: [f64; 3] =
                    std::array::from_fn(|axis| corner[axis] + u[axis] * s + v[axis] * t);
                points.push([x + 450_000.0, z, 5_400_000.0 - y]);
            }
        }
    };
    for z in [0.0, 2.6] {
        plane([0.0, 0.0, z], [8.0, 0.0, 0.0], [0.0, 6.0, 0.0], 80, 60);
    }
    for y in [0.0, 6.0] {
        plane([0.0, y, 0.0], [8.0, 0.0, 0.0], [0.0, 0.0, 2.6], 80, 26);
    }
    for x in [0.0, 8.0] {
        plane([x, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 2.6], 60, 26);
    }
    plane([x, 4.0, 0.8], [1.4, 0.0, 0.0], [0.0, 0.8, 0.0], 14, 8);
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\nend_header\n",
        points.len()
    );
    for [x, y, z] in points {
        writeln!(text, "{x:.3} {y:.3} {z:.3}").expect("writing to a string cannot fail");
    }
    text
}

#[test]
fn an_imported_cloud_is_a_map_like_any_other() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = |name: &str| dir.path().join(name);
    fs::write(path("room.ply"), room()).expect("writable");
    let [file, out, again, store] = ["room.ply", "m", "again", "data"].map(path);
    let report = json(&["import", text(&file), "--out", text(&out)]);
    assert_eq!((&report["up"], &report["name"], &report["scans"]), (&"y".into(), &"room".into(), &1.into()));
    assert_eq!(report["offset"], serde_json::json!([450_000.0, 0.0, 5_400_000.0]));
    let bounds = |corner: usize, axis: usize| report["bounds"][corner][axis].as_f64().expect("a number");
    assert!((bounds(1, 2) - bounds(0, 2) - 2.6).abs() < 1e-3, "{report}");
    let places = report["places"].as_u64().expect("a number");
    assert!((8..60).contains(&places), "{report}");
    // It is a map like any other, and the same file gives the same map.
    let exported = json(&["export", text(&out), "--out", text(&path("room.laz"))]);
    assert!(exported["points"].as_u64() > Some(1_000), "{exported}");
    json(&["import", text(&file), "--out", text(&again)]);
    let graph = |map: &std::path::Path| fs::read(map.join("graph.json")).expect("readable");
    assert_eq!(graph(&out), graph(&again));
    // One file has the clouds of all viewpoints, and the map states that it has no pose graph.
    let clouds = fs::read_dir(out.join("clouds")).expect("readable").count();
    let document = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&fs::read(out.join(name)).expect("readable")).expect("JSON")
    };
    assert_eq!((clouds, &document("map.json")["has_pose_graph"]), (1, &false.into()));
    assert!(document("tiles.json")["robust_bounds"]["min"][0].is_number());
    // Aligned with an equal map by picked points, it is the same map again.
    let aligned = path("aligned");
    let pairs = ["0,0,0=1,0,0", "2,0,0=3,0,0"];
    let [map, onto, to] = [&out, &again, &aligned].map(|path| text(path));
    json(&["align", map, "--onto", onto, "--out", to, "--pair", pairs[0], "--pair", pairs[1]]);
    let moved = json(&["export", to, "--out", text(&path("aligned.ply")), "--spacing", "0"]);
    let whole = json(&["export", map, "--out", text(&path("whole.ply")), "--spacing", "0"]);
    assert_eq!(moved["points"], whole["points"]);
    // A platform's data directory accepts it only once.
    let added = json(&["import", text(&file), "--data", text(&store), "--name", "Room"]);
    assert_eq!(added["name"], "Room");
    assert!(fs::read_dir(store.join("maps")).expect("readable").count() == 1);
    let taken = crate::program::run(&["import", text(&file), "--data", text(&store)]);
    assert_eq!(taken.status.code(), Some(1), "{}", String::from_utf8_lossy(&taken.stderr));
}

#[test]
fn other_files_are_rejected_with_one_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let out = dir.path().join("m");
    let write = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        fs::write(&path, bytes).expect("writable");
        path
    };
    let mut inputs = vec![
        dir.path().join("missing.las"),
        write("empty.las", b""),
        write("short.las", b"LASF"),
        write("words.ptx", b"these are words\n"),
        write("none.e57", b"ASTM-E57"),
    ];
    if let Some(folder) = data("map-import") {
        inputs.extend(["empty.e57", "malformed/corrupt_crc.e57"].map(|name| folder.join(name)));
        inputs.push(folder.join("malformed/garbage_nVariableLength.las"));
    }
    for input in &inputs {
        let complaint = refused(&["import", text(input), "--out", text(&out)]);
        let sentences = complaint.lines().filter(|line| line.starts_with("error:")).count();
        assert_eq!(sentences, 1, "{}: {complaint}", input.display());
        assert!(!out.exists());
    }
    refused(&["import", text(&inputs[0])]);
}

/// The header of a LAS 1.2 file of points of 20 bytes that begin after it, with a step of 1 mm.
fn las_header(points: u32) -> Vec<u8> {
    let mut header = vec![0; 227];
    header[..4].copy_from_slice(b"LASF");
    header[24..26].copy_from_slice(&[1, 2]);
    header[94..96].copy_from_slice(&227_u16.to_le_bytes());
    header[96..100].copy_from_slice(&227_u32.to_le_bytes());
    header[105..107].copy_from_slice(&20_u16.to_le_bytes());
    header[107..111].copy_from_slice(&points.to_le_bytes());
    for axis in 0..3 {
        header[131 + 8 * axis..139 + 8 * axis].copy_from_slice(&0.001_f64.to_le_bytes());
    }
    header
}

/// A floor of `edge` times `edge` points, 10 cm apart, as LAS.
fn floor(edge: i32) -> Vec<u8> {
    let mut file = las_header((edge * edge) as u32);
    for x in 0..edge {
        for y in 0..edge {
            file.extend([100 * x, 100 * y, 0].map(i32::to_le_bytes).concat());
            file.extend([0; 8]);
        }
    }
    file
}

mod nightly {
    use super::las_header;
    use crate::program::{json, text};
    use std::fs;
    use std::io::{BufWriter, Write};

    /// Halls of 60 m x 60 m above each other, a point every 3 cm, as many points as an import takes: no wall hides any of them from a viewpoint. The memory of an import is a limit of the system, so that it ends beyond it.
    #[test]
    fn dense_floors_of_the_most_points_fit_the_memory() {
        const POINTS: i32 = 8_000_000;
        const EDGE: i32 = 2_000;
        let dir = tempfile::tempdir().expect("temporary directory");
        let (file, out) = (dir.path().join("halls.las"), dir.path().join("m"));
        let mut writer = BufWriter::new(fs::File::create(&file).expect("writable"));
        writer.write_all(&las_header(POINTS as u32)).expect("written");
        for point in 0..POINTS {
            let (hall, of_hall) = (point / (EDGE * EDGE), point % (EDGE * EDGE));
            let position = [30 * (of_hall % EDGE), 30 * (of_hall / EDGE), 3_000 * hall];
            let mut record = position.map(i32::to_le_bytes).concat();
            record.extend((point as u16 & 1_023).to_le_bytes());
            record.extend([0; 6]);
            writer.write_all(&record).expect("written");
        }
        writer.into_inner().expect("written").sync_all().expect("written");
        let report = json(&["import", text(&file), "--out", text(&out)]);
        assert_eq!(report["points"].as_u64(), Some(POINTS as u64));
        let (places, memory) = (report["places"].as_u64(), report["memory_bytes"].as_u64());
        eprintln!("{places:?} viewpoints, peak {memory:?} bytes");
        assert!(places > Some(1_000) && memory < Some(512 << 20), "{report}");
    }
}

/// The only sentence of an import that fails.
fn complaint(arguments: &[&str]) -> String {
    let output = crate::program::run(arguments);
    assert!(!output.status.success());
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    let sentences: Vec<&str> = errors.lines().filter_map(|line| line.strip_prefix("error: ")).collect();
    assert_eq!(sentences.len(), 1, "{errors}");
    sentences[0].to_owned()
}

#[test]
fn a_survey_beyond_a_limit_ends_with_a_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let out = dir.path().join("m");
    // 100 million points, of which the disk holds the header only.
    let huge = dir.path().join("huge.las");
    fs::write(&huge, las_header(100_000_000)).expect("writable");
    let complaint_of = |file: &std::path::Path, options: &[&str]| {
        let sentence = complaint(&[&["import", text(file), "--out", text(&out)], options].concat());
        assert!(!out.join("map.json").exists());
        sentence
    };
    assert!(complaint_of(&huge, &[]).contains("cut off"));
    let file = fs::OpenOptions::new().write(true).open(&huge).expect("opens");
    file.set_len(227 + 20 * 100_000_000).expect("a sparse file");
    let sentence = complaint_of(&huge, &[]);
    assert!(sentence.contains("more than 8000000 points") && sentence.contains("thin it"), "{sentence}");
    // Without that limit it meets that of memory.
    let sentence = complaint_of(&huge, &["--max-points", "200000000"]);
    assert!(sentence.contains("more than 512 MB of memory") && sentence.contains("thin"), "{sentence}");
    // Viewpoints take memory and time too.
    let wide = dir.path().join("wide.las");
    fs::write(&wide, floor(1_000)).expect("writable");
    let sentence = complaint_of(&wide, &["--max-memory", "64"]);
    assert!(sentence.contains("more than 64 MB of memory"), "{sentence}");
    let sentence = complaint_of(&wide, &["--max-minutes", "0.01"]);
    assert!(sentence.contains("more than 0.01 minutes of processor time"), "{sentence}");
    refused(&["import", text(&wide), "--out", text(&out), "--max-memory", "1"]);
}

#[test]
fn an_import_in_the_background_ends_with_the_program_that_started_it() {
    let dir = tempfile::tempdir().expect("temporary directory");
    // Nobody writes into this pipe, so that the import never gets further.
    let pipe = dir.path().join("pipe");
    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).expect("made");
    let mut import = program()
        .args(["import", text(&pipe), "--out", text(&dir.path().join("m")), "--background"])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("starts");
    assert!(import.try_wait().expect("known").is_none());
    // As the system does when that program is killed.
    drop(import.stdin.take());
    assert_eq!(import.wait().expect("ends").code(), Some(1));
}
