//! Descriptions of gauges.

use crate::assert_sentence;
use gauges::{GaugeConfig, GaugeReading, Picture, read_gauge, read_slanted_gauge};

/// Width and height of the picture in which the described gauge is read, pixels: small, so that the fuzzer tries many descriptions.
const SIDE_PX: usize = 48;

/// The JSON file that describes gauges. What is described is read in a picture of a dark needle on a light dial.
///
/// # Panics
/// When what is read is no number, or lies outside the scale.
pub fn gauge(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let gauge = match gauge_file::parse(text, None) {
        Ok(gauge) => gauge,
        Err(error) => return assert_sentence(&error),
    };
    let config = GaugeConfig::default();
    let reading = match &gauge.marks {
        Some(marks) => read_slanted_gauge(&picture(), marks, &config),
        None => read_gauge(&picture(), &gauge.dial, &config),
    };
    match &reading {
        Ok(GaugeReading::Read { value, uncertainty, direction_rad, tip_px, quality, .. }) => {
            let numbers = [*value, *uncertainty, *direction_rad, tip_px[0], tip_px[1], *quality];
            assert!(numbers.iter().all(|number| number.is_finite()), "{reading:?}");
            let [first, last] = gauge.dial.range;
            assert!((first.min(last)..=first.max(last)).contains(value), "{reading:?}");
        }
        Ok(GaugeReading::Unsure { .. } | GaugeReading::TooSmall { .. }) => {}
        Err(error) => assert_sentence(error),
    }
}

/// A light dial with a dark needle that points up to the right.
fn picture() -> Picture {
    let middle = SIDE_PX as f64 / 2.0;
    let pixel = |index: usize| {
        let (x, y) = ((index % SIDE_PX) as f64 - middle, middle - (index / SIDE_PX) as f64);
        let is_needle = x > 0.0 && (x - y).abs() < 2.0 && x.hypot(y) < 0.7 * middle;
        [if is_needle { 20 } else { 230 }; 3]
    };
    let pixels = (0..SIDE_PX * SIDE_PX).map(pixel).collect();
    Picture::new([SIDE_PX; 2], pixels).expect("there are as many pixels as its sides say")
}
