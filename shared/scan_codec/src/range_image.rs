//! The bytes of a sweep as a range image.
//!
//! A message is a header and streams of bytes, all little endian:
//!
//! | offset | type | meaning |
//! | --- | --- | --- |
//! | 0 | 4 bytes | `AIRI` |
//! | 4 | u8 | version, 1 |
//! | 5 | u8 | intensities: 0 none, 1 whole numbers, 2 any numbers |
//! | 6 | u8 | bit 0: points have channels; bit 1: points have times |
//! | 7 | u8 | 0, reserved |
//! | 8 | i64 | stamp, nanoseconds since 1970 |
//! | 16 | u32 | number of points |
//! | 20 | u32 | step of the range, micrometres |
//! | 24 | u16 | highest channel |
//! | 26 | u16 | 0, reserved |
//!
//! The points are columns of one firing of each channel: a new column begins with a channel that is not above the previous one. Each number is
//! stored as its difference from a prediction by the points before it, so that the beam table of the sensor need not be stored: after the
//! first column, channel, time and direction of a regular sensor are all as expected. A range is expected from its neighbours as in LOCO-I (Weinberger, Seroussi and
//! Sapiro, 2000), and its difference belongs to one of four classes by how well its neighbours were predicted. What remains is the
//! noise of the sensor, which is why the sweep before is of no use. Each quantity has one stream for each class and one of escapes: channels, times,
//! azimuths, elevations, ranges, intensities. Intensities that are not whole numbers follow as four streams of one byte of their f32 each.

use crate::error::RangeImageError;
use crate::grid::{ANGLE_STEPS, DirectionGuesses, Grid, GridPoint, MAX_ELEVATION, MAX_RANGE, RANGE_STEP_UM};
use crate::predictor::{CLASSES, Predictor, wrap_angle_steps};
use crate::symbols::{SymbolReader, SymbolWriter, pack, unpack};
use crate::texts;
use messages::Scan;
use std::ops::RangeInclusive;
use vocab::Stamp;

const MAGIC: &[u8; 4] = b"AIRI";
const VERSION: u8 = 1;
const HEADER_LEN: usize = 28;
/// Largest number of points in a sweep.
const MAX_POINTS: usize = 1 << 20;
/// Largest whole number as intensity.
const MAX_INTENSITY: f32 = 65_535.0;

/// How intensities are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum IntensityKind {
    None = 0,
    Whole = 1,
    Any = 2,
}

impl IntensityKind {
    fn of(intensity: &[f32]) -> Self {
        let is_whole = |value: &f32| {
            (0.0..=MAX_INTENSITY).contains(value) && value.to_bits() == value.trunc().abs().to_bits()
        };
        match intensity {
            [] => Self::None,
            all if all.iter().all(is_whole) => Self::Whole,
            _ => Self::Any,
        }
    }
}

/// Appends the range image of a sweep to `out`, such that [`decode`] restores every bit. Returns false, and appends nothing, if the sweep is not on the
/// grid of [`crate::quantise`] or its columns have different lengths.
pub fn encode(scan: &Scan, out: &mut Vec<u8>) -> bool {
    let count = scan.xyz.len();
    let is_full = |length: usize| length == 0 || length == count;
    if count > MAX_POINTS
        || !is_full(scan.intensity.len())
        || !is_full(scan.offset_ns.len())
        || !is_full(scan.ring.len())
    {
        return false;
    }
    let Some(points) = grid_points(scan) else { return false };
    let kind = IntensityKind::of(&scan.intensity);
    let ring_last = scan.ring.iter().copied().max().unwrap_or_default();

    out.extend(MAGIC);
    out.extend([VERSION, kind as u8]);
    out.push(u8::from(!scan.ring.is_empty()) | u8::from(!scan.offset_ns.is_empty()) << 1);
    out.push(0);
    out.extend(scan.stamp.nanos().to_le_bytes());
    out.extend((count as u32).to_le_bytes());
    out.extend(RANGE_STEP_UM.to_le_bytes());
    out.extend(ring_last.to_le_bytes());
    out.extend([0; 2]);

    let mut predictor = Predictor::new(ring_last);
    let [mut rings, mut times, mut azimuths, mut elevations] = [1; 4].map(SymbolWriter::new);
    let [mut ranges, mut intensities] = [CLASSES; 2].map(SymbolWriter::new);
    for (index, &point) in points.iter().enumerate() {
        let ring = scan.ring.get(index).copied().unwrap_or_default();
        if !scan.ring.is_empty() {
            rings.put(0, i64::from(ring) - i64::from(predictor.expected_ring()));
        }
        let is_new = predictor.begin(ring);
        if let Some(&offset_ns) = scan.offset_ns.get(index) {
            let time = i64::from(offset_ns);
            times.put(0, time - predictor.expected_time(ring, is_new));
            predictor.learn_time(ring, is_new, time);
        }
        azimuths
            .put(0, i64::from(wrap_angle_steps(point.azimuth - predictor.expected_azimuth(ring, is_new))));
        predictor.learn_azimuth(ring, is_new, point.azimuth);
        elevations.put(0, i64::from(point.elevation - predictor.expected_elevation(ring)));
        let expected = predictor.expected_range(ring);
        ranges.put(expected.class, i64::from(point.range) - i64::from(expected.range));
        let mut intensity = 0;
        if kind == IntensityKind::Whole {
            intensity = scan.intensity[index] as i64;
            let (wanted, class) = predictor.expected_intensity(ring, point.range.abs_diff(expected.range));
            intensities.put(class, intensity - wanted);
        }
        predictor.learn(ring, point, expected, intensity);
    }
    for stream in [rings, times, azimuths, elevations, ranges, intensities] {
        stream.finish(out);
    }
    if kind == IntensityKind::Any {
        for byte in 0..4 {
            let plane: Vec<u8> = scan.intensity.iter().map(|value| value.to_le_bytes()[byte]).collect();
            pack(&plane, out);
        }
    }
    true
}

/// The points of a sweep on the grid; `None` if one is not on it to the last bit.
fn grid_points(scan: &Scan) -> Option<Vec<GridPoint>> {
    let grid = Grid::new(RANGE_STEP_UM);
    let mut guesses = DirectionGuesses::default();
    let mut points = Vec::with_capacity(scan.xyz.len());
    for (index, &position) in scan.xyz.iter().enumerate() {
        let ring = scan.ring.get(index).copied().unwrap_or_default();
        let point = grid.nearest(position, guesses.guess(ring))?;
        if grid.position(point).map(f32::to_bits) != position.map(f32::to_bits) {
            return None;
        }
        guesses.learn(ring, point);
        points.push(point);
    }
    Some(points)
}

/// The sweep in a range image.
///
/// # Errors
/// When the bytes are damaged or of a later version.
pub fn decode(bytes: &[u8]) -> Result<Scan, RangeImageError> {
    use RangeImageError::Malformed;
    let (header, mut rest) = bytes.split_first_chunk::<HEADER_LEN>().ok_or(Malformed(texts::TOO_SHORT))?;
    if header[..4] != *MAGIC {
        return Err(Malformed(texts::OTHER_BEGINNING));
    }
    if header[4] != VERSION {
        return Err(RangeImageError::Version(header[4]));
    }
    let kind = match header[5] {
        0 => IntensityKind::None,
        1 => IntensityKind::Whole,
        2 => IntensityKind::Any,
        _ => return Err(Malformed(texts::UNKNOWN_INTENSITIES)),
    };
    let (has_rings, has_times) = (header[6] & 1 != 0, header[6] & 2 != 0);
    let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
    let stamp = i64::from(word(8)) | i64::from(word(12)) << 32;
    let (count, range_step_um) = (word(16) as usize, word(20));
    let ring_last = word(24) as u16;
    if count > MAX_POINTS {
        return Err(Malformed(texts::TOO_MANY_POINTS));
    }
    let mut reader = |classes| SymbolReader::new(classes, count, &mut rest);
    let (mut rings, mut times, mut azimuths, mut elevations) =
        (reader(1)?, reader(1)?, reader(1)?, reader(1)?);
    let (mut ranges, mut intensities) = (reader(CLASSES)?, reader(CLASSES)?);

    let grid = Grid::new(range_step_um);
    let mut predictor = Predictor::new(ring_last);
    let mut scan = Scan { stamp: Stamp::from_nanos(stamp), ..Scan::default() };
    for _ in 0..count {
        let mut ring = 0;
        if has_rings {
            let value = i64::from(predictor.expected_ring()).wrapping_add(rings.get(0)?);
            ring = in_bounds(value, 0..=i64::from(ring_last), texts::CHANNEL_OUT_OF_RANGE)? as u16;
            scan.ring.push(ring);
        }
        let is_new = predictor.begin(ring);
        if has_times {
            let value = predictor.expected_time(ring, is_new).wrapping_add(times.get(0)?);
            let time = in_bounds(value, i64::from(i32::MIN)..=i64::from(i32::MAX), texts::TIME_OUT_OF_RANGE)?;
            scan.offset_ns.push(time as i32);
            predictor.learn_time(ring, is_new, time);
        }
        let turn = i64::from(ANGLE_STEPS);
        let difference = in_bounds(azimuths.get(0)?, -turn..=turn, texts::AZIMUTH_OUT_OF_RANGE)? as i32;
        let azimuth = (predictor.expected_azimuth(ring, is_new) + difference).rem_euclid(ANGLE_STEPS);
        predictor.learn_azimuth(ring, is_new, azimuth);
        let value = i64::from(predictor.expected_elevation(ring)).wrapping_add(elevations.get(0)?);
        let quarter = i64::from(MAX_ELEVATION);
        let elevation = in_bounds(value, -quarter..=quarter, texts::ELEVATION_OUT_OF_RANGE)? as i32;
        let expected = predictor.expected_range(ring);
        let value = i64::from(expected.range).wrapping_add(ranges.get(expected.class)?);
        let range = in_bounds(value, 1..=i64::from(MAX_RANGE), texts::RANGE_OUT_OF_RANGE)? as u32;
        let mut intensity = 0;
        if kind == IntensityKind::Whole {
            let (wanted, class) = predictor.expected_intensity(ring, range.abs_diff(expected.range));
            let value = wanted.wrapping_add(intensities.get(class)?);
            intensity = in_bounds(value, 0..=MAX_INTENSITY as i64, texts::INTENSITY_OUT_OF_RANGE)?;
            scan.intensity.push(intensity as f32);
        }
        let point = GridPoint { azimuth, elevation, range };
        scan.xyz.push(grid.position(point));
        predictor.learn(ring, point, expected, intensity);
    }
    if kind == IntensityKind::Any {
        let mut planes = Vec::with_capacity(4);
        for _ in 0..4 {
            let plane = unpack(&mut rest, count)?;
            if plane.len() != count {
                return Err(Malformed(texts::OTHER_INTENSITIES_LENGTH));
            }
            planes.push(plane);
        }
        let value = |index: usize| f32::from_le_bytes(std::array::from_fn(|byte| planes[byte][index]));
        scan.intensity = (0..count).map(value).collect();
    }
    Ok(scan)
}

fn in_bounds(value: i64, bounds: RangeInclusive<i64>, problem: &'static str) -> Result<i64, RangeImageError> {
    if bounds.contains(&value) { Ok(value) } else { Err(RangeImageError::Malformed(problem)) }
}
