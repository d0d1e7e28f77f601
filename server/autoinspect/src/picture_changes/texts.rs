//! The sentences of `autoinspect picture-changes`.

use std::path::Path;

/// Two pictures of different sizes.
pub fn other_size(before: &Path, before_px: [usize; 2], after: &Path, after_px: [usize; 2]) -> String {
    let ([width, height], [other_width, other_height]) = (before_px, after_px);
    format!(
        "{} is {width} x {height} pixels and {} is {other_width} x {other_height}; give two pictures of the same camera and size",
        before.display(),
        after.display()
    )
}

/// Pictures without enough pixels.
pub fn too_small(path: &Path, [width, height]: [usize; 2], least_px: usize) -> String {
    format!(
        "{} is {width} x {height} pixels, which is too small; give pictures of at least {least_px} pixels a side",
        path.display()
    )
}

/// Pictures that are aligned.
pub fn aligned(residual_px: f64, overlap: f64) -> String {
    format!(
        "aligned, with a residual of {residual_px:.1} pixels; {:.0} % of the earlier picture are in both",
        100.0 * overlap
    )
}

/// Pictures that are not.
pub fn not_aligned(reason: &str) -> String {
    format!("not aligned: {reason}")
}

/// The same as a sentence of its own.
pub fn not_aligned_sentence(reason: &str) -> String {
    format!("The pictures could not be aligned: {reason}.")
}

/// Numbers that are no mapping.
pub const PREDICTED_NO_MAPPING: &str =
    "the predicted mapping has no inverse; give nine other numbers, or leave it out";

/// No region has changed.
pub const UNCHANGED: &str = "nothing has changed";

/// A region that has changed.
pub fn region([left, top]: [usize; 2], [right, bottom]: [usize; 2], area_px: usize, score: f64) -> String {
    format!("changed: columns {left} to {right}, rows {top} to {bottom}, {area_px} pixels, score {score:.2}")
}
