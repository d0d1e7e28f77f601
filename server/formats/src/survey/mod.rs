//! Surveys: the points of a whole site as one cloud, or by the stations of a scanner.
//!
//! PCD, PLY, LAS, LAZ, E57 and PTX are recognised by their first bytes. Coordinates of surveys are often hundreds of kilometres from the
//! origin, where single precision resolves decimetres only. An offset is therefore subtracted from them and reported.

mod e57;
mod las;
mod ptx;
mod table;

use crate::{FormatError, pcd, ply, texts};
use std::fs::File;
use std::io::{BufReader, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use vocab::{Pose, Vec3};

/// Parameters of the offset that is subtracted from coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OffsetConfig {
    /// Coordinates up to this size get no offset, metres: single precision resolves a tenth of a millimetre there.
    coordinate_max_m: f64,
    /// The offset is a multiple of this, metres, so that people can add it in their heads.
    multiple_m: f64,
    /// Number of points whose median decides on the offset.
    sample_points: usize,
}

const OFFSET: OffsetConfig =
    OffsetConfig { coordinate_max_m: 1_000.0, multiple_m: 10.0, sample_points: 1_000 };

/// A survey of a site.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    /// Subtracted from all coordinates of the file, metres.
    pub offset: [f64; 3],
    /// One for each station of the scanner; a single one if the file has no stations.
    pub stations: Vec<Station>,
    /// Number of points left out: not finite, or without a return.
    pub unusable: usize,
}

/// The points of one station, or the whole cloud.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Station {
    /// As written in the file.
    pub name: Option<String>,
    /// Pose of the scanner in the file's frame without the offset. None if the file does not say; the points are then in that
    /// frame.
    pub survey_from_station: Option<Pose>,
    /// Metres.
    pub xyz: Vec<[f32; 3]>,
    /// In the file's units, one for each point, or empty.
    pub intensity: Vec<f32>,
}

impl Survey {
    /// Usable points of all stations.
    pub fn points(&self) -> usize {
        self.stations.iter().map(|station| station.xyz.len()).sum()
    }
}

/// Reads a whole file. `progress` is called with the share done, 0 to 1. Memory: 16 bytes a point, up to twice that while reading; for
/// PCD and PLY the file itself and 28 bytes a point more.
///
/// # Errors
/// When the file is none of the formats, contradicts itself, or holds fewer points than it states.
pub fn read(path: &Path, progress: &mut dyn FnMut(f64)) -> Result<Survey, FormatError> {
    let mut start = [0; 512];
    let length = fill(&mut File::open(path)?, &mut start)?;
    let start = &start[..length];
    if start.starts_with(b"LASF") {
        return guarded("LAS or LAZ file", || las::read(path, progress));
    }
    if start.starts_with(b"ASTM-E57") {
        return guarded("E57 file", || e57::read(path, progress));
    }
    if pcd::is_pcd(start) {
        return table::read(&pcd::read(&std::fs::read(path)?)?);
    }
    if ply::is_ply(start) {
        return table::read(&ply::read(&std::fs::read(path)?)?);
    }
    if ptx::is_ptx(start) {
        let file = File::open(path)?;
        let bytes = file.metadata()?.len();
        return ptx::read(BufReader::new(file), bytes, progress);
    }
    Err(FormatError::WrongKind {
        expected: "a map that can be imported",
        found: texts::NO_SURVEY_FORMAT.into(),
    })
}

/// Reads until a buffer is full or the file ends.
fn fill(file: &mut impl Read, buffer: &mut [u8]) -> Result<usize, FormatError> {
    let mut length = 0;
    loop {
        match file.read(&mut buffer[length..])? {
            0 => return Ok(length),
            more => length += more,
        }
    }
}

/// Runs a decoder of a library, which may panic on damage that it does not check for.
fn guarded(
    what: &'static str,
    read: impl FnOnce() -> Result<Survey, FormatError>,
) -> Result<Survey, FormatError> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| {
        let problem = texts::COMPRESSED_DATA_DAMAGED.into();
        Err(FormatError::Malformed { what, place: texts::UNKNOWN_PLACE.into(), problem })
    })
}

/// The offset of a file, once it is decided.
#[derive(Clone, Copy, Debug, Default)]
struct CoordinateOffset {
    offset: Option<[f64; 3]>,
}

impl CoordinateOffset {
    /// Decides by the median of the first points, or of the first positions of a scanner.
    fn decide(&mut self, first: &[[f64; 3]]) {
        self.offset.get_or_insert_with(|| {
            std::array::from_fn(|axis| {
                let mut values: Vec<f64> =
                    first.iter().map(|point| point[axis]).filter(|value| value.is_finite()).collect();
                values.sort_by(f64::total_cmp);
                let median = values.get(values.len() / 2).copied().unwrap_or(0.0);
                if median.abs() > OFFSET.coordinate_max_m {
                    (median / OFFSET.multiple_m).round() * OFFSET.multiple_m
                } else {
                    0.0
                }
            })
        });
    }

    fn offset(&self) -> [f64; 3] {
        self.offset.unwrap_or_default()
    }

    /// A position less the offset.
    fn relative(&self, place: Vec3) -> Vec3 {
        let [x, y, z] = self.offset();
        Vec3::new(place.x - x, place.y - y, place.z - z)
    }
}

/// A station with its pose. `xyz` is in its own frame, less the offset `local`. Some programs write points in the survey's frame and a scanner at its
/// origin. If points are far from the scanner, its pose is therefore unknown.
fn station_with_pose(
    survey_from_station: &Pose,
    local: &CoordinateOffset,
    mut xyz: Vec<[f32; 3]>,
    intensity: Vec<f32>,
    coordinate_offset: &mut CoordinateOffset,
) -> Station {
    let [x, y, z] = rotate(&survey_from_station.orientation, local.offset());
    let place = survey_from_station.position;
    let origin = Vec3::new(place.x + x, place.y + y, place.z + z);
    coordinate_offset.decide(&[[origin.x, origin.y, origin.z]]);
    let position = coordinate_offset.relative(origin);
    let orientation = survey_from_station.orientation;
    if local.offset() == [0.0; 3] {
        let survey_from_station = Some(Pose { position, orientation });
        return Station { name: None, survey_from_station, xyz, intensity };
    }
    for point in &mut xyz {
        let [x, y, z] = rotate(&orientation, point.map(f64::from));
        *point = [position.x + x, position.y + y, position.z + z].map(|coordinate| coordinate as f32);
    }
    Station { name: None, survey_from_station: None, xyz, intensity }
}

fn rotate(q: &vocab::Quat, v: [f64; 3]) -> [f64; 3] {
    let axis = [q.x, q.y, q.z];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let turn = cross(axis, v).map(|c| 2.0 * c);
    let second = cross(axis, turn);
    std::array::from_fn(|i| v[i] + q.w * turn[i] + second[i])
}

/// A cloud that is being read. The first points wait until there are enough to decide on the offset.
#[derive(Debug)]
struct PointCollector<'a> {
    coordinate_offset: &'a mut CoordinateOffset,
    first: Vec<([f64; 3], f32)>,
    xyz: Vec<[f32; 3]>,
    intensity: Vec<f32>,
    unusable: usize,
}

impl<'a> PointCollector<'a> {
    fn new(coordinate_offset: &'a mut CoordinateOffset) -> Self {
        Self { coordinate_offset, first: Vec::new(), xyz: Vec::new(), intensity: Vec::new(), unusable: 0 }
    }

    fn add(&mut self, point: [f64; 3], intensity: f32) {
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            self.unusable += 1;
            return;
        }
        if self.coordinate_offset.offset.is_some() && self.first.is_empty() {
            self.put(point, intensity);
            return;
        }
        self.first.push((point, intensity));
        if self.first.len() >= OFFSET.sample_points {
            self.flush_first();
        }
    }

    fn put(&mut self, point: [f64; 3], intensity: f32) {
        let offset = self.coordinate_offset.offset();
        let point: [f32; 3] = std::array::from_fn(|axis| (point[axis] - offset[axis]) as f32);
        // Markers of missing values are often beyond single precision.
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            self.unusable += 1;
            return;
        }
        self.xyz.push(point);
        self.intensity.push(intensity);
    }

    fn flush_first(&mut self) {
        let first = std::mem::take(&mut self.first);
        let places: Vec<[f64; 3]> = first.iter().map(|(point, _)| *point).collect();
        self.coordinate_offset.decide(&places);
        for (point, intensity) in first {
            self.put(point, intensity);
        }
    }

    /// The points less the offset, their intensities if any is not zero, and the number of points left out.
    fn finish(mut self) -> (Vec<[f32; 3]>, Vec<f32>, usize) {
        self.flush_first();
        if self.intensity.iter().all(|intensity| *intensity == 0.0) {
            self.intensity = Vec::new();
        }
        (self.xyz, self.intensity, self.unusable)
    }
}
