//! Tests of `autoinspect picture-changes`: drawn pictures.

use crate::program::{json, refused, run, text};
use std::fs;

/// A PNG file of a wall with tiles of different sizes, displaced to the right, with a red thing or without.
fn wall(displaced_px: i32, has_thing: bool) -> Vec<u8> {
    let (width, height) = (160_i32, 120_i32);
    let mut pixels = Vec::new();
    for row in 0..height {
        for column in 0..width {
            let x = column - displaced_px + 1_000;
            let is_tile = ((x / 23) + (row / 17)) % 2 == 0 || (x % 41 < 6 && row % 29 < 9);
            let is_thing = has_thing && (1_070..1_085).contains(&x) && (50..65).contains(&row);
            let grey = if is_tile { 180 } else { 90 };
            pixels.extend(if is_thing { [200, 30, 30] } else { [grey; 3] });
        }
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width.unsigned_abs(), height.unsigned_abs());
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().expect("written").write_image_data(&pixels).expect("written");
    file
}

#[test]
fn a_thing_that_is_new_is_found_and_bad_input_gets_a_sentence() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let write = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        fs::write(&path, bytes).expect("written");
        path
    };
    let before = write("before.png", &wall(0, false));
    let moved = write("moved.png", &wall(5, false));
    let same = json(&["picture-changes", text(&before), text(&moved)]);
    assert_eq!(same["aligned"], true, "{same}");
    assert_eq!(same["changes"].as_array().map(Vec::len), Some(0), "{same}");
    let right = same["after_from_before"][0][2].as_f64().expect("a number");
    assert!((right - 5.0).abs() < 0.5, "{same}");
    assert!(same["residual_px"].as_f64().is_some_and(|residual| residual < 1.0), "{same}");
    let after = write("after.png", &wall(5, true));
    let changed = json(&["picture-changes", text(&before), text(&after)]);
    let region = &changed["changes"][0];
    let side = |key: &str| region[key][0].as_u64().expect("a column");
    assert!((68..=76).contains(&side("min_px")) && (78..=87).contains(&side("max_px")), "{changed}");
    let printed =
        String::from_utf8(run(&["picture-changes", text(&before), text(&after)]).stdout).expect("text");
    assert!(
        printed.starts_with("aligned, with a residual of") && printed.contains("\nchanged: columns"),
        "{printed}"
    );

    let out = dir.path().join("compared");
    run(&["picture-changes", text(&before), text(&after), "--out", text(&out)]);
    let written = fs::read(out.join("picture-changes.json")).expect("written");
    let written: serde_json::Value = serde_json::from_slice(&written).expect("JSON");
    assert_eq!(written, changed);
    let aligned = fs::File::open(out.join("aligned.png")).expect("written");
    let mut reader = png::Decoder::new(std::io::BufReader::new(aligned)).read_info().expect("PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).expect("whole");
    let pixel = |x: usize, y: usize| &pixels[3 * (160 * y + x)..][..3];
    let frame = (60..100).find(|x| pixel(*x, 57) == [255, 211, 61]).expect("a frame left of the thing");
    assert!((66..=76).contains(&frame), "{frame}");
    // The wall of the earlier picture is drawn 5 pixels further right; there is nothing of it on the left.
    assert_eq!(pixel(1, 60), [40, 40, 40]);
    let predicted = "1,0,5,0,1,0,0,0,1";
    let guided = json(&["picture-changes", text(&before), text(&moved), "--predicted", predicted]);
    assert!(guided["after_from_before"][0][2].as_f64().is_some_and(|right| (right - 5.0).abs() < 0.5));

    let refused_with = |before: &str, after: &str, part: &str| {
        let sentence = refused(&["picture-changes", before, after]);
        assert!(sentence.contains(part), "{sentence}");
    };
    let whole = wall(0, false);
    let cut = write("cut.png", &whole[..whole.len() / 2]);
    refused_with(text(&before), text(&cut), "cut.png");
    let none = write("none.png", b"no picture");
    refused_with(text(&none), text(&after), "neither a JPEG nor a PNG nor a BMP");
    refused_with(text(&before), text(&dir.path().join("missing.png")), "missing.png could not be read");
    let mut small = Vec::new();
    let mut encoder = png::Encoder::new(&mut small, 20, 20);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().expect("written").write_image_data(&[90; 1_200]).expect("written");
    let small = write("small.png", &small);
    refused_with(text(&before), text(&small), "give two pictures of the same camera and size");
    refused_with(text(&small), text(&small), "too small");
    let sentence =
        refused(&["picture-changes", text(&before), text(&after), "--predicted", "0,0,0,0,0,0,0,0,0"]);
    assert!(sentence.contains("has no inverse"), "{sentence}");
}
