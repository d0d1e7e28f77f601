//! PTX (Leica): text. Each scan has its size, the scanner's position and axes, a matrix, and one line a point.

use super::coordinate_offset::CoordinateOffset;
use super::point_collector::PointCollector;
use super::station::{Survey, station_with_pose};
use crate::{FormatError, SurveyLimits, texts};
use std::io::{BufRead, Read};
use vocab::{Pose, Quat, Vec3};

const WHAT: &str = "PTX file";
/// Lines between a scan's size and its points: position, three axes, four rows of a matrix.
const POSE_LINES: usize = 8;
/// Lines between two reports of progress.
const PROGRESS_LINES: usize = 1 << 14;
/// Longest line of the format, bytes.
const MAX_LINE_BYTES: u64 = 1024;

/// Whether a file begins with two counts and a line of three numbers, as no other format does.
pub(super) fn is_ptx(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let mut lines = text.lines();
    let counts = |line: &str| line.trim().parse::<u32>().is_ok();
    let numbers = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        words.len() == 3 && words.iter().all(|word| word.parse::<f64>().is_ok())
    };
    lines.next().is_some_and(counts) && lines.next().is_some_and(counts) && lines.next().is_some_and(numbers)
}

/// Reads all scans of a file of `bytes` bytes.
///
/// # Errors
/// When a line does not fit the format, or the file ends early.
pub(super) fn read(
    input: impl BufRead,
    bytes: u64,
    limits: SurveyLimits,
    progress: &mut dyn FnMut(f64),
) -> Result<Survey, FormatError> {
    let mut lines = LineReader { input, number: 0, read: 0, line: String::new() };
    let mut coordinate_offset = CoordinateOffset::default();
    let mut survey = Survey::default();
    while let Some(columns) = lines.count()? {
        let Some(rows) = lines.count()? else { return Err(lines.ended()) };
        let pose = lines.pose()?;
        let mut local = CoordinateOffset::default();
        let mut collector = PointCollector::new(&mut local, limits, survey.points());
        for _ in 0..u64::from(columns) * u64::from(rows) {
            let (point, intensity) = lines.point()?;
            // A point without a return is written at the scanner's own position.
            let hit = point.iter().any(|coordinate| *coordinate != 0.0);
            collector.add(if hit { point } else { [f64::NAN; 3] }, intensity)?;
            if lines.number % PROGRESS_LINES == 0 {
                progress((lines.read as f64 / bytes.max(1) as f64).min(1.0));
            }
        }
        let (xyz, intensity, unusable) = collector.finish();
        survey.unusable += unusable;
        survey.stations.push(station_with_pose(&pose, &local, xyz, intensity, &mut coordinate_offset));
    }
    survey.offset = coordinate_offset.offset();
    Ok(survey)
}

struct LineReader<R> {
    input: R,
    number: usize,
    read: u64,
    line: String,
}

impl<R: BufRead> LineReader<R> {
    /// The next line; none at the end.
    fn next(&mut self) -> Result<Option<&str>, FormatError> {
        self.line.clear();
        let length = self.input.by_ref().take(MAX_LINE_BYTES).read_line(&mut self.line)?;
        self.read += length as u64;
        self.number += 1;
        if length as u64 == MAX_LINE_BYTES {
            return Err(FormatError::at_line(WHAT, self.number, texts::PTX_LINE_TOO_LONG));
        }
        Ok((length > 0).then_some(self.line.trim()))
    }

    fn ended(&self) -> FormatError {
        FormatError::Truncated { what: WHAT, at: self.read, missing: 1 }
    }

    /// A number of columns or rows; none at the end of the file.
    fn count(&mut self) -> Result<Option<u32>, FormatError> {
        loop {
            let number = self.number + 1;
            let Some(line) = self.next()? else { return Ok(None) };
            // Some programs leave lines empty between scans.
            if !line.is_empty() {
                let problem = || FormatError::at_line(WHAT, number, texts::PTX_COUNT_EXPECTED);
                return line.parse().map(Some).map_err(|_| problem());
            }
        }
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], FormatError> {
        let number = self.number + 1;
        let Some(line) = self.next()? else { return Err(self.ended()) };
        let mut words = line.split_whitespace().map(str::parse::<f64>);
        let mut values = [0.0; N];
        for value in &mut values {
            let problem = || FormatError::at_line(WHAT, number, texts::numbers_expected(N));
            *value = words.next().and_then(Result::ok).ok_or_else(problem)?;
        }
        Ok(values)
    }

    /// The pose by the matrix, whose rows are the images of the axes and of the origin. The lines before it say the same and are skipped.
    fn pose(&mut self) -> Result<Pose, FormatError> {
        for _ in 0..POSE_LINES / 2 {
            self.numbers::<3>()?;
        }
        let mut rows = [[0.0; 4]; 4];
        for row in &mut rows {
            *row = self.numbers::<4>()?;
        }
        let [x, y, z, origin] = rows;
        let problem = || FormatError::at_line(WHAT, self.number, texts::PTX_MATRIX_INVALID);
        let orientation = rotation([x, y, z].map(|row| [row[0], row[1], row[2]])).ok_or_else(problem)?;
        let position = Vec3::new(origin[0], origin[1], origin[2]);
        if !origin.iter().all(|value| value.is_finite()) {
            return Err(problem());
        }
        Ok(Pose { position, orientation })
    }

    /// A point and its intensity, 0.5 if the file has none.
    fn point(&mut self) -> Result<([f64; 3], f32), FormatError> {
        let number = self.number + 1;
        let Some(line) = self.next()? else { return Err(self.ended()) };
        let mut words = line.split_whitespace().map(str::parse::<f64>);
        let mut next = || words.next().and_then(Result::ok);
        match (next(), next(), next()) {
            (Some(x), Some(y), Some(z)) => Ok(([x, y, z], next().unwrap_or(0.5) as f32)),
            _ => Err(FormatError::at_line(WHAT, number, texts::PTX_POINT_EXPECTED)),
        }
    }
}

/// Which axes of a scanner are a rotation.
#[derive(Clone, Copy, Debug)]
struct ScannerAxesConfig {
    /// Tolerance of right angles and unit lengths. Files have six digits, some only three. Chosen: three digits, with the rounding of several products.
    tolerance: f64,
}

const AXES: ScannerAxesConfig = ScannerAxesConfig { tolerance: 5e-3 };

/// The rotation that maps the unit vectors to these axes; none if they are not right-handed and orthonormal.
fn rotation([x, y, z]: [[f64; 3]; 3]) -> Option<Quat> {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    let one = [dot(x, x), dot(y, y), dot(z, z), dot(cross, z)];
    let none = [dot(x, y), dot(y, z), dot(z, x)];
    let right = one.iter().all(|value| (value - 1.0).abs() < AXES.tolerance)
        && none.iter().all(|value| value.abs() < AXES.tolerance);
    if !right {
        return None;
    }
    // Shepperd's method: starts with the largest component.
    let trace = x[0] + y[1] + z[2];
    let [w, i, j, k] = if trace > 0.0 {
        [1.0 + trace, y[2] - z[1], z[0] - x[2], x[1] - y[0]]
    } else if x[0] >= y[1] && x[0] >= z[2] {
        [y[2] - z[1], 1.0 + x[0] - y[1] - z[2], x[1] + y[0], z[0] + x[2]]
    } else if y[1] >= z[2] {
        [z[0] - x[2], x[1] + y[0], 1.0 + y[1] - x[0] - z[2], y[2] + z[1]]
    } else {
        [x[1] - y[0], z[0] + x[2], y[2] + z[1], 1.0 + z[2] - x[0] - y[1]]
    };
    let length = (w * w + i * i + j * j + k * k).sqrt();
    Some(Quat { w: w / length, x: i / length, y: j / length, z: k / length })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Survey, FormatError> {
        read(text.as_bytes(), text.len() as u64, SurveyLimits::NONE, &mut |_| {})
    }

    const QUARTER: &str = "2\n2\n5 6 7\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n5 6 7 1\n";

    #[test]
    fn scans_have_their_poses_and_points_without_a_return_are_skipped() {
        let points = "1 2 3 0.5\n0 0 0 0.5\n4 5 6 0.25 1 2 3\n7 8 9 1\n";
        let survey = read_text(&[QUARTER, points, "\n", QUARTER, points, "\n"].concat()).unwrap();
        assert_eq!((survey.stations.len(), survey.points(), survey.unusable), (2, 6, 2));
        let station = &survey.stations[1];
        assert_eq!(station.xyz[1], [4.0, 5.0, 6.0]);
        assert_eq!(station.intensity, [0.5, 0.25, 1.0]);
        let pose = station.survey_from_station.unwrap();
        assert_eq!(pose.position, Vec3::new(5.0, 6.0, 7.0));
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert!((pose.orientation.w - half).abs() < 1e-9 && (pose.orientation.z - half).abs() < 1e-9);
        assert!(is_ptx(QUARTER.as_bytes()) && !is_ptx(b"2\n3 4 5\n"));
    }

    #[test]
    fn points_far_from_their_scanner_keep_their_precision() {
        let plain = "1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
        let survey =
            read_text(&[plain, "637012.241 849028.312 431.5 1\n637014.241 849028.312 432.5 1\n"].concat());
        let survey = survey.unwrap();
        assert_eq!(survey.offset, [637_010.0, 849_030.0, 0.0]);
        assert_eq!(survey.stations[0].survey_from_station, None);
        assert!((survey.stations[0].xyz[0][0] - 2.241).abs() < 1e-4);
    }

    #[test]
    fn errors_name_their_line() {
        for (text, words) in [
            (QUARTER.to_owned(), "cut off"),
            (QUARTER.replace("0 1 0 0", "0 2 0 0"), "matrix"),
            (QUARTER.replace("5 6 7\n0 1 0\n", "5 six 7\n0 1 0\n"), "line 3"),
            (format!("{QUARTER}1 2\n"), "line 11"),
            ("4000000000\n4000000000\n0 0 0\n".to_owned(), "cut off"),
            (format!("{QUARTER}{}", "1".repeat(5_000)), "longer"),
        ] {
            let problem = read_text(&text).unwrap_err().to_string();
            assert!(problem.contains(words), "{problem}");
        }
    }

    #[test]
    fn every_rotation_comes_back() {
        let turns = [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.5, -0.5, 0.5, 0.5],
            [0.1, 0.7, -0.7, 0.1],
        ];
        for [w, x, y, z] in turns {
            let axis = |v: [f64; 3]| {
                let (u, dot) = ([x, y, z], x * v[0] + y * v[1] + z * v[2]);
                let cross = [y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]];
                let length = w * w - (x * x + y * y + z * z);
                std::array::from_fn(|i| 2.0 * dot * u[i] + length * v[i] + 2.0 * w * cross[i])
            };
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(axis);
            let found = rotation(axes).unwrap();
            let same = found.w * w + found.x * x + found.y * y + found.z * z;
            assert!((same.abs() - 1.0).abs() < 1e-9, "{found:?}");
        }
        assert_eq!(rotation([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]), None);
    }
}
