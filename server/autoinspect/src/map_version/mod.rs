//! Writes the files of a map's new version: the same graph, and clouds with the changes of a [`MapEdit`].

mod regression;

use crate::failure::Failure;
use api::MapSummary;
use geometry::{Isometry, Vector3};
use mapping::map_changes::{MapChangesConfig, is_in_free_space};
use mapping::range_image::RangeImage;
use messages::{Cloud, FinishedMap, Keyframe, RevisitCounts};
pub use regression::{Fitness, RegressionConfig, find_regression};
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use store::{
    MapCloud, MapFileOptions, MapPoints, SavedMap, StoreError, TileFiles, copy_viewpoint_files,
    map_clouds_and_sensors, write_map_files, write_map_files_of,
};
use uuid::Uuid;
use vocab::{MapId, SessionId, Stamp};

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
pub struct AddedPoint {
    /// Position in the map, metres.
    pub in_map: Vector3,
    /// Intensity, sensor units.
    pub intensity: f32,
    /// Index of the keyframe nearest to the scan that saw it. This keyframe always contains it.
    pub nearest_keyframe: usize,
}

/// What a new version of a map has less and more.
pub trait MapEdit {
    /// Indices of the points of a cloud (frame of its keyframe, metres) that are gone.
    fn removed(&self, map_from_keyframe: &Isometry, xyz: &[[f32; 3]]) -> Vec<u32>;

    /// Takes note of the points of a cloud that stay.
    fn keep(&mut self, map_from_keyframe: &Isometry, xyz: &[[f32; 3]]);

    /// The points that are new. All points that stay are known.
    fn added(&mut self) -> Vec<AddedPoint>;
}

/// A new version of a map.
pub struct NewVersion<'a> {
    /// Its id.
    pub id: MapId,
    /// Its name.
    pub name: &'a str,
    /// When what it shows was seen.
    pub at: Stamp,
}

impl<'a> NewVersion<'a> {
    /// A version of a map; the same numbers give the same id.
    pub fn new(saved: &SavedMap, name: &'a str, at: Stamp, numbers: impl IntoIterator<Item = f64>) -> Self {
        let of_map = saved.summary.id.0.as_u128();
        let id =
            numbers.into_iter().fold(of_map, |id, number| id.rotate_left(7) ^ u128::from(number.to_bits()));
        Self { id: MapId(Uuid::from_u128(id)), name, at }
    }
}

/// Writes the new version into the prepared folder `out`. Cost: that of the edit, linear in the map's points, and in keyframes times added points.
///
/// # Errors
/// When a cloud cannot be read or a file cannot be written.
pub fn write_version(
    saved: &SavedMap,
    edit: &mut dyn MapEdit,
    version: &NewVersion<'_>,
    out: &Path,
) -> Result<(MapSummary, ChangeCounts), Failure> {
    let clouds = || map_clouds_and_sensors(&saved.path).map_err(Failure::usage);
    let pose_of = |cloud: &MapCloud| saved.poses[cloud.keyframe.0 as usize];
    let config = MapChangesConfig::default();
    let mut removed = Vec::new();
    for read in clouds()? {
        let (mut cloud, _) = read.map_err(Failure::usage)?;
        let pose = pose_of(&cloud);
        let indices = edit.removed(&pose, &cloud.xyz);
        cloud.drop_points(&indices);
        edit.keep(&pose, &cloud.xyz);
        removed.push(indices);
    }
    let added_points = edit.added();
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
    let finished = finished_map(saved, version);
    let tiles = TileFiles::new(out.join("tiles"));
    let options = MapFileOptions { ply: true, has_pose_graph: saved.summary.has_pose_graph };
    let files = if saved.summary.has_pose_graph {
        write_map_files(out, &tiles, &finished, options)
    } else {
        // The tiles of an imported map have all points, its clouds only a part.
        let points = edited_points(saved, edit, &added_points)?;
        write_map_files_of(out, &tiles, &finished, options, points)
    };
    Ok((files.map_err(Failure::failed)?.summary, changes))
}

/// The points of the map's tiles, without those that are gone and with those that are new.
fn edited_points(saved: &SavedMap, edit: &dyn MapEdit, added: &[AddedPoint]) -> Result<MapPoints, Failure> {
    let mut points = MapPoints::from_tiles(&saved.path).map_err(Failure::usage)?;
    let gone = edit.removed(&Isometry::identity(), &points.xyz);
    points.drop_points(&gone);
    points.xyz.extend(added.iter().map(|point| <[f32; 3]>::from(point.in_map.map(|c| c as f32))));
    points.intensity.extend(added.iter().map(|point| point.intensity));
    Ok(points)
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

/// The same graph as a new map.
fn finished_map(saved: &SavedMap, version: &NewVersion<'_>) -> FinishedMap {
    let SavedMap { trajectory, decisions, summary, .. } = saved;
    FinishedMap {
        map: version.id,
        name: version.name.to_owned(),
        session: SessionId(Uuid::nil()),
        extends: None,
        at: version.at,
        distance_m: summary.distance_m,
        graph: Arc::new(saved.graph()),
        trajectory: trajectory.clone(),
        degenerate: Vec::new(),
        decisions: decisions.clone(),
        unverified: 0,
        revisits: RevisitCounts::default(),
    }
}
