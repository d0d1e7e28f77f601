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
}
