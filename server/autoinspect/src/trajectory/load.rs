//! Reads trajectories from files.

use super::Track;
use crate::failure::Failure;
use crate::texts;
use geometry::{Isometry, Rotation};
use nalgebra::{Rotation3, Translation3};
use recorder::{Recording, TopicSelection};
use std::path::Path;
use vocab::{Pose, Stamp};

/// Reads a TUM file, a KITTI file with the `times.txt` beside it, or the truth of a recording.
pub fn load(path: &Path) -> Result<Track, Failure> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let mut track = match extension {
        "tum" | "txt" => read_text(path)?,
        _ => plain(&truth_of_recording(path)?),
    };
    track.sort_by_key(|(stamp, _)| *stamp);
    if track.is_empty() {
        return Err(Failure::usage(texts::no_poses(path)));
    }
    Ok(track)
}

fn plain(poses: &[(Stamp, Pose)]) -> Track {
    poses.iter().filter_map(|(stamp, pose)| Some((*stamp, geometry::isometry_from_pose(pose)?))).collect()
}

/// Reads a text file. Lines of eight numbers are TUM's, lines of twelve are KITTI's.
fn read_text(path: &Path) -> Result<Track, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::unreadable(path, error))?;
    let first = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    if first.is_some_and(|line| line.split_whitespace().count() == 12) {
        return read_kitti(path, &text);
    }
    formats::tum::read(&text).map(|poses| plain(&poses)).map_err(|error| Failure::unreadable(path, error))
}

/// Reads KITTI's poses: each line is the upper 3x4 part of a matrix. The times are in `times.txt`, one on each line, in seconds.
fn read_kitti(path: &Path, text: &str) -> Result<Track, Failure> {
    let times = path.with_file_name("times.txt");
    let stamps = std::fs::read_to_string(&times).map_err(|error| Failure::unreadable(&times, error))?;
    let stamps = stamps.lines().filter_map(|line| formats::tum::stamp(line.split_whitespace().next()?));
    let poses = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    poses
        .zip(stamps)
        .map(|((index, line), stamp)| {
            let pose =
                kitti_pose(line).ok_or_else(|| Failure::usage(texts::invalid_kitti_line(path, index + 1)))?;
            Ok((stamp, pose))
        })
        .collect()
}

fn kitti_pose(line: &str) -> Option<Isometry> {
    let numbers: Vec<f64> = line.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let matrix = nalgebra::Matrix3x4::from_row_iterator((numbers.len() == 12).then_some(numbers)?);
    let rotation = Rotation3::from_matrix_unchecked(matrix.fixed_columns::<3>(0).into_owned());
    let translation = Translation3::from(matrix.column(3).into_owned());
    // The matrix has few digits and is only nearly a rotation, so the quaternion is normalised.
    let rotation = Rotation::new_normalize(Rotation::from_rotation_matrix(&rotation).into_inner());
    Some(Isometry::from_parts(translation, rotation))
        .filter(|pose| pose.to_homogeneous().iter().all(|n| n.is_finite()))
}

fn truth_of_recording(path: &Path) -> Result<Vec<(Stamp, Pose)>, Failure> {
    let recording = Recording::open(path, &TopicSelection::default()).map_err(Failure::usage)?;
    let truth = recording.truth().map_err(Failure::usage)?;
    truth.ok_or_else(|| Failure::usage(texts::no_truth(path)))
}
