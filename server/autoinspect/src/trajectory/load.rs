//! Trajectories from files.

use super::Track;
use crate::failure::Failure;
use recorder::{Recording, TopicSelection};
use std::path::Path;
use vocab::{Pose, Stamp};

/// Reads a TUM file, or the truth of a recording.
pub fn load(path: &Path) -> Result<Track, Failure> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let poses = match extension {
        "tum" | "txt" => read_tum(path)?,
        _ => truth_of_recording(path)?,
    };
    let mut track: Track = poses
        .iter()
        .filter_map(|(stamp, pose)| Some((*stamp, geometry::isometry_from_pose(pose)?)))
        .collect();
    track.sort_by_key(|(stamp, _)| *stamp);
    if track.is_empty() {
        return Err(Failure::usage(format!("{} holds no poses", path.display())));
    }
    Ok(track)
}

fn read_tum(path: &Path) -> Result<Vec<(Stamp, Pose)>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| Failure::unreadable(path, error))?;
    formats::tum::read(&text).map_err(|error| Failure::unreadable(path, error))
}

fn truth_of_recording(path: &Path) -> Result<Vec<(Stamp, Pose)>, Failure> {
    let recording = Recording::open(path, &TopicSelection::default()).map_err(Failure::usage)?;
    let truth = recording.truth().map_err(Failure::usage)?;
    truth.ok_or_else(|| Failure::usage(format!("{} does not say where the robot really was", path.display())))
}
