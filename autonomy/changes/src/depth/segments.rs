//! Connected parts of a depth image.

use super::config::DepthChangesConfig;
use super::image::DepthImage;

/// Groups of these pixels in which each has another at most `gap_px` away in the image and near it in depth: each in ascending order, the groups by their first pixel. Linear in
/// the pixels.
pub(crate) fn connected(
    pixels: &[usize],
    image: &DepthImage,
    gap_px: usize,
    config: &DepthChangesConfig,
) -> Vec<Vec<usize>> {
    let mut is_waiting = vec![false; image.len()];
    for pixel in pixels {
        is_waiting[*pixel] = true;
    }
    let mut groups = Vec::new();
    for start in pixels {
        if !is_waiting[*start] {
            continue;
        }
        is_waiting[*start] = false;
        let mut group = vec![*start];
        let mut done = 0;
        while let Some(pixel) = group.get(done).copied() {
            done += 1;
            let depth_m = image.depth_m(pixel);
            let gap_m = config.gap_m + 3.0 * config.noise_m(depth_m);
            for near in image.around(pixel, gap_px) {
                if is_waiting[near] && (image.depth_m(near) - depth_m).abs() <= gap_m {
                    is_waiting[near] = false;
                    group.push(near);
                }
            }
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

/// Area that the camera sees of these pixels, square metres.
pub(crate) fn area_m2(pixels: impl IntoIterator<Item = usize>, image: &DepthImage) -> f64 {
    pixels.into_iter().map(|pixel| image.camera().pixel_area_m2(image.depth_m(pixel))).sum()
}
