//! A picture at several resolutions, each made insensitive to light.

use crate::PictureAlignmentConfig;
use crate::homography::Homography;
use crate::image::GreyImage;
use geometry::Matrix3;

/// The normalised values of a picture, the full resolution first; each further one has half the width and height.
pub(crate) fn normalised_levels(image: &GreyImage, config: &PictureAlignmentConfig) -> Vec<GreyImage> {
    let mut levels = Vec::new();
    let mut noise = f64::from(image.noise());
    let mut level = image.clone();
    loop {
        let floor = config.min_contrast.max(config.min_contrast_to_noise * noise);
        levels.push(level.normalised(config.normalisation_radius_px, floor as f32));
        if level.width.min(level.height) < 2 * config.coarsest_side_px {
            return levels;
        }
        level = level.halved();
        // The mean of four pixels has half their noise. Compression hides noise of single pixels, which then shows on this level.
        noise = f64::from(level.noise()).max(0.5 * noise);
    }
}

/// A mapping between two pictures as that between their levels of this number; the first is 0.
pub(crate) fn at_level(homography: &Homography, level: usize) -> Option<Homography> {
    let (to, from) = (level_from_full(level), full_from_level(level));
    Homography::new(&(to * homography.matrix() * from))
}

/// The reverse of [`at_level`].
pub(crate) fn from_level(homography: &Homography, level: usize) -> Option<Homography> {
    let (to, from) = (full_from_level(level), level_from_full(level));
    Homography::new(&(to * homography.matrix() * from))
}

/// Pixels of the full picture from those of a level. The middle of the first pixel of a level is in the middle of its square.
fn full_from_level(level: usize) -> Matrix3 {
    let size = f64::from(1_u32 << level);
    let offset = 0.5 * (size - 1.0);
    Matrix3::new(size, 0.0, offset, 0.0, size, offset, 0.0, 0.0, 1.0)
}

fn level_from_full(level: usize) -> Matrix3 {
    let size = f64::from(1_u32 << level);
    let offset = 0.5 * (size - 1.0) / size;
    Matrix3::new(1.0 / size, 0.0, -offset, 0.0, 1.0 / size, -offset, 0.0, 0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_displacement_is_half_as_many_pixels_on_the_next_level() {
        let moved = Homography::translation([8.0, -4.0]);
        let level = at_level(&moved, 2).expect("a mapping");
        assert_eq!(level.map([10.0, 10.0]), Some([12.0, 9.0]));
        let back = from_level(&level, 2).expect("a mapping");
        assert!((back.matrix() - moved.matrix()).norm() < 1e-12);
    }

    #[test]
    fn levels_end_before_they_are_too_small() {
        let image = GreyImage { width: 640, height: 480, values: vec![0.5; 640 * 480] };
        let sizes: Vec<_> = normalised_levels(&image, &PictureAlignmentConfig::default())
            .iter()
            .map(|level| [level.width, level.height])
            .collect();
        assert_eq!(sizes, [[640, 480], [320, 240], [160, 120], [80, 60]]);
    }
}
