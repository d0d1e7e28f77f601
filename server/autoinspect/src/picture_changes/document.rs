//! The result of `autoinspect picture-changes` as JSON and for people.

use super::texts;
use ::picture_changes::{ChangedRegion, PictureAlignment, PictureAlignmentError, WarpModel};
use serde::{Deserialize, Serialize};
use site_model::{AlignedPictures, PictureChange, PictureComparison, PictureComparisonOutcome};

/// What two pictures say of each other.
#[derive(Debug, Serialize, Deserialize)]
pub struct Document {
    aligned: bool,
    /// Why they are not aligned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    #[serde(flatten)]
    alignment: Option<Alignment>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Alignment {
    /// Estimate of the error of the mapping in the middle of the picture, pixels.
    residual_px: f64,
    /// Share of the earlier picture that is in the later one.
    overlap: f64,
    /// Parameters of the mapping: translation, similarity, affine or homography.
    model: String,
    /// Rows of the matrix that maps pixels of the earlier picture, with a third coordinate of 1, to those of the later one; the middle of the first pixel is 0, 0.
    after_from_before: [[f64; 3]; 3],
    /// Columns and rows of both pictures.
    before_size_px: [u32; 2],
    after_size_px: [u32; 2],
    changes: Vec<Region>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Region {
    /// First column and row in the earlier picture, and the last ones.
    min_px: [usize; 2],
    max_px: [usize; 2],
    /// Changed pixels.
    area_px: usize,
    /// How clear the change is, 0.5 to 1.
    score: f64,
}

impl Document {
    /// The document of pictures that are aligned.
    pub fn aligned(
        alignment: &PictureAlignment,
        regions: &[ChangedRegion],
        sizes_px: [[usize; 2]; 2],
    ) -> Self {
        let model = match alignment.model {
            WarpModel::Translation => "translation",
            WarpModel::Similarity => "similarity",
            WarpModel::Affine => "affine",
            WarpModel::Homography => "homography",
        };
        let region = |&ChangedRegion { min_px, max_px, area_px, score }: &ChangedRegion| Region {
            min_px,
            max_px,
            area_px,
            score,
        };
        let [before_size_px, after_size_px] = sizes_px.map(|size| size.map(|side| side as u32));
        let matrix = alignment.after_from_before.matrix();
        let alignment = Alignment {
            residual_px: alignment.residual_px,
            overlap: alignment.overlap,
            model: model.to_owned(),
            before_size_px,
            after_size_px,
            after_from_before: [0, 1, 2].map(|row| [0, 1, 2].map(|column| matrix[(row, column)])),
            changes: regions.iter().map(region).collect(),
        };
        Self { aligned: true, reason: None, alignment: Some(alignment) }
    }

    /// The document of pictures that are not.
    pub fn not_aligned(reason: &PictureAlignmentError) -> Self {
        Self { aligned: false, reason: Some(reason.to_string()), alignment: None }
    }

    /// As it is kept beside a result.
    pub fn outcome(self) -> PictureComparisonOutcome {
        let Some(alignment) = self.alignment else {
            return PictureComparisonOutcome::NotAligned(texts::not_aligned_sentence(
                self.reason.as_deref().unwrap_or_default(),
            ));
        };
        let change = |region: &Region| PictureChange {
            min_px: region.min_px.map(|px| px as u32),
            max_px: region.max_px.map(|px| px as u32),
            area_px: region.area_px as u32,
            strength: region.score,
        };
        PictureComparisonOutcome::Aligned(AlignedPictures {
            after_from_before: alignment.after_from_before,
            residual_px: alignment.residual_px,
            before_size_px: alignment.before_size_px,
            after_size_px: alignment.after_size_px,
            changes: alignment.changes.iter().take(PictureComparison::MAX_CHANGES).map(change).collect(),
        })
    }

    /// A line for the alignment and one for each region.
    pub fn describe(&self) -> String {
        let Some(alignment) = &self.alignment else {
            return texts::not_aligned(self.reason.as_deref().unwrap_or_default());
        };
        let mut lines = vec![texts::aligned(alignment.residual_px, alignment.overlap)];
        lines.extend(
            alignment.changes.iter().map(|it| texts::region(it.min_px, it.max_px, it.area_px, it.score)),
        );
        if alignment.changes.is_empty() {
            lines.push(texts::UNCHANGED.to_owned());
        }
        lines.join("\n")
    }
}
