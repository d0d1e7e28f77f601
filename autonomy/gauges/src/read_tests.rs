//! Drawn dials of several kinds: water meters, pressure gauges, instruments with light needles.

use super::*;

const SIDE: usize = 160;
const CENTRE: f64 = 79.5;
const RADIUS: f64 = 66.0;

/// How a dial is drawn.
#[derive(Clone, Copy)]
struct Drawing {
    face: [f64; 3],
    print: [f64; 3],
    needle: [f64; 3],
    /// Half the width of the needle at the axis, its length and that of its tail, pixels.
    half_width_px: f64,
    length_px: f64,
    tail_px: f64,
}

const WATER_METER: Drawing = Drawing {
    face: [215.0, 220.0, 205.0],
    print: [40.0; 3],
    needle: [200.0, 30.0, 25.0],
    half_width_px: 14.0,
    length_px: 58.0,
    tail_px: 8.0,
};
const PRESSURE: Drawing = Drawing {
    face: [225.0; 3],
    print: [30.0; 3],
    needle: [25.0; 3],
    half_width_px: 4.0,
    length_px: 55.0,
    tail_px: 18.0,
};
const INSTRUMENT: Drawing =
    Drawing { face: [35.0, 38.0, 40.0], print: [180.0; 3], needle: [235.0, 235.0, 225.0], ..PRESSURE };
const ORANGE: Drawing = Drawing { needle: [240.0, 140.0, 20.0], ..INSTRUMENT };

impl Drawing {
    /// The colour at an offset from the axis, pixels.
    fn colour(&self, [x, y]: [f64; 2], direction_rad: f64) -> [f64; 3] {
        let (sine, cosine) = direction_rad.sin_cos();
        let (along, across) = (x * sine - y * cosine, x * cosine + y * sine);
        let taper = 1.0 - (along / self.length_px).max(0.0);
        if (-self.tail_px..self.length_px).contains(&along)
            && across.abs() <= self.half_width_px * taper.max(0.05)
        {
            return self.needle;
        }
        let range_px = x.hypot(y);
        let turn = x.atan2(-y).rem_euclid(TAU) / TAU;
        let to_tick = |ticks: f64| ((turn * ticks).round() / ticks - turn).abs() * TAU * range_px;
        let is_tick = range_px > 60.0 && range_px < 70.0 && to_tick(10.0) < 1.5;
        // Digits: blobs beside the ticks.
        let digit = (turn * 10.0).round() / 10.0 * TAU;
        let (digit_x, digit_y) = (46.0 * digit.sin(), -46.0 * digit.cos());
        let from_digit = (x - digit_x).hypot(y - digit_y);
        if is_tick || (3.5..6.5).contains(&from_digit) { self.print } else { self.face }
    }

    /// A picture with shading from left to right, soft edges and noise.
    fn picture(&self, direction_rad: f64) -> Picture {
        let mut noise = 1_u32;
        let mut pixels = Vec::new();
        for row in 0..SIDE {
            for column in 0..SIDE {
                let mut sum = [0.0; 3];
                for (dx, dy) in [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)] {
                    let at = [column as f64 + dx - CENTRE, row as f64 + dy - CENTRE];
                    let colour = self.colour(at, direction_rad);
                    sum = [0, 1, 2].map(|part| sum[part] + colour[part] / 4.0);
                }
                let light = 0.85 + 0.3 * column as f64 / SIDE as f64;
                pixels.push(sum.map(|part| {
                    noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (part * light + f64::from(noise >> 24) / 256.0 * 10.0 - 5.0).clamp(0.0, 255.0) as u8
                }));
            }
        }
        Picture::new([SIDE, SIDE], pixels).expect("a picture")
    }
}

fn dial(start_deg: f64, sweep_deg: f64) -> Dial {
    Dial {
        centre_px: [CENTRE; 2],
        axis_px: [CENTRE; 2],
        radius_px: RADIUS,
        start_rad: start_deg.to_radians(),
        sweep_rad: sweep_deg.to_radians(),
        range: [0.0, 10.0],
    }
}

fn read(picture: &Picture, dial: &Dial) -> GaugeReading {
    read_gauge(picture, dial, &GaugeConfig::default()).expect("a dial")
}

#[test]
fn needles_of_any_colour_are_read_all_round() {
    for (drawing, name) in
        [(WATER_METER, "water meter"), (PRESSURE, "pressure"), (INSTRUMENT, "instrument"), (ORANGE, "orange")]
    {
        for step in 0..25 {
            let expected = f64::from(step) * 0.4 + 0.05;
            let reading = read(&drawing.picture(expected / 10.0 * TAU), &dial(0.0, 360.0));
            let GaugeReading::Read { value, uncertainty, tip_px, .. } = reading else {
                panic!("{name} at {expected}: {reading:?}");
            };
            let off = (value - expected + 5.0).rem_euclid(10.0) - 5.0;
            assert!(off.abs() < 0.1, "{name} at {expected}: {reading:?}");
            assert!(off.abs() < 4.0 * uncertainty, "{name} at {expected}: {reading:?}");
            let length_px = (tip_px[0] - CENTRE).hypot(tip_px[1] - CENTRE);
            assert!((length_px - drawing.length_px).abs() < 0.2 * drawing.length_px, "{name}: {reading:?}");
        }
    }
}

#[test]
fn scales_of_less_than_a_turn_end() {
    let pressure = dial(-135.0, 270.0);
    let of = |direction_deg: f64| read(&PRESSURE.picture(direction_deg.to_radians()), &pressure);
    assert!(matches!(of(0.0), GaugeReading::Read { value, .. } if (value - 5.0).abs() < 0.1));
    assert!(matches!(of(-137.0), GaugeReading::Read { value, .. } if value == 0.0));
    assert!(matches!(
        of(180.0),
        GaugeReading::Unsure { reason: UnsureReason::OutsideScale, likeliest: None }
    ));
}

#[test]
fn pictures_without_a_clear_needle_are_unsure_with_a_reason() {
    let reason = |picture: &Picture, dial: &Dial| match read(picture, dial) {
        GaugeReading::Unsure { reason, .. } => Some(reason),
        _ => None,
    };
    let whole = dial(0.0, 360.0);
    let blank = Picture::new([SIDE, SIDE], vec![[128; 3]; SIDE * SIDE]).expect("a picture");
    assert_eq!(reason(&blank, &whole), Some(UnsureReason::NoNeedle));
    let no_needle = Drawing { needle: WATER_METER.face, ..WATER_METER }.picture(1.0);
    assert!(
        matches!(reason(&no_needle, &whole), Some(UnsureReason::NoNeedle | UnsureReason::Indistinct)),
        "print alone"
    );
    let short = Drawing { length_px: 16.0, ..WATER_METER }.picture(1.0);
    assert!(reason(&short, &whole).is_some(), "a stump");
    let outside = Dial { centre_px: [300.0, 80.0], axis_px: [300.0, 80.0], ..whole };
    assert_eq!(reason(&WATER_METER.picture(1.0), &outside), Some(UnsureReason::OutsidePicture));
    let small = Dial { radius_px: 9.0, ..whole };
    assert!(matches!(read(&WATER_METER.picture(1.0), &small), GaugeReading::TooSmall { radius_px: 9.0, .. }));
}
