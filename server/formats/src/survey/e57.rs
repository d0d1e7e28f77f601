//! E57 (ASTM E2807): several scans with their poses; Cartesian or spherical, integer or floating point.

use super::coordinate_offset::CoordinateOffset;
use super::point_collector::PointCollector;
use super::station::{Station, Survey, station_with_pose};
use crate::{FormatError, SurveyLimits, texts};
use ::e57::{CartesianCoordinate, E57Reader, PointCloud, RecordDataType};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use vocab::{MAX_SHOWN_NAME_CHARS, Pose, Quat, Vec3, legible};

/// Points between two reports of progress.
const PROGRESS_POINTS: u64 = 1 << 16;
/// Characters of the library's error that ours shows, at most.
const MAX_SHOWN_ERROR_CHARS: usize = 200;
/// Shortest quaternion that counts as a rotation.
const MIN_QUATERNION_LENGTH: f64 = 1e-6;

/// Reads all scans.
///
/// # Errors
/// When a checksum is wrong, or the file contradicts itself.
pub(super) fn read(
    path: &Path,
    limits: SurveyLimits,
    progress: &mut dyn FnMut(f64),
) -> Result<Survey, FormatError> {
    let mut reader = E57Reader::from_file(path).map_err(malformed)?;
    let scans = reader.pointclouds();
    let total: u64 = scans.iter().fold(0, |sum, scan| sum.saturating_add(scan.records));
    let mut coordinate_offset = CoordinateOffset::default();
    let mut survey = Survey::default();
    let mut done = 0;
    for scan in &scans {
        read_scan(&mut reader, scan, &mut coordinate_offset, &mut survey, limits, &mut |more| {
            done += more;
            progress((done as f64 / total.max(1) as f64).min(1.0));
        })?;
    }
    survey.offset = coordinate_offset.offset();
    Ok(survey)
}

/// Adds a scan to the survey.
fn read_scan(
    reader: &mut E57Reader<BufReader<File>>,
    scan: &PointCloud,
    coordinate_offset: &mut CoordinateOffset,
    survey: &mut Survey,
    limits: SurveyLimits,
    done: &mut dyn FnMut(u64),
) -> Result<(), FormatError> {
    if scan.records > 0 && scan.prototype.iter().all(|record| is_constant(&record.data_type)) {
        return Err(FormatError::Malformed {
            what: texts::E57_FILE,
            place: texts::scan_place(&legible(
                scan.name.as_deref().unwrap_or(texts::UNNAMED_SCAN),
                MAX_SHOWN_NAME_CHARS,
            )),
            problem: texts::SCAN_WITHOUT_DATA.into(),
        });
    }
    let pose = pose(scan);
    let mut points = reader.pointcloud_simple(scan).map_err(malformed)?;
    points.apply_pose(false);
    points.intensity_to_color(false);
    points.normalize_intensity(false);
    points.normalize_color(false);
    let mut local = CoordinateOffset::default();
    let offset = if pose.is_some() { &mut local } else { &mut *coordinate_offset };
    let mut collector = PointCollector::new(offset, limits, survey.points());
    let mut read = 0;
    for point in points {
        let point = point.map_err(malformed)?;
        let intensity = point.intensity.unwrap_or(0.0);
        match point.cartesian {
            CartesianCoordinate::Valid { x, y, z } => collector.add([x, y, z], intensity)?,
            CartesianCoordinate::Direction { .. } | CartesianCoordinate::Invalid => collector.skip()?,
        }
        read += 1;
        if read % PROGRESS_POINTS == 0 {
            done(PROGRESS_POINTS);
        }
    }
    done(read % PROGRESS_POINTS);
    let (xyz, intensity, left_out) = collector.finish();
    survey.unusable += left_out;
    let name = scan.name.clone();
    survey.stations.push(match pose {
        Some(pose) => Station { name, ..station_with_pose(&pose, &local, xyz, intensity, coordinate_offset) },
        None => Station { name, survey_from_station: None, xyz, intensity },
    });
    Ok(())
}

/// Whether values of this type take no bits. A file can announce any number of such values.
fn is_constant(kind: &RecordDataType) -> bool {
    match kind {
        RecordDataType::Single { .. } | RecordDataType::Double { .. } => false,
        RecordDataType::ScaledInteger { min, max, .. } | RecordDataType::Integer { min, max } => min >= max,
    }
}

/// Pose of the scanner, if the file has one.
fn pose(scan: &PointCloud) -> Option<Pose> {
    let transform = scan.transform.as_ref()?;
    let (q, t) = (&transform.rotation, &transform.translation);
    let length = (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z).sqrt();
    let position = Vec3::new(t.x, t.y, t.z);
    let finite = [position.x, position.y, position.z].iter().all(|value| value.is_finite());
    if !(finite && length.is_finite() && length > MIN_QUATERNION_LENGTH) {
        return None;
    }
    let orientation = Quat { w: q.w / length, x: q.x / length, y: q.y / length, z: q.z / length };
    Some(Pose { position, orientation })
}

fn malformed(error: ::e57::Error) -> FormatError {
    FormatError::Malformed {
        what: texts::E57_FILE,
        place: texts::WHILE_READING.into(),
        problem: texts::library_error(legible(&error.to_string(), MAX_SHOWN_ERROR_CHARS)),
    }
}
