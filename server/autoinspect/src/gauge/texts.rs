//! The sentences of `autoinspect gauge`.

use gauges::UnsureReason;
use std::fmt::Display;
use std::path::Path;

/// A file that does not describe the gauge.
pub fn no_gauge(path: &Path, error: &dyn Display) -> String {
    format!("{} {error}", path.display())
}

/// A gauge whose description contradicts itself.
pub fn no_dial(path: &Path, name: &str, reason: &dyn Display) -> String {
    format!("the gauge '{name}' in {} cannot be read: {reason}", path.display())
}

/// A dial that the alignment of two pictures puts behind the camera.
pub const DIAL_BEHIND_CAMERA: &str = "the dial would be behind the camera";

/// A picture of another size than those of the camera.
pub fn other_size(path: &Path, [width, height]: [usize; 2], name: &str, expected_px: [usize; 2]) -> String {
    let [expected_width, expected_height] = expected_px;
    format!(
        "{} is {width} x {height} pixels, and the gauge '{name}' was described in pictures of {expected_width} x {expected_height}; give a picture of the same camera and crop",
        path.display()
    )
}

/// Why a picture gives no value: a key for programs and a sentence for people.
pub fn unsure(reason: UnsureReason) -> (&'static str, &'static str) {
    match reason {
        UnsureReason::OutsidePicture => (
            "outside_picture",
            "most of the dial is outside the picture; compare the gauge's centre with the picture",
        ),
        UnsureReason::NoNeedle => (
            "no_needle",
            "nothing like a needle stands out from the dial; the picture may be dark, blurred or of something else",
        ),
        UnsureReason::Indistinct => (
            "indistinct",
            "the needle is short or indistinct; glare, dirt or something before the dial may hide it",
        ),
        UnsureReason::Ambiguous => ("ambiguous", "two directions are about as likely"),
        UnsureReason::Inexact => ("inexact", "the direction of the needle is not exact enough"),
        UnsureReason::OutsideScale => ("outside_scale", "the needle points outside the scale"),
    }
}
