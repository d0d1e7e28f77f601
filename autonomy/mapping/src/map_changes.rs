//! What later walks found changed in a map: what is gone from its keyframes, and what has come.
//!
//! Both are said by sight. What stood in a keyframe's cloud and was looked through from several places near it is gone. What was met
//! from several places, looked through from none, and lies where the map shows nothing, has come. People who walk by are neither: they
//! were met from too few places, or looked through from others.

use crate::dynamic_points::{VOTERS, moving_points, standing_points};
use crate::range_image::{Occupancy, RangeImage};
use geometry::{Isometry, Vector3};
use points::Downsampler;
use points::hash::{CellKey, CellTable};
use std::collections::BTreeMap;

/// Appearance from farther away from a point than this have no vote on it, metres.
const REACH: f64 = 8.0;
/// What was seen belongs to keyframes within that, and on its level, metres.
const LEVEL: f64 = 1.5;
/// What has come is told within such a range: beyond it a scan's points lie too far apart to say where something ends.
const NEAR: f32 = 10.0;
/// Points are judged by the looks nearest to them, in blocks of this edge, metres.
const BLOCK: f32 = 2.0;
/// Edge of the cells in which a map shows something, metres. What lies in a neighbouring one is the same thing.
const SHOWN: f32 = 0.2;
/// Of what has come, one point in each cell of this edge is taken, metres: as fine as keyframes are.
const TAKEN: f32 = 0.04;

/// A scan of a later walk whose place in the map is known.
#[derive(Clone, Debug)]
pub struct RevisitScan {
    /// The base.
    pub map_from_base: Isometry,
    /// Its points as far as they can say what has come, thinned: base frame, metres.
    pub xyz: Vec<[f32; 3]>,
    /// Sensor units, one for each point.
    pub intensity: Vec<f32>,
    /// Where rays went.
    view: RangeImage,
}

impl RevisitScan {
    /// Of a motion-corrected cloud (base frame, metres) seen from `sensor` (base frame). Linear in its points; keeps some 100 kB.
    pub fn new(
        map_from_base: Isometry,
        xyz: &[[f32; 3]],
        intensity: &[f32],
        sensor: [f32; 3],
        downsampler: &mut Downsampler,
    ) -> Self {
        let mut centroids = Vec::new();
        downsampler.downsample(xyz, intensity, TAKEN, &mut centroids);
        centroids.retain(|one| one.xyz.iter().map(|c| c * c).sum::<f32>() <= NEAR * NEAR);
        Self {
            map_from_base,
            xyz: centroids.iter().map(|one| one.xyz).collect(),
            intensity: centroids.iter().map(|one| one.attribute).collect(),
            view: RangeImage::new(xyz, sensor),
        }
    }
}

/// Chooses points (frame of a body, metres) by images with their poses in it.
type Judge = fn(&[[f32; 3]], &[(Isometry, &RangeImage)]) -> Vec<u32>;

/// Where a map shows something, and what has been added to it.
#[derive(Debug, Default)]
pub struct OccupiedCells {
    cells: CellTable,
    taken: CellTable,
}

/// Indices of the points of a keyframe (its frame, metres) that are gone. Linear in the looks for each block of points, and in the
/// points 12 times.
pub fn removed_points(map_from_keyframe: &Isometry, xyz: &[[f32; 3]], looks: &[RevisitScan]) -> Vec<u32> {
    judged(map_from_keyframe, xyz, looks, None, moving_points)
}

/// Indices of the points of one of the looks that have come since the map was made, as far as `shown` does not have them. They are in
/// it then. Linear in the looks for each block of points, and in the
/// points 39 times.
pub fn added_points(looks: &[RevisitScan], one: usize, shown: &mut OccupiedCells) -> Vec<u32> {
    let look = &looks[one];
    let in_map = |point: &[f32; 3]| transform_to_map(&look.map_from_base, point);
    let new: Vec<u32> =
        (0..look.xyz.len() as u32).filter(|&index| !shown.has(&in_map(&look.xyz[index as usize]))).collect();
    let xyz: Vec<[f32; 3]> = new.iter().map(|&index| look.xyz[index as usize]).collect();
    let stands = judged(&look.map_from_base, &xyz, looks, Some(one), standing_points);
    let mut come: Vec<u32> = stands.into_iter().map(|index| new[index as usize]).collect();
    come.retain(|&index| shown.take(&in_map(&look.xyz[index as usize])));
    come
}

/// Whether what stands at a point (keyframe's frame, metres) belongs in a keyframe that saw so: it looked through there.
pub fn is_in_free_space(view: &RangeImage, point: &[f32; 3]) -> bool {
    point.iter().map(|c| c * c).sum::<f32>() <= NEAR * NEAR && view.classify(point) == Occupancy::Free
}

/// Number of the keyframe in which what was seen from a place belongs: the nearest that is near enough. Linear in the keyframes.
pub fn nearest_keyframe(map_from_base: &Isometry, keyframes: &[Isometry]) -> Option<usize> {
    let at = map_from_base.translation.vector;
    let apart = |keyframe: &Isometry| keyframe.translation.vector - at;
    let is_near = |apart: Vector3| apart.norm() <= REACH && apart.z.abs() <= LEVEL;
    let near = keyframes.iter().enumerate().filter(|(_, keyframe)| is_near(apart(keyframe)));
    near.min_by(|(_, a), (_, b)| apart(a).norm().total_cmp(&apart(b).norm())).map(|(index, _)| index)
}

impl OccupiedCells {
    /// Adds a point of the map, map frame, metres.
    pub fn add(&mut self, point: &Vector3) {
        self.cells.get_or_insert(cell(point, SHOWN), 0);
    }

    fn has(&self, point: &Vector3) -> bool {
        let [x, y, z] = cell(point, SHOWN).cell();
        let about = |at: i64| at - 1..=at + 1;
        about(x)
            .any(|x| about(y).any(|y| about(z).any(|z| self.cells.get(CellKey::new([x, y, z])).is_some())))
    }

    /// Whether a point that has come is the first one of its cell.
    fn take(&mut self, point: &Vector3) -> bool {
        self.taken.get_or_insert(cell(point, TAKEN), 0).1
    }
}

fn cell(point: &Vector3, edge: f32) -> CellKey {
    CellKey::new([0, 1, 2].map(|axis| (point[axis] / f64::from(edge)).floor() as i64))
}

/// A point (body's frame, metres) in the map.
pub fn transform_to_map(map_from_body: &Isometry, point: &[f32; 3]) -> Vector3 {
    map_from_body.rotation * Vector3::from(point.map(f64::from)) + map_from_body.translation.vector
}

/// Indices of the points (frame of a body, metres) for which those that looked from nearest to them say so, without one of them.
fn judged(
    map_from_body: &Isometry,
    xyz: &[[f32; 3]],
    looks: &[RevisitScan],
    without: Option<usize>,
    judge: Judge,
) -> Vec<u32> {
    let mut blocks: BTreeMap<[i32; 3], Vec<u32>> = BTreeMap::new();
    for (index, point) in (0..).zip(xyz) {
        blocks.entry(point.map(|c| (c / BLOCK).floor() as i32)).or_default().push(index);
    }
    let body_from_map = map_from_body.inverse();
    let mut found = Vec::new();
    for (block, members) in blocks {
        let middle = transform_to_map(map_from_body, &block.map(|c| (c as f32 + 0.5) * BLOCK));
        let voters: Vec<_> = voters(&middle, looks, without)
            .map(|look| (body_from_map * look.map_from_base, &look.view))
            .collect();
        let points: Vec<[f32; 3]> = members.iter().map(|&index| xyz[index as usize]).collect();
        found.extend(judge(&points, &voters).into_iter().map(|index| members[index as usize]));
    }
    found.sort_unstable();
    found
}

/// The looks from nearest to a point of the map, without one of them.
fn voters<'a>(
    at: &Vector3,
    looks: &'a [RevisitScan],
    without: Option<usize>,
) -> impl Iterator<Item = &'a RevisitScan> {
    let others = looks.iter().enumerate().filter(move |(index, _)| Some(*index) != without);
    let mut near: Vec<(f64, &RevisitScan)> = others
        .map(|(_, look)| ((look.map_from_base.translation.vector - at).norm(), look))
        .filter(|(apart, _)| *apart <= REACH)
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.into_iter().take(VOTERS).map(|(_, look)| look)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The wall of a hall 8 m wide, with a box 1 m wide and high before it or not, seen from `x`.
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

    fn looks(box_at: Option<f64>) -> Vec<RevisitScan> {
        let look = |number: u32| {
            let x = -2.5 + f64::from(number);
            let xyz = seen(x, box_at);
            let at = Isometry::translation(x, 0.0, 0.0);
            RevisitScan::new(at, &xyz, &[], [0.0; 3], &mut Downsampler::default())
        };
        (0..6).map(look).collect()
    }

    #[test]
    fn a_box_that_was_pushed_along_the_wall_is_gone_from_there_and_has_come_here() {
        let (keyframe, old) = (Isometry::identity(), seen(0.0, Some(-1.0)));
        let looks = looks(Some(1.5));
        let is_box =
            |point: &[f32; 3], at: f32| point[1] > 1.9 && point[1] < 2.1 && (point[0] - at).abs() < 0.55;
        let gone = removed_points(&keyframe, &old, &looks);
        let boxes = old.iter().filter(|point| is_box(point, -1.0)).count();
        let right = gone.iter().filter(|index| is_box(&old[**index as usize], -1.0)).count();
        assert!(boxes > 500 && right * 10 > boxes * 9, "{right} of {boxes}");
        assert!((gone.len() - right) * 100 < old.len(), "{} of {}", gone.len() - right, old.len());

        let mut shown = OccupiedCells::default();
        for (index, point) in old.iter().enumerate() {
            if !gone.contains(&(index as u32)) {
                shown.add(&transform_to_map(&keyframe, point));
            }
        }
        let (mut of_box, mut other) = (0, 0);
        for one in 0..looks.len() {
            for index in added_points(&looks, one, &mut shown) {
                let point = transform_to_map(&looks[one].map_from_base, &looks[one].xyz[index as usize]);
                let at = [point.x as f32, point.y as f32, point.z as f32];
                // The wall behind the old box comes to light as well.
                let wall = at[1] > 3.9 && (at[0] + 1.5).abs() < 2.0;
                if is_box(&at, 1.5) { of_box += 1 } else { other += usize::from(!wall && at[1] > 0.0) }
            }
        }
        assert!(of_box > 300, "{of_box}");
        assert!(other * 20 < of_box, "{other} others, {of_box} of the box");
        assert!(added_points(&looks, 0, &mut shown).is_empty(), "once is enough");
        let view = RangeImage::new(&old, [0.0; 3]);
        assert!(is_in_free_space(&view, &[1.5, 2.0, 0.0]), "it looked through there");
        assert!(
            !is_in_free_space(&view, &[-2.0, 4.0, 0.0])
                && !is_in_free_space(&view, &[-1.5, 3.0, 0.0])
                && !is_in_free_space(&view, &[11.0, 2.0, 0.0])
        );
        assert_eq!(
            nearest_keyframe(
                &Isometry::translation(0.4, 0.0, 0.0),
                &[Isometry::translation(9.0, 0.0, 0.0), keyframe]
            ),
            Some(1)
        );
        assert_eq!(
            nearest_keyframe(&Isometry::translation(0.4, 0.0, 3.0), &[keyframe]),
            None,
            "it is on another floor"
        );
    }
}
