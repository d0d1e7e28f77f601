//! Surveys: the points of a whole site as one cloud, or by the stations of a scanner.
//!
//! PCD, PLY, LAS, LAZ, E57 and PTX are recognised by their first bytes. Coordinates of surveys are often hundreds of kilometres from the
//! origin, where single precision resolves decimetres only. An offset is therefore subtracted from them and reported.

mod coordinate_offset;
mod e57;
mod las;
mod laz_layers;
mod point_collector;
mod ptx;
mod station;
mod table;

use crate::{FormatError, SurveyLimits, pcd, ply, texts};
use std::fs::File;
use std::io::{BufReader, Read};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

pub use station::{Station, Survey};

/// Bytes at the start of a file by which its format is recognised: more than any format needs.
const START_BYTES: u64 = 512;

/// Reads a whole file. `progress` is called with the share done, 0 to 1. Memory: 16 bytes a point, up to twice that while reading; for
/// PCD and PLY the file itself more.
///
/// # Errors
/// When the file is none of the formats, contradicts itself, holds fewer points than it states, or more than the limit.
pub fn read(path: &Path, limits: SurveyLimits, progress: &mut dyn FnMut(f64)) -> Result<Survey, FormatError> {
    let mut start = Vec::new();
    File::open(path)?.take(START_BYTES).read_to_end(&mut start)?;
    let start = start.as_slice();
    if start.starts_with(b"LASF") {
        return guarded("LAS or LAZ file", || las::read(path, limits, progress));
    }
    if start.starts_with(b"ASTM-E57") {
        return guarded("E57 file", || e57::read(path, limits, progress));
    }
    if pcd::is_pcd(start) {
        return table::read(&pcd::read(&std::fs::read(path)?)?, limits);
    }
    if ply::is_ply(start) {
        return table::read(&ply::read(&std::fs::read(path)?)?, limits);
    }
    if ptx::is_ptx(start) {
        let file = File::open(path)?;
        let bytes = file.metadata()?.len();
        return ptx::read(BufReader::new(file), bytes, limits, progress);
    }
    Err(FormatError::WrongKind { expected: texts::IMPORTABLE_MAP, found: texts::NO_SURVEY_FORMAT.into() })
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
