//! Robust bounds of a map: the box that holds it without stray points.
//!
//! A survey may hold a few points hundreds of metres away, seen through a window or reflected by glass. The box around all tiles then shows
//! the map as a dot. Tiles know their box and their number of points, so the box is taken from quantiles of the points along each axis.

use vocab::Aabb;

/// Parameters of [`robust_bounds`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TileBoundsConfig {
    /// Share of the points that is cut off at each end of each axis. Chosen: as in the store, half a per cent (`store::robust_bounds`).
    pub(crate) trimmed_share: f64,
    /// Margin on each side, as a share of the trimmed extent. A uniform distribution loses less than this by trimming. Chosen: twice what it loses at both ends.
    pub(crate) margin_ratio: f64,
    /// Share of the points that coarse levels may hold to be left out. A coarse level keeps one point of each large cell: stray points weigh
    /// much there, and its boxes are large. Chosen: where there are finer levels, coarse ones hold less.
    pub(crate) max_coarse_share: f64,
}

impl Default for TileBoundsConfig {
    fn default() -> Self {
        Self { trimmed_share: 0.005, margin_ratio: 0.02, max_coarse_share: 0.3 }
    }
}

/// A tile: its box in the map frame (m), its level and its number of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TileExtent {
    pub(crate) bounds: Aabb,
    pub(crate) level: u8,
    pub(crate) points: u32,
}

/// The box (m, map frame) between two quantiles of the points along each axis, with a margin, and within the box of all tiles. The points of
/// a tile count as evenly distributed over its box. None without points. Cost: `n log n` in the tiles.
pub(crate) fn robust_bounds(config: &TileBoundsConfig, tiles: &[TileExtent]) -> Option<Aabb> {
    let total: f64 = tiles.iter().map(|tile| f64::from(tile.points)).sum();
    let finest = tiles.iter().map(|tile| tile.level).max()?;
    let points_above = |level: u8| -> f64 {
        tiles.iter().filter(|tile| tile.level < level).map(|tile| f64::from(tile.points)).sum()
    };
    let coarsest =
        (0..=finest).rev().find(|level| points_above(*level) <= config.max_coarse_share * total)?;
    let counted: Vec<&TileExtent> =
        tiles.iter().filter(|tile| tile.level >= coarsest && tile.points > 0).collect();
    let mut robust = Aabb::EMPTY;
    for axis in 0..3 {
        let low = quantile(&counted, axis, config.trimmed_share)?;
        let high = quantile(&counted, axis, 1.0 - config.trimmed_share)?;
        let margin = config.margin_ratio * (high - low);
        let all = |pick: fn(f64, f64) -> f64, side: fn(&Aabb) -> [f32; 3], start: f64| {
            tiles.iter().map(|tile| f64::from(side(&tile.bounds)[axis])).fold(start, pick)
        };
        robust.min[axis] = (low - margin).max(all(f64::min, |bounds| bounds.min, f64::INFINITY)) as f32;
        robust.max[axis] = (high + margin).min(all(f64::max, |bounds| bounds.max, f64::NEG_INFINITY)) as f32;
    }
    Some(robust)
}

/// The coordinate below which this share of the points lies.
fn quantile(tiles: &[&TileExtent], axis: usize, share: f64) -> Option<f64> {
    // Density of points (1/m) as a sum of steps, each at an end of a box.
    let mut steps: Vec<(f64, f64)> = Vec::with_capacity(2 * tiles.len());
    let mut total = 0.0;
    for tile in tiles {
        let low = f64::from(tile.bounds.min[axis]);
        let high = f64::from(tile.bounds.max[axis]).max(low + MIN_EXTENT_M);
        let points = f64::from(tile.points);
        steps.extend([(low, points / (high - low)), (high, -points / (high - low))]);
        total += points;
    }
    steps.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let wanted = share * total;
    let (mut below, mut density) = (0.0, 0.0);
    for pair in steps.windows(2) {
        let [(from, step), (to, _)] = pair else { continue };
        density += step;
        let between = density * (to - from);
        if below + between >= wanted && density > 0.0 {
            return Some(from + (wanted - below) / density);
        }
        below += between;
    }
    steps.last().map(|(end, _)| *end)
}

/// Flat boxes count as this thick, m, so that their density is finite.
const MIN_EXTENT_M: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(min: [f32; 3], max: [f32; 3], level: u8, points: u32) -> TileExtent {
        TileExtent { bounds: Aabb { min, max }, level, points }
    }

    /// A building of 40 x 20 x 6 m: a coarse level over it and 8 x 4 finer tiles.
    fn building() -> Vec<TileExtent> {
        let mut tiles = vec![tile([0.0; 3], [40.0, 20.0, 6.0], 0, 20_000)];
        for x in 0..8_u8 {
            for y in 0..4_u8 {
                let (x, y) = (5.0 * f32::from(x), 5.0 * f32::from(y));
                tiles.push(tile([x, y, 0.0], [x + 5.0, y + 5.0, 6.0], 1, 50_000));
            }
        }
        tiles
    }

    fn assert_near(bounds: Aabb, min: [f32; 3], max: [f32; 3], tolerance_m: f32) {
        for axis in 0..3 {
            assert!((bounds.min[axis] - min[axis]).abs() <= tolerance_m, "{bounds:?}");
            assert!((bounds.max[axis] - max[axis]).abs() <= tolerance_m, "{bounds:?}");
        }
    }

    #[test]
    fn a_map_without_strays_keeps_its_box() {
        let bounds = robust_bounds(&TileBoundsConfig::default(), &building()).unwrap();
        assert_near(bounds, [0.0; 3], [40.0, 20.0, 6.0], 0.1);
    }

    #[test]
    fn strays_far_away_do_not_enlarge_the_box() {
        let mut tiles = building();
        // The coarse level reaches to the strays, and each has a fine tile.
        tiles[0] = tile([-400.0, -300.0, -50.0], [420.0, 350.0, 90.0], 0, 20_400);
        for at in [[-400.0, -300.0, -50.0], [418.0, 348.0, 88.0], [10.0, 300.0, 2.0]] {
            tiles.push(tile(at, at.map(|side: f32| side + 2.0), 1, 300));
        }
        let bounds = robust_bounds(&TileBoundsConfig::default(), &tiles).unwrap();
        assert_near(bounds, [0.0; 3], [40.0, 20.0, 6.0], 0.8);
    }

    #[test]
    fn a_second_building_is_no_stray() {
        let mut tiles = building();
        tiles.push(tile([100.0, 0.0, 0.0], [120.0, 20.0, 6.0], 1, 100_000));
        let bounds = robust_bounds(&TileBoundsConfig::default(), &tiles).unwrap();
        assert!(bounds.max[0] > 117.0, "{bounds:?}");
    }

    #[test]
    fn maps_of_one_level_one_point_or_none_have_sensible_bounds() {
        let config = TileBoundsConfig::default();
        assert_eq!(robust_bounds(&config, &[]), None);
        let one = tile([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], 0, 1);
        assert_near(robust_bounds(&config, &[one]).unwrap(), [1.0, 2.0, 3.0], [1.0, 2.0, 3.0], 0.01);
        let flat = tile([0.0; 3], [10.0, 10.0, 0.0], 3, 1000);
        assert_near(robust_bounds(&config, &[flat]).unwrap(), [0.0; 3], [10.0, 10.0, 0.0], 0.1);
    }
}
