//! The alignment of two pictures of one thing.

use crate::PictureAlignmentConfig;
use crate::blocks::{PictureBlock, match_blocks};
use crate::homography::Homography;
use crate::image::{GreyImage, median};
use crate::levels::{at_level, from_level, normalised_levels};
use crate::refine::{Refined, StructurePixel, refine, structure_pixels};
use crate::search::search_displacement;
use crate::warp::{PictureFrame, WarpModel};
use gauges::Picture;
use std::fmt;

/// How a picture is mapped to a later one of the same thing.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureAlignment {
    /// From pixels of the earlier picture to those of the later one.
    pub after_from_before: Homography,
    /// The model that was refined at full resolution.
    pub model: WarpModel,
    /// Estimate of the remaining error round the middle of the picture, where the target is, pixels: at most this in 95 % of the pictures.
    pub residual_px: f64,
    /// Pixels of the earlier picture that have a place in the later one, as a share.
    pub overlap: f64,
    pub(crate) blocks: Vec<PictureBlock>,
}

/// Why two pictures are not aligned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PictureAlignmentError {
    /// A picture is smaller than what can be compared.
    TooSmall {
        /// Its size, pixels.
        size_px: [usize; 2],
        /// The least length of a side, pixels.
        least_px: usize,
    },
    /// A picture shows nothing that fixes its place.
    NoTexture,
    /// Too little of one picture is in the other one.
    TooLittleOverlap {
        /// The share that is in both.
        overlap: f64,
    },
    /// No mapping was found at which the pictures agree.
    NotConverged,
}

impl fmt::Display for PictureAlignmentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooSmall { size_px: [width, height], least_px } => {
                write!(
                    f,
                    "a picture of {width} x {height} pixels is too small; both sides need {least_px} pixels"
                )
            }
            Self::NoTexture => f.write_str(
                "a picture shows nothing that fixes its place: it is too dark, blurred or of a bare surface",
            ),
            Self::TooLittleOverlap { overlap } => {
                write!(
                    f,
                    "only {:.0} % of the earlier picture are in the later one; take it from nearer to the same place",
                    100.0 * overlap
                )
            }
            Self::NotConverged => {
                f.write_str("the pictures do not show the same thing, or too much has changed")
            }
        }
    }
}

impl std::error::Error for PictureAlignmentError {}

/// Shortest side of a picture that is compared, pixels.
const MIN_SIDE_PX: usize = 64;

/// Finds the mapping from a picture to a later one, coarse to fine. `predicted`: what the poses of the camera say ([`Homography::predicted`]); without it the pictures
/// are taken from nearly the same place.
///
/// # Errors
/// When a picture is too small or without texture, they overlap too little, or do not agree.
pub fn align_pictures(
    before: &Picture,
    after: &Picture,
    predicted: Option<&Homography>,
    config: &PictureAlignmentConfig,
) -> Result<PictureAlignment, PictureAlignmentError> {
    for picture in [before, after] {
        let size_px = picture.size_px();
        if size_px.iter().any(|side| *side < MIN_SIDE_PX) {
            return Err(PictureAlignmentError::TooSmall { size_px, least_px: MIN_SIDE_PX });
        }
    }
    let levels = [before, after].map(|picture| normalised_levels(&GreyImage::of(picture), config));
    let pixels = levels[0].iter().map(|level| structure_pixels(level, config)).collect::<Vec<_>>();
    if levels.iter().any(|levels| !has_texture(levels, config)) {
        return Err(PictureAlignmentError::NoTexture);
    }
    let start = search(&levels, predicted, config)?;
    let Refined { homography, model, deviation_px } =
        coarse_to_fine(&levels, &pixels, &start, config).ok_or(PictureAlignmentError::NotConverged)?;
    let overlap = overlap(&homography, before.size_px(), after.size_px());
    if overlap < config.min_overlap {
        return Err(PictureAlignmentError::TooLittleOverlap { overlap });
    }
    let correlation = correlation(&levels, &homography, config).ok_or(PictureAlignmentError::NotConverged)?;
    if correlation < config.min_correlation {
        return Err(PictureAlignmentError::NotConverged);
    }
    let blocks = blocks(&levels, &homography, config).ok_or(PictureAlignmentError::NotConverged)?;
    let residual_px = residual_px(&blocks, before.size_px(), deviation_px, config);
    Ok(PictureAlignment { after_from_before: homography, model, residual_px, overlap, blocks })
}

/// Whether there are enough pixels of texture at full or half resolution: noise hides fine structure.
fn has_texture(levels: &[GreyImage], config: &PictureAlignmentConfig) -> bool {
    levels.iter().take(2).any(|level| {
        let count = (1..level.height - 1).flat_map(|y| (1..level.width - 1).map(move |x| (x, y)));
        let is_structure = |(x, y): &(usize, usize)| {
            let [gx, gy] = level.gradient(*x, *y).map(f64::from);
            gx.hypot(gy) >= config.texture_gradient
        };
        count.filter(is_structure).count() as f64 >= config.min_structure_share * level.values.len() as f64
    })
}

/// The displacement of the predicted mapping at which the coarsest levels agree best.
fn search(
    levels: &[Vec<GreyImage>; 2],
    predicted: Option<&Homography>,
    config: &PictureAlignmentConfig,
) -> Result<Homography, PictureAlignmentError> {
    let share = if predicted.is_some() { config.search_share } else { config.search_share_without_poses };
    let coarsest = levels[0].len().min(levels[1].len()) - 1;
    let [before, after] = [0, 1].map(|picture| &levels[picture][coarsest]);
    let start = at_level(predicted.unwrap_or(&Homography::identity()), coarsest);
    let reach = (share * before.width as f64).ceil() as isize;
    let found = start.and_then(|start| search_displacement(before, after, &start, reach, config));
    found
        .and_then(|found| from_level(&found, coarsest))
        .ok_or(PictureAlignmentError::TooLittleOverlap { overlap: 0.0 })
}

/// Refines from the coarsest level to the full resolution: more numbers as pixels allow.
fn coarse_to_fine(
    levels: &[Vec<GreyImage>; 2],
    pixels: &[Vec<StructurePixel>],
    start: &Homography,
    config: &PictureAlignmentConfig,
) -> Option<Refined> {
    let coarsest = levels[0].len().min(levels[1].len()) - 1;
    let mut refined =
        Refined { homography: *start, model: WarpModel::Translation, deviation_px: f64::INFINITY };
    for level in (0..=coarsest).rev() {
        let largest = match coarsest - level {
            0 if level > 0 => WarpModel::Similarity,
            1 if level > 0 => WarpModel::Affine,
            _ => WarpModel::Homography,
        };
        let [before, after] = [0, 1].map(|picture| &levels[picture][level]);
        let frame = PictureFrame::new(before.width, before.height);
        let start = at_level(&refined.homography, level)?;
        let Some(found) = refine(&pixels[level], &frame, after, &start, largest, config) else {
            // What a coarse or a noisy level does not hold, another one may.
            continue;
        };
        let scale = f64::from(1_u32 << level);
        refined = Refined {
            homography: from_level(&found.homography, level)?,
            model: found.model,
            deviation_px: scale * found.deviation_px,
        };
    }
    refined.deviation_px.is_finite().then_some(refined)
}

/// Pixels of the earlier picture that have a place in the later one, as a share: a grid of 32 x 32 places.
fn overlap(homography: &Homography, before_px: [usize; 2], after_px: [usize; 2]) -> f64 {
    const GRID: usize = 32;
    let place = |at: usize| {
        let share = [at % GRID, at / GRID].map(|at| (at as f64 + 0.5) / GRID as f64);
        [share[0] * before_px[0] as f64 - 0.5, share[1] * before_px[1] as f64 - 0.5]
    };
    let is_inside =
        |px: &[f64; 2]| (0..2).all(|axis| px[axis] >= 0.0 && px[axis] <= after_px[axis] as f64 - 1.0);
    let count =
        (0..GRID * GRID).filter(|at| homography.map(place(*at)).as_ref().is_some_and(is_inside)).count();
    count as f64 / (GRID * GRID) as f64
}

/// Correlation of the aligned pictures at a quarter of the resolution, or less if there is none: noise is small there. None if they do not overlap.
fn correlation(
    levels: &[Vec<GreyImage>; 2],
    homography: &Homography,
    config: &PictureAlignmentConfig,
) -> Option<f64> {
    let level = 2.min(levels[0].len() - 1).min(levels[1].len() - 1);
    let [before, after] = [0, 1].map(|picture| &levels[picture][level]);
    let resampled = resample(after, &at_level(homography, level)?, [before.width, before.height]);
    let frame = PictureFrame::new(before.width, before.height);
    let [mut aa, mut bb, mut ab] = [0.0; 3];
    for (at, (a, b)) in before.values.iter().zip(&resampled.values).enumerate() {
        let (a, b) = (f64::from(*a), f64::from(*b));
        if b.is_finite() {
            let px = [(at % before.width) as f64, (at / before.width) as f64];
            let weight = frame.weight(px, config.weight_radius_share);
            (aa, bb, ab) = (aa + weight * a * a, bb + weight * b * b, ab + weight * a * b);
        }
    }
    (aa > 0.0 && bb > 0.0).then(|| ab / (aa * bb).sqrt())
}

/// The blocks of the earlier picture, and where they are in the later one after the alignment. At half resolution, if there is one: there is less noise.
fn blocks(
    levels: &[Vec<GreyImage>; 2],
    homography: &Homography,
    config: &PictureAlignmentConfig,
) -> Option<Vec<PictureBlock>> {
    let level = usize::from(levels.iter().all(|levels| levels.len() > 1));
    let [before, after] = [0, 1].map(|picture| &levels[picture][level]);
    let resampled = resample(after, &at_level(homography, level)?, [before.width, before.height]);
    Some(match_blocks(before, &resampled, 1 << level, config))
}

/// The later picture at the pixels of the earlier one; NaN where it has none.
fn resample(after: &GreyImage, homography: &Homography, [width, height]: [usize; 2]) -> GreyImage {
    let value = |at: usize| {
        let place = homography.map([(at % width) as f64, (at / width) as f64]);
        place.and_then(|px| after.sample(px)).map_or(f32::NAN, |sample| sample.value as f32)
    };
    GreyImage { width, height, values: (0..width * height).map(value).collect() }
}

/// Equation 8 of docs/maths/picture-changes.md: what the blocks round the middle, or all if there are none, say of the remaining error.
fn residual_px(
    blocks: &[PictureBlock],
    [width, height]: [usize; 2],
    deviation_px: f64,
    config: &PictureAlignmentConfig,
) -> f64 {
    let centre = [0.5 * (width as f64 - 1.0), 0.5 * (height as f64 - 1.0)];
    let reach = config.target_radius_share * width as f64;
    let is_near = |block: &PictureBlock| {
        (block.centre_px[0] - centre[0]).abs() <= reach && (block.centre_px[1] - centre[1]).abs() <= reach
    };
    let typical = |blocks: &mut dyn Iterator<Item = &PictureBlock>| {
        let mut sizes: Vec<f32> = blocks
            .filter(|block| block.is_corner)
            .filter_map(|block| block.displacement_px)
            .map(|[right, down]| right.hypot(down) as f32)
            .collect();
        median(&mut sizes).map(f64::from)
    };
    let near_px = typical(&mut blocks.iter().filter(|block| is_near(block)));
    let typical_px = near_px.or_else(|| typical(&mut blocks.iter())).unwrap_or(0.0);
    (typical_px + 2.0 * deviation_px).max(config.min_residual_px)
}
