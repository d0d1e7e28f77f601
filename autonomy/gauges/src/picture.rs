//! A picture in colour.

use std::fmt;

/// A picture: red, green and blue of each pixel, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

/// The number of pixels is not width times height, or a side is shorter than two pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureError {
    /// Pixels that were given.
    pub pixels: usize,
    /// Width and height that were given.
    pub size_px: [usize; 2],
}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size_px;
        write!(f, "{} pixels are no picture of {width} x {height}", self.pixels)
    }
}

impl std::error::Error for PictureError {}

impl Picture {
    /// A picture of this width and height.
    ///
    /// # Errors
    /// When the number of pixels is another, or a side is shorter than two pixels.
    pub fn new(size_px: [usize; 2], pixels: Vec<[u8; 3]>) -> Result<Self, PictureError> {
        let [width, height] = size_px;
        if width < 2 || height < 2 || width.checked_mul(height) != Some(pixels.len()) {
            return Err(PictureError { pixels: pixels.len(), size_px });
        }
        Ok(Self { width, height, pixels })
    }

    /// Width and height, pixels.
    pub fn size_px(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The pixels, row by row.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// The colour at a place between pixels, bilinear. Outside the picture it is that of the nearest pixel.
    pub fn sample(&self, [x, y]: [f64; 2]) -> [u8; 3] {
        let split = |place: f64, size: usize| {
            let place = place.clamp(0.0, (size - 1) as f64);
            let whole = (place.floor() as usize).min(size - 2);
            (whole, place - whole as f64)
        };
        let ((column, right), (row, down)) = (split(x, self.width), split(y, self.height));
        let pixel = |column: usize, row: usize| self.pixels[row * self.width + column];
        let corners =
            [pixel(column, row), pixel(column + 1, row), pixel(column, row + 1), pixel(column + 1, row + 1)];
        let shares = [(1.0 - right) * (1.0 - down), right * (1.0 - down), (1.0 - right) * down, right * down];
        std::array::from_fn(|colour| {
            let light = |(corner, share): (&[u8; 3], &f64)| share * f64::from(corner[colour]);
            corners.iter().zip(&shares).map(light).sum::<f64>().round() as u8
        })
    }
}
