//! Changes of a finished map according to later scans: points of its keyframes that were removed, and points that were added.
//!
//! Both follow from free space. A point of a keyframe that several later scans nearby looked through was removed. A point that several later
//! scans measured, that none looked through, and where the map has nothing, was added. People who walk by are neither: too few scans measured
//! them, or others looked through.

use crate::dynamic_points::{DynamicPointsConfig, dynamic_points, static_points};
use crate::range_image::{Occupancy, RangeImage};
use geometry::{Isometry, Vector3};
use points::Downsampler;
use points::hash::{CellKey, CellTable};
use std::collections::BTreeMap;

/// Parameters of the change detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapChangesConfig {
    /// Scans from farther away than this from a point do not vote on it, metres. Chosen: as the voters' of moving objects ([`DynamicPointsConfig::max_walk_distance_m`]).
    pub max_viewing_distance_m: f64,
    /// Added points are put into keyframes within the viewing distance and this height difference, metres. Chosen: half a storey.
    pub max_height_m: f64,
    /// Added points are searched within this range of a scan, metres. Beyond it, the points of a scan lie too far apart to tell where an
    /// object ends. Chosen: at 10 m the rings of an XT-32 (1 degree apart) are 0.17 m apart, about [`Self::occupied_cell_m`].
    pub max_range_m: f32,
    /// Points are decided on in blocks of this edge; the scans nearest to a block vote, metres. Chosen: the edge of a root cube of the surfaces; smaller blocks search
    /// for scans more often.
    pub block_m: f32,
    /// Edge of the cells in which the map counts as occupied, metres. A point in a neighbouring cell belongs to the same object. Chosen: as the voxels that scans decide
    /// on ([`DynamicPointsConfig::voxel_m`]).
    pub occupied_cell_m: f32,
    /// Of the added points, one in each cell of this edge is taken, metres. As fine as the clouds of keyframes.
    pub added_cell_m: f32,
    /// How scans vote.
    pub votes: DynamicPointsConfig,
}

impl Default for MapChangesConfig {
    fn default() -> Self {
        Self {
            max_viewing_distance_m: 8.0,
            max_height_m: 1.5,
            max_range_m: 10.0,
            block_m: 2.0,
            occupied_cell_m: 0.2,
            added_cell_m: 0.04,
            votes: DynamicPointsConfig::default(),
        }
    }
}

/// A scan of a later walk whose pose in the map is known.
#[derive(Clone, Debug)]
pub struct RevisitScan {
    /// Pose of the base.
    pub map_from_base: Isometry,
    /// The points within the range of the search for added points, thinned: base frame, metres.
    pub xyz: Vec<[f32; 3]>,
    /// Sensor units, one for each point.
    pub intensity: Vec<f32>,
    /// Range image of the whole scan.
    view: RangeImage,
}

impl RevisitScan {
    /// Takes a motion-corrected cloud (base frame, metres) measured from `sensor` (base frame, metres). Linear in its points. Keeps some
    /// 100 kB.
    pub fn new(
        map_from_base: Isometry,
        xyz: &[[f32; 3]],
        intensity: &[f32],
        sensor: [f32; 3],
        downsampler: &mut Downsampler,
        config: &MapChangesConfig,
    ) -> Self {
        let mut centroids = Vec::new();
        downsampler.downsample(xyz, intensity, config.added_cell_m, &mut centroids);
        let limit = config.max_range_m * config.max_range_m;
        centroids.retain(|one| one.xyz.iter().map(|c| c * c).sum::<f32>() <= limit);
        Self {
            map_from_base,
            xyz: centroids.iter().map(|one| one.xyz).collect(),
            intensity: centroids.iter().map(|one| one.attribute).collect(),
            view: RangeImage::new(xyz, sensor),
        }
    }
}

/// Selects points (frame of a body, metres) by range images with their poses in it.
type Selection = fn(&[[f32; 3]], &[(Isometry, &RangeImage)], &DynamicPointsConfig) -> Vec<u32>;

/// Cells in which a map is occupied, and those in which points were added to it.
#[derive(Debug, Default)]
pub struct OccupiedCells {
    config: MapChangesConfig,
    cells: CellTable,
    added: CellTable,
}

/// Indices of the points of a keyframe (its frame, metres) that were removed since. Linear in the scans for each block of points, and in the
/// points times the voters.
pub fn removed_points(
    map_from_keyframe: &Isometry,
    xyz: &[[f32; 3]],
    scans: &[RevisitScan],
    config: &MapChangesConfig,
) -> Vec<u32> {
    select_in_blocks(map_from_keyframe, xyz, scans, None, config, dynamic_points)
}

/// Indices of the points of the scan `index` that were added since the map was made and that `occupied` does not hold yet. They are added to
/// it. Linear in the scans for each block of points, and in the points 39 times.
pub fn added_points(scans: &[RevisitScan], index: usize, occupied: &mut OccupiedCells) -> Vec<u32> {
    let (scan, config) = (&scans[index], occupied.config);
    let in_map = |point: u32| transform_to_map(&scan.map_from_base, &scan.xyz[point as usize]);
    let new: Vec<u32> =
        (0..scan.xyz.len() as u32).filter(|&point| !occupied.contains(&in_map(point))).collect();
    let xyz: Vec<[f32; 3]> = new.iter().map(|&point| scan.xyz[point as usize]).collect();
    let selected = select_in_blocks(&scan.map_from_base, &xyz, scans, Some(index), &config, static_points);
    let mut added: Vec<u32> = selected.into_iter().map(|point| new[point as usize]).collect();
    added.retain(|&point| occupied.insert_added(&in_map(point)));
    added
}

/// Whether an added point (keyframe's frame, metres) belongs into a keyframe with this range image: the keyframe's scan looked through there.
pub fn is_in_free_space(view: &RangeImage, point: &[f32; 3], config: &MapChangesConfig) -> bool {
    let limit = config.max_range_m * config.max_range_m;
    point.iter().map(|c| c * c).sum::<f32>() <= limit && view.classify(point) == Occupancy::Free
}

/// Number of the keyframe that points seen from a pose are added to: the nearest one within reach. Linear in the keyframes.
pub fn nearest_keyframe(
    map_from_base: &Isometry,
    keyframes: &[Isometry],
    config: &MapChangesConfig,
) -> Option<usize> {
    let position = map_from_base.translation.vector;
    let offset = |keyframe: &Isometry| keyframe.translation.vector - position;
    let is_near = |offset: Vector3| {
        offset.norm() <= config.max_viewing_distance_m && offset.z.abs() <= config.max_height_m
    };
    let near = keyframes.iter().enumerate().filter(|(_, keyframe)| is_near(offset(keyframe)));
    near.min_by(|(_, a), (_, b)| offset(a).norm().total_cmp(&offset(b).norm())).map(|(index, _)| index)
}

impl OccupiedCells {
    /// Adds a point of the map, map frame, metres.
    pub fn insert(&mut self, point: &Vector3) {
        self.cells.get_or_insert(cell(point, self.config.occupied_cell_m), 0);
    }

    /// Whether the map is occupied in the cell of a point or next to it.
    fn contains(&self, point: &Vector3) -> bool {
        let [x, y, z] = cell(point, self.config.occupied_cell_m).cell();
        let around = |at: i64| at - 1..=at + 1;
        around(x)
            .any(|x| around(y).any(|y| around(z).any(|z| self.cells.get(CellKey::new([x, y, z])).is_some())))
    }

    /// Inserts an added point. Returns whether it is the first one of its cell.
    fn insert_added(&mut self, point: &Vector3) -> bool {
        self.added.get_or_insert(cell(point, self.config.added_cell_m), 0).1
    }
}

fn cell(point: &Vector3, edge_m: f32) -> CellKey {
    CellKey::new([0, 1, 2].map(|axis| (point[axis] / f64::from(edge_m)).floor() as i64))
}

/// Transforms a point (body's frame, metres) to the map.
pub fn transform_to_map(map_from_body: &Isometry, point: &[f32; 3]) -> Vector3 {
    map_from_body.rotation * Vector3::from(point.map(f64::from)) + map_from_body.translation.vector
}

/// Indices of the points (frame of a body, metres) that the scans nearest to them select; the scan `without` does not vote.
fn select_in_blocks(
    map_from_body: &Isometry,
    xyz: &[[f32; 3]],
    scans: &[RevisitScan],
    without: Option<usize>,
    config: &MapChangesConfig,
    select: Selection,
) -> Vec<u32> {
    let block_m = config.block_m;
    let mut blocks: BTreeMap<[i32; 3], Vec<u32>> = BTreeMap::new();
    for (index, point) in (0..).zip(xyz) {
        blocks.entry(point.map(|c| (c / block_m).floor() as i32)).or_default().push(index);
    }
    let body_from_map = map_from_body.inverse();
    let mut found = Vec::new();
    for (block, members) in blocks {
        let centre = transform_to_map(map_from_body, &block.map(|c| (c as f32 + 0.5) * block_m));
        let voters: Vec<_> = voters(&centre, scans, without, config)
            .map(|scan| (body_from_map * scan.map_from_base, &scan.view))
            .collect();
        let points: Vec<[f32; 3]> = members.iter().map(|&index| xyz[index as usize]).collect();
        let selected = select(&points, &voters, &config.votes);
        found.extend(selected.into_iter().map(|index| members[index as usize]));
    }
    found.sort_unstable();
    found
}

/// The scans nearest to a point of the map, except `without`.
fn voters<'a>(
    point: &Vector3,
    scans: &'a [RevisitScan],
    without: Option<usize>,
    config: &MapChangesConfig,
) -> impl Iterator<Item = &'a RevisitScan> {
    let others = scans.iter().enumerate().filter(move |(index, _)| Some(*index) != without);
    let mut near: Vec<(f64, &RevisitScan)> = others
        .map(|(_, scan)| ((scan.map_from_base.translation.vector - point).norm(), scan))
        .filter(|(distance_m, _)| *distance_m <= config.max_viewing_distance_m)
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.into_iter().take(config.votes.max_voters).map(|(_, scan)| scan)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hall 8 m wide as seen from `x`, with or without a box 1 m wide in front of its wall.
    fn seen(x: f64, box_at: Option<f64>) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        for column in 0..1440 {
            for row in -16..=16 {
                let (sin, cos) = (f64::from(column) * std::f64::consts::TAU / 1440.0).sin_cos();
                let tangent = (f64::from(row) * 1.0_f64.to_radians()).tan();
                let mut range = if sin.abs() > 1e-9 { 4.0 / sin.abs() } else { f64::INFINITY };
                if let Some(at) = box_at
                    && sin > 0.0
                    && (x + 2.0 * cos / sin - at).abs() < 0.5
                {
                    range = 2.0 / sin;
                }
                if range < 20.0 {
                    points.push([range * cos, range * sin, range * tangent].map(|c| c as f32));
                }
            }
        }
        points
    }

    fn scans(box_at: Option<f64>) -> Vec<RevisitScan> {
        let scan = |number: u32| {
            let x = -2.5 + f64::from(number);
            let xyz = seen(x, box_at);
            let at = Isometry::translation(x, 0.0, 0.0);
            RevisitScan::new(
                at,
                &xyz,
                &[],
                [0.0; 3],
                &mut Downsampler::default(),
                &MapChangesConfig::default(),
            )
        };
        (0..6).map(scan).collect()
    }

    #[test]
    fn a_box_that_was_pushed_along_the_wall_is_removed_there_and_added_here() {
        let config = MapChangesConfig::default();
        let (keyframe, old) = (Isometry::identity(), seen(0.0, Some(-1.0)));
        let scans = scans(Some(1.5));
        let is_box =
            |point: &[f32; 3], at: f32| point[1] > 1.9 && point[1] < 2.1 && (point[0] - at).abs() < 0.55;
        let removed = removed_points(&keyframe, &old, &scans, &config);
        let boxes = old.iter().filter(|point| is_box(point, -1.0)).count();
        let right = removed.iter().filter(|index| is_box(&old[**index as usize], -1.0)).count();
        assert!(boxes > 500 && right * 10 > boxes * 9, "{right} of {boxes}");
        assert!((removed.len() - right) * 100 < old.len(), "{} of {}", removed.len() - right, old.len());

        let mut occupied = OccupiedCells::default();
        for (index, point) in old.iter().enumerate() {
            if !removed.contains(&(index as u32)) {
                occupied.insert(&transform_to_map(&keyframe, point));
            }
        }
        let (mut of_box, mut other) = (0, 0);
        for one in 0..scans.len() {
            for index in added_points(&scans, one, &mut occupied) {
                let point = transform_to_map(&scans[one].map_from_base, &scans[one].xyz[index as usize]);
                let at = [point.x as f32, point.y as f32, point.z as f32];
                // The wall behind the old box is new as well.
                let wall = at[1] > 3.9 && (at[0] + 1.5).abs() < 2.0;
                if is_box(&at, 1.5) { of_box += 1 } else { other += usize::from(!wall && at[1] > 0.0) }
            }
        }
        assert!(of_box > 300, "{of_box}");
        assert!(other * 20 < of_box, "{other} others, {of_box} of the box");
        assert!(added_points(&scans, 0, &mut occupied).is_empty(), "added once only");
        let view = RangeImage::new(&old, [0.0; 3]);
        assert!(is_in_free_space(&view, &[1.5, 2.0, 0.0], &config), "the scan looked through there");
        assert!(
            !is_in_free_space(&view, &[-2.0, 4.0, 0.0], &config)
                && !is_in_free_space(&view, &[-1.5, 3.0, 0.0], &config)
                && !is_in_free_space(&view, &[11.0, 2.0, 0.0], &config)
        );
        assert_eq!(
            nearest_keyframe(
                &Isometry::translation(0.4, 0.0, 0.0),
                &[Isometry::translation(9.0, 0.0, 0.0), keyframe],
                &config
            ),
            Some(1)
        );
        assert_eq!(
            nearest_keyframe(&Isometry::translation(0.4, 0.0, 3.0), &[keyframe], &config),
            None,
            "another floor"
        );
    }
}
