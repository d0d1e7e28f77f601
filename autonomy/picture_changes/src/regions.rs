//! Changed pixels that belong together.

use crate::PictureChangesConfig;

/// A part of the earlier picture that looks different in the later one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChangedRegion {
    /// First column and row, pixels.
    pub min_px: [usize; 2],
    /// Last column and row, pixels.
    pub max_px: [usize; 2],
    /// Changed pixels.
    pub area_px: usize,
    /// How clear the change is, 0.5 to 1: more with its area and its strength.
    pub score: f64,
}

/// The regions of pixels of a strength of at least 1, the clearest first.
pub(crate) fn regions(
    strength: &[f32],
    [width, height]: [usize; 2],
    config: &PictureChangesConfig,
) -> Vec<ChangedRegion> {
    let reach = config.join_px.cast_signed();
    let mut is_open: Vec<bool> = strength.iter().map(|strength| *strength >= 1.0).collect();
    let mut found = Vec::new();
    for start in 0..is_open.len() {
        if !std::mem::take(&mut is_open[start]) {
            continue;
        }
        let mut pixels = vec![start];
        let mut next = 0;
        while let Some(at) = pixels.get(next).copied() {
            next += 1;
            let (x, y) = (at % width, at / width);
            for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
                let place = x.checked_add_signed(dx).zip(y.checked_add_signed(dy));
                let Some((x, y)) = place.filter(|(x, y)| *x < width && *y < height) else { continue };
                if std::mem::take(&mut is_open[y * width + x]) {
                    pixels.push(y * width + x);
                }
            }
        }
        let total: f64 = pixels.iter().map(|at| f64::from(strength[*at])).sum();
        if pixels.len() >= config.min_area_px && total >= config.min_total_strength {
            found.push(region(&pixels, total, width, config));
        }
    }
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    found
}

fn region(pixels: &[usize], total: f64, width: usize, config: &PictureChangesConfig) -> ChangedRegion {
    let places = || pixels.iter().map(|at| [at % width, at / width]);
    let edge = |pick: fn(usize, usize) -> usize| {
        places().reduce(|a, b| [pick(a[0], b[0]), pick(a[1], b[1])]).unwrap_or_default()
    };
    ChangedRegion {
        min_px: edge(usize::min),
        max_px: edge(usize::max),
        area_px: pixels.len(),
        score: total / (total + config.min_total_strength),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_pixels_are_one_region_and_few_or_weak_ones_are_none() {
        let size = [40, 30];
        let mut strength = vec![0.0; 40 * 30];
        // Four by four, with a gap of two columns to four more; far away three strong ones, and twelve weak ones.
        for (x, y) in (5..9).flat_map(|x| (5..9).map(move |y| (x, y))).chain((11..15).map(|x| (x, 6))) {
            strength[y * 40 + x] = 2.0;
        }
        (30..33).for_each(|x| strength[20 * 40 + x] = 50.0);
        (2..14).for_each(|x| strength[25 * 40 + x] = 1.0);
        let found = regions(&strength, size, &PictureChangesConfig::default());
        let expected = ChangedRegion { min_px: [5, 5], max_px: [14, 8], area_px: 20, score: 40.0 / 70.0 };
        assert_eq!(found, [expected]);
    }
}
