//! Which pixels show a surface that the other image does not have.

use super::config::DepthChangesConfig;
use super::image::DepthImage;
use super::support::Support;

/// What the other image says of the point of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// There is no point, or none above the plane.
    Nothing,
    /// The other image has a surface there.
    Same,
    /// The other image looked through the place.
    Changed,
    /// The other image has no return there, or one in front.
    Unknown,
}

/// What the other image says of each pixel of an image. Linear in the pixels.
pub(crate) fn verdicts(
    image: &DepthImage,
    other: &DepthImage,
    support: &Support,
    config: &DepthChangesConfig,
) -> Vec<Verdict> {
    (0..image.len()).map(|pixel| verdict(pixel, image, other, support, config)).collect()
}

fn verdict(
    pixel: usize,
    image: &DepthImage,
    other: &DepthImage,
    support: &Support,
    config: &DepthChangesConfig,
) -> Verdict {
    let Some(point) = image.point(pixel) else { return Verdict::Nothing };
    if support.height_m(&point) <= config.min_height_m {
        return Verdict::Nothing;
    }
    let [depth_m, other_m] = [point.z, other.depth_m(pixel)];
    if other_m.is_nan() {
        return Verdict::Unknown;
    }
    let same_m = config.same_surface_m(depth_m);
    if (depth_m - other_m).abs() <= same_m {
        return Verdict::Same;
    }
    // The edges of things flicker: all rays around have to have gone through.
    let nearest_m = other
        .around(pixel, config.edge_px)
        .map(|near| other.depth_m(near))
        .filter(|depth_m| !depth_m.is_nan())
        .fold(f64::INFINITY, f64::min);
    if nearest_m > depth_m + same_m { Verdict::Changed } else { Verdict::Unknown }
}
