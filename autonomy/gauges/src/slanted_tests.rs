//! Drawn dials that are seen from the side.

use super::*;

const SIZE_PX: [usize; 2] = [200, 160];
const CENTRE_PX: [f64; 2] = [98.0, 83.0];
const RADIUS_PX: f64 = 60.0;
const HALF_SWEEP_RAD: f64 = 2.356;

/// A point of the dial, turned in the picture by 0.2 rad and narrowed by `narrowed`. `angle_rad`: clockwise from the middle of the scale.
fn place(narrowed: f64, angle_rad: f64, radius_px: f64) -> [f64; 2] {
    let (right, up) = (narrowed * radius_px * angle_rad.sin(), radius_px * angle_rad.cos());
    let (sine, cosine) = 0.2_f64.sin_cos();
    [CENTRE_PX[0] + cosine * right + sine * up, CENTRE_PX[1] + sine * right - cosine * up]
}

/// A white picture with a red needle at this value of 0 to 10.
fn drawn(narrowed: f64, value: f64) -> Picture {
    let angle_rad = HALF_SWEEP_RAD * (value / 5.0 - 1.0);
    let mut pixels = vec![[225_u8; 3]; SIZE_PX[0] * SIZE_PX[1]];
    for step in 0..2_000 {
        let along_px = -12.0 + 66.0 * f64::from(step) / 2_000.0;
        for across in -2..=2 {
            let at = place(narrowed, angle_rad + f64::from(across) * 0.4 / along_px.abs().max(6.0), along_px);
            pixels[at[1].round() as usize * SIZE_PX[0] + at[0].round() as usize] = [190, 30, 30];
        }
    }
    Picture::new(SIZE_PX, pixels).expect("a picture")
}

fn marks(narrowed: f64) -> DialMarks {
    let at = |angle_rad| place(narrowed, angle_rad, RADIUS_PX);
    DialMarks {
        centre_px: CENTRE_PX,
        start_px: at(-HALF_SWEEP_RAD),
        middle_px: at(0.0),
        end_px: at(HALF_SWEEP_RAD),
        range: [0.0, 10.0],
    }
}

fn value_of(reading: GaugeReading) -> f64 {
    match reading {
        GaugeReading::Read { value, .. } => value,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_needle_is_read_within_one_and_a_half_percent_whatever_the_slant() {
    for narrowed in [1.0, 0.9, 0.7, 0.5] {
        for value in [0.4, 1.7, 3.1, 5.0, 6.6, 8.2, 9.8] {
            let picture = drawn(narrowed, value);
            let read =
                read_slanted_gauge(&picture, &marks(narrowed), &GaugeConfig::default()).expect("a dial");
            assert!((value_of(read) - value).abs() < 0.15, "{narrowed} {value}: {read:?}");
        }
    }
    // As a circle the same dial is read wrongly.
    let DialMarks { centre_px, start_px, end_px, range, .. } = marks(0.5);
    let [start_rad, end_rad] = [start_px, end_px].map(|end| Dial::direction_rad(centre_px, end));
    let sweep_rad = (end_rad - start_rad).rem_euclid(TAU);
    let circle = Dial { centre_px, axis_px: centre_px, radius_px: 40.0, start_rad, sweep_rad, range };
    let read = read_gauge(&drawn(0.5, 1.7), &circle, &GaugeConfig::default()).expect("a dial");
    assert!((value_of(read) - 1.7).abs() > 0.3, "{read:?}");
}

#[test]
fn the_tip_is_where_it_is_in_the_picture_and_a_scale_may_run_the_other_way() {
    let picture = drawn(0.7, 3.1);
    let read = read_slanted_gauge(&picture, &marks(0.7), &GaugeConfig::default()).expect("a dial");
    let GaugeReading::Read { tip_px, .. } = read else { panic!("{read:?}") };
    let expected = place(0.7, HALF_SWEEP_RAD * (3.1 / 5.0 - 1.0), 54.0);
    assert!((tip_px[0] - expected[0]).hypot(tip_px[1] - expected[1]) < 2.5, "{tip_px:?} {expected:?}");
    let DialMarks { start_px, end_px, .. } = marks(0.7);
    let backwards = DialMarks { start_px: end_px, end_px: start_px, ..marks(0.7) };
    let read = read_slanted_gauge(&picture, &backwards, &GaugeConfig::default()).expect("a dial");
    assert!((value_of(read) - 6.9).abs() < 0.15, "{read:?}");
}

#[test]
fn marks_that_are_no_scale_are_refused_and_small_or_cut_dials_are_said_to_be_so() {
    let config = GaugeConfig::default();
    let picture = drawn(0.7, 3.1);
    let read = |marks: DialMarks| read_slanted_gauge(&picture, &marks, &config);
    let good = marks(0.7);
    assert_eq!(read(DialMarks { middle_px: good.end_px, ..good }), Err(DialError::MarksDisagree));
    assert_eq!(read(DialMarks { middle_px: good.centre_px, ..good }), Err(DialError::NoRadius));
    assert_eq!(read(DialMarks { end_px: good.start_px, ..good }), Err(DialError::MarksDisagree));
    assert_eq!(read(DialMarks { range: [2.0; 2], ..good }), Err(DialError::NoRange));
    assert_eq!(read(DialMarks { centre_px: [f64::NAN; 2], ..good }), Err(DialError::NotFinite));
    let moved = |by_px: f64, scale: f64| {
        let to = |px: [f64; 2]| {
            [
                CENTRE_PX[0] + by_px + scale * (px[0] - CENTRE_PX[0]),
                CENTRE_PX[1] + scale * (px[1] - CENTRE_PX[1]),
            ]
        };
        let DialMarks { centre_px, start_px, middle_px, end_px, range } = good;
        let [centre_px, start_px, middle_px, end_px] = [centre_px, start_px, middle_px, end_px].map(to);
        DialMarks { centre_px, start_px, middle_px, end_px, range }
    };
    assert!(matches!(read(moved(0.0, 0.2)), Ok(GaugeReading::TooSmall { .. })));
    let outside = GaugeReading::Unsure { reason: UnsureReason::OutsidePicture, likeliest: None };
    assert_eq!(read(moved(120.0, 1.0)), Ok(outside));
}
