//! Pictures as numbers: one value for each pixel, halved, smoothed, and sampled between pixels.

use gauges::Picture;

/// One value for each pixel, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GreyImage {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<f32>,
}

/// A value between pixels, and how it changes with the place, per pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PixelSample {
    pub(crate) value: f64,
    pub(crate) gradient: [f64; 2],
}

impl GreyImage {
    /// The mean of red, green and blue, 0 to 1.
    pub(crate) fn of(picture: &Picture) -> Self {
        let [width, height] = picture.size_px();
        let grey = |[r, g, b]: &[u8; 3]| (f32::from(*r) + f32::from(*g) + f32::from(*b)) / 765.0;
        Self { width, height, values: picture.pixels().iter().map(grey).collect() }
    }

    /// The difference of red and green, -1 to 1: noise of the light is the same in both.
    pub(crate) fn colour_difference(picture: &Picture) -> Self {
        let [width, height] = picture.size_px();
        let difference = |[r, g, _]: &[u8; 3]| (f32::from(*r) - f32::from(*g)) / 255.0;
        Self { width, height, values: picture.pixels().iter().map(difference).collect() }
    }

    /// The mean of each two by two pixels. An odd last row or column is left out.
    pub(crate) fn halved(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let mut values = Vec::with_capacity(width * height);
        for y in 0..height {
            let rows = [2 * y, 2 * y + 1].map(|row| &self.values[row * self.width..(row + 1) * self.width]);
            values.extend(
                (0..width).map(|x| 0.25 * rows.iter().map(|row| row[2 * x] + row[2 * x + 1]).sum::<f32>()),
            );
        }
        Self { width, height, values }
    }

    /// The value at a place, by bilinear interpolation, with the gradient of that. None outside the picture.
    pub(crate) fn sample(&self, [x, y]: [f64; 2]) -> Option<PixelSample> {
        if !(x >= 0.0 && y >= 0.0 && x < (self.width - 1) as f64 && y < (self.height - 1) as f64) {
            return None;
        }
        let (left, top) = (x as usize, y as usize);
        let (right_share, low_share) = (x - left as f64, y - top as f64);
        let at = top * self.width + left;
        let [a, b] = [self.values[at], self.values[at + 1]].map(f64::from);
        let [c, d] = [self.values[at + self.width], self.values[at + self.width + 1]].map(f64::from);
        let (upper, lower) = (a + (b - a) * right_share, c + (d - c) * right_share);
        Some(PixelSample {
            value: upper + (lower - upper) * low_share,
            gradient: [(b - a) * (1.0 - low_share) + (d - c) * low_share, lower - upper],
        })
    }

    /// Gradient at a pixel by differences of its neighbours, per pixel. Zero at the edge of the picture.
    pub(crate) fn gradient(&self, x: usize, y: usize) -> [f32; 2] {
        if x == 0 || y == 0 || x + 1 >= self.width || y + 1 >= self.height {
            return [0.0; 2];
        }
        let at = y * self.width + x;
        let value = |at: usize| self.values[at];
        [0.5 * (value(at + 1) - value(at - 1)), 0.5 * (value(at + self.width) - value(at - self.width))]
    }

    /// The mean over a square of this radius round each pixel, cut at the edge of the picture.
    pub(crate) fn box_mean(&self, radius: usize) -> Self {
        let mut rows = vec![0.0; self.values.len()];
        for y in 0..self.height {
            let row = y * self.width;
            running_mean(self.width, radius, |x| self.values[row + x], |x, mean| rows[row + x] = mean);
        }
        let mut values = vec![0.0; self.values.len()];
        for x in 0..self.width {
            running_mean(
                self.height,
                radius,
                |y| rows[y * self.width + x],
                |y, mean| values[y * self.width + x] = mean,
            );
        }
        Self { width: self.width, height: self.height, values }
    }

    /// What does not change with gain and slow shading: the difference from the local mean over the local standard deviation. Where that is below `floor`, the values
    /// stay small. Equation 2 of docs/maths/picture-changes.md.
    pub(crate) fn normalised(&self, radius: usize, floor: f32) -> Self {
        let mean = self.box_mean(radius);
        let centred = |(value, mean): (&f32, &f32)| value - mean;
        let difference: Vec<f32> = self.values.iter().zip(&mean.values).map(centred).collect();
        let squares = Self { values: difference.iter().map(|d| d * d).collect(), ..*self };
        let variance = squares.box_mean(radius);
        let values = difference.iter().zip(&variance.values).map(|(d, v)| d / (v + floor * floor).sqrt());
        Self { width: self.width, height: self.height, values: values.collect() }
    }

    /// Standard deviation of the noise of the pixels: the median of what a filter leaves that removes planes and edges. Source: Immerkær, *Fast Noise Variance
    /// Estimation*, 1996, with the median in place of the mean, because texture is an outlier.
    pub(crate) fn noise(&self) -> f32 {
        let mut left = Vec::new();
        for y in 1..self.height.saturating_sub(1) {
            for x in 1..self.width.saturating_sub(1) {
                let at = y * self.width + x;
                let value = |at: usize| self.values[at];
                let row = |at: usize| value(at - 1) - 2.0 * value(at) + value(at + 1);
                left.push((row(at - self.width) - 2.0 * row(at) + row(at + self.width)).abs());
            }
        }
        // Six is the root of the sum of the squares of that filter's weights.
        median(&mut left).map_or(0.0, |middle| MEDIAN_TO_DEVIATION * middle / 6.0)
    }
}

/// Ratio of the standard deviation to the median of the magnitude of normal noise.
pub(crate) const MEDIAN_TO_DEVIATION: f32 = 1.4826;

/// The median; none of nothing. The order of the values changes.
pub(crate) fn median(values: &mut [f32]) -> Option<f32> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

fn running_mean(count: usize, radius: usize, value: impl Fn(usize) -> f32, mut set: impl FnMut(usize, f32)) {
    let mut sum: f64 = (0..radius.min(count)).map(|at| f64::from(value(at))).sum();
    for at in 0..count {
        if at + radius < count {
            sum += f64::from(value(at + radius));
        }
        if at > radius {
            sum -= f64::from(value(at - radius - 1));
        }
        let summed = (at + radius + 1).min(count) - at.saturating_sub(radius);
        set(at, (sum / summed as f64) as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    fn noisy(width: usize, height: usize) -> GreyImage {
        let mut rng = RngTree::new(1).child("pixels").rng();
        GreyImage { width, height, values: (0..width * height).map(|_| rng.uniform() as f32).collect() }
    }

    #[test]
    fn the_gradient_between_pixels_is_that_of_the_interpolation() {
        let image = noisy(8, 6);
        let mut rng = RngTree::new(2).child("places").rng();
        for _ in 0..200 {
            // Within one cell: the gradient jumps from cell to cell.
            let at =
                [rng.uniform() * 6.9, rng.uniform() * 4.9].map(|c: f64| c.floor() + 0.01 + 0.98 * c.fract());
            let value = |at: [f64; 2]| image.sample(at).expect("inside").value;
            let step = 1e-5;
            let gradient = image.sample(at).expect("inside").gradient;
            let [x, y] = at;
            let expected =
                [value([x + step, y]) - value([x - step, y]), value([x, y + step]) - value([x, y - step])];
            for axis in 0..2 {
                assert!((gradient[axis] - expected[axis] / (2.0 * step)).abs() < 1e-6);
            }
        }
        assert_eq!(image.sample([7.0, 1.0]), None);
        assert_eq!(image.sample([f64::NAN, 1.0]), None);
    }

    #[test]
    fn means_over_squares_are_those_of_their_pixels() {
        let image = noisy(9, 7);
        let mean = image.box_mean(2);
        for (x, y) in [(0, 0), (4, 3), (8, 6), (1, 5)] {
            let (columns, rows) = (x.max(2) - 2..(x + 3).min(9), y.max(2) - 2..(y + 3).min(7));
            let values: Vec<f32> = rows
                .flat_map(|row| columns.clone().map(move |column| (row, column)))
                .map(|(row, column)| image.values[row * 9 + column])
                .collect();
            let expected = values.iter().sum::<f32>() / values.len() as f32;
            assert!((mean.values[y * 9 + x] - expected).abs() < 1e-5);
        }
    }

    #[test]
    fn normalised_values_do_not_change_with_gain_and_brightness() {
        let image = noisy(40, 30);
        let lit = GreyImage { values: image.values.iter().map(|v| 0.1 + 0.4 * v).collect(), ..image };
        let [a, b] = [&image, &lit].map(|image| image.normalised(5, 1e-4));
        assert!(a.values.iter().zip(&b.values).all(|(a, b)| (a - b).abs() < 1e-2));
    }

    #[test]
    fn noise_is_measured_on_slopes_too() {
        let mut rng = RngTree::new(3).child("noise").rng();
        let value = |at: usize| 0.3 + 0.004 * (at % 80) as f32 + 0.02 * rng.normal() as f32;
        let image = GreyImage { width: 80, height: 60, values: (0..80 * 60).map(value).collect() };
        assert!((image.noise() - 0.02).abs() < 0.002, "{}", image.noise());
    }
}
