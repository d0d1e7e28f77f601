//! Maps from elsewhere: the points of a whole site, in one cloud or by the stations of a scanner.
//!
//! PCD, PLY, LAS, LAZ, E57 and PTX, told apart by how they begin. Surveyors' coordinates are often hundreds of kilometres from their
//! origin, where single precision knows decimetres only: a whole number of tens of metres is taken off and told.

mod e57;
mod las;
mod ptx;
mod table;

use crate::{FormatError, pcd, ply};
use std::fs::File;
use std::io::{BufReader, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use vocab::{Pose, Vec3};

/// Coordinates up to this size are left as they are, metres: single precision knows them to a tenth of a millimetre.
const NEAR: f64 = 1_000.0;
/// What is taken off is a multiple of this, metres.
const STEP: f64 = 10.0;
/// The middle of so many points decides what is taken off.
const SAMPLE: usize = 1_000;

/// A site as somebody else measured it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    /// What was taken off all coordinates of the file, metres.
    pub offset: [f64; 3],
    /// One for each place that a scanner stood at; one in all where the file knows none.
    pub stations: Vec<Station>,
    /// Points left out: not finite, or directions in which nothing was hit.
    pub unusable: usize,
}

/// What was seen from one place, or the whole cloud.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Station {
    /// As written in the file.
    pub name: Option<String>,
    /// Where the scanner stood, in the file's frame without the offset; none where the file does not say, and the points are in that
    /// frame themselves.
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

/// Reads a whole file; `progress` hears how much of it is done, from 0 to 1. Memory: 16 bytes a point and up to twice that while they come; for
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
        found: "it begins like no PCD, PLY, LAS, LAZ, E57 or PTX file; convert it to one of them".into(),
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

/// Others' decoders may panic where a file is damaged in ways that they do not look for.
fn guarded(
    what: &'static str,
    read: impl FnOnce() -> Result<Survey, FormatError>,
) -> Result<Survey, FormatError> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| {
        let problem = "its compressed data is damaged; copy or export it again".into();
        Err(FormatError::Malformed { what, place: "an unknown place".into(), problem })
    })
}

/// Decides on the offset, and takes it off.
#[derive(Clone, Copy, Debug, Default)]
struct Centre {
    offset: Option<[f64; 3]>,
}

impl Centre {
    /// By the middle of the first points, or of the first places of a scanner.
    fn decide(&mut self, first: &[[f64; 3]]) {
        self.offset.get_or_insert_with(|| {
            std::array::from_fn(|axis| {
                let mut values: Vec<f64> =
                    first.iter().map(|point| point[axis]).filter(|value| value.is_finite()).collect();
                values.sort_by(f64::total_cmp);
                let middle = values.get(values.len() / 2).copied().unwrap_or(0.0);
                if middle.abs() > NEAR { (middle / STEP).round() * STEP } else { 0.0 }
            })
        });
    }

    fn offset(&self) -> [f64; 3] {
        self.offset.unwrap_or_default()
    }

    /// A place without the offset.
    fn relative(&self, place: Vec3) -> Vec3 {
        let [x, y, z] = self.offset();
        Vec3::new(place.x - x, place.y - y, place.z - z)
    }
}

/// A station that saw points (its own frame, `local` taken off). Some programs write points in the survey's frame and a scanner at its
/// origin: where points are far from the scanner, where that stood is not known.
fn seen_from(
    survey_from_station: &Pose,
    local: &Centre,
    mut xyz: Vec<[f32; 3]>,
    intensity: Vec<f32>,
    centre: &mut Centre,
) -> Station {
    let [x, y, z] = rotate(&survey_from_station.orientation, local.offset());
    let place = survey_from_station.position;
    let origin = Vec3::new(place.x + x, place.y + y, place.z + z);
    centre.decide(&[[origin.x, origin.y, origin.z]]);
    let position = centre.relative(origin);
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

/// A cloud being read: points are held back until there are enough to decide on the offset.
#[derive(Debug)]
struct Gathered<'a> {
    centre: &'a mut Centre,
    first: Vec<([f64; 3], f32)>,
    xyz: Vec<[f32; 3]>,
    intensity: Vec<f32>,
    unusable: usize,
}

impl<'a> Gathered<'a> {
    fn new(centre: &'a mut Centre) -> Self {
        Self { centre, first: Vec::new(), xyz: Vec::new(), intensity: Vec::new(), unusable: 0 }
    }

    fn add(&mut self, point: [f64; 3], intensity: f32) {
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            self.unusable += 1;
            return;
        }
        if self.centre.offset.is_some() && self.first.is_empty() {
            self.put(point, intensity);
            return;
        }
        self.first.push((point, intensity));
        if self.first.len() >= SAMPLE {
            self.release();
        }
    }

    fn put(&mut self, point: [f64; 3], intensity: f32) {
        let offset = self.centre.offset();
        let point: [f32; 3] = std::array::from_fn(|axis| (point[axis] - offset[axis]) as f32);
        // What marks missing values is often larger than any single number.
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            self.unusable += 1;
            return;
        }
        self.xyz.push(point);
        self.intensity.push(intensity);
    }

    fn release(&mut self) {
        let first = std::mem::take(&mut self.first);
        let places: Vec<[f64; 3]> = first.iter().map(|(point, _)| *point).collect();
        self.centre.decide(&places);
        for (point, intensity) in first {
            self.put(point, intensity);
        }
    }

    /// The points without their offset, their intensities if any is not zero, and how many were left out.
    fn finish(mut self) -> (Vec<[f32; 3]>, Vec<f32>, usize) {
        self.release();
        if self.intensity.iter().all(|intensity| *intensity == 0.0) {
            self.intensity = Vec::new();
        }
        (self.xyz, self.intensity, self.unusable)
    }
}
