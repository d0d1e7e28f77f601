//! A search of the displacement of two coarse pictures, where Gauss-Newton would begin too far away.

use crate::PictureAlignmentConfig;
use crate::homography::Homography;
use crate::image::GreyImage;
use crate::warp::PictureFrame;

/// Where a pixel of the earlier picture is expected in the later one, and how much it counts.
struct SearchPlace {
    mapped: [isize; 2],
    weight: f64,
}

/// `start` after the displacement of at most `reach` pixels of the later picture at which both pictures correlate best. None if they overlap too little everywhere.
pub(crate) fn search_displacement(
    before: &GreyImage,
    after: &GreyImage,
    start: &Homography,
    reach: isize,
    config: &PictureAlignmentConfig,
) -> Option<Homography> {
    let frame = PictureFrame::new(before.width, before.height);
    let place = |at: usize| {
        let px = [(at % before.width) as f64, (at / before.width) as f64];
        let mapped = start.map(px)?.map(|at| at.round() as isize);
        Some(SearchPlace { mapped, weight: frame.weight(px, config.weight_radius_share) })
    };
    let places: Vec<Option<SearchPlace>> = (0..before.values.len()).map(place).collect();
    let min_overlap = config.min_overlap;
    let least = min_overlap * before.values.len() as f64;
    let mut best: Option<(f64, [isize; 2])> = None;
    for dy in -reach..=reach {
        for dx in -reach..=reach {
            let Some(score) = correlation(before, after, &places, [dx, dy], least) else { continue };
            if best.is_none_or(|(greatest, _)| score > greatest) {
                best = Some((score, [dx, dy]));
            }
        }
    }
    let (_, shift) = best?;
    Homography::translation(shift.map(|shift| shift as f64)).after(start)
}

/// Correlation of what both pictures show; none of fewer than `least` pixels.
fn correlation(
    before: &GreyImage,
    after: &GreyImage,
    places: &[Option<SearchPlace>],
    [dx, dy]: [isize; 2],
    least: f64,
) -> Option<f64> {
    let [mut aa, mut bb, mut ab] = [0.0_f64; 3];
    let mut count = 0_usize;
    let (width, height) = (after.width.cast_signed(), after.height.cast_signed());
    for (value, place) in before.values.iter().zip(places) {
        let Some(SearchPlace { mapped: [x, y], weight }) = place else { continue };
        let (x, y) = (x + dx, y + dy);
        if x < 0 || y < 0 || x >= width || y >= height {
            continue;
        }
        let (p, q) = (f64::from(*value), f64::from(after.values[(y * width + x).cast_unsigned()]));
        (aa, bb, ab) = (aa + weight * p * p, bb + weight * q * q, ab + weight * p * q);
        count += 1;
    }
    (count as f64 >= least && aa > 0.0 && bb > 0.0).then(|| ab / (aa * bb).sqrt())
}
