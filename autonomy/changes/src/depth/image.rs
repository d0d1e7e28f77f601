//! An image of a depth camera.

use super::camera::Camera;
use geometry::Vector3;
use std::fmt;

/// Which points are an image of a depth camera.
#[derive(Clone, Copy, Debug)]
struct DepthImageConfig {
    /// Points may be this far from the rays of their pixels (root mean square), pixels: rounding of coordinates to a millimetre, and a little distortion. Chosen: one
    /// pixel, above which the points are not those of the pixels.
    max_ray_error_px: f64,
    /// Pixels with a point from which on there is an image. Chosen: far below an image of any depth camera, and enough to fit its rays.
    min_points: usize,
}

const CONFIG: DepthImageConfig = DepthImageConfig { max_ray_error_px: 1.0, min_points: 1_000 };

/// An image of a depth camera: a point for each pixel that has a return, in the camera's frame with the third axis forward.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthImage {
    size_px: [usize; 2],
    camera: Camera,
    /// Metres, row by row; not finite where there is no return.
    points: Vec<[f32; 3]>,
    /// Red, green and blue of each pixel; empty if there are none.
    colours: Vec<[u8; 3]>,
}

/// Why points are no depth image, or two images cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthImageError {
    /// The number of points or of colours is not that of the pixels.
    SizeDiffers,
    /// Hardly a pixel has a return.
    TooFewReturns {
        /// Pixels with a return.
        returns: usize,
    },
    /// The points are not on the rays of the pixels of a pinhole camera that looks along the third axis.
    NoPinholeCamera,
    /// The images are of different sizes or of cameras with different rays.
    CamerasDiffer,
    /// No plane holds enough of the points, so that there is no direction up.
    NoSupport,
}

impl fmt::Display for DepthImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SizeDiffers => f.write_str("the number of points is not that of the pixels"),
            Self::TooFewReturns { returns } => {
                write!(f, "only {returns} pixels have a return; {} are needed", CONFIG.min_points)
            }
            Self::NoPinholeCamera => f.write_str(
                "the points are not on the rays of the pixels of a camera that looks along z; give the camera's own points, in its frame",
            ),
            Self::CamerasDiffer => f.write_str(
                "the two images are of different sizes or cameras; give two of one camera that has not moved",
            ),
            Self::NoSupport => f.write_str(
                "no plane, such as a table or a floor, holds a good part of the points, so that the direction up is unknown; aim the camera at a flat support",
            ),
        }
    }
}

impl std::error::Error for DepthImageError {}

impl DepthImage {
    /// An image of this many columns and rows, of points row by row (metres, third axis forward; not finite, or zero, where there is no return) and their colours, or none.
    ///
    /// # Errors
    /// When the points are not those of a pinhole camera.
    pub fn new(
        size_px: [usize; 2],
        mut points: Vec<[f32; 3]>,
        colours: Vec<[u8; 3]>,
    ) -> Result<Self, DepthImageError> {
        let count = size_px[0].saturating_mul(size_px[1]);
        if points.len() != count || !(colours.is_empty() || colours.len() == count) {
            return Err(DepthImageError::SizeDiffers);
        }
        for point in &mut points {
            if !(point.iter().all(|at| at.is_finite()) && point[2] > 0.0) {
                *point = [f32::NAN; 3];
            }
        }
        let seen = || points.iter().enumerate().filter(|(_, point)| point[2].is_finite());
        let returns = seen().count();
        if returns < CONFIG.min_points {
            return Err(DepthImageError::TooFewReturns { returns });
        }
        let fitted =
            Camera::fit(seen().map(|(pixel, point)| (pixel % size_px[0], pixel / size_px[0], *point)));
        let (camera, _) = fitted
            .filter(|(_, error_px)| *error_px <= CONFIG.max_ray_error_px)
            .ok_or(DepthImageError::NoPinholeCamera)?;
        Ok(Self { size_px, camera, points, colours })
    }

    /// Columns and rows.
    pub(crate) fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// The camera.
    pub(crate) fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Number of pixels.
    pub(crate) fn len(&self) -> usize {
        self.points.len()
    }

    /// Depth of a pixel, metres; not a number where there is no return.
    pub(crate) fn depth_m(&self, pixel: usize) -> f64 {
        f64::from(self.points[pixel][2])
    }

    /// The point of a pixel, metres; none without a return.
    pub(crate) fn point(&self, pixel: usize) -> Option<Vector3> {
        let point = self.points[pixel];
        point[2].is_finite().then(|| Vector3::from(point.map(f64::from)))
    }

    /// The point of a pixel as it was given.
    pub(crate) fn raw_point(&self, pixel: usize) -> [f32; 3] {
        self.points[pixel]
    }

    /// Colours of all pixels; empty if there are none.
    pub(crate) fn colours(&self) -> &[[u8; 3]] {
        &self.colours
    }

    /// The pixels at most `reach` columns and rows from a pixel, itself included, row by row.
    pub(crate) fn around(&self, pixel: usize, reach: usize) -> impl Iterator<Item = usize> + use<> {
        let [width, height] = self.size_px;
        let (column, row) = (pixel % width, pixel / width);
        let columns = column.saturating_sub(reach)..(column + reach + 1).min(width);
        let rows = row.saturating_sub(reach)..(row + reach + 1).min(height);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }
}
