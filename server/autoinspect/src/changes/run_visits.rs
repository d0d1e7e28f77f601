//! Visits of which the clouds were kept on runs of missions.

use super::view::view;
use crate::failure::Failure;
use crate::texts;
use changes::Visit;
use geometry::isometry_from_pose;
use site_model::LocalisationQuality;
use std::path::Path;
use store::{RunCloudEntry, read_run_clouds, read_run_index};
use vocab::MapId;

/// The visits of two runs, in the frame of the last map of the later one in which both were localised.
pub fn of_runs(before: &Path, after: &Path) -> Result<[Visit; 2], Failure> {
    let maps_of = |path: &Path| -> Result<Vec<MapId>, Failure> {
        let entries = read_run_index(path).map_err(Failure::usage)?;
        Ok(entries.iter().filter_map(map_of).collect())
    };
    let (of_before, of_after) = (maps_of(before)?, maps_of(after)?);
    let common = of_after.iter().rev().find(|map| of_before.contains(map));
    let map = *common.ok_or_else(|| Failure::usage(texts::no_clouds_in_map(before)))?;
    Ok([of_run(before, map)?, of_run(after, map)?])
}

/// The visit of a run, in the frame of a map in which it was localised.
pub fn of_run(path: &Path, map: MapId) -> Result<Visit, Failure> {
    let mut visit = Visit::default();
    for cloud in read_run_clouds(path).map_err(Failure::usage)? {
        let cloud = cloud.map_err(Failure::usage)?;
        if map_of(&cloud.entry) != Some(map) {
            continue;
        }
        let Some(map_from_base) = isometry_from_pose(&cloud.entry.place.map_from_base) else { continue };
        let sensor = cloud.entry.base_from_sensor_m.map(|at| at as f32);
        visit.views.push(view(&map_from_base, &sensor, &cloud.xyz));
    }
    if visit.views.is_empty() {
        return Err(Failure::usage(texts::no_clouds_in_map(path)));
    }
    Ok(visit)
}

/// The map in which the robot was localised well when it saw a cloud.
fn map_of(entry: &RunCloudEntry) -> Option<MapId> {
    entry.place.map.filter(|_| entry.place.quality == LocalisationQuality::Good)
}
