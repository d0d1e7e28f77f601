//! Small changes of a mapping, as up to eight numbers.
//!
//! The numbers are displacement to the right and down, turn, growth, two shears and two tilts of the plane, in this order, so that a picture which holds fewer of them
//! is aligned with the first ones. Coordinates are relative to the middle of the picture, in halves of its width: all numbers are of the same size.

use crate::Homography;
use geometry::Matrix3;
use nalgebra::{SVector, Vector3};

/// Numbers of a change.
pub(crate) const PARAMETERS: usize = 8;
/// A change of a mapping.
pub(crate) type WarpUpdate = SVector<f64, PARAMETERS>;

/// Models with ever more numbers: displacement; and turn and growth; and shears; and tilts of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum WarpModel {
    /// Two parameters.
    Translation,
    /// Four parameters.
    Similarity,
    /// Six parameters.
    Affine,
    /// Eight parameters.
    Homography,
}

impl WarpModel {
    /// All, that with the most parameters first.
    pub(crate) const LARGEST_FIRST: [Self; 4] =
        [Self::Homography, Self::Affine, Self::Similarity, Self::Translation];

    /// Number of parameters.
    pub fn parameters(self) -> usize {
        match self {
            Self::Translation => 2,
            Self::Similarity => 4,
            Self::Affine => 6,
            Self::Homography => PARAMETERS,
        }
    }
}

/// The coordinates in which changes are small numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PictureFrame {
    centre_px: [f64; 2],
    half_width_px: f64,
}

impl PictureFrame {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let centre_px = [width, height].map(|side| 0.5 * (side as f64 - 1.0));
        Self { centre_px, half_width_px: 0.5 * width as f64 }
    }

    /// A pixel in halves of the width from the middle.
    pub(crate) fn relative(&self, px: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (px[axis] - self.centre_px[axis]) / self.half_width_px)
    }

    /// How much a pixel counts: 1 in the middle, less outside of `radius_share` of the width.
    pub(crate) fn weight(&self, px: [f64; 2], radius_share: f64) -> f64 {
        let [right, down] = self.relative(px).map(|offset| 0.5 * offset / radius_share);
        (-0.5 * (right * right + down * down)).exp()
    }

    /// Corners of the square round the middle that reaches this far to each side, in halves of the width, pixels.
    pub(crate) fn around_centre(&self, reach: f64) -> [[f64; 2]; 4] {
        let [x, y] = self.centre_px;
        let r = reach * self.half_width_px;
        [[x - r, y - r], [x + r, y - r], [x - r, y + r], [x + r, y + r]]
    }

    /// `homography` after a small change of the points that it maps: equation 3 of docs/maths/picture-changes.md. None if that is no mapping.
    pub(crate) fn updated(&self, homography: &Homography, update: &WarpUpdate) -> Option<Homography> {
        let [x, y] = self.centre_px;
        let s = self.half_width_px;
        let relative_from_px = Matrix3::new(1.0 / s, 0.0, -x / s, 0.0, 1.0 / s, -y / s, 0.0, 0.0, 1.0);
        let px_from_relative = Matrix3::new(s, 0.0, x, 0.0, s, y, 0.0, 0.0, 1.0);
        Homography::new(&(homography.matrix() * px_from_relative * change(update) * relative_from_px))
    }

    /// How a point that is mapped moves with each number, pixels of the picture that it is mapped from: equation 4 of docs/maths/picture-changes.md.
    pub(crate) fn displacements(&self, px: [f64; 2]) -> [[f64; 2]; PARAMETERS] {
        let [x, y] = self.relative(px);
        let per_parameter =
            [[1.0, 0.0], [0.0, 1.0], [-y, x], [x, y], [x, -y], [y, x], [-x * x, -x * y], [-x * y, -y * y]];
        per_parameter.map(|[dx, dy]| [dx * self.half_width_px, dy * self.half_width_px])
    }
}

/// The matrix of a small change.
fn change(update: &WarpUpdate) -> Matrix3 {
    let [right, down, turn, growth, stretch, shear, tilt_x, tilt_y] = update.data.0[0];
    Matrix3::new(
        1.0 + growth + stretch,
        shear - turn,
        right,
        shear + turn,
        1.0 + growth - stretch,
        down,
        tilt_x,
        tilt_y,
        1.0,
    )
}

/// How the point in the other picture moves when the point that is mapped moves: rows are x and y of the other picture, columns those of this one. None behind the camera.
pub(crate) fn point_jacobian(homography: &Homography, [x, y]: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let h = homography.matrix();
    let mapped = h * Vector3::new(x, y, 1.0);
    let [px, py] = homography.map([x, y])?;
    let row = |row: usize, at: f64| [0, 1].map(|column| (h[(row, column)] - at * h[(2, column)]) / mapped.z);
    Some([row(0, px), row(1, py)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    #[test]
    fn derivatives_of_the_mapping_are_those_of_central_differences() {
        let mut rng = RngTree::new(7).child("warps").rng();
        let frame = PictureFrame::new(640, 480);
        for _ in 0..100 {
            let start = WarpUpdate::from_fn(|_, _| rng.range(-0.1, 0.1));
            let homography = frame.updated(&Homography::identity(), &start).expect("a mapping");
            let px = [rng.range(0.0, 639.0), rng.range(0.0, 479.0)];
            let point = point_jacobian(&homography, px).expect("ahead");
            let displacements = frame.displacements(px);
            for parameter in 0..PARAMETERS {
                let step = 1e-6;
                let moved = |sign: f64| {
                    let mut update = WarpUpdate::zeros();
                    update[parameter] = sign * step;
                    frame.updated(&homography, &update).and_then(|moved| moved.map(px)).expect("ahead")
                };
                let (plus, minus) = (moved(1.0), moved(-1.0));
                for axis in 0..2 {
                    let expected = (plus[axis] - minus[axis]) / (2.0 * step);
                    let [dx, dy] = displacements[parameter];
                    let found = point[axis][0] * dx + point[axis][1] * dy;
                    assert!(
                        (found - expected).abs() < 1e-4 * (1.0 + expected.abs()),
                        "{parameter}: {found} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_first_numbers_are_those_of_the_smaller_models() {
        let frame = PictureFrame::new(100, 80);
        let mut update = WarpUpdate::zeros();
        (update[0], update[1]) = (0.1, -0.2);
        let moved = frame.updated(&Homography::identity(), &update).expect("a mapping");
        assert_eq!(moved.map([10.0, 20.0]), Some([15.0, 10.0]));
        let counts = WarpModel::LARGEST_FIRST.map(WarpModel::parameters);
        assert_eq!(counts, [8, 6, 4, 2]);
    }
}
