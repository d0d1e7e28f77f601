//! Gauss-Newton on one level: the mapping at which both pictures agree.
//!
//! The residual of a pixel is the normalised value of the later picture at its mapped place minus its own. Pixels of structure count, those near the middle more, and those
//! that disagree with the others less (Tukey's biweight), because something has changed there, or it is before or behind the plane.

use crate::PictureAlignmentConfig;
use crate::homography::Homography;
use crate::image::{GreyImage, MEDIAN_TO_DEVIATION, median};
use crate::warp::{PARAMETERS, PictureFrame, WarpModel, WarpUpdate, point_jacobian};
use nalgebra::SMatrix;

/// The information matrix of all numbers of a change.
type Information = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Residuals beyond this multiple of their standard deviation do not count at all. Source: Tukey's biweight with 95 % of the efficiency of least squares.
const BIWEIGHT: f64 = 4.685;
/// Standard deviation of the residuals that no picture falls below, normalised values.
const MIN_DEVIATION: f64 = 0.02;

/// A pixel of structure of the earlier picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StructurePixel {
    px: [f64; 2],
    value: f64,
    weight: f64,
}

/// The residual of a pixel, and how it changes with each number.
struct Residual {
    value: f64,
    weight: f64,
    jacobian: WarpUpdate,
}

/// A mapping that was refined on a level.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refined {
    pub(crate) homography: Homography,
    pub(crate) model: WarpModel,
    /// Standard deviation of the mapping, pixels of the level.
    pub(crate) deviation_px: f64,
}

/// The pixels of structure of a level, at most as many as the configuration says, evenly chosen.
pub(crate) fn structure_pixels(image: &GreyImage, config: &PictureAlignmentConfig) -> Vec<StructurePixel> {
    let frame = PictureFrame::new(image.width, image.height);
    let mut pixels = Vec::new();
    for y in 1..image.height.saturating_sub(1) {
        for x in 1..image.width.saturating_sub(1) {
            let [gx, gy] = image.gradient(x, y).map(f64::from);
            if gx.hypot(gy) < config.min_gradient {
                continue;
            }
            let px = [x as f64, y as f64];
            let weight = frame.weight(px, config.weight_radius_share);
            pixels.push(StructurePixel { px, value: f64::from(image.values[y * image.width + x]), weight });
        }
    }
    let step = pixels.len().div_ceil(config.max_samples).max(1);
    pixels.into_iter().step_by(step).collect()
}

/// Refines a mapping from the level of these pixels to `after`, with the largest model up to `largest` that the picture holds. None if it holds none, or too few pixels are
/// in both pictures.
pub(crate) fn refine(
    pixels: &[StructurePixel],
    frame: &PictureFrame,
    after: &GreyImage,
    start: &Homography,
    largest: WarpModel,
    config: &PictureAlignmentConfig,
) -> Option<Refined> {
    let mut refined = Refined { homography: *start, model: largest, deviation_px: f64::INFINITY };
    for _ in 0..config.max_steps {
        let (residuals, deviation) = residuals(pixels, frame, after, &refined.homography)?;
        let (information, gradient) = normal_equations(&residuals, deviation);
        let (model, update, deviation_px) = solve(&information, &gradient, frame, largest, config)?;
        refined = Refined { homography: frame.updated(&refined.homography, &update)?, model, deviation_px };
        let moved_px = corners(frame).map(|px| length(sum(&frame.displacements(px), &update)));
        if moved_px.into_iter().fold(0.0, f64::max) < config.converged_px {
            break;
        }
    }
    Some(refined)
}

/// The residual of each pixel that is in both pictures, and their standard deviation. None of fewer pixels than there are numbers.
fn residuals(
    pixels: &[StructurePixel],
    frame: &PictureFrame,
    after: &GreyImage,
    homography: &Homography,
) -> Option<(Vec<Residual>, f64)> {
    let residuals: Vec<Residual> =
        pixels.iter().filter_map(|pixel| residual(pixel, frame, after, homography)).collect();
    let mut sizes: Vec<f32> = residuals.iter().map(|residual| residual.value.abs() as f32).collect();
    let middle = median(&mut sizes).filter(|_| residuals.len() > PARAMETERS)?;
    Some((residuals, f64::from(MEDIAN_TO_DEVIATION * middle).max(MIN_DEVIATION)))
}

/// Equation 5 of docs/maths/picture-changes.md. None outside the later picture.
fn residual(
    pixel: &StructurePixel,
    frame: &PictureFrame,
    after: &GreyImage,
    homography: &Homography,
) -> Option<Residual> {
    let sample = after.sample(homography.map(pixel.px)?)?;
    let point = point_jacobian(homography, pixel.px)?;
    let along = [0, 1].map(|axis| sample.gradient[0] * point[0][axis] + sample.gradient[1] * point[1][axis]);
    let displacements = frame.displacements(pixel.px);
    let jacobian = WarpUpdate::from_fn(|parameter, _| {
        let [dx, dy] = displacements[parameter];
        along[0] * dx + along[1] * dy
    });
    Some(Residual { value: sample.value - pixel.value, weight: pixel.weight, jacobian })
}

/// Equation 6 of docs/maths/picture-changes.md.
fn normal_equations(residuals: &[Residual], deviation: f64) -> (Information, WarpUpdate) {
    let (mut information, mut gradient) = (Information::zeros(), WarpUpdate::zeros());
    for residual in residuals {
        let share = residual.value / (BIWEIGHT * deviation);
        let agreement = (1.0 - share * share).max(0.0).powi(2);
        let weight = residual.weight * agreement / (deviation * deviation);
        information.syger(weight, &residual.jacobian, &residual.jacobian, 1.0);
        gradient.axpy(weight * residual.value, &residual.jacobian, 1.0);
    }
    information.fill_upper_triangle_with_lower_triangle();
    (information, gradient)
}

/// The step of the largest model whose mapping is certain enough, and the standard deviation of that, pixels.
fn solve(
    information: &Information,
    gradient: &WarpUpdate,
    frame: &PictureFrame,
    largest: WarpModel,
    config: &PictureAlignmentConfig,
) -> Option<(WarpModel, WarpUpdate, f64)> {
    WarpModel::LARGEST_FIRST.into_iter().filter(|model| *model <= largest).find_map(|model| {
        let count = model.parameters();
        let part = information.view((0, 0), (count, count)).into_owned();
        let factor = part.cholesky()?;
        let step = factor.solve(&gradient.rows(0, count).into_owned());
        let covariance = factor.inverse() * config.correlated_pixels;
        let deviation = |px: &[f64; 2]| {
            let displacements = frame.displacements(*px);
            let variance = |axis: usize| {
                let row = nalgebra::DVector::from_fn(count, |parameter, _| displacements[parameter][axis]);
                (row.transpose() * &covariance * row)[(0, 0)]
            };
            (variance(0) + variance(1)).sqrt()
        };
        let deviation_px = target_corners(frame, config).iter().map(deviation).fold(0.0, f64::max);
        let mut update = WarpUpdate::zeros();
        update.rows_mut(0, count).copy_from(&-step);
        (deviation_px <= config.max_deviation_px).then_some((model, update, deviation_px))
    })
}

/// Corners of the picture, pixels.
fn corners(frame: &PictureFrame) -> [[f64; 2]; 4] {
    frame.around_centre(1.0)
}

/// Corners of the square within which the mapping has to be certain, pixels.
fn target_corners(frame: &PictureFrame, config: &PictureAlignmentConfig) -> [[f64; 2]; 4] {
    frame.around_centre(2.0 * config.target_radius_share)
}

fn sum(displacements: &[[f64; 2]; PARAMETERS], update: &WarpUpdate) -> [f64; 2] {
    [0, 1]
        .map(|axis| displacements.iter().zip(update.iter()).map(|(moved, number)| moved[axis] * number).sum())
}

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    #[test]
    fn derivatives_of_residuals_are_those_of_central_differences() {
        let mut rng = RngTree::new(5).child("residuals").rng();
        let image =
            GreyImage { width: 60, height: 40, values: (0..2_400).map(|_| rng.uniform() as f32).collect() };
        let frame = PictureFrame::new(60, 40);
        let mut checked = 0;
        for _ in 0..300 {
            let start = WarpUpdate::from_fn(|_, _| rng.range(-0.03, 0.03));
            let homography = frame.updated(&Homography::identity(), &start).expect("a mapping");
            let px = [rng.range(8.0, 50.0), rng.range(8.0, 30.0)];
            let pixel = StructurePixel { px, value: 0.3, weight: 1.0 };
            let mapped = homography.map(px).expect("ahead");
            // Within one cell of the interpolation: the gradient jumps from cell to cell.
            if mapped.iter().any(|at| (at.fract() - 0.5).abs() > 0.45) {
                continue;
            }
            checked += 1;
            let found = residual(&pixel, &frame, &image, &homography).expect("inside").jacobian;
            for parameter in 0..PARAMETERS {
                let step = 1e-6;
                let value = |sign: f64| {
                    let mut update = WarpUpdate::zeros();
                    update[parameter] = sign * step;
                    let moved = frame.updated(&homography, &update).expect("a mapping");
                    residual(&pixel, &frame, &image, &moved).expect("inside").value
                };
                let expected = (value(1.0) - value(-1.0)) / (2.0 * step);
                assert!((found[parameter] - expected).abs() < 1e-4 * (1.0 + expected.abs()));
            }
        }
        assert!(checked > 100);
    }
}
