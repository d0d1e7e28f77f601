//! Reads visits: what was seen from where.

use super::run_visits;
use super::view::view;
use crate::failure::Failure;
use crate::texts;
use changes::Visit;
use geometry::{Isometry, isometry_from_pose, se3};
use messages::Sensor;
use recorder::{Recording, TopicSelection};
use std::path::Path;
use store::{SavedMap, is_run_clouds_folder, map_clouds_and_sensors};
use vocab::{MapId, Pose, Span, Stamp};

/// How poses are found at the times of scans.
#[derive(Clone, Copy, Debug)]
struct VisitPosesConfig {
    /// Longest time between two poses between which a pose is interpolated: two of a pose estimate with 10 Hz, and some lost ones. Chosen: at walking speed the robot
    /// goes half a metre in it.
    max_gap: Span,
}

const CONFIG: VisitPosesConfig = VisitPosesConfig { max_gap: Span::from_millis(500) };

/// Reads both visits, in one frame.
pub fn read_both(before: &Path, after: &Path) -> Result<[Visit; 2], Failure> {
    match [before, after].map(is_run_clouds_folder) {
        [false, false] => Ok([read(before)?, read(after)?]),
        [true, true] => run_visits::of_runs(before, after),
        [true, false] => {
            let map = map_of(after, before)?;
            Ok([run_visits::of_run(before, map)?, of_map(after)?])
        }
        [false, true] => {
            let map = map_of(before, after)?;
            Ok([of_map(before)?, run_visits::of_run(after, map)?])
        }
    }
}

/// Reads a visit that is in the frame of a map: a run that was localised in it, or what somebody has brought into its frame.
pub fn read_after(path: &Path, map: MapId) -> Result<Visit, Failure> {
    if is_run_clouds_folder(path) { run_visits::of_run(path, map) } else { read(path) }
}

/// The map in the folder `path`, with which the run in `run` is compared.
fn map_of(path: &Path, run: &Path) -> Result<MapId, Failure> {
    if !is_map(path) {
        return Err(Failure::usage(texts::run_and_recording(run, path)));
    }
    Ok(SavedMap::read(path).map_err(Failure::usage)?.summary.id)
}

fn is_map(path: &Path) -> bool {
    path.join("graph.json").is_file()
}

/// Reads the visit of a recording or of the folder of a map.
fn read(path: &Path) -> Result<Visit, Failure> {
    if is_map(path) { of_map(path) } else { of_recording(path) }
}

/// The keyframes of a map.
fn of_map(path: &Path) -> Result<Visit, Failure> {
    let clouds = map_clouds_and_sensors(path).map_err(Failure::usage)?;
    let mut visit = Visit::default();
    for read in clouds {
        let (cloud, sensor) = read.map_err(Failure::usage)?;
        let Some(map_from_keyframe) = isometry_from_pose(&cloud.map_from_keyframe) else { continue };
        visit.views.push(view(&map_from_keyframe, &sensor, &cloud.xyz));
    }
    Ok(visit)
}

/// The scans of a recording whose poses it holds.
fn of_recording(path: &Path) -> Result<Visit, Failure> {
    let recording = Recording::open(path, &TopicSelection::default()).map_err(Failure::usage)?;
    recording.require_scans().map_err(Failure::usage)?;
    let mounting = recording.mounting();
    let base_from =
        |sensor: Option<Pose>| sensor.and_then(|pose| isometry_from_pose(&pose)).unwrap_or_default();
    let external_from_lidar =
        base_from(mounting.base_from_external).inverse() * base_from(mounting.base_from_lidar);
    let (mut scans, mut poses) = (Vec::new(), Vec::new());
    for message in recording.inputs() {
        match message.map_err(Failure::usage)?.1 {
            Sensor::Scan(scan) => scans.push(scan),
            Sensor::Odometry(odometry) => {
                poses.extend(
                    isometry_from_pose(&odometry.odom_from_external).map(|pose| (odometry.stamp, pose)),
                );
            }
            _ => {}
        }
    }
    poses.sort_by_key(|(stamp, _)| *stamp);
    let mut visit = Visit::default();
    for scan in scans {
        if let Some(map_from_external) = pose_at(&poses, scan.stamp) {
            let map_from_lidar = map_from_external * external_from_lidar;
            visit.views.push(view(&map_from_lidar, &[0.0; 3], &scan.xyz));
        }
    }
    if visit.views.is_empty() {
        return Err(Failure::usage(texts::no_poses_in(path)));
    }
    Ok(visit)
}

/// The pose at an instant, between those before and after it.
fn pose_at(poses: &[(Stamp, Isometry)], at: Stamp) -> Option<Isometry> {
    let after = poses.partition_point(|(stamp, _)| *stamp < at);
    if let Some((stamp, pose)) = poses.get(after)
        && *stamp == at
    {
        return Some(*pose);
    }
    let ((from, first), (to, second)) = poses.get(after.checked_sub(1)?).zip(poses.get(after))?;
    let gap = *to - *from;
    (gap <= CONFIG.max_gap).then(|| se3::interpolate(first, second, (at - *from).secs_f64() / gap.secs_f64()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_interpolated_over_short_gaps_only() {
        let at = |x: f64| Isometry::translation(x, 0.0, 0.0);
        let stamp = Stamp::from_secs_f64;
        let poses = [(stamp(1.0), at(0.0)), (stamp(1.2), at(1.0)), (stamp(9.0), at(2.0))];
        let x = |secs: f64| pose_at(&poses, stamp(secs)).map(|pose| (pose.translation.x * 1e6).round() / 1e6);
        assert_eq!(x(1.0), Some(0.0));
        assert_eq!(x(1.05), Some(0.25));
        assert_eq!(x(1.2), Some(1.0));
        assert_eq!((x(5.0), x(0.5), x(9.5)), (None, None, None));
        assert_eq!(x(9.0), Some(2.0));
    }
}
