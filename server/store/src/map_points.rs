//! All points of a map in the map frame.

use crate::{MapCloud, MapClouds, StoreError, TileFiles, files};
use api::TileList;
use std::path::Path;

/// Points of a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapPoints {
    /// Metres, map frame.
    pub xyz: Vec<[f32; 3]>,
    /// Sensor units, one for each point.
    pub intensity: Vec<f32>,
}

impl MapPoints {
    /// Reads all `clouds` and moves them into the map. Memory: 16 bytes a point, 32 while they come.
    ///
    /// # Errors
    /// When a cloud cannot be read.
    pub fn read(clouds: MapClouds) -> Result<Self, StoreError> {
        let mut points = Self::default();
        for cloud in clouds {
            points.add(&cloud?);
        }
        // Whoever works with these has need of the rest.
        points.xyz.shrink_to_fit();
        points.intensity.shrink_to_fit();
        Ok(points)
    }

    /// All that is drawn of the map in the folder `dir`, of its tiles: in that folder, or in the data directory that it belongs to. Each point
    /// is in one tile; they come coarsest first, placed to half a centimetre.
    ///
    /// # Errors
    /// When a tile is missing or cannot be understood.
    pub fn from_tiles(dir: &Path) -> Result<Self, StoreError> {
        let (own, shared) = (dir.join("tiles"), dir.join("..").join("..").join("tiles"));
        let tiles = TileFiles::new(if own.is_dir() { own } else { shared });
        let path = dir.join("tiles.json");
        let list: TileList = files::read_json(&path)?;
        let mut points = Self::default();
        for entry in &list.tiles {
            let chunk = map_codec::decode(&tiles.read(entry.hash)?)
                .map_err(|_| StoreError::Broken { path: path.clone(), what: "names a broken tile" })?;
            points.xyz.extend(chunk.points.iter().map(|point| chunk.position(point)));
            let unit = chunk.intensity_unit;
            points.intensity.extend(chunk.points.iter().map(|point| f32::from(point.intensity) * unit));
        }
        Ok(points)
    }

    /// Adds a keyframe's points; none when its pose is not one.
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
