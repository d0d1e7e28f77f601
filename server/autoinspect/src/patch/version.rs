//! The new version's files: the same graph, clouds with the changes.

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

/// What was changed.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Changes {
    pub keyframes: u64,
    pub keyframes_changed: u64,
    /// Points of keyframes that were taken out.
    pub gone: u64,
    /// Points that were seen where the map showed nothing; several keyframes may have one.
    pub come: u64,
}

/// A point that has come.
#[derive(Clone, Copy, Debug)]
struct AddedPoint {
    in_map: Vector3,
    intensity: f32,
    /// The keyframe that is nearest to where it was seen from.
    home: usize,
}

/// Writes the version into a folder that is ready for it. Linear in the map's points; each keyframe looks at all that has come.
pub fn write_version(
    saved: &SavedMap,
    looks: &[RevisitScan],
    out: &Path,
    name: &str,
) -> Result<(MapSummary, Changes), Failure> {
    let clouds = || map_clouds_and_sensors(&saved.path).map_err(Failure::usage);
    let pose_of = |cloud: &MapCloud| saved.poses[cloud.keyframe.0 as usize];
    let (mut left, mut shown) = (Vec::new(), OccupiedCells::default());
    for read in clouds()? {
        let (mut cloud, _) = read.map_err(Failure::usage)?;
        let pose = pose_of(&cloud);
        let gone = removed_points(&pose, &cloud.xyz, looks, &MapChangesConfig::default());
        cloud.drop_points(&gone);
        cloud.xyz.iter().for_each(|point| shown.insert(&transform_to_map(&pose, point)));
        left.push(gone);
    }
    let added_points = added_points(saved, looks, &mut shown);
    let mut changes = Changes { come: added_points.len() as u64, ..Changes::default() };
    let out_clouds = out.join("clouds");
    let virtual_keyframes =
        copy_viewpoint_files(&saved.path.join("clouds"), &out_clouds, 0).map_err(Failure::failed)?;
    for (read, gone) in clouds()?.zip(left) {
        let (mut cloud, sensor) = read.map_err(Failure::usage)?;
        cloud.drop_points(&gone);
        let pose = pose_of(&cloud);
        let before = cloud.xyz.len();
        let view = RangeImage::new(&cloud.xyz, sensor);
        put_in(&mut cloud, &pose, &view, &added_points);
        changes.keyframes += 1;
        changes.gone += gone.len() as u64;
        let is_changed = !gone.is_empty() || cloud.xyz.len() > before;
        changes.keyframes_changed += u64::from(is_changed);
        // A virtual keyframe that did not change is in the shared file already.
        if is_changed || !virtual_keyframes.contains(cloud.keyframe) {
            write_cloud(&out_clouds, saved, cloud, sensor).map_err(Failure::failed)?;
        }
    }
    let finished = finished(saved, looks, name);
    let tiles = TileFiles::new(out.join("tiles"));
    let options = MapFileOptions { ply: true, has_pose_graph: saved.summary.has_pose_graph };
    let files = write_map_files(out, &tiles, &finished, options).map_err(Failure::failed)?;
    Ok((files.summary, changes))
}

fn added_points(saved: &SavedMap, looks: &[RevisitScan], shown: &mut OccupiedCells) -> Vec<AddedPoint> {
    let mut added_points = Vec::new();
    for (one, look) in looks.iter().enumerate() {
        let Some(home) = nearest_keyframe(&look.map_from_base, &saved.poses, &MapChangesConfig::default())
        else {
            continue;
        };
        added_points.extend(map_changes::added_points(looks, one, shown).into_iter().map(|index| {
            AddedPoint {
                in_map: transform_to_map(&look.map_from_base, &look.xyz[index as usize]),
                intensity: look.intensity.get(index as usize).copied().unwrap_or(0.0),
                home,
            }
        }));
    }
    added_points
}

/// Adds what belongs in a keyframe: what is at home there, and what stands where it looked through.
fn put_in(
    cloud: &mut MapCloud,
    map_from_keyframe: &Isometry,
    view: &RangeImage,
    added_points: &[AddedPoint],
) {
    let keyframe_from_map = map_from_keyframe.inverse();
    for added_point in added_points {
        let at = keyframe_from_map.rotation * added_point.in_map + keyframe_from_map.translation.vector;
        let point = at.map(|c| c as f32).into();
        if added_point.home == cloud.keyframe.0 as usize
            || is_in_free_space(view, &point, &MapChangesConfig::default())
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

/// The same graph, as a map of its own; the same recordings give the same id.
fn finished(saved: &SavedMap, looks: &[RevisitScan], name: &str) -> FinishedMap {
    let SavedMap { trajectory, decisions, summary, .. } = saved;
    let places = looks.iter().flat_map(|look| look.map_from_base.translation.vector.data.0[0]);
    let id = places.fold(summary.id.0.as_u128(), |id, c| id.rotate_left(7) ^ u128::from(c.to_bits()));
    FinishedMap {
        map: MapId(Uuid::from_u128(id)),
        name: name.to_owned(),
        session: SessionId(Uuid::nil()),
        extends: None,
        at: summary.created,
        distance: summary.distance,
        graph: Arc::new(saved.graph()),
        trajectory: trajectory.clone(),
        degenerate: Vec::new(),
        decisions: decisions.clone(),
        unverified: 0,
        visits: RevisitCounts::default(),
    }
}
