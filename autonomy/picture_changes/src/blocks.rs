//! What is left of the displacement after the alignment, block by block.

use crate::PictureAlignmentConfig;
use crate::image::GreyImage;

/// A block of pixels of the earlier picture, and how far the aligned later picture is displaced there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PictureBlock {
    /// Its middle, pixels.
    pub(crate) centre_px: [f64; 2],
    /// The displacement at which it is found again, to a fraction of a pixel; none if it is not.
    pub(crate) displacement_px: Option<[f64; 2]>,
    /// Whether its structure fixes both directions: along a single edge the displacement is not known.
    pub(crate) is_corner: bool,
}

/// Blocks with structure, row by row. `after`: the later picture, resampled at the pixels of the earlier one; NaN where it has none. A pixel of both is `scale` pixels of the
/// full picture wide.
pub(crate) fn match_blocks(
    before: &GreyImage,
    after: &GreyImage,
    scale: usize,
    config: &PictureAlignmentConfig,
) -> Vec<PictureBlock> {
    let side = config.block_px / scale;
    let full = |px: f64| scale as f64 * (px + 0.5) - 0.5;
    let mut blocks = Vec::new();
    for top in (1..before.height.saturating_sub(side)).step_by(side) {
        for left in (1..before.width.saturating_sub(side)).step_by(side) {
            let [weakest, strongest] = structure(before, [left, top], side);
            if strongest < config.min_block_structure {
                continue;
            }
            let is_corner = weakest >= config.min_block_structure;
            let half = 0.5 * (side as f64 - 1.0);
            let centre_px = [left as f64 + half, top as f64 + half].map(full);
            let reach = config.block_search_px / scale;
            let found = find(before, after, [left, top], [side, reach], config.min_block_correlation);
            let displacement_px = found.map(|displacement| displacement.map(|px| scale as f64 * px));
            blocks.push(PictureBlock { centre_px, displacement_px, is_corner });
        }
    }
    blocks
}

/// The eigenvalues of the mean structure tensor: how well each direction is fixed, the least first.
fn structure(image: &GreyImage, [left, top]: [usize; 2], side: usize) -> [f64; 2] {
    let [mut xx, mut xy, mut yy] = [0.0; 3];
    for y in top..top + side {
        for x in left..left + side {
            let [gx, gy] = image.gradient(x, y).map(f64::from);
            (xx, xy, yy) = (xx + gx * gx, xy + gx * gy, yy + gy * gy);
        }
    }
    let (mean, spread) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    [mean - spread, mean + spread].map(|eigenvalue| eigenvalue / (side * side) as f64)
}

/// Correlations that differ by less are equally good: along an edge all displacements are.
const EQUALLY_GOOD: f64 = 0.03;

/// The least displacement of those with the greatest correlation. None if that is too small, or at the end of the search.
fn find(
    before: &GreyImage,
    after: &GreyImage,
    corner: [usize; 2],
    [side, reach]: [usize; 2],
    min_correlation: f64,
) -> Option<[f64; 2]> {
    let reach = reach.cast_signed();
    let width = 2 * reach + 1;
    let correlations: Vec<f64> = (0..width * width)
        .map(|at| [at % width - reach, at / width - reach])
        .map(|shift| correlation(before, after, corner, shift, side).unwrap_or(-1.0))
        .collect();
    let greatest = correlations.iter().copied().fold(-1.0, f64::max);
    let length = |at: &usize| {
        let [x, y] = [*at % width.cast_unsigned(), *at / width.cast_unsigned()];
        (x.cast_signed() - reach).pow(2) + (y.cast_signed() - reach).pow(2)
    };
    let good = (0..correlations.len()).filter(|at| correlations[*at] >= greatest - EQUALLY_GOOD);
    let nearest = good.min_by_key(length)?;
    let best = climb(&correlations, nearest, width.cast_unsigned());
    let [x, y] = [best.cast_signed() % width, best.cast_signed() / width];
    let is_inside = (1..width - 1).contains(&x) && (1..width - 1).contains(&y);
    if !is_inside || correlations[best] < min_correlation {
        return None;
    }
    let row = width.cast_unsigned();
    let right = vertex(correlations[best - 1], correlations[best], correlations[best + 1]);
    let down = vertex(correlations[best - row], correlations[best], correlations[best + row]);
    Some([(x - reach) as f64 + right, (y - reach) as f64 + down])
}

/// The place, or the one of its four neighbours whose correlation is greater than its own and the greatest.
fn climb(correlations: &[f64], start: usize, width: usize) -> usize {
    let around = |at: usize| [at.wrapping_sub(1), at + 1, at.wrapping_sub(width), at + width];
    let higher = |at: usize| {
        let best = around(at).into_iter().filter(|next| *next < correlations.len());
        best.max_by(|a, b| correlations[*a].total_cmp(&correlations[*b]))
            .filter(|next| correlations[*next] > correlations[at])
    };
    // One step, which leads from the edge of a peak to its middle.
    higher(start).unwrap_or(start)
}

/// Where a parabola through three values one apart has its greatest value, from the middle one: at most a half.
fn vertex(before: f64, middle: f64, after: f64) -> f64 {
    let bend = 2.0 * middle - before - after;
    if bend > 0.0 { (0.5 * (after - before) / bend).clamp(-0.5, 0.5) } else { 0.0 }
}

/// Correlation of a block with the place that is displaced by whole pixels. None where the later picture ends.
fn correlation(
    before: &GreyImage,
    after: &GreyImage,
    [left, top]: [usize; 2],
    [dx, dy]: [isize; 2],
    side: usize,
) -> Option<f64> {
    let (x, y) = (left.checked_add_signed(dx)?, top.checked_add_signed(dy)?);
    if x + side > after.width || y + side > after.height {
        return None;
    }
    let [mut a, mut b, mut aa, mut bb, mut ab] = [0.0_f32; 5];
    for row in 0..side {
        let from = &before.values[(top + row) * before.width + left..][..side];
        let to = &after.values[(y + row) * after.width + x..][..side];
        for (p, q) in from.iter().zip(to) {
            (a, b) = (a + p, b + q);
            (aa, bb, ab) = (aa + p * p, bb + q * q, ab + p * q);
        }
    }
    let count = (side * side) as f32;
    let (product, squares) = (ab - a * b / count, (aa - a * a / count) * (bb - b * b / count));
    (squares > 0.0).then(|| f64::from(product / squares.sqrt()))
}
