//! What a picture of an inspection point shows otherwise than an earlier one: the JSON that is kept beside its result.

use serde::{Deserialize, Serialize};

/// The picture of a result, compared with an earlier one of the same inspection point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureComparison {
    /// Number of the result with the earlier picture.
    pub before: u64,
    /// What was found.
    pub outcome: PictureComparisonOutcome,
}

/// What a comparison of two pictures has found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PictureComparisonOutcome {
    /// Both show the same, from nearly the same place.
    Aligned(AlignedPictures),
    /// They could not be aligned: why, one sentence.
    NotAligned(String),
}

/// Two pictures of one thing. Pixels count from the top left; the middle of the first one is 0, 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AlignedPictures {
    /// Rows of the matrix that maps pixels of the earlier picture, with a third coordinate of 1, to those of the later one: a homography. The last number is 1.
    pub after_from_before: [[f64; 3]; 3],
    /// Estimate of the error of the mapping in the middle of the picture, pixels: at most this in 95 % of the pictures.
    pub residual_px: f64,
    /// Columns and rows of the earlier picture.
    pub before_size_px: [u32; 2],
    /// Columns and rows of the later picture.
    pub after_size_px: [u32; 2],
    /// What has changed, the clearest first.
    #[serde(default)]
    pub changes: Vec<PictureChange>,
}

/// A part of the earlier picture that looks different in the later one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureChange {
    /// First column and row, pixels of the earlier picture.
    pub min_px: [u32; 2],
    /// Last column and row.
    pub max_px: [u32; 2],
    /// Changed pixels.
    pub area_px: u32,
    /// How clear the change is, 0.5 to 1.
    pub strength: f64,
}

impl PictureComparison {
    /// Most changes of one comparison that are kept, the clearest. A camera that was covered sees everything changed.
    pub const MAX_CHANGES: usize = 50;

    /// What has changed; nothing if the pictures could not be aligned.
    pub fn changes(&self) -> &[PictureChange] {
        match &self.outcome {
            PictureComparisonOutcome::Aligned(aligned) => &aligned.changes,
            PictureComparisonOutcome::NotAligned(_) => &[],
        }
    }
}

impl AlignedPictures {
    /// Where a place of the earlier picture is in the later one. None if it is not ahead of that camera.
    pub fn map(&self, px: [f64; 2]) -> Option<[f64; 2]> {
        let row = |row: [f64; 3]| row[0] * px[0] + row[1] * px[1] + row[2];
        let [x, y, depth] = self.after_from_before.map(row);
        (depth > 1e-6).then(|| [x / depth, y / depth])
    }

    /// The corners of a change in the later picture, clockwise from the first column and row: the outer edges of its pixels. None if one has no place there.
    pub fn corners_after(&self, change: &PictureChange) -> Option<[[f64; 2]; 4]> {
        let [left, top] = change.min_px.map(|px| f64::from(px) - 0.5);
        let [right, bottom] = change.max_px.map(|px| f64::from(px) + 0.5);
        let [a, b, c, d] =
            [[left, top], [right, top], [right, bottom], [left, bottom]].map(|px| self.map(px));
        Some([a?, b?, c?, d?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comparison_is_read_as_it_was_written_and_maps_pixels() {
        let change = PictureChange { min_px: [10, 20], max_px: [19, 24], area_px: 30, strength: 0.8 };
        let aligned = AlignedPictures {
            after_from_before: [[2.0, 0.0, 4.0], [0.0, 2.0, -6.0], [0.0, 0.0, 1.0]],
            residual_px: 0.25,
            before_size_px: [640, 480],
            after_size_px: [640, 480],
            changes: vec![change],
        };
        assert_eq!(aligned.map([3.0, 5.0]), Some([10.0, 4.0]));
        let corners = [[23.0, 33.0], [43.0, 33.0], [43.0, 43.0], [23.0, 43.0]];
        assert_eq!(aligned.corners_after(&change), Some(corners));
        let behind = AlignedPictures {
            after_from_before: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 1.0]],
            ..aligned.clone()
        };
        assert_eq!(behind.map([2.0, 0.0]), None);
        for outcome in
            [PictureComparisonOutcome::Aligned(aligned), PictureComparisonOutcome::NotAligned("Dark.".into())]
        {
            let comparison = PictureComparison { before: 3, outcome };
            let text = serde_json::to_string(&comparison).unwrap();
            assert_eq!(serde_json::from_str::<PictureComparison>(&text).unwrap(), comparison, "{text}");
            let is_aligned = matches!(comparison.outcome, PictureComparisonOutcome::Aligned(_));
            assert_eq!(comparison.changes().len(), usize::from(is_aligned));
        }
    }
}
