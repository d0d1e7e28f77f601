//! The surfaces of a known map in square tiles, each built when a point in it is first looked up.
//!
//! A lookup builds only the tile around its point. A robot whose pose is given can therefore begin within a second in a map of any size. A tile is
//! built from the keyframes alone, in their order, so it does not depend on the order of the lookups.

use geometry::{Isometry, Vector3};
use mapping::KeyframeDescriptor;
use points::hash::{CellKey, CellTable};
use points::{GaussianMap, GaussianMapConfig, Surface, SurfaceMap};
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

/// The keyframes of a map, each with its pose.
pub(crate) type Keyframes = Arc<[(Isometry, KeyframeDescriptor)]>;

/// Parameters of [`TiledSurfaces`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiledSurfacesConfig {
    /// Parameters of the surfaces in a tile.
    pub surfaces: GaussianMapConfig,
    /// Edge of a tile in root cubes of the surfaces, as a power of two: 4 means 16 cubes, 32 m. Larger tiles take longer to build at once,
    /// smaller ones transform the same points more often. A power of two, because every lookup divides by it. Chosen: a hall or some rooms.
    pub tile_size_log2: u32,
}

impl Default for TiledSurfacesConfig {
    fn default() -> Self {
        Self { surfaces: GaussianMapConfig::for_thinned_clouds(), tile_size_log2: 4 }
    }
}

/// Surfaces by tile.
#[derive(Debug)]
pub struct TiledSurfaces {
    config: TiledSurfacesConfig,
    keyframes: Keyframes,
    /// Indices into `tiles`.
    table: CellTable,
    tiles: Vec<Tile>,
}

#[derive(Debug)]
struct Tile {
    /// Index of the tile along x and y.
    index: [i64; 2],
    /// Keyframes whose points may lie in the tile, in their order.
    keyframes: Vec<u32>,
    surfaces: OnceLock<GaussianMap>,
}

impl TiledSurfaces {
    /// Tiles over these keyframes. Builds none of the surfaces yet. Linear in the points: one or two nanoseconds each.
    pub(crate) fn new(config: TiledSurfacesConfig, keyframes: Keyframes) -> Self {
        let mut reached: BTreeMap<[i64; 2], Vec<u32>> = BTreeMap::new();
        for (number, (map_from_keyframe, descriptor)) in (0..).zip(keyframes.iter()) {
            let Some([min, max]) = bounding_box(map_from_keyframe, descriptor) else { continue };
            // A tile also holds the root cubes next to it.
            let [first, last] = [(min, -1), (max, 1)].map(|(corner, margin)| {
                let cube = config.surfaces.root_cell(corner.as_ref());
                [cube[0], cube[1]].map(|index| (index + margin) >> config.tile_size_log2)
            });
            for x in first[0]..=last[0] {
                for y in first[1]..=last[1] {
                    reached.entry([x, y]).or_default().push(number);
                }
            }
        }
        let mut table = CellTable::with_capacity(reached.len());
        let tiles: Vec<Tile> = reached
            .into_iter()
            .map(|(index, keyframes)| Tile { index, keyframes, surfaces: OnceLock::new() })
            .collect();
        for (number, tile) in (0..).zip(&tiles) {
            table.get_or_insert(key(tile.index), number);
        }
        Self { config, keyframes, table, tiles }
    }

    /// The surfaces around a point; the first call builds them. `None` where no surface was seen.
    #[inline]
    fn surfaces_at(&self, point: &[f64; 3]) -> Option<&GaussianMap> {
        let cube = self.config.surfaces.root_cell(point);
        let index = [cube[0], cube[1]].map(|index| index >> self.config.tile_size_log2);
        let tile = &self.tiles[self.table.get(key(index))? as usize];
        Some(tile.surfaces.get_or_init(|| self.build(tile)))
    }

    /// Builds a tile with the root cubes next to it, which hold what lies near its border. Linear in the points of the keyframes that reach
    /// it: 5 ns each, and 0.2 us each for those that lie in it.
    fn build(&self, tile: &Tile) -> GaussianMap {
        let size = 1_i64 << self.config.tile_size_log2;
        let mut surfaces = GaussianMap::new(self.config.surfaces);
        let is_within = |cube: i64, tile: i64| (-1..=size).contains(&(cube - tile * size));
        for (map_from_keyframe, descriptor) in
            tile.keyframes.iter().map(|number| &self.keyframes[*number as usize])
        {
            let rotation = map_from_keyframe.rotation.to_rotation_matrix();
            let origin = map_from_keyframe.translation.vector;
            for point in descriptor.points() {
                let at = (rotation * Vector3::from(point.map(f64::from)) + origin).into();
                let cube = self.config.surfaces.root_cell(&at);
                if is_within(cube[0], tile.index[0]) && is_within(cube[1], tile.index[1]) {
                    surfaces.insert_from_viewpoint(&at, origin.as_ref());
                }
            }
        }
        surfaces
    }

    /// Builds all tiles within a distance of a position, metres, so that a robot that walks there never waits for one.
    pub fn build_around(&self, position: &Vector3, radius_m: f64) {
        for tile in &self.tiles {
            let edge_m = f64::from(1_u32 << self.config.tile_size_log2) * self.config.surfaces.root_size_m;
            let centre = tile.index.map(|index| (index as f64 + 0.5) * edge_m);
            let distance_m = (centre[0] - position.x).abs().max((centre[1] - position.y).abs());
            if distance_m <= radius_m + edge_m / 2.0 {
                tile.surfaces.get_or_init(|| self.build(tile));
            }
        }
    }

    /// Number of tiles built so far, and of all tiles.
    pub fn built_tiles(&self) -> (usize, usize) {
        (self.tiles.iter().filter(|tile| tile.surfaces.get().is_some()).count(), self.tiles.len())
    }
}

impl SurfaceMap for TiledSurfaces {
    #[inline]
    fn find_surface(&self, point: &[f64; 3], gate: f32) -> Option<Surface> {
        self.surfaces_at(point)?.find_surface(point, gate)
    }

    #[inline]
    fn find_surface_facing(&self, point: &[f64; 3], from: &[f64; 3], gate: f32) -> Option<Surface> {
        self.surfaces_at(point)?.find_surface_facing(point, from, gate)
    }
}

fn key([x, y]: [i64; 2]) -> CellKey {
    CellKey::new([x, y, 0])
}

/// Corners of a box along the map's axes that holds all points of a keyframe, metres; none if it has no points.
fn bounding_box(map_from_keyframe: &Isometry, descriptor: &KeyframeDescriptor) -> Option<[Vector3; 2]> {
    let [min, max] = descriptor.extent()?.map(|corner| Vector3::from(corner.map(f64::from)));
    let rotation = map_from_keyframe.rotation.to_rotation_matrix().into_inner();
    let centre = rotation * ((min + max) / 2.0) + map_from_keyframe.translation.vector;
    let half = rotation.abs() * ((max - min) / 2.0);
    Some([centre - half, centre + half])
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{RngTree, Rotation};
    use points::Downsampler;

    /// Keyframes along a street 150 m long, with the ground and a wall on both sides.
    fn street() -> Keyframes {
        let mut rng = RngTree::new(5).child("street").rng();
        let mut place = || {
            let xyz: Vec<[f32; 3]> = (0..6_000)
                .map(|number| {
                    let [x, across, noise] =
                        [30.0, 4.0, 0.01].map(|reach| reach * (2.0 * rng.uniform() - 1.0));
                    match number % 3 {
                        0 => [x, across, -0.5 + noise],
                        1 => [x, 4.0 + noise, across / 2.0 + 1.5],
                        _ => [x, -4.0 + noise, across / 2.0 + 1.5],
                    }
                    .map(|c| c as f32)
                })
                .collect();
            KeyframeDescriptor::new(&xyz, &Rotation::identity(), [0.0; 3], &mut Downsampler::default())
        };
        let turn = geometry::so3::exp(&(Vector3::z() * 0.6));
        (0..12)
            .map(|step| {
                let at = turn * Vector3::new(12.0 * f64::from(step), 0.0, 0.0);
                (Isometry::from_parts(at.into(), turn), place())
            })
            .collect()
    }

    #[test]
    fn tiles_agree_with_one_map_of_all_keyframes() {
        let keyframes = street();
        let config = TiledSurfacesConfig::default();
        let mut whole = GaussianMap::new(config.surfaces);
        for (pose, place) in keyframes.iter() {
            for point in place.points() {
                let at = pose.rotation * Vector3::from(point.map(f64::from)) + pose.translation.vector;
                whole.insert_from_viewpoint(&at.into(), pose.translation.vector.as_ref());
            }
        }
        let tiled = TiledSurfaces::new(config, keyframes.clone());
        assert_eq!(tiled.built_tiles().0, 0);
        let (mut known, mut unlike) = (0, 0);
        for (pose, place) in keyframes.iter() {
            let from = pose.translation.vector;
            for point in place.points() {
                // Two centimetres off the surface; some points lie on the border of two tiles.
                let at = pose.rotation * Vector3::from(point.map(|c| f64::from(c) + 0.02)) + from;
                let one = whole.find_surface_facing(at.as_ref(), from.as_ref(), 0.1);
                known += usize::from(one.is_some());
                unlike += usize::from(one != tiled.find_surface_facing(at.as_ref(), from.as_ref(), 0.1));
            }
        }
        assert!(known > 10_000, "{known}");
        assert_eq!(unlike, 0, "of {known}");
        assert!(tiled.built_tiles().0 > 4, "{:?}", tiled.built_tiles());
        assert_eq!(tiled.find_surface(&[500.0, 500.0, 0.0], 0.1), None);
    }

    #[test]
    fn only_tiles_that_are_looked_up_are_built() {
        let tiled = TiledSurfaces::new(TiledSurfacesConfig::default(), street());
        assert!(tiled.find_surface(&[0.0, 0.0, -0.5], 0.1).is_some());
        let (built, all) = tiled.built_tiles();
        assert!(built == 1 && all > 8, "{built} of {all}");
        tiled.build_around(&Vector3::zeros(), 20.0);
        let about = tiled.built_tiles().0;
        assert!(about > built && about < all, "{about} of {all}");
        for at in [[15.0, 15.0, -0.5], [-15.0, 0.0, -0.5], [19.0, -19.0, 0.0]] {
            tiled.find_surface(&at, 0.1);
        }
        assert_eq!(tiled.built_tiles().0, about);
    }
}
