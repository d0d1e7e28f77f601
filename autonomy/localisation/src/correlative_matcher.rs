//! Correlative scan matching over a whole map (Olson 2009; Hess and others 2016): how many points of a scan fall on occupied cells, for every
//! position near a keyframe and every heading.
//!
//! Each level of the map is a small occupancy grid, seen from above, of the objects that stand on its floor. The scan is projected onto such a grid
//! in the same way and compared with it at each position and heading. The search finds poses that place recognition misses, such as one some metres
//! beside the path on which the map was recorded. Heights count from the floor that the scan itself shows, so that a robot can use a map that was
//! recorded by a lower one.
//!
//! A position and heading is dropped once the first few points of the scan match too few cells. Otherwise the search is exhaustive; it does
//! without the coarser grids of branch and bound because one machine word compares 64 positions at once.

use crate::bit_grid::{BitCounters, BitGrid, set_bits};
use crate::localisation_map::LocalisationMap;
use crate::pose_hypothesis::HypothesisTolerance;
use geometry::{Isometry, Rotation, Vector3, so3};
use mapping::{FloorDetectionConfig, estimate_base_height};
use nalgebra::Translation3;
use std::cmp::Reverse;
use std::f64::consts::TAU;

/// Parameters of [`CorrelativeMatcher`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorrelativeMatcherConfig {
    /// Edge of a grid cell, and distance between tried positions, metres. Chosen: the coarse alignment converges from this error. Half the size needs four times as many
    /// positions.
    pub cell_size_m: f64,
    /// Least height over the floor of points that are projected, metres. It excludes the floor and objects that lie on it. Chosen: the error of the floor and things that
    /// lie about stay below.
    pub min_height_m: f64,
    /// Greatest height over the floor of points that are projected, metres. It includes walls and racks, but no ceiling. Chosen: as high as a door.
    pub max_height_m: f64,
    /// Height of the base over the floor if the scan does not show the floor, metres: that of a quadruped. Chosen: heights from [`Self::min_height_m`] to
    /// [`Self::max_height_m`] leave room for an error of some decimetres.
    pub default_base_height_m: f64,
    /// Parameters of the floor detection. Points nearer than its `min_range_m` are not projected either.
    pub floor: FloorDetectionConfig,
    /// Keyframes of one level lie at most this far above the lowest of them, metres. Chosen: less than half a storey, so that storeys are apart and ramps are joined.
    pub level_height_m: f64,
    /// Positions are tried up to this distance from a keyframe, metres. Chosen: robots walk beside the path of the map, in another lane or in a room that was seen
    /// through its door. The time grows with its square.
    pub search_radius_m: f64,
    /// Number of headings tried at each position; 72 are 5 degrees apart. Chosen: at 5 m, 5 degrees move a point by one cell of 0.4 m.
    pub headings: u16,
    /// Two headings kept at one position are further apart than this many steps; 6 are 30 degrees. Chosen: a nearer heading leads to the same pose.
    pub heading_separation: u16,
    /// Greatest horizontal range of projected points, metres. Chosen: at 15 m, half a step of the headings moves a point by 0.65 m, which the grown cells of the map
    /// still cover.
    pub max_range_m: f64,
    /// Number of projected points, spread evenly. At most 127, the limit of the counters. Chosen below that limit.
    pub max_points: usize,
    /// Number of points that decide whether a position and heading is dropped. Chosen: a fifth of the points.
    pub prefix_points: usize,
    /// A position and heading is dropped if fewer of these points fall on occupied cells. Chosen: half. More drops right poses among many people, less costs time.
    pub min_prefix_matches: u8,
    /// A candidate is suppressed if a better one is this near: refinement from either finds the same pose. Chosen: two cells and two steps of heading.
    pub suppression: HypothesisTolerance,
}

impl Default for CorrelativeMatcherConfig {
    fn default() -> Self {
        Self {
            cell_size_m: 0.4,
            min_height_m: 0.4,
            max_height_m: 2.0,
            default_base_height_m: 0.5,
            floor: FloorDetectionConfig::default(),
            level_height_m: 1.0,
            search_radius_m: 5.0,
            headings: 72,
            heading_separation: 6,
            max_range_m: 15.0,
            max_points: 120,
            prefix_points: 24,
            min_prefix_matches: 12,
            suppression: HypothesisTolerance { distance_m: 0.85, angle_rad: 0.2 },
        }
    }
}

/// The occupancy grids of a map.
#[derive(Clone, Debug)]
pub(crate) struct CorrelativeMatcher {
    config: CorrelativeMatcherConfig,
    levels: Vec<Level>,
}

/// One floor of a building, or a part of it.
#[derive(Clone, Debug)]
struct Level {
    /// Height of the floor in the map, metres.
    floor_m: f64,
    /// Cells with an object, and their neighbours.
    occupied: BitGrid,
    /// Cells in which the robot may be.
    positions: BitGrid,
}

/// A position and heading with its score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ScoredPose {
    /// Points of the scan on occupied cells.
    matches: u8,
    heading: u16,
    level: u16,
    cell: [i32; 2],
}

impl CorrelativeMatcher {
    /// Builds the grids of a map. Linear in its points.
    pub fn new(config: CorrelativeMatcherConfig, map: &LocalisationMap) -> Self {
        let mut order: Vec<&Isometry> = map.keyframes().iter().map(|(pose, _)| pose).collect();
        order.sort_by(|a, b| a.translation.z.total_cmp(&b.translation.z));
        let mut heights: Vec<f64> = Vec::new();
        for pose in order {
            if heights.last().is_none_or(|height| pose.translation.z - height > config.level_height_m) {
                heights.push(pose.translation.z);
            }
        }
        let levels = heights.iter().filter_map(|height| Level::new(&config, map, *height)).collect();
        Self { config, levels }
    }

    /// Poses of the base at which most of the scan's points (base frame, metres) fall on occupied cells (equation 6): the best first, none next
    /// to a better one, `count` at most. `level_from_base` is the base's roll and pitch. Linear in the area that was walked: some
    /// milliseconds for 100 m².
    pub fn search(&self, points: &[[f32; 3]], level_from_base: &Rotation, count: usize) -> Vec<Isometry> {
        let config = &self.config;
        let base_height_m =
            config.base_height_m(points, level_from_base).unwrap_or(config.default_base_height_m);
        let outline = config.project(points, level_from_base, base_height_m);
        if outline.len() < config.prefix_points {
            return Vec::new();
        }
        // The base is in the middle of its cell.
        let steps = |metres: f64| (metres / config.cell_size_m + 0.5).floor() as i64;
        let rotated: Vec<Vec<[i64; 2]>> = (0..config.headings)
            .map(|heading| {
                let (sin, cos) = config.yaw(heading).sin_cos();
                outline.iter().map(|[x, y]| [cos * x - sin * y, sin * x + cos * y].map(steps)).collect()
            })
            .collect();
        let mut scored = Vec::new();
        for (number, level) in self.levels.iter().enumerate() {
            level.score(config, number as u16, &rotated, &mut scored);
        }
        // The sort is stable: of equal scores the first wins.
        scored.sort_by_key(|one| Reverse(one.matches));
        let poses = scored.iter().map(|one| {
            let [x, y] = one.cell.map(|index| config.cell_centre(i64::from(index)));
            let position =
                Translation3::new(x, y, self.levels[usize::from(one.level)].floor_m + base_height_m);
            let rotation = so3::exp(&(Vector3::z() * config.yaw(one.heading))) * level_from_base;
            Isometry::from_parts(position, rotation)
        });
        suppress_neighbours(&config.suppression, poses, count)
    }
}

/// The first poses that are not next to a pose before them: without this, the neighbours of one good pose would fill the whole list.
fn suppress_neighbours(
    tolerance: &HypothesisTolerance,
    poses: impl IntoIterator<Item = Isometry>,
    count: usize,
) -> Vec<Isometry> {
    let is_neighbour = |a: &Isometry, b: &Isometry| {
        (a.translation.vector - b.translation.vector).norm() <= tolerance.distance_m
            && a.rotation.angle_to(&b.rotation) <= tolerance.angle_rad
    };
    let mut chosen: Vec<Isometry> = Vec::new();
    for pose in poses {
        if chosen.len() == count {
            break;
        }
        if !chosen.iter().any(|other| is_neighbour(&pose, other)) {
            chosen.push(pose);
        }
    }
    chosen
}

impl Level {
    /// The level whose lowest keyframe is at this height. `None` if no object stands on it.
    fn new(config: &CorrelativeMatcherConfig, map: &LocalisationMap, height_m: f64) -> Option<Self> {
        let is_on_level =
            |pose: &Isometry| (0.0..=config.level_height_m).contains(&(pose.translation.z - height_m));
        let mut cells: Vec<[i64; 2]> = Vec::new();
        let mut floors: Vec<f64> = Vec::new();
        for (pose, descriptor) in map.keyframes().iter().filter(|(pose, _)| is_on_level(pose)) {
            let points: Vec<[f32; 3]> = descriptor.points().collect();
            let base_height_m = config.base_height_m(&points, &pose.rotation);
            floors.extend(base_height_m.map(|base_height_m| pose.translation.z - base_height_m));
            let rotation = pose.rotation.to_rotation_matrix();
            for point in points {
                let offset = rotation * Vector3::from(point.map(f64::from));
                if config.is_projected(offset.z + base_height_m.unwrap_or(config.default_base_height_m)) {
                    let at = offset + pose.translation.vector;
                    cells.push([at.x, at.y].map(|metres| config.cell(metres)));
                }
            }
        }
        floors.sort_by(f64::total_cmp);
        let floor_m =
            floors.get(floors.len() / 2).copied().unwrap_or(height_m - config.default_base_height_m);
        if cells.is_empty() {
            return None;
        }
        let with_neighbours = |cell: [i64; 2]| {
            [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].map(|(x, y)| [cell[0] + x, cell[1] + y])
        };
        cells.sort_unstable();
        cells.dedup();
        let occupied = BitGrid::from_cells(&cells.into_iter().flat_map(with_neighbours).collect::<Vec<_>>());
        let near: Vec<Vector3> = map
            .keyframes()
            .iter()
            .map(|(pose, _)| pose.translation.vector)
            .filter(|at| (at.z - height_m).abs() <= config.level_height_m)
            .collect();
        Some(Self { floor_m, occupied, positions: BitGrid::from_cells(&config.positions(&near)) })
    }

    /// Scores every position and heading, and appends the two best headings of each position that are not dropped and not next to each
    /// other. `rotated` holds the cells of the scan's points for each heading, relative to the base's cell.
    fn score(
        &self,
        config: &CorrelativeMatcherConfig,
        level: u16,
        rotated: &[Vec<[i64; 2]>],
        scored: &mut Vec<ScoredPose>,
    ) {
        for ([x, y], positions) in self.positions.words() {
            let mut best = [BestHeadings::default(); 64];
            for (heading, cells) in (0..).zip(rotated) {
                let (prefix, rest) = cells.split_at(config.prefix_points.min(cells.len()));
                let mut matches = BitCounters::default();
                prefix.iter().for_each(|at| matches.add(self.occupied.window([x + at[0], y + at[1]])));
                let kept = matches.at_least(config.min_prefix_matches) & positions;
                if kept != 0 {
                    rest.iter().for_each(|at| matches.add(self.occupied.window([x + at[0], y + at[1]])));
                    set_bits(kept)
                        .for_each(|bit| best[bit as usize].insert(config, matches.get(bit), heading));
                }
            }
            for bit in set_bits(positions) {
                let cell = [x as i32, y as i32 + bit as i32];
                let pose = |(matches, heading)| ScoredPose { matches, heading, level, cell };
                scored.extend(best[bit as usize].0.into_iter().flatten().map(pose));
            }
        }
    }
}

/// The two best headings of a position that are not next to each other: matches and heading of each.
#[derive(Clone, Copy, Debug, Default)]
struct BestHeadings([Option<(u8, u16)>; 2]);

impl BestHeadings {
    fn insert(&mut self, config: &CorrelativeMatcherConfig, matches: u8, heading: u16) {
        let is_better = |than: Option<(u8, u16)>| than.is_none_or(|(other, _)| matches > other);
        let is_neighbour = self.0[0].is_some_and(|(_, other)| {
            let apart = heading.abs_diff(other);
            apart.min(config.headings - apart) <= config.heading_separation
        });
        if is_better(self.0[0]) {
            if !is_neighbour {
                self.0[1] = self.0[0];
            }
            self.0[0] = Some((matches, heading));
        } else if !is_neighbour && is_better(self.0[1]) {
            self.0[1] = Some((matches, heading));
        }
    }
}

impl CorrelativeMatcherConfig {
    /// Height of the base over the floor that a scan (base frame, metres) shows, metres. `None` if the scan shows no floor.
    fn base_height_m(&self, points: &[[f32; 3]], level_from_base: &Rotation) -> Option<f64> {
        let rotation = level_from_base.to_rotation_matrix();
        let levelled = points.iter().map(|point| rotation * Vector3::from(point.map(f64::from)));
        estimate_base_height(levelled, &self.floor)
    }

    /// Whether a point at this height over the floor is projected.
    fn is_projected(&self, height_m: f64) -> bool {
        (self.min_height_m..=self.max_height_m).contains(&height_m)
    }

    /// The outline of the objects around the base, in a level frame at the base, metres. It has one point for each cell, and the points are spread
    /// evenly.
    fn project(&self, points: &[[f32; 3]], level_from_base: &Rotation, base_height_m: f64) -> Vec<[f64; 2]> {
        let rotation = level_from_base.to_rotation_matrix();
        let mut cells: Vec<[i64; 2]> = points
            .iter()
            .map(|point| rotation * Vector3::from(point.map(f64::from)))
            .filter(|at| {
                self.is_projected(at.z + base_height_m)
                    && (self.floor.min_range_m..=self.max_range_m).contains(&at.xy().norm())
            })
            .map(|at| [at.x, at.y].map(|metres| self.cell(metres)))
            .collect();
        cells.sort_unstable();
        cells.dedup();
        // A stride by a prime mixes near and far points, so that the first few already represent all of them.
        let count = cells.len();
        let kept = count.min(self.max_points).min(BitCounters::MAX);
        (0..kept)
            .map(|index| cells[(index * 7919) % count.max(1)].map(|index| self.cell_centre(index)))
            .collect()
    }

    /// Cells within the search radius of one of these positions.
    fn positions(&self, near: &[Vector3]) -> Vec<[i64; 2]> {
        let reach = (self.search_radius_m / self.cell_size_m).ceil() as i64;
        let mut cells: Vec<[i64; 2]> = Vec::new();
        for at in near {
            let [x, y] = [at.x, at.y].map(|metres| self.cell(metres));
            for dx in -reach..=reach {
                for dy in -reach..=reach {
                    if ((dx * dx + dy * dy) as f64).sqrt() * self.cell_size_m <= self.search_radius_m {
                        cells.push([x + dx, y + dy]);
                    }
                }
            }
        }
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// Centre of a cell along one axis, metres.
    fn cell_centre(&self, index: i64) -> f64 {
        (index as f64 + 0.5) * self.cell_size_m
    }

    /// Cell of a coordinate.
    fn cell(&self, metres: f64) -> i64 {
        (metres / self.cell_size_m).floor() as i64
    }

    /// Yaw of a heading, radians.
    fn yaw(&self, heading: u16) -> f64 {
        f64::from(heading) * TAU / f64::from(self.headings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{at, room_keyframe, rooms, rooms_keyframes};
    use geometry::RngTree;
    use std::collections::BTreeSet;

    /// All positions and headings, one by one and with all points, with the same rule for the two best headings.
    fn exhaustive_search(
        config: &CorrelativeMatcherConfig,
        occupied: &[[i64; 2]],
        positions: &[[i64; 2]],
        rotated: &[Vec<[i64; 2]>],
    ) -> Vec<ScoredPose> {
        let [occupied, positions] =
            [occupied, positions].map(|cells| cells.iter().copied().collect::<BTreeSet<_>>());
        let mut scored = Vec::new();
        for position in positions {
            let mut best = BestHeadings::default();
            for (heading, outline) in (0..).zip(rotated) {
                let count = |points: &[[i64; 2]]| {
                    let hits =
                        |at: &&[i64; 2]| occupied.contains(&[position[0] + at[0], position[1] + at[1]]);
                    points.iter().filter(hits).count() as u8
                };
                if count(&outline[..config.prefix_points.min(outline.len())]) >= config.min_prefix_matches {
                    best.insert(config, count(outline), heading);
                }
            }
            let cell = position.map(|index| index as i32);
            let pose = |(matches, heading)| ScoredPose { matches, heading, level: 2, cell };
            scored.extend(best.0.into_iter().flatten().map(pose));
        }
        scored
    }

    #[test]
    fn the_pruned_search_agrees_with_an_exhaustive_one() {
        for seed in 0..12 {
            let mut rng = RngTree::new(seed).child("search").rng();
            let mut cells = |count: usize, reach: f64| -> Vec<[i64; 2]> {
                (0..count)
                    .map(|_| [rng.range(-reach, reach) as i64, rng.range(-reach, reach) as i64])
                    .collect()
            };
            // From sparse grids, where nearly all is dropped, to dense ones, where nearly nothing is.
            let density = 1_000 + 900 * seed as usize;
            let (occupied, positions) = (cells(density, 50.0), cells(150, 40.0));
            let points = 12 + 10 * seed as usize;
            let config = CorrelativeMatcherConfig::default();
            let rotated: Vec<Vec<[i64; 2]>> = (0..config.headings).map(|_| cells(points, 20.0)).collect();
            let level = Level {
                floor_m: 0.0,
                occupied: BitGrid::from_cells(&occupied),
                positions: BitGrid::from_cells(&positions),
            };
            let mut scored = Vec::new();
            level.score(&config, 2, &rotated, &mut scored);
            assert_eq!(scored, exhaustive_search(&config, &occupied, &positions, &rotated), "{seed}");
            assert!(seed < 6 || scored.len() > 50, "{seed}: {}", scored.len());
        }
    }

    #[test]
    fn dropping_by_the_first_points_never_loses_a_pose_that_matches_all_points() {
        let mut rng = RngTree::new(7).child("exact").rng();
        let config = CorrelativeMatcherConfig::default();
        let outline: Vec<[i64; 2]> =
            (0..100).map(|_| [rng.range(-30.0, 30.0) as i64, rng.range(-30.0, 30.0) as i64]).collect();
        let occupied: Vec<[i64; 2]> = outline.iter().map(|at| [at[0] + 5, at[1] - 3]).collect();
        let positions: Vec<[i64; 2]> = (-10..10).flat_map(|x| (-10..10).map(move |y| [x, y])).collect();
        let level = Level {
            floor_m: 0.0,
            occupied: BitGrid::from_cells(&occupied),
            positions: BitGrid::from_cells(&positions),
        };
        let mut scored = Vec::new();
        level.score(&config, 0, &[outline], &mut scored);
        let best = scored.iter().max_by_key(|one| one.matches);
        assert_eq!(best.map(|one| (one.matches, one.cell)), Some((100, [5, -3])));
    }

    #[test]
    fn a_scan_beside_the_recorded_path_is_found_to_a_cell() {
        let map = LocalisationMap::new(rooms_keyframes());
        let matcher = CorrelativeMatcher::new(CorrelativeMatcherConfig::default(), &map);
        let (truth, descriptor) = room_keyframe(&rooms(), 30.0, -0.6, 0.7);
        let points: Vec<[f32; 3]> = descriptor.points().collect();
        let found = matcher.search(&points, &Rotation::identity(), 200);
        let nearest = found
            .iter()
            .map(|pose| truth.inverse() * pose)
            .filter(|error| error.rotation.angle() < 0.2)
            .map(|error| error.translation.vector.norm())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.6, "{nearest} m of {}", found.len());
        assert!(matcher.search(&points[..20], &Rotation::identity(), 200).is_empty(), "too few points");
    }

    #[test]
    fn neighbours_of_a_good_pose_do_not_crowd_out_others() {
        let mut all: Vec<Isometry> = (0..50).map(|step| at(0.01 * f64::from(step), 0.0, 0.0)).collect();
        all.extend([at(0.0, 0.0, 1.0), at(3.0, 0.0, 0.0), at(6.0, 0.0, 0.0)]);
        let tolerance = CorrelativeMatcherConfig::default().suppression;
        let poses: Vec<(f64, f64)> = suppress_neighbours(&tolerance, all, 3)
            .iter()
            .map(|pose| (pose.translation.x, so3::log(&pose.rotation).z.round()))
            .collect();
        assert_eq!(poses, [(0.0, 0.0), (0.0, 1.0), (3.0, 0.0)]);
    }
}
