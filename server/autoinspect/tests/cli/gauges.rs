//! Tests of `autoinspect gauge`: dials in recorded pictures.

use crate::program::{data, json, refused, run, text};
use serde_json::Value;
use std::fs;

/// A row of the data's truth: file, gauge, value.
fn truth(table: &str) -> Vec<(String, String, f64)> {
    let row = |line: &str| {
        let mut words = line.split(',');
        let (file, gauge) = (words.next()?.to_owned(), words.next()?.to_owned());
        Some((file, gauge, words.nth(1)?.parse().ok()?))
    };
    table.lines().skip(1).filter_map(row).collect()
}

#[test]
fn recorded_dials_are_read_and_those_that_cannot_be_are_said_to_be_unsure() {
    let Some(gauges) = data("gauges") else { return };
    let rows = truth(&fs::read_to_string(gauges.join("truth.csv")).expect("truth"));
    let description = gauges.join("gauge.json");
    let (mut right, mut wrong, mut unsure) = (0_usize, Vec::new(), 0_usize);
    for (file, gauge, value) in &rows {
        let picture = gauges.join(file);
        let read = json(&["gauge", text(&picture), "--gauge", text(&description), "--name", gauge]);
        match read["result"].as_str() {
            Some("read") => {
                // The digit of a meter goes round from 10 to 0.
                let off = (read["value"].as_f64().expect("a value") - value + 5.0).rem_euclid(10.0) - 5.0;
                if off.abs() <= 0.2 { right += 1 } else { wrong.push(format!("{file}: {value}, {read}")) }
            }
            Some("unsure") => unsure += 1,
            _ => panic!("{file}: {read}"),
        }
    }
    println!("{right} of {} dials right, {} wrong, {unsure} unsure", rows.len(), wrong.len());
    assert!(
        !rows.is_empty() && right as f64 >= 0.95 * rows.len() as f64,
        "{right} right, {unsure} unsure, {wrong:#?}"
    );
    assert!(wrong.len() as f64 <= 0.02 * rows.len() as f64, "{wrong:#?}");
}

/// A PNG file of a white dial with a black needle that points to the right, 100 pixels wide.
fn drawn_dial() -> Vec<u8> {
    picture([100, 100], |column, row| {
        let is_needle = (45..85).contains(&column) && (row - 50).abs() <= 2;
        if is_needle { 20 } else { 230 }
    })
}

/// A PNG file of a wall of stones with a dial, 240 x 180 pixels. The dial is 60 pixels wide, and its needle points to the right or up. `moved_px`: where the camera has moved.
fn wall_with_dial(moved_px: i32, is_upright: bool) -> Vec<u8> {
    picture([240, 180], |column, row| {
        let (x, y) = (column + moved_px, row + moved_px / 2);
        let (from_axis, from_axis_down) = (x - 120, y - 90);
        if from_axis.pow(2) + from_axis_down.pow(2) > 30_i32.pow(2) {
            // Stones of 13 pixels, each with a brightness of its own.
            let stone = (x.div_euclid(13) * 31 + y.div_euclid(13) * 17).rem_euclid(23);
            return 60 + 5 * stone as u8;
        }
        let (along, across) =
            if is_upright { (-from_axis_down, from_axis) } else { (from_axis, from_axis_down) };
        if (-2..26).contains(&along) && across.abs() <= 1 { 20 } else { 230 }
    })
}

/// A grey PNG file.
fn picture([width, height]: [i32; 2], brightness: impl Fn(i32, i32) -> u8) -> Vec<u8> {
    let places = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
    let pixels: Vec<u8> = places.flat_map(|(column, row)| [brightness(column, row); 3]).collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().expect("written").write_image_data(&pixels).expect("written");
    file
}

#[test]
fn a_gauge_is_read_by_name_and_bad_input_gets_a_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let write = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        fs::write(&path, bytes).expect("written");
        path
    };
    let picture = write("dial.png", &drawn_dial());
    let boiler = r#"{"centre": [50, 50], "zero_tick": [18, 82], "end_tick": [82, 82], "range": [0, 6], "unit": "bar"}"#;
    let one = write("one.json", format!(r#"{{"dials": {{"boiler": {boiler}}}}}"#).as_bytes());
    let read = json(&["gauge", text(&picture), "--gauge", text(&one)]);
    assert_eq!(
        (&read["result"], &read["unit"], &read["gauge"]),
        (&"read".into(), &"bar".into(), &"boiler".into())
    );
    assert!((read["value"].as_f64().expect("a value") - 5.0).abs() < 0.1, "{read}");
    let printed = run(&["gauge", text(&picture), "--gauge", text(&one), "--name", "boiler"]);
    assert_eq!(serde_json::from_slice::<Value>(&printed.stdout).expect("JSON without --json too"), read);
    let refused_with = |picture: &str, gauge: &str, name: &[&str], part: &str| {
        let sentence = refused(&[&["gauge", picture, "--gauge", gauge], name].concat());
        assert!(sentence.contains(part), "{sentence}");
    };
    refused_with(
        text(&picture),
        text(&one),
        &["--name", "pump"],
        "describes no gauge 'pump'; it has: boiler",
    );
    let two = write("two.json", format!(r#"{{"dials": {{"a": {boiler}, "b": {boiler}}}}}"#).as_bytes());
    refused_with(text(&picture), text(&two), &[], "choose one with --name: a, b");
    refused_with(text(&picture), text(&write("none.json", br#"{"dials": {}}"#)), &[], "describes no gauges");
    refused_with(text(&picture), text(&write("no.json", b"{")), &[], "no.json could not be read");
    let cut = write("cut.png", &drawn_dial()[..60]);
    refused_with(text(&cut), text(&one), &[], "cut.png");
    let no_end = write("cut.jpg", b"\xff\xd8\xff\xe0\x00\x10JFIF");
    refused_with(text(&no_end), text(&one), &[], "cut.jpg is cut short");
    refused_with(text(&one), text(&one), &[], "neither a JPEG nor a PNG nor a BMP");
    refused_with(text(&dir.path().join("missing.jpg")), text(&one), &[], "missing.jpg could not be read");
    let sized = boiler.replace(r#""range""#, r#""image_size": [193, 193], "range""#);
    let sized = write("sized.json", format!(r#"{{"dials": {{"boiler": {sized}}}}}"#).as_bytes());
    refused_with(text(&picture), text(&sized), &[], "is 100 x 100 pixels");
}

#[test]
fn a_gauge_that_was_described_in_another_picture_is_read_where_it_is_now() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let write = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        fs::write(&path, bytes).expect("written");
        path
    };
    let monday = write("monday.png", &wall_with_dial(0, false));
    let tuesday = write("tuesday.png", &wall_with_dial(14, true));
    let description = write(
        "gauge.json",
        br#"{"dials": {"boiler": {"centre": [120, 90], "zero_tick": [99, 111], "end_tick": [141, 111], "range": [0, 6], "unit": "bar"}}}"#,
    );
    let read =
        json(&["gauge", text(&tuesday), "--gauge", text(&description), "--described-in", text(&monday)]);
    assert_eq!(read["result"], "read", "{read}");
    assert!((read["value"].as_f64().expect("a value") - 3.0).abs() < 0.1, "{read}");
    let axis = [106.0, 83.0];
    for (index, px) in axis.into_iter().enumerate() {
        assert!((read["axis_px"][index].as_f64().expect("a pixel") - px).abs() < 1.0, "{read}");
    }
    assert!(read["alignment_residual_px"].as_f64().is_some_and(|residual_px| residual_px < 1.5), "{read}");
    // Without the earlier picture the dial is sought where it was.
    let where_it_was = json(&["gauge", text(&tuesday), "--gauge", text(&description)]);
    assert_ne!(where_it_was["value"].as_f64().map(f64::round), Some(3.0), "{where_it_was}");
    // Two pictures that show nothing of the same.
    let other =
        write("other.png", &picture([240, 180], |column, row| ((column * column + 7 * row) % 251) as u8));
    let not_aligned =
        json(&["gauge", text(&other), "--gauge", text(&description), "--described-in", text(&monday)]);
    assert_eq!(not_aligned["result"], "not_aligned", "{not_aligned}");
    let small = write("small.png", &drawn_dial());
    let sentence =
        refused(&["gauge", text(&small), "--gauge", text(&description), "--described-in", text(&monday)]);
    assert!(sentence.contains("small.png is 100 x 100 pixels"), "{sentence}");
}

#[test]
fn a_recorded_picture_that_is_cut_anywhere_is_refused() {
    let Some(gauges) = data("gauges") else { return };
    let whole = fs::read(gauges.join("dials/o_001.jpg")).expect("a picture");
    let dir = tempfile::tempdir().expect("temporary directory");
    let description = gauges.join("gauge.json");
    for share in [0.05, 0.3, 0.6, 0.9, 0.99] {
        let cut = dir.path().join("cut.jpg");
        fs::write(&cut, &whole[..(whole.len() as f64 * share) as usize]).expect("written");
        let sentence =
            refused(&["gauge", text(&cut), "--gauge", text(&description), "--name", "zeiger3_201911_193"]);
        assert!(sentence.contains("cut.jpg is cut short"), "{share}: {sentence}");
    }
}
