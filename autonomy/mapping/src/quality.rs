//! Quality of a map during its recording: floor that was seen from near, unvisited areas, and the uncertainty of each keyframe (docs/maths/loops.md,
//! section 10).
//!
//! For every keyframe, the floor that it saw is recorded with the viewing distance. Floor that was only seen from afar, through a door or across a
//! yard, is a target to walk to. Keyframes with a large standard deviation are targets of another visit, best by returning to a keyframe with a small
//! one.

use crate::covariance_graph::CovarianceGraph;
use crate::floor_detection::{FloorDetectionConfig, estimate_base_height};
use crate::submap::KeyframeCloud;
use geometry::{Isometry, Rotation, Vector3};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, OnceLock};

/// Parameters of [`MapQuality`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapQualityConfig {
    /// Edge of a cell of floor, metres. Chosen: a square metre, in which coverage is shown; smaller cells have gaps between rings.
    pub cell_m: f64,
    /// Least height difference of two floors, metres. Chosen: less than a storey, more than a platform that a robot steps onto.
    pub floor_spacing_m: f64,
    /// Floor seen from at most this distance is covered, metres. There, the rings of a spinning LiDAR are a step apart.
    pub covered_range_m: f64,
    /// Range within which floor is searched, metres. Chosen: there the floor is seen at 3 degrees, and its height is uncertain.
    pub max_range_m: f64,
    /// Parameters of the floor detection.
    pub floor: FloorDetectionConfig,
    /// Points within this height of the floor belong to it, metres, ... Chosen: one slice of the floor detection and half.
    pub flatness_m: f64,
    /// ... plus this share of their range. Chosen: 2 %, a tilt of a degree.
    pub flatness_share: f64,
    /// Cells of one unvisited area are at most this many cells apart. Chosen: shadows of posts and furniture do not part an area.
    pub max_gap_cells: i32,
    /// Least number of cells of an unvisited area: a small room. Chosen: less sends people to corners.
    pub min_area_cells: usize,
    /// The target of an area is the cell with most cells of the area within this many cells. Chosen: the middle of a room of 8 m.
    pub target_radius_cells: i32,
    /// Greatest number of cells that are tried as target. Chosen: some hundred are enough to find a good one.
    pub max_target_trials: usize,
    /// Keyframes with a larger standard deviation are worth another visit, metres. Chosen: below the 0.4 m from which the graph cannot confirm loops by itself
    /// ([`crate::PoseCertaintyConfig`]).
    pub max_std_m: f64,
    /// Greatest number of targets of each kind. Chosen: a list that a person reads at once.
    pub max_targets: usize,
}

impl Default for MapQualityConfig {
    fn default() -> Self {
        Self {
            cell_m: 1.0,
            floor_spacing_m: 1.5,
            covered_range_m: 6.0,
            max_range_m: 15.0,
            floor: FloorDetectionConfig::default(),
            flatness_m: 0.15,
            flatness_share: 0.02,
            max_gap_cells: 2,
            min_area_cells: 10,
            target_radius_cells: 4,
            max_target_trials: 300,
            max_std_m: 0.3,
            max_targets: 6,
        }
    }
}

/// Quality of a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapQuality {
    /// Floor seen from near, m².
    pub covered_m2: f64,
    /// Floor seen from afar only, m².
    pub from_afar_m2: f64,
    /// Standard deviation of each keyframe's position in the first one, metres.
    pub deviations_m: Vec<f32>,
    /// Targets of a visit or another visit. Targets seen from afar come first, the largest of each kind first.
    pub targets: Vec<SurveyTarget>,
}

/// A target of a visit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurveyTarget {
    /// Position on the floor, map frame, metres.
    pub position: Vector3,
    /// Why.
    pub reason: SurveyReason,
}

/// Reason for a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurveyReason {
    /// The floor around it was seen from afar only. Its area, m².
    FromAfar(f64),
    /// The keyframes around it have a large standard deviation, metres.
    Uncertain(f64),
}

/// Column, row and floor of a cell.
type Cell = [i32; 3];

/// The floor that a keyframe saw, computed on first use. The result depends on the cloud alone, so it does not matter who computes it.
#[derive(Debug)]
pub(crate) struct KeyframeFloor {
    cloud: Arc<KeyframeCloud>,
    level_from_base: Rotation,
    /// Indices of points of the cloud, one for each cell.
    points: OnceLock<Box<[u16]>>,
}

impl KeyframeFloor {
    /// Of a keyframe whose frame is levelled by `level_from_base`.
    pub fn new(cloud: Arc<KeyframeCloud>, level_from_base: Rotation) -> Self {
        Self { cloud, level_from_base, points: OnceLock::new() }
    }

    /// One point for each cell of floor, in the keyframe's frame. Empty where no floor is found. The first call is linear in the points of the cloud.
    fn points(&self, config: &MapQualityConfig) -> impl Iterator<Item = Vector3> {
        let indices = self.points.get_or_init(|| floor(&self.cloud, &self.level_from_base, config));
        indices.iter().map(|index| Vector3::from(self.cloud.point(usize::from(*index)).map(f64::from)))
    }
}

/// A snapshot of a map from which its quality is computed. It owns what it needs, so that a job can do it.
#[derive(Debug)]
pub struct MapQualityData {
    pub(crate) config: MapQualityConfig,
    /// Pose of each keyframe in the map, and its floor.
    pub(crate) keyframes: Vec<(Isometry, Arc<KeyframeFloor>)>,
    pub(crate) covariances: CovarianceGraph,
}

impl MapQualityData {
    /// Computes the quality: a pure function of the data. Costs a search of the graph, a look at every cell of floor of every keyframe, and a pass
    /// over the points of keyframes that no earlier snapshot had.
    pub fn run(&self) -> MapQuality {
        let coverage = Coverage::new(&self.keyframes, self.config);
        let reached = self.covariances.poses_in(0);
        let deviations_m: Vec<f64> =
            reached.iter().map(|pose| pose.map_or(f64::INFINITY, |pose| pose.translation_std_m())).collect();
        let (covered_m2, from_afar_m2) = coverage.areas_m2();
        let mut targets = coverage.unvisited();
        targets.extend(uncertain_keyframes(&deviations_m, &self.keyframes, &self.config));
        let deviations_m = deviations_m.into_iter().map(|deviation| deviation as f32).collect();
        MapQuality { covered_m2, from_afar_m2, deviations_m, targets }
    }
}

/// The floor of a map, cell by cell, as its keyframes saw it.
#[derive(Debug)]
struct Coverage {
    config: MapQualityConfig,
    /// For each cell: the least range from which it was seen, and its height then, metres.
    cells: BTreeMap<Cell, (f64, f64)>,
}

impl Coverage {
    fn new(keyframes: &[(Isometry, Arc<KeyframeFloor>)], config: MapQualityConfig) -> Self {
        let mut cells = BTreeMap::new();
        // Height of the first floor seen, metres.
        let mut ground_z_m = None;
        for (map_from_keyframe, floor) in keyframes {
            for seen in floor.points(&config) {
                let range = seen.xy().norm();
                let at = map_from_keyframe * nalgebra::Point3::from(seen);
                let ground = *ground_z_m.get_or_insert(at.z);
                let level = ((at.z - ground) / config.floor_spacing_m).round() as i32;
                let edge = config.cell_m;
                let cell = [(at.x / edge).floor() as i32, (at.y / edge).floor() as i32, level];
                let nearest = cells.entry(cell).or_insert((range, at.z));
                if range < nearest.0 {
                    *nearest = (range, at.z);
                }
            }
        }
        Self { config, cells }
    }

    /// Area seen from near, and area seen from afar only, m².
    fn areas_m2(&self) -> (f64, f64) {
        let (near_m, edge) = (self.config.covered_range_m, self.config.cell_m);
        let near = self.cells.values().filter(|(range, _)| *range <= near_m).count() as f64;
        (near * edge * edge, (self.cells.len() as f64 - near) * edge * edge)
    }

    /// Targets in areas that were seen from afar only, the largest area first.
    fn unvisited(&self) -> Vec<SurveyTarget> {
        let config = &self.config;
        let is_far = |range: f64| range > config.covered_range_m;
        let mut far: BTreeSet<Cell> =
            self.cells.iter().filter(|(_, (range, _))| is_far(*range)).map(|(cell, _)| *cell).collect();
        let mut areas = Vec::new();
        while let Some(first) = far.pop_first() {
            let (mut area, mut waiting) = (Vec::new(), VecDeque::from([first]));
            while let Some(cell) = waiting.pop_front() {
                area.push(cell);
                for near in neighbours(cell, config.max_gap_cells) {
                    if far.remove(&near) {
                        waiting.push_back(near);
                    }
                }
            }
            if area.len() >= config.min_area_cells {
                areas.push(area);
            }
        }
        // Stable: of equal sizes the first one found comes first.
        areas.sort_by_key(|area| std::cmp::Reverse(area.len()));
        areas.truncate(config.max_targets);
        let targets = areas.iter().map(|area| SurveyTarget {
            position: self.target(area),
            reason: SurveyReason::FromAfar(area.len() as f64 * config.cell_m * config.cell_m),
        });
        targets.collect()
    }

    /// The cell of an area with most of the area around it; of equals the one nearest to the mean. The mean itself may lie outside of the
    /// area, in the middle of what was walked already.
    fn target(&self, area: &[Cell]) -> Vector3 {
        let config = &self.config;
        let centre = |cell: &Cell| {
            let height = self.cells.get(cell).map_or(0.0, |(_, height)| *height);
            let [x, y] = [cell[0], cell[1]].map(|c| (f64::from(c) + 0.5) * config.cell_m);
            Vector3::new(x, y, height)
        };
        let mean = area.iter().map(centre).sum::<Vector3>() / area.len() as f64;
        let all: BTreeSet<&Cell> = area.iter().collect();
        let around = |cell: &Cell| {
            neighbours(*cell, config.target_radius_cells).filter(|near| all.contains(near)).count()
        };
        // Some hundred cells are enough to find a good one.
        let trials = area.iter().step_by(area.len().div_ceil(config.max_target_trials));
        let best = trials.map(|cell| (around(cell), centre(cell))).max_by(|(a, here), (b, there)| {
            a.cmp(b).then((there - mean).norm().total_cmp(&(here - mean).norm()))
        });
        best.map_or(mean, |(_, centre)| centre)
    }
}

/// The points of a cloud that are floor, one for each cell. Empty where no floor is found.
fn floor(cloud: &KeyframeCloud, level_from_base: &Rotation, config: &MapQualityConfig) -> Box<[u16]> {
    let points: Vec<Vector3> =
        cloud.points().map(|point| level_from_base * Vector3::from(point.map(f64::from))).collect();
    let Some(base_height_m) = estimate_base_height(points.iter().copied(), &config.floor) else {
        return Box::default();
    };
    let mut cells: BTreeMap<[i32; 2], u16> = BTreeMap::new();
    // A cloud has fewer points than 16 bits count.
    for (index, point) in (0..=u16::MAX).zip(&points) {
        let range = point.xy().norm();
        let is_flat = (point.z + base_height_m).abs() <= config.flatness_m + config.flatness_share * range;
        if range <= config.max_range_m && is_flat {
            let cell = [(point.x / config.cell_m).floor() as i32, (point.y / config.cell_m).floor() as i32];
            cells.entry(cell).or_insert(index);
        }
    }
    cells.into_values().collect()
}

fn neighbours([x, y, floor]: Cell, reach: i32) -> impl Iterator<Item = Cell> {
    (-reach..=reach).flat_map(move |dx| (-reach..=reach).map(move |dy| [x + dx, y + dy, floor]))
}

/// Of each run of keyframes with a large standard deviation the worst one, the worst first.
fn uncertain_keyframes(
    deviations_m: &[f64],
    keyframes: &[(Isometry, Arc<KeyframeFloor>)],
    config: &MapQualityConfig,
) -> Vec<SurveyTarget> {
    let mut worst: Vec<(usize, f64)> = Vec::new();
    let mut last = None;
    for (index, deviation) in deviations_m.iter().copied().enumerate().take(keyframes.len()) {
        if deviation <= config.max_std_m || !deviation.is_finite() {
            continue;
        }
        match worst.last_mut() {
            Some(held) if last == index.checked_sub(1) => {
                if deviation > held.1 {
                    *held = (index, deviation);
                }
            }
            _ => worst.push((index, deviation)),
        }
        last = Some(index);
    }
    worst.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    worst.truncate(config.max_targets);
    let target = |(index, deviation): (usize, f64)| SurveyTarget {
        position: keyframes[index].0.translation.vector,
        reason: SurveyReason::Uncertain(deviation),
    };
    worst.into_iter().map(target).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{SENSOR, World, at, edge, room, scan};
    use crate::{LoopConfig, LoopFinder, NewKeyframe, PoseGraph};

    /// Two rooms of 12 m by 8 m with a door between them, floor at z = -0.5.
    fn rooms() -> World {
        let mut world = room([-12.0, -4.0], [12.0, 4.0]);
        world.push([[-0.1, -4.0, -0.5], [0.1, -1.5, 2.5]]);
        world.push([[-0.1, 1.5, -0.5], [0.1, 4.0, 2.5]]);
        world
    }

    fn walked(world: &World, poses: &[Isometry], deviation: f64) -> (LoopFinder, PoseGraph) {
        let (mut finder, mut graph) = (LoopFinder::new(LoopConfig::default()), PoseGraph::default());
        let mut last: Option<Isometry> = None;
        for (number, pose) in (0_u32..).zip(poses) {
            let step = last.map(|last| {
                edge(number - 1, number, last.inverse() * pose, (1e-3 * deviation, 0.01 * deviation))
            });
            let xyz = scan(world, pose, u64::from(number));
            let new = NewKeyframe { edge: step.as_ref(), rotation: pose.rotation, xyz: &xyz, sensor: SENSOR };
            finder.add_keyframe(&mut graph, &new);
            last = Some(*pose);
        }
        (finder, graph)
    }

    #[test]
    fn a_room_seen_through_its_door_is_a_target() {
        let world = rooms();
        let walk: Vec<Isometry> = (0..6).map(|x| at(f64::from(x) * 1.5 - 10.5, 0.0, 0.0)).collect();
        let (finder, graph) = walked(&world, &walk, 1.0);
        let quality = finder.quality_data(&graph, &walk).run();
        // 12 m by 8 m, and some more through the door.
        assert!((75.0..150.0).contains(&quality.covered_m2), "{quality:?}");
        let [place] = quality.targets[..] else { panic!("{quality:?}") };
        assert!(
            matches!(place.reason, SurveyReason::FromAfar(area) if area >= 10.0 && area <= quality.from_afar_m2)
        );
        assert!(place.position.x > 2.0 && (place.position.z + 0.5).abs() < 0.1, "{place:?}");

        // After walking there, no target is left and the uncertainty is small.
        let mut on = walk.clone();
        on.extend((1..9).map(|x| at(f64::from(x) * 1.3 - 1.0, 0.0, 0.0)));
        let (finder, graph) = walked(&world, &on, 1.0);
        let quality = finder.quality_data(&graph, &on).run();
        assert_eq!(quality.targets, []);
        assert!(quality.covered_m2 > 150.0 && quality.from_afar_m2 < 10.0, "{quality:?}");
        assert_eq!(quality.deviations_m.len(), on.len());
        assert!(quality.deviations_m.windows(2).all(|pair| pair[0] <= pair[1]));
    }

    #[test]
    fn the_least_certain_keyframe_is_a_target() {
        let world = rooms();
        let walk: Vec<Isometry> = (0..8).map(|x| at(f64::from(x) * 1.2 - 10.0, 0.0, 0.0)).collect();
        let (finder, graph) = walked(&world, &walk, 40.0);
        let quality = finder.quality_data(&graph, &walk).run();
        let unsure: Vec<&SurveyTarget> = quality
            .targets
            .iter()
            .filter(|place| matches!(place.reason, SurveyReason::Uncertain(_)))
            .collect();
        let [place] = unsure[..] else { panic!("{quality:?}") };
        assert!((place.position - walk[7].translation.vector).norm() < 1e-9, "{place:?}");
    }

    #[test]
    fn the_floor_moves_along_with_the_map() {
        let world = rooms();
        let walk: Vec<Isometry> = (0..4).map(|x| at(f64::from(x) - 8.0, 0.0, 0.0)).collect();
        let (finder, graph) = walked(&world, &walk, 1.0);
        let before = finder.quality_data(&graph, &walk).run();
        let moved: Vec<Isometry> = walk.iter().map(|pose| at(0.0, 30.0, 0.0) * pose).collect();
        let after = finder.quality_data(&graph, &moved).run();
        assert!((before.covered_m2 - after.covered_m2).abs() <= 4.0, "{before:?} {after:?}");
        let (finder, graph) = walked(&world, &walk, 1.0);
        let fresh = finder.quality_data(&graph, &moved).run();
        assert_eq!(after, fresh, "whether the floors were computed before does not matter");
        assert_eq!(
            LoopFinder::new(LoopConfig::default()).quality_data(&PoseGraph::default(), &[]).run(),
            MapQuality::default()
        );
    }
}
