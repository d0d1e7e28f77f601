//! All points of a map in the map frame.

use crate::map_cloud::drop_places;
use crate::{MapCloud, Store, StoreError, TileFiles, files, texts};
use api::TileList;
use map_codec::PointChunk;
use mapping::line_of_sight::{LineOfSightConfig, OccupiedVoxels};
use std::path::Path;
use vocab::MapId;

/// Points of a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapPoints {
    /// Metres, map frame.
    pub xyz: Vec<[f32; 3]>,
    /// Sensor units, one for each point.
    pub intensity: Vec<f32>,
}

impl MapPoints {
    /// Takes all `clouds` (see [`crate::map_clouds()`]) and transforms them into the map frame. Memory: 16 bytes a point, 32 while reading.
    ///
    /// # Errors
    /// When a cloud cannot be read.
    pub fn read(clouds: impl IntoIterator<Item = Result<MapCloud, StoreError>>) -> Result<Self, StoreError> {
        let mut points = Self::default();
        for cloud in clouds {
            points.add(&cloud?);
        }
        // The caller needs the memory for its work on these points.
        points.xyz.shrink_to_fit();
        points.intensity.shrink_to_fit();
        Ok(points)
    }

    /// All points of the tiles of the map in the folder `dir`. The tiles lie in that folder, or in the data directory that it belongs to. Each point
    /// is in one tile. Points come coarsest tile first, each coordinate within half a centimetre.
    ///
    /// # Errors
    /// When a tile is missing or cannot be understood.
    pub fn from_tiles(dir: &Path) -> Result<Self, StoreError> {
        let mut points = Self::default();
        for_each_tile(dir, |chunk| {
            points.xyz.extend(chunk.points.iter().map(|point| chunk.position(point)));
            let unit = chunk.intensity_unit;
            points.intensity.extend(chunk.points.iter().map(|point| f32::from(point.intensity) * unit));
        })?;
        Ok(points)
    }

    /// Drops the points with these indices, which ascend.
    pub fn drop_points(&mut self, indices: &[u32]) {
        drop_places(&mut self.xyz, indices);
        drop_places(&mut self.intensity, indices);
    }

    /// Adds a keyframe's points; none if its pose is invalid.
    fn add(&mut self, cloud: &MapCloud) {
        let Some(map_from_keyframe) = geometry::isometry_from_pose(&cloud.map_from_keyframe) else {
            return;
        };
        self.xyz.extend(cloud.xyz.iter().map(|point| -> [f32; 3] {
            let in_map = map_from_keyframe.rotation * geometry::Vector3::from(point.map(f64::from))
                + map_from_keyframe.translation.vector;
            in_map.map(|coordinate| coordinate as f32).into()
        }));
        self.intensity.extend(&cloud.intensity);
    }
}

impl Store {
    /// The occupied voxels of a saved map, by which lines of sight are checked. Memory: those, and one tile at a time.
    ///
    /// # Errors
    /// When there is no such map, or a tile is missing or cannot be understood.
    pub fn occupied_voxels(
        &self,
        map: MapId,
        config: LineOfSightConfig,
    ) -> Result<OccupiedVoxels, StoreError> {
        let mut voxels = OccupiedVoxels::new(config);
        for_each_tile(&self.dir().map(map), |chunk| {
            chunk.points.iter().for_each(|point| voxels.insert(&chunk.position(point)));
        })?;
        Ok(voxels)
    }
}

/// Reads the tiles of the map in the folder `dir`, one at a time.
fn for_each_tile(dir: &Path, mut take: impl FnMut(&PointChunk)) -> Result<(), StoreError> {
    let (own_tiles, shared_tiles) = (dir.join("tiles"), dir.join("..").join("..").join("tiles"));
    let tiles = TileFiles::new(if own_tiles.is_dir() { own_tiles } else { shared_tiles });
    let path = dir.join("tiles.json");
    let list: TileList = files::read_json(&path)?;
    for entry in &list.tiles {
        let chunk = map_codec::decode(&tiles.read(entry.hash)?)
            .map_err(|_| StoreError::Broken { path: path.clone(), what: texts::BROKEN_TILE })?;
        take(&chunk);
    }
    Ok(())
}
