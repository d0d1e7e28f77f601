//! Parameters of the alignment of pictures and of the search for changes in them.

/// Parameters of [`crate::align_pictures`].
///
/// docs/benchmarks/picture-changes.md says which of them were varied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureAlignmentConfig {
    /// Pictures are halved while their shorter side stays at least this long, pixels. Chosen: 60 pixels are 480 halved three times.
    pub coarsest_side_px: usize,
    /// Radius of the square over which brightness is normalised, pixels of each level. Chosen: larger than the blur of an edge, smaller than a shadow.
    pub normalisation_radius_px: usize,
    /// Contrast below this is not amplified to 1, as a share of white. Chosen: ten steps of 256, more than the texture of a wall.
    pub min_contrast: f64,
    /// That limit is at least this multiple of the noise of the picture. Chosen: noise alone is a quarter then.
    pub min_contrast_to_noise: f64,
    /// How far the search on the coarsest level reaches if the poses are known, as a share of the width. Chosen: 60 of 640 pixels, eight times the worst error of an aim
    /// in docs/benchmarks/missions.md.
    pub search_share: f64,
    /// How far it reaches if they are not. Chosen: a quarter, so that half of each side is in both pictures.
    pub search_share_without_poses: f64,
    /// A pixel counts as structure if its normalised value changes by this much a pixel. Chosen: a third of a full edge; noise alone rarely has it.
    pub min_gradient: f64,
    /// It counts as texture, which noise is not, if that value changes by this much. Chosen: four standard deviations of what noise alone does.
    pub texture_gradient: f64,
    /// Fewer pixels of texture than this share of the picture are no texture. Chosen: one in 500, which is 600 pixels of 640 x 480.
    pub min_structure_share: f64,
    /// At least this share of the pixels of one picture has a place in the other one. Chosen: a quarter, half of each side.
    pub min_overlap: f64,
    /// Standard deviation of the weight of pixels round the middle of the picture, as a share of its width: the target is there. Chosen: a third.
    pub weight_radius_share: f64,
    /// Most pixels that are used on one level. Chosen: for the time; an eighth of the pixels of 640 x 480.
    pub max_samples: usize,
    /// Most steps on one level. Chosen: far more than the two to six that are needed.
    pub max_steps: usize,
    /// A step that moves no corner by more than this ends a level, pixels of that level. Chosen: a tenth of what the alignment reaches.
    pub converged_px: f64,
    /// Residuals of neighbouring pixels are alike: the information of this many counts as one. Chosen: a square of 4 pixels.
    pub correlated_pixels: f64,
    /// A model is used if the standard deviation of its mapping is below this, pixels. Chosen: a quarter of the 1.5 pixels that are wanted.
    pub max_deviation_px: f64,
    /// Side of the blocks whose remaining displacement is measured, pixels. Chosen: large enough for a mark or a letter, smaller than what stands before a wall.
    pub block_px: usize,
    /// Greatest remaining displacement that is looked for, pixels. Chosen: what a camera that moves by 3 cm sees of something twice as far away, at 0.8 m of width.
    pub block_search_px: usize,
    /// A block is found where the correlation of both pictures is at least this. Chosen: half of the variance is explained.
    pub min_block_correlation: f64,
    /// A block is used if its structure fixes a direction: greatest eigenvalue of its mean structure tensor, squared normalised values per squared pixel. It fixes both if the
    /// smallest one is as large. Chosen: more than noise alone has (0.03).
    pub min_block_structure: f64,
    /// Least correlation of both pictures after the alignment, at a quarter of the resolution: with less they do not show the same. Chosen: with 0.5 grainy pictures of the
    /// simulator that show the same were refused too.
    pub min_correlation: f64,
    /// Blocks within this distance of the middle say how well the target is aligned, as a share of the width. Chosen: as
    /// [`Self::weight_radius_share`].
    pub target_radius_share: f64,
    /// The residual is at least this, pixels: what bilinear interpolation and noise cost.
    pub min_residual_px: f64,
}

impl Default for PictureAlignmentConfig {
    fn default() -> Self {
        Self {
            coarsest_side_px: 60,
            normalisation_radius_px: 8,
            min_contrast: 0.04,
            min_contrast_to_noise: 4.0,
            search_share: 0.1,
            search_share_without_poses: 0.25,
            min_gradient: 0.3,
            texture_gradient: 0.7,
            min_structure_share: 0.002,
            min_overlap: 0.25,
            weight_radius_share: 0.33,
            max_samples: 40_000,
            max_steps: 25,
            converged_px: 0.01,
            correlated_pixels: 16.0,
            max_deviation_px: 0.4,
            block_px: 32,
            block_search_px: 20,
            min_block_correlation: 0.7,
            min_block_structure: 0.04,
            min_correlation: 0.3,
            target_radius_share: 0.3,
            min_residual_px: 0.1,
        }
    }
}

/// Parameters of [`crate::find_picture_changes`].
///
/// docs/benchmarks/picture-changes.md says which of them were varied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureChangesConfig {
    /// Light below this is not told from darkness, as a share of white. Chosen: a little more than black print has (0.02), so that noise and compression in black make no
    /// change. With 0.01 the results of docs/benchmarks/picture-changes.md were nearly the same.
    pub dark_light: f64,
    /// Side of the cells in which the difference of light of both pictures is measured, pixels. Chosen: for the time.
    pub light_cell_px: usize,
    /// The light of a place is the median of the cells within this many cells of it. Chosen: a sixth of a picture of 640 pixels is larger than what changes, and smaller than
    /// most shadows.
    pub light_radius_cells: usize,
    /// Standard deviation of the noise that every picture has, as a share of white: rounding and compression. Chosen: two steps of 256.
    pub min_noise: f64,
    /// Differences below this multiple of the noise do not count. Chosen: two, because what is near a pixel has noise too.
    pub noise_tolerance: f64,
    /// Side of the squares for which it is decided which displacements explain a difference, pixels. Chosen: half a block.
    pub tolerance_cell_px: usize,
    /// Blocks whose middle is at most this far from that of a square say so, pixels along each axis: two blocks.
    pub tolerance_reach_px: f64,
    /// A displacement of this many pixels explains a difference everywhere: interpolation and the coarser colours of JPEG files. Source:
    /// with 1 pixel fewer small changes of docs/benchmarks/picture-changes.md were flagged.
    pub displacement_tolerance_px: f64,
    /// A place is of the plane if this share of the blocks round it is where the plane says. Chosen: half.
    pub plane_share: f64,
    /// It is not if more than this share of them is displaced. Source: with 0.1 changes of gauges were
    /// missed (docs/benchmarks/picture-changes.md).
    pub displaced_share: f64,
    /// Elsewhere differences count only this much. Chosen: what is seen past an edge was hidden before, so that
    /// only strong differences say something.
    pub off_plane_share: f64,
    /// Displacement that is assumed of a block that was not found again, pixels: the farthest that it is looked for.
    pub lost_block_px: f64,
    /// Values from this on are overexposed, as a share of white: what was brighter looks the same. Chosen.
    pub overexposed: f64,
    /// How much brighter they may have been, as a logarithm. Chosen: a factor of 2.
    pub overexposed_range: f64,
    /// A colour has changed if the logarithms of the light of two of red, green and blue differ by this much more than before. Chosen: a factor of 1.8.
    pub min_colour_change: f64,
    /// Light alone makes a place at most this much darker or brighter than its surroundings, as a logarithm: shadows of lamps. Chosen: a factor of 6.
    pub max_light_change: f64,
    /// Changed pixels within this distance belong to one region, pixels.
    pub join_px: usize,
    /// A region has at least this many changed pixels. Chosen: a needle of 2 pixels and 5 pixels of its length.
    pub min_area_px: usize,
    /// The strengths of its pixels sum to at least this. Source: noise in a grainy picture came to 25, with 22 pixels (docs/benchmarks/picture-changes.md).
    pub min_total_strength: f64,
}

impl Default for PictureChangesConfig {
    fn default() -> Self {
        Self {
            dark_light: 0.025,
            light_cell_px: 8,
            light_radius_cells: 6,
            min_noise: 0.008,
            noise_tolerance: 2.0,
            tolerance_cell_px: 16,
            tolerance_reach_px: 64.0,
            displacement_tolerance_px: 2.0,
            plane_share: 0.5,
            displaced_share: 0.2,
            off_plane_share: 0.3,
            lost_block_px: 20.0,
            overexposed: 0.97,
            overexposed_range: 0.7,
            min_colour_change: 0.6,
            max_light_change: 1.8,
            join_px: 3,
            min_area_px: 12,
            min_total_strength: 30.0,
        }
    }
}
