//! Normals of the surface in a depth image.

use super::config::DepthChangesConfig;
use super::image::DepthImage;
use geometry::{Matrix3, Vector3};

/// The unit normal of the surface at a pixel, towards the camera, in its frame: that of the plane that fits the window around it best. In an image a plane has an inverse depth
/// that is linear in the pixels, so that three sums give it. None without a point, or with too few points of its surface around.
pub(crate) fn normal(image: &DepthImage, pixel: usize, config: &DepthChangesConfig) -> Option<Vector3> {
    let middle = image.point(pixel)?;
    let ray = |point: &Vector3| (point.x / point.z, point.y / point.z);
    let (x, y) = ray(&middle);
    let reach_m = config.gap_m + 3.0 * config.noise_m(middle.z);
    let (mut count, mut normal_matrix, mut right) = (0, Matrix3::zeros(), Vector3::zeros());
    for near in image.around(pixel, config.normal_px) {
        let Some(point) = image.point(near) else { continue };
        if (point.z - middle.z).abs() > reach_m {
            continue;
        }
        let (near_x, near_y) = ray(&point);
        // Scaled to pixels, so that the matrix is well conditioned.
        let [focal_x, focal_y] = image.camera().focal_px;
        let row = Vector3::new(1.0, (near_x - x) * focal_x, (near_y - y) * focal_y);
        normal_matrix += row * row.transpose();
        right += row * (1.0 / point.z - 1.0 / middle.z);
        count += 1;
    }
    if count < config.min_normal_points {
        return None;
    }
    let fitted = normal_matrix.cholesky()?.solve(&right);
    let [focal_x, focal_y] = image.camera().focal_px;
    let (slope_x, slope_y) = (fitted[1] * focal_x, fitted[2] * focal_y);
    // The plane a X + b Y + c Z = 1 has the inverse depth a x + b y + c.
    let inverse_m = 1.0 / middle.z + fitted[0] - slope_x * x - slope_y * y;
    Vector3::new(-slope_x, -slope_y, -inverse_m).try_normalize(1e-12)
}
