//! Writes the files of a map's new version: the same graph, and clouds with the changes.

use crate::failure::Failure;
use api::MapSummary;
use geometry::{Isometry, Vector3};
use mapping::map_changes::{
    self, MapChangesConfig, OccupiedCells, RevisitScan, is_in_free_space, nearest_keyframe, removed_points,
    transform_to_map,
};
use mapping::range_image::RangeImage;
use messages::{Cloud, FinishedMap, Keyframe, RevisitCounts};
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use store::{
    MapCloud, MapFileOptions, SavedMap, StoreError, TileFiles, copy_viewpoint_files, map_clouds_and_sensors,
    write_map_files,
};
use uuid::Uuid;
use vocab::{MapId, SessionId};

/// Numbers of changes.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct ChangeCounts {
    pub keyframes: u64,
    pub keyframes_changed: u64,
    /// Number of points that were removed from keyframes.
    #[serde(rename = "gone")]
    pub removed: u64,
    /// Number of points that were added because the map had no surface there. Several keyframes may contain the same point.
    #[serde(rename = "come")]
    pub added: u64,
}

/// A point at which the map had no surface.
#[derive(Clone, Copy, Debug)]
struct AddedPoint {
    /// Position in the map, metres.
    in_map: Vector3,
    /// Intensity, sensor units.
    intensity: f32,
    /// Index of the keyframe nearest to the scan that saw it. This keyframe always contains it.
    nearest_keyframe: usize,
}

/// Writes the new version into the prepared folder `out`. `scans` are localised scans of later recordings. Cost: linear in the
/// map's points, and in keyframes times added points.
///
/// # Errors
/// When a cloud cannot be read or a file cannot be written.
pub fn write_version(
    saved: &SavedMap,
    scans: &[RevisitScan],
    out: &Path,
    name: &str,
) -> Result<(MapSummary, ChangeCounts), Failure> {
    let clouds = || map_clouds_and_sensors(&saved.path).map_err(Failure::usage);
    let pose_of = |cloud: &MapCloud| saved.poses[cloud.keyframe.0 as usize];
    let config = MapChangesConfig::default();
    let (mut removed, mut occupied) = (Vec::new(), OccupiedCells::default());
    for read in clouds()? {
        let (mut cloud, _) = read.map_err(Failure::usage)?;
        let pose = pose_of(&cloud);
        let indices = removed_points(&pose, &cloud.xyz, scans, &config);
        cloud.drop_points(&indices);
        cloud.xyz.iter().for_each(|point| occupied.insert(&transform_to_map(&pose, point)));
        removed.push(indices);
    }
    let added_points = added_points(saved, scans, &mut occupied, &config);
    let mut changes = ChangeCounts { added: added_points.len() as u64, ..ChangeCounts::default() };
    let out_clouds = out.join("clouds");
    let virtual_keyframes =
        copy_viewpoint_files(&saved.path.join("clouds"), &out_clouds, 0).map_err(Failure::failed)?;
    for (read, indices) in clouds()?.zip(removed) {
        let (mut cloud, sensor) = read.map_err(Failure::usage)?;
        cloud.drop_points(&indices);
        let pose = pose_of(&cloud);
        let count = cloud.xyz.len();
        let view = RangeImage::new(&cloud.xyz, sensor);
        insert_points(&mut cloud, &pose, &view, &added_points, &config);
        changes.keyframes += 1;
        changes.removed += indices.len() as u64;
        let is_changed = !indices.is_empty() || cloud.xyz.len() > count;
        changes.keyframes_changed += u64::from(is_changed);
        // A virtual keyframe that did not change is already in the shared file.
        if is_changed || !virtual_keyframes.contains(cloud.keyframe) {
            write_cloud(&out_clouds, saved, cloud, sensor).map_err(Failure::failed)?;
        }
    }
    let finished = new_version(saved, scans, name);
    let tiles = TileFiles::new(out.join("tiles"));
    let options = MapFileOptions { ply: true, has_pose_graph: saved.summary.has_pose_graph };
    let files = write_map_files(out, &tiles, &finished, options).map_err(Failure::failed)?;
    Ok((files.summary, changes))
}

fn added_points(
    saved: &SavedMap,
    scans: &[RevisitScan],
    occupied: &mut OccupiedCells,
    config: &MapChangesConfig,
) -> Vec<AddedPoint> {
    let mut added_points = Vec::new();
    for (index_of_scan, scan) in scans.iter().enumerate() {
        let Some(keyframe) = nearest_keyframe(&scan.map_from_base, &saved.poses, config) else { continue };
        added_points.extend(map_changes::added_points(scans, index_of_scan, occupied).into_iter().map(
            |index| AddedPoint {
                in_map: transform_to_map(&scan.map_from_base, &scan.xyz[index as usize]),
                intensity: scan.intensity.get(index as usize).copied().unwrap_or(0.0),
                nearest_keyframe: keyframe,
            },
        ));
    }
    added_points
}

/// Adds to a keyframe the points of the scans nearest to it, and the points in its free space.
fn insert_points(
    cloud: &mut MapCloud,
    map_from_keyframe: &Isometry,
    view: &RangeImage,
    added_points: &[AddedPoint],
    config: &MapChangesConfig,
) {
    let keyframe_from_map = map_from_keyframe.inverse();
    for added_point in added_points {
        let at = keyframe_from_map.rotation * added_point.in_map + keyframe_from_map.translation.vector;
        let point = at.map(|c| c as f32).into();
        if added_point.nearest_keyframe == cloud.keyframe.0 as usize || is_in_free_space(view, &point, config)
        {
            cloud.xyz.push(point);
            cloud.intensity.push(added_point.intensity);
        }
    }
}

fn write_cloud(clouds: &Path, saved: &SavedMap, cloud: MapCloud, lidar: [f32; 3]) -> Result<(), StoreError> {
    let MapCloud { keyframe: id, map_from_keyframe, xyz, intensity } = cloud;
    let keyframe = Keyframe {
        session: SessionId(Uuid::nil()),
        id,
        stamp: saved.stamps[id.0 as usize],
        map_from_keyframe,
        cloud: Arc::new(Cloud { xyz, intensity }),
        lidar,
    };
    store::write_cloud(clouds, &keyframe)
}

/// The same graph as a new map. The same scans give the same id.
fn new_version(saved: &SavedMap, scans: &[RevisitScan], name: &str) -> FinishedMap {
    let SavedMap { trajectory, decisions, summary, .. } = saved;
    let coordinates = scans.iter().flat_map(|scan| scan.map_from_base.translation.vector.data.0[0]);
    let id = coordinates.fold(summary.id.0.as_u128(), |id, c| id.rotate_left(7) ^ u128::from(c.to_bits()));
    FinishedMap {
        map: MapId(Uuid::from_u128(id)),
        name: name.to_owned(),
        session: SessionId(Uuid::nil()),
        extends: None,
        at: summary.created,
        distance_m: summary.distance_m,
        graph: Arc::new(saved.graph()),
        trajectory: trajectory.clone(),
        degenerate: Vec::new(),
        decisions: decisions.clone(),
        unverified: 0,
        revisits: RevisitCounts::default(),
    }
}
