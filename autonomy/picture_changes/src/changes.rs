//! What has changed between two aligned pictures, apart from light.
//!
//! A difference does not count if it can come from one of these:
//!
//! - noise;
//! - a displacement within the error of the alignment;
//! - parallax of things before or behind the plane;
//! - light, which makes all colours darker or brighter alike.

use crate::PictureChangesConfig;
use crate::align::PictureAlignment;
use crate::light::LightImage;
use crate::regions::{ChangedRegion, regions};
use crate::tolerance::ToleranceCells;
use gauges::Picture;

/// Finds the regions of the earlier picture that look different in the later one, the strongest first.
pub fn find_picture_changes(
    before: &Picture,
    after: &Picture,
    alignment: &PictureAlignment,
    config: &PictureChangesConfig,
) -> Vec<ChangedRegion> {
    let [light_before, light_after] = [before, after].map(|picture| LightImage::of(picture, config));
    let mut light_after = light_after.resampled(&alignment.after_from_before, before.size_px());
    light_after.lit_as(&light_before, config);
    let strength = change_strength(&light_before, &light_after, alignment, config);
    regions(&strength, before.size_px(), config)
}

/// How strongly each pixel has changed: 1 is what is just a change, 0 is none.
fn change_strength(
    before: &LightImage,
    after: &LightImage,
    alignment: &PictureAlignment,
    config: &PictureChangesConfig,
) -> Vec<f32> {
    let cells = ToleranceCells::of(alignment, [before.width, before.height], config);
    let mut radii: Vec<usize> = cells.cells.iter().map(|cell| cell.radius_px).collect();
    radii.sort_unstable();
    radii.dedup();
    let mut strength = vec![0.0; before.values.len()];
    for radius in radii {
        let [near_before, near_after] = [before, after].map(|light| Extremes::of(light, radius));
        for at in 0..strength.len() {
            let px = [at % before.width, at / before.width];
            let cell = cells.at(px);
            // Near the edge of a picture it is not known what was beside it.
            let is_inside = px[0] >= radius
                && px[1] >= radius
                && px[0] + radius < before.width
                && px[1] + radius < before.height;
            if cell.radius_px == radius && is_inside {
                let to =
                    cell.displacements.iter().filter_map(|displacement| displaced(px, *displacement, after));
                let differences = to.filter_map(|to| {
                    let gone = difference(before, at, after, to, &near_after, config)?;
                    let new = difference(after, to, before, at, &near_before, config)?;
                    Some(gone.max(new))
                });
                let scale = if cell.is_plane { 1.0 } else { config.off_plane_share as f32 };
                strength[at] = scale * differences.min_by(f32::total_cmp).unwrap_or(0.0);
            }
        }
    }
    strength
}

/// The pixel at a displacement from another one. None outside the picture.
fn displaced([x, y]: [usize; 2], [dx, dy]: [isize; 2], light: &LightImage) -> Option<usize> {
    let (column, row) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
    (column < light.width && row < light.height).then_some(row * light.width + column)
}

/// How much a pixel differs from all near a place of the other picture: 1 is just a change. None without light there.
fn difference(
    light: &LightImage,
    at: usize,
    other: &LightImage,
    to: usize,
    near: &Extremes,
    config: &PictureChangesConfig,
) -> Option<f32> {
    let value = light.values[at];
    let (least, greatest) = (near.least[to], near.greatest[to]);
    if !(0..3).all(|colour| value[colour].is_finite() && least[colour].is_finite()) {
        return None;
    }
    let headroom = config.overexposed_range as f32;
    // Beyond what is near there: positive if this picture is brighter.
    let beyond = [0, 1, 2].map(|colour| {
        // What is overexposed may have been brighter.
        let [here, there] = [light.is_overexposed[at], near.is_overexposed[to]]
            .map(|is| if is[colour] { headroom } else { 0.0 });
        if value[colour] > greatest[colour] {
            (value[colour] - greatest[colour] - there).max(0.0)
        } else {
            (value[colour] - least[colour] + here).min(0.0)
        }
    });
    let tolerance =
        [0, 1].map(|kind| config.noise_tolerance as f32 * light.noise[at][kind].hypot(other.noise[to][kind]));
    let (low, high) = (
        beyond.iter().copied().fold(f32::INFINITY, f32::min),
        beyond.iter().copied().fold(f32::NEG_INFINITY, f32::max),
    );
    let colour = (high - low - tolerance[0]) / config.min_colour_change as f32;
    // The least of the three, with its sign.
    let grey = if low > 0.0 { low } else { (-high).max(0.0) };
    let brightness = (grey - tolerance[1]) / config.max_light_change as f32;
    Some(colour.max(brightness).max(0.0))
}

/// The least and greatest light within a distance of each pixel.
struct Extremes {
    least: Vec<[f32; 3]>,
    greatest: Vec<[f32; 3]>,
    is_overexposed: Vec<[bool; 3]>,
}

impl Extremes {
    fn of(light: &LightImage, radius: usize) -> Self {
        let size = [light.width, light.height];
        // A place without light makes its surroundings unknown.
        let lesser = |a: f32, b: f32| if a.is_nan() || a < b { a } else { b };
        let least = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|colour| lesser(a[colour], b[colour]));
        let greatest = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|colour| a[colour].max(b[colour]));
        Self {
            least: over_squares(&light.values, size, radius, least),
            greatest: over_squares(&light.values, size, radius, greatest),
            is_overexposed: over_squares(&light.is_overexposed, size, radius, |a, b| {
                [0, 1, 2].map(|colour| a[colour] || b[colour])
            }),
        }
    }
}

/// Combines the values of a square round each pixel, cut at the edge of the picture.
fn over_squares<T: Copy>(
    values: &[T],
    [width, height]: [usize; 2],
    radius: usize,
    combine: impl Fn(T, T) -> T + Copy,
) -> Vec<T> {
    let along = |values: &[T], stride: usize, count: usize, place: &dyn Fn(usize) -> usize| -> Vec<T> {
        (0..values.len())
            .map(|at| {
                let place = place(at);
                let (back, ahead) = (radius.min(place), radius.min(count - 1 - place));
                let first = at - back * stride;
                (1..=back + ahead)
                    .fold(values[first], |all, step| combine(all, values[first + step * stride]))
            })
            .collect()
    };
    let rows = along(values, 1, width, &|at| at % width);
    along(&rows, width, height, &|at| at / width)
}
