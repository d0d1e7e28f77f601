//! A known map's surfaces in square tiles, each made when it is first looked at.
//!
//! Whatever looks at a place pays for the tiles about it and no others, so that a robot that is told where it is can begin within a
//! second in a map of any size. A tile is made of the keyframes alone, in their order: who looks first, and when, changes nothing.

use geometry::{Isometry, Vector3};
use mapping::KeyframeDescriptor;
use points::hash::{CellKey, CellTable};
use points::{GaussianMap, GaussianMapConfig, Surface, SurfaceMap};
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

/// Edge of a tile, root cubes: 32 m. Larger ones take longer at once, smaller ones more often turn the same points.
const TILE: i64 = 16;

/// What the surfaces are made of: keyframes, each with its pose in the map.
pub(crate) type Keyframes = Arc<[(Isometry, KeyframeDescriptor)]>;

/// SurfaceMap by tile.
#[derive(Debug)]
pub struct TiledSurfaces {
    config: GaussianMapConfig,
    keyframes: Keyframes,
    /// Numbers of `tiles`.
    table: CellTable,
    tiles: Vec<Tile>,
}

#[derive(Debug)]
struct Tile {
    /// In tiles along x and y.
    at: [i64; 2],
    /// Keyframes whose points may lie in it, in their order.
    reached_by: Vec<u32>,
    surfaces: OnceLock<GaussianMap>,
}

impl TiledSurfaces {
    /// Of keyframes; makes none of the surfaces yet. Linear in their points: a nanosecond or two each.
    pub(crate) fn new(config: GaussianMapConfig, keyframes: Keyframes) -> Self {
        let mut reached: BTreeMap<[i64; 2], Vec<u32>> = BTreeMap::new();
        for (number, (map_from_keyframe, place)) in (0..).zip(keyframes.iter()) {
            let Some([least, most]) = extent(map_from_keyframe, place) else { continue };
            let [first, last] = [(least, -1), (most, 1)].map(|(corner, beyond)| {
                let cell = config.root_cell(corner.as_ref());
                [cell[0], cell[1]].map(|cell| (cell + beyond).div_euclid(TILE))
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
            .map(|(at, reached_by)| Tile { at, reached_by, surfaces: OnceLock::new() })
            .collect();
        for (number, tile) in (0..).zip(&tiles) {
            table.get_or_insert(key(tile.at), number);
        }
        Self { config, keyframes, table, tiles }
    }

    /// SurfaceMap of all that lies about a point; the first call makes them. None where nothing was seen.
    #[inline]
    fn about(&self, point: &[f64; 3]) -> Option<&GaussianMap> {
        let cell = self.config.root_cell(point);
        let number = self.table.get(key([cell[0], cell[1]].map(|cell| cell.div_euclid(TILE))))?;
        let tile = &self.tiles[number as usize];
        Some(tile.surfaces.get_or_init(|| self.make(tile)))
    }

    /// A tile with the root cubes next to it, which hold what lies near its border. Linear in the points of the keyframes that reach it:
    /// 5 ns each, and 0.2 us each for those that lie in it.
    fn make(&self, tile: &Tile) -> GaussianMap {
        let mut surfaces = GaussianMap::new(self.config);
        let within = |cell: i64, tile: i64| (-1..=TILE).contains(&(cell - tile * TILE));
        for (map_from_keyframe, place) in
            tile.reached_by.iter().map(|number| &self.keyframes[*number as usize])
        {
            let turn = map_from_keyframe.rotation.to_rotation_matrix();
            let from = map_from_keyframe.translation.vector;
            for point in place.points() {
                let at = (turn * Vector3::from(point.map(f64::from)) + from).into();
                let cell = self.config.root_cell(&at);
                if within(cell[0], tile.at[0]) && within(cell[1], tile.at[1]) {
                    surfaces.insert_from_viewpoint(&at, from.as_ref());
                }
            }
        }
        surfaces
    }

    /// Makes all tiles within so many metres of a place, so that nobody who walks there has to wait for one.
    pub fn make_about(&self, place: &Vector3, metres: f64) {
        for tile in &self.tiles {
            let edge = TILE as f64 * self.config.root_size_m;
            let middle = tile.at.map(|index| (index as f64 + 0.5) * edge);
            if (middle[0] - place.x).abs().max((middle[1] - place.y).abs()) <= metres + edge / 2.0 {
                tile.surfaces.get_or_init(|| self.make(tile));
            }
        }
    }

    /// Tiles made so far, and all there are.
    pub fn made(&self) -> (usize, usize) {
        (self.tiles.iter().filter(|tile| tile.surfaces.get().is_some()).count(), self.tiles.len())
    }
}

impl SurfaceMap for TiledSurfaces {
    #[inline]
    fn find_surface(&self, point: &[f64; 3], gate: f32) -> Option<Surface> {
        self.about(point)?.find_surface(point, gate)
    }

    #[inline]
    fn find_surface_facing(&self, point: &[f64; 3], from: &[f64; 3], gate: f32) -> Option<Surface> {
        self.about(point)?.find_surface_facing(point, from, gate)
    }
}

fn key([x, y]: [i64; 2]) -> CellKey {
    CellKey::new([x, y, 0])
}

/// Corners of a box along the map's axes about all that a keyframe saw, metres; none if that is nothing.
fn extent(map_from_keyframe: &Isometry, place: &KeyframeDescriptor) -> Option<[Vector3; 2]> {
    let [least, most] = place.extent()?.map(|corner| Vector3::from(corner.map(f64::from)));
    let turn = map_from_keyframe.rotation.to_rotation_matrix().into_inner();
    let middle = turn * ((least + most) / 2.0) + map_from_keyframe.translation.vector;
    let half = turn.abs() * ((most - least) / 2.0);
    Some([middle - half, middle + half])
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{RngTree, Rotation};
    use points::Downsampler;

    /// What robots along a street 150 m long saw: the ground, and a wall to both sides.
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
    fn a_tile_knows_what_one_map_of_all_would() {
        let keyframes = street();
        let config = GaussianMapConfig { min_points: 6, ..GaussianMapConfig::default() };
        let mut whole = GaussianMap::new(config);
        for (pose, place) in keyframes.iter() {
            for point in place.points() {
                let at = pose.rotation * Vector3::from(point.map(f64::from)) + pose.translation.vector;
                whole.insert_from_viewpoint(&at.into(), pose.translation.vector.as_ref());
            }
        }
        let tiled = TiledSurfaces::new(config, keyframes.clone());
        assert_eq!(tiled.made().0, 0);
        let (mut known, mut unlike) = (0, 0);
        for (pose, place) in keyframes.iter() {
            let from = pose.translation.vector;
            for point in place.points() {
                // Beside the surface, and some of them on the border of two tiles.
                let at = pose.rotation * Vector3::from(point.map(|c| f64::from(c) + 0.02)) + from;
                let one = whole.find_surface_facing(at.as_ref(), from.as_ref(), 0.1);
                known += usize::from(one.is_some());
                unlike += usize::from(one != tiled.find_surface_facing(at.as_ref(), from.as_ref(), 0.1));
            }
        }
        assert!(known > 10_000, "{known}");
        assert_eq!(unlike, 0, "of {known}");
        assert!(tiled.made().0 > 4, "{:?}", tiled.made());
        assert_eq!(tiled.find_surface(&[500.0, 500.0, 0.0], 0.1), None);
    }

    #[test]
    fn only_what_is_looked_at_is_made() {
        let tiled = TiledSurfaces::new(GaussianMapConfig::default(), street());
        assert!(tiled.find_surface(&[0.0, 0.0, -0.5], 0.1).is_some());
        let (made, all) = tiled.made();
        assert!(made == 1 && all > 8, "{made} of {all}");
        tiled.make_about(&Vector3::zeros(), 20.0);
        let about = tiled.made().0;
        assert!(about > made && about < all, "{about} of {all}");
        for at in [[15.0, 15.0, -0.5], [-15.0, 0.0, -0.5], [19.0, -19.0, 0.0]] {
            tiled.find_surface(&at, 0.1);
        }
        assert_eq!(tiled.made().0, about);
    }
}
