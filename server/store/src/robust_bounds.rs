//! A box round a map that a few stray points do not widen.
//!
//! Surveys contain returns from beyond windows, birds and reflections, hundreds of metres away. A view that shows the box round all points then shows the
//! site as a speck. Stray points are few and lie alone, so cells with few points are ignored, and of the rest a small share at each end of each axis.

use std::collections::BTreeMap;
use vocab::Aabb;

/// Parameters of [`robust_bounds`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RobustBoundsConfig {
    /// Edge of the cells in which points are counted, metres. Large against the distance between points on a surface of the map. Chosen: a metre; in smaller cells, walls
    /// far from the walk have too few points, and larger ones hold stray points together with good ones.
    pub(crate) cell_m: f32,
    /// Cells with fewer points are ignored. Chosen: a square metre of a surface has 400 at 5 cm.
    pub(crate) min_cell_points: u32,
    /// Share of all points that cells with enough points must hold, else no cell is ignored: the whole map is sparse then. Chosen: of a dense map, a tenth at most is
    /// stray.
    pub(crate) min_dense_share: f64,
    /// Share of the points that may lie outside the box at each end of each axis. Chosen: half a per cent as a round number: more cuts rooms at the border off, less lets
    /// stray points widen the box.
    pub(crate) outlier_share: f64,
    /// Where the box of all points is larger by at most this share of the robust box's edge, its side is taken: nothing is gained by cutting a wall. Chosen: a tenth,
    /// which nobody sees in a view of the whole map.
    pub(crate) tolerance_share: f32,
}

impl Default for RobustBoundsConfig {
    fn default() -> Self {
        Self {
            cell_m: 1.0,
            min_cell_points: 10,
            min_dense_share: 0.9,
            outlier_share: 0.005,
            tolerance_share: 0.1,
        }
    }
}

/// The box round most points (metres, any frame); none for no finite points. Linear in the points; takes 5 bytes for each.
pub(crate) fn robust_bounds(xyz: &[[f32; 3]], config: &RobustBoundsConfig) -> Option<Aabb> {
    let finite = |point: &&[f32; 3]| point.iter().all(|c| c.is_finite());
    let cell = |point: &[f32; 3]| point.map(|c| (c / config.cell_m).floor() as i64);
    let mut counts: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let (mut all, mut count) = (Aabb::EMPTY, 0_usize);
    for point in xyz.iter().filter(finite) {
        all.include(*point);
        count += 1;
        let entry = counts.entry(cell(point)).or_default();
        *entry = entry.saturating_add(1);
    }
    if count == 0 {
        return None;
    }
    counts.retain(|_, points| *points >= config.min_cell_points);
    let dense: u64 = counts.values().map(|points| u64::from(*points)).sum();
    let is_sparse = (dense as f64) < config.min_dense_share * count as f64;
    let is_kept = |point: &[f32; 3]| finite(&point) && (is_sparse || counts.contains_key(&cell(point)));
    let kept: Vec<bool> = xyz.iter().map(is_kept).collect();
    let mut bounds = all;
    // One axis after the other: a large map must not be in memory twice.
    let mut column = Vec::with_capacity(count);
    for axis in 0..3 {
        column.clear();
        column.extend(xyz.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(point, _)| point[axis]));
        let outliers = (config.outlier_share * column.len() as f64) as usize;
        let last = column.len() - 1;
        let mut in_order = |index: usize| *column.select_nth_unstable_by(index, f32::total_cmp).1;
        let (low, high) = (in_order(outliers), in_order(last - outliers));
        let tolerance = config.tolerance_share * (high - low);
        if low - all.min[axis] > tolerance {
            bounds.min[axis] = low;
        }
        if all.max[axis] - high > tolerance {
            bounds.max[axis] = high;
        }
    }
    Some(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A floor of 20 m by 10 m, a point every 0.1 m.
    fn floor() -> Vec<[f32; 3]> {
        (0..200).flat_map(|x| (0..100).map(move |y| [x as f32 * 0.1, y as f32 * 0.1, 0.0])).collect()
    }

    fn bounds(xyz: &[[f32; 3]]) -> Option<Aabb> {
        robust_bounds(xyz, &RobustBoundsConfig::default())
    }

    #[test]
    fn stray_points_do_not_widen_the_box() {
        let mut xyz = floor();
        let of_floor = bounds(&xyz).expect("there are points");
        assert_eq!((of_floor.min, of_floor.max[2]), ([0.0; 3], 0.0));
        assert!((of_floor.max[0] - 19.9).abs() < 1e-4 && (of_floor.max[1] - 9.9).abs() < 1e-4);
        xyz.extend([[400.0, 0.0, 0.0], [-380.0, 3.0, 90.0], [1.0, 1.0, -97.0], [f32::NAN, 0.0, 0.0]]);
        let robust = bounds(&xyz).expect("there are points");
        assert!(
            robust.max[0] < 21.0 && robust.min[0] > -1.0 && robust.max[2] < 1.0 && robust.min[2] > -1.0,
            "{robust:?}"
        );
    }

    #[test]
    fn a_sparse_map_keeps_its_points_and_nothing_has_no_box() {
        let sparse: Vec<[f32; 3]> = (0..50).map(|i| [i as f32 * 5.0, 0.0, 0.0]).collect();
        assert_eq!(bounds(&sparse).map(|bounds| bounds.max[0]), Some(245.0));
        assert_eq!(bounds(&[[1.0, 2.0, 3.0]]).map(|bounds| bounds.min), Some([1.0, 2.0, 3.0]));
        assert_eq!(bounds(&[]), None);
        assert_eq!(bounds(&[[f32::INFINITY, 0.0, 0.0]]), None);
    }
}
