//! The light of each pixel as logarithms: a gain is a sum, the same for all colours.

use crate::PictureChangesConfig;
use crate::homography::Homography;
use crate::image::{GreyImage, median};
use gauges::Picture;

/// Red, green and blue of each pixel, row by row.
#[derive(Clone, Debug)]
pub(crate) struct LightImage {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Logarithms of the light; NaN where there is none.
    pub(crate) values: Vec<[f32; 3]>,
    /// Standard deviation of the noise of the difference of two of these, and of all together.
    pub(crate) noise: Vec<[f32; 2]>,
    /// Which colours are overexposed.
    pub(crate) is_overexposed: Vec<[bool; 3]>,
}

impl LightImage {
    /// The light of a picture. Equation 9 of docs/maths/picture-changes.md.
    pub(crate) fn of(picture: &Picture, config: &PictureChangesConfig) -> Self {
        let noise = [GreyImage::colour_difference(picture), GreyImage::of(picture)]
            .map(|image| f64::from(image.noise()));
        let noise = noise.map(|noise| noise.max(config.min_noise));
        let table: Vec<[f32; 2]> =
            (0..=255_u8).map(|byte| light_and_slope(byte, config.dark_light)).collect();
        let entry = |byte: u8| table[usize::from(byte)];
        let values = picture.pixels().iter().map(|pixel| pixel.map(|byte| entry(byte)[0])).collect();
        // The darkest colour is the noisiest.
        let slope = |pixel: &[u8; 3]| pixel.iter().map(|byte| entry(*byte)[1]).fold(0.0, f32::max);
        let noise =
            picture.pixels().iter().map(|pixel| noise.map(|noise| noise as f32 * slope(pixel))).collect();
        let overexposed = (255.0 * config.overexposed) as u8;
        let is_overexposed = picture.pixels().iter().map(|pixel| pixel.map(|byte| byte >= overexposed));
        let [width, height] = picture.size_px();
        Self { width, height, values, noise, is_overexposed: is_overexposed.collect() }
    }

    /// This picture at the pixels of an earlier one of that size.
    pub(crate) fn resampled(&self, homography: &Homography, [width, height]: [usize; 2]) -> Self {
        let count = width * height;
        let mut resampled = Self {
            width,
            height,
            values: vec![[f32::NAN; 3]; count],
            noise: vec![[0.0; 2]; count],
            is_overexposed: vec![[false; 3]; count],
        };
        for at in 0..count {
            let place = homography.map([(at % width) as f64, (at / width) as f64]);
            let Some([x, y]) = place.filter(|px| self.has(*px)) else { continue };
            let (left, top) = (x as usize, y as usize);
            let [right_share, low_share] = [(x - left as f64) as f32, (y - top as f64) as f32];
            let corner = top * self.width + left;
            let corners = [corner, corner + 1, corner + self.width, corner + self.width + 1];
            let shares = [
                (1.0 - right_share) * (1.0 - low_share),
                right_share * (1.0 - low_share),
                (1.0 - right_share) * low_share,
                right_share * low_share,
            ];
            let mean = |value: &dyn Fn(usize) -> f32| -> f32 {
                corners.iter().zip(shares).map(|(at, share)| share * value(*at)).sum()
            };
            resampled.values[at] = [0, 1, 2].map(|colour| mean(&|at| self.values[at][colour]));
            resampled.noise[at] = [0, 1].map(|kind| mean(&|at| self.noise[at][kind]));
            resampled.is_overexposed[at] =
                [0, 1, 2].map(|colour| corners.iter().any(|at| self.is_overexposed[*at][colour]));
        }
        resampled
    }

    fn has(&self, [x, y]: [f64; 2]) -> bool {
        x >= 0.0 && y >= 0.0 && x < (self.width - 1) as f64 && y < (self.height - 1) as f64
    }

    /// Removes the difference of light from an earlier picture of the same size, in which it changes slowly. Equation 10 of docs/maths/picture-changes.md.
    pub(crate) fn lit_as(&mut self, before: &Self, config: &PictureChangesConfig) {
        let side = config.light_cell_px;
        let (columns, rows) = (self.width.div_ceil(side), self.height.div_ceil(side));
        let mut cells = vec![[f32::NAN; 3]; columns * rows];
        for (at, cell) in cells.iter_mut().enumerate() {
            *cell = self.cell_difference(before, [at % columns, at / columns], side);
        }
        let smooth: Vec<[f32; 3]> = (0..cells.len())
            .map(|at| around(&cells, [at % columns, at / columns], columns, config.light_radius_cells))
            .collect();
        for y in 0..self.height {
            for x in 0..self.width {
                let difference = between(&smooth, [x, y], [columns, rows], side);
                let value = &mut self.values[y * self.width + x];
                *value = [0, 1, 2].map(|colour| value[colour] - difference[colour]);
            }
        }
    }

    /// Mean difference in a cell; NaN where a picture has nothing.
    fn cell_difference(&self, before: &Self, [column, row]: [usize; 2], side: usize) -> [f32; 3] {
        let (mut sum, mut count) = ([0.0_f32; 3], 0.0_f32);
        for y in row * side..((row + 1) * side).min(self.height) {
            for x in column * side..((column + 1) * side).min(self.width) {
                let at = y * self.width + x;
                let difference = [0, 1, 2].map(|colour| self.values[at][colour] - before.values[at][colour]);
                if difference.iter().all(|value| value.is_finite()) {
                    sum = [0, 1, 2].map(|colour| sum[colour] + difference[colour]);
                    count += 1.0;
                }
            }
        }
        sum.map(|sum| sum / count)
    }
}

/// The logarithm of the light that a byte of sRGB stands for, and how much it changes with the byte, per white.
fn light_and_slope(byte: u8, dark_light: f64) -> [f32; 2] {
    let linear = |value: f64| {
        if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    };
    let value = f64::from(byte) / 255.0;
    let logarithm = |value: f64| (linear(value.clamp(0.0, 1.0)) + dark_light).ln();
    let (low, high) = ((value - 1.0 / 255.0).max(0.0), (value + 1.0 / 255.0).min(1.0));
    [logarithm(value) as f32, ((logarithm(high) - logarithm(low)) / (high - low)) as f32]
}

/// Medians of the cells round one.
fn around(cells: &[[f32; 3]], [column, row]: [usize; 2], columns: usize, radius: usize) -> [f32; 3] {
    let rows = cells.len() / columns;
    [0, 1, 2].map(|colour| {
        let mut values = Vec::new();
        for y in row.saturating_sub(radius)..(row + radius + 1).min(rows) {
            let row = &cells[y * columns..(y + 1) * columns];
            let near = &row[column.saturating_sub(radius)..(column + radius + 1).min(columns)];
            values.extend(near.iter().map(|cell| cell[colour]).filter(|value| value.is_finite()));
        }
        median(&mut values).unwrap_or(0.0)
    })
}

/// Values of cells interpolated at a pixel.
fn between(cells: &[[f32; 3]], px: [usize; 2], [columns, rows]: [usize; 2], side: usize) -> [f32; 3] {
    let place = |px: usize, count: usize| {
        let at = ((px as f32 + 0.5) / side as f32 - 0.5).clamp(0.0, (count - 1) as f32);
        let first = (at as usize).min(count.saturating_sub(2));
        (first, (first + 1).min(count - 1), at - first as f32)
    };
    let (left, right, right_share) = place(px[0], columns);
    let (top, low, low_share) = place(px[1], rows);
    [0, 1, 2].map(|colour| {
        let cell = |row: usize, column: usize| cells[row * columns + column][colour];
        let upper = cell(top, left) + (cell(top, right) - cell(top, left)) * right_share;
        let lower = cell(low, left) + (cell(low, right) - cell(low, left)) * right_share;
        upper + (lower - upper) * low_share
    })
}
