//! Visits of which the clouds were kept on runs of missions.

use super::place::Place;
use super::two_threads::OnTwoThreads;
use super::view::view;
use crate::failure::Failure;
use crate::texts;
use changes::{Join, UprightBox, Visit};
use geometry::isometry_from_pose;
use site_model::{LocalisationQuality, OrientedBox};
use std::path::Path;
use store::{ChangedSince, RunCloudEntry, read_changed_since, read_run_clouds, read_run_index};
use vocab::MapId;

/// Rays of older clouds that ended this close to where something was, metres, or passed this close to where something is, tell nothing of it any more. Chosen: a box that was found is right to some
/// centimetres, and so are poses.
const CHANGED_MARGIN_M: f64 = 0.1;

/// The visits of two runs, in the frame of the last map of the later one in which both were localised.
pub fn of_runs(before: &Path, after: &Path) -> Result<[Visit; 2], Failure> {
    let maps_of = |path: &Path| -> Result<Vec<MapId>, Failure> {
        let entries = read_run_index(path).map_err(Failure::usage)?;
        Ok(entries.iter().filter_map(map_of).collect())
    };
    let (of_before, of_after) = (maps_of(before)?, maps_of(after)?);
    let common = of_after.iter().rev().find(|map| of_before.contains(map));
    let map = *common.ok_or_else(|| Failure::usage(texts::no_clouds_in_map(before)))?;
    let (before, after) = OnTwoThreads.join(|| of_run(before, map), || of_run(after, map));
    Ok([before?, after?])
}

/// The visit of a run, or what was last seen on several, in the frame of a map in which the robot was localised.
pub fn of_run(path: &Path, map: MapId) -> Result<Visit, Failure> {
    let changes = read_changed_since(path).map_err(Failure::usage)?;
    let mut visit = Visit::default();
    for cloud in read_run_clouds(path).map_err(Failure::usage)? {
        let cloud = cloud.map_err(Failure::usage)?;
        if map_of(&cloud.entry) != Some(map) {
            continue;
        }
        let Some(map_from_base) = isometry_from_pose(&cloud.entry.place.map_from_base) else { continue };
        let sensor = cloud.entry.base_from_sensor_m.map(|at| at as f32);
        let view = view(&map_from_base, &sensor, &cloud.xyz);
        let newer: Vec<&ChangedSince> =
            changes.iter().filter(|change| change.utc_ns > cloud.entry.utc_ns).collect();
        let boxes = |place: fn(&ChangedSince) -> Option<OrientedBox>| -> Vec<UprightBox> {
            newer
                .iter()
                .filter_map(|change| place(change))
                .map(|place| Place::of_box(&place).upright_box())
                .collect()
        };
        let (was, is) = (boxes(|change| change.was), boxes(|change| change.is));
        visit.views.push(if newer.is_empty() {
            view
        } else {
            view.without_changed(&was, &is, CHANGED_MARGIN_M)
        });
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

#[cfg(test)]
mod tests {
    use super::*;
    use site_model::{ReportPlace, RunId};
    use store::{RunCloudCause, RunCloudsConfig, Store};
    use uuid::Uuid;
    use vocab::{BlobHash, Covariance6, Pose, Stamp, Vec3};

    #[test]
    fn older_clouds_do_not_show_what_a_newer_run_found_elsewhere() {
        let map = MapId(Uuid::from_u128(1));
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path().join("data")).expect("opens");
        let clouds = [10, 20].map(|utc_ns| {
            let entry = RunCloudEntry {
                cloud: BlobHash([0; 32]),
                bytes: 0,
                robot_time: Stamp::EPOCH,
                utc_ns,
                cause: RunCloudCause::Distance,
                mission: None,
                step: None,
                place: ReportPlace {
                    map: Some(map),
                    map_from_base: Pose::IDENTITY,
                    covariance: Covariance6::default(),
                    quality: LocalisationQuality::Good,
                },
                base_from_sensor_m: [0.0; 3],
                points: 2,
            };
            let run = RunId(Uuid::from_u128(utc_ns as u128));
            let config = RunCloudsConfig { min_free_bytes: 0, ..RunCloudsConfig::default() };
            let points = [[3.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
            let put = store.put_run_cloud(run, entry, &points, &[], &config);
            (run, put.expect("written").expect("there is room"))
        });
        let place = OrientedBox { centre_m: Vec3::new(3.0, 0.0, 0.0), size_m: [0.5; 3], yaw_rad: 0.0 };
        let change = ChangedSince { utc_ns: 20, was: Some(place), is: None };
        let folder = dir.path().join("background");
        store.put_background(&folder, &clouds, vec![change]).expect("written");
        let visit = of_run(&folder, map).expect("read");
        let counts: Vec<usize> = visit.views.iter().map(|view| view.points.len()).collect();
        assert_eq!(counts, [1, 2], "the run that found it saw what is there now");
    }
}
