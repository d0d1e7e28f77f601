//! The mapping of a plane between two pictures.

use geometry::{Isometry, Matrix3, Vector3};

/// The pinhole model of a camera without distortion, and where it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosedCamera {
    /// Focal length, pixels, along both axes.
    pub focal_px: f64,
    /// Principal point, pixels: the middle of the first pixel is 0, 0.
    pub centre_px: [f64; 2],
    /// Pose of the camera: x right, y down, z ahead. Any frame that both cameras share.
    pub map_from_camera: Isometry,
}

/// A mapping of points of one picture to points of another, as a plane is seen in both. Pixels: x to the right, y down, the middle of the first pixel is 0, 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homography(Matrix3);

/// Points whose third coordinate is below this share of that of the middle of a picture are seen edge-on or from behind: they have no place in the other picture.
const MIN_DEPTH_SHARE: f64 = 1e-6;

impl Homography {
    /// Every point stays where it is.
    pub fn identity() -> Self {
        Self(Matrix3::identity())
    }

    /// A displacement, pixels.
    pub fn translation([x, y]: [f64; 2]) -> Self {
        Self(Matrix3::new(1.0, 0.0, x, 0.0, 1.0, y, 0.0, 0.0, 1.0))
    }

    /// The mapping of a matrix, scaled such that its last element is 1. None if that cannot be: an element is not finite, the matrix has no inverse, or the last element is 0.
    pub fn new(matrix: &Matrix3) -> Option<Self> {
        let last = matrix[(2, 2)];
        let scaled = matrix / last;
        let is_mapping =
            scaled.iter().all(|element| element.is_finite()) && scaled.determinant().abs() > 1e-12;
        is_mapping.then_some(Self(scaled))
    }

    /// The mapping from the picture `before` to the picture `after` of the plane through a target that faces the camera `before`: equation 1 of docs/maths/picture-changes.md.
    ///
    /// `target_distance_m`: distance of the plane from the camera `before` along its axis, metres. None where the plane is behind the camera `after`, or a number is not finite.
    pub fn predicted(before: &PosedCamera, after: &PosedCamera, target_distance_m: f64) -> Option<Self> {
        if target_distance_m.is_nan() || target_distance_m <= 0.0 {
            return None;
        }
        let after_from_before = after.map_from_camera.inverse() * before.map_from_camera;
        let rotation = after_from_before.rotation.to_rotation_matrix().into_inner();
        let plane =
            rotation + after_from_before.translation.vector * Vector3::z().transpose() / target_distance_m;
        // The target is ahead of the other camera too.
        if (plane * Vector3::z()).z <= 0.0 {
            return None;
        }
        Self::new(&(after.matrix() * plane * before.inverse_matrix()))
    }

    /// The matrix, whose last element is 1.
    pub fn matrix(&self) -> &Matrix3 {
        &self.0
    }

    /// Where a point is in the other picture. None if it is not ahead of that camera.
    pub fn map(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let mapped = self.0 * Vector3::new(x, y, 1.0);
        (mapped.z > MIN_DEPTH_SHARE).then(|| [mapped.x / mapped.z, mapped.y / mapped.z])
    }

    /// First `other`, then this mapping. None if the product is no mapping.
    pub fn after(&self, other: &Self) -> Option<Self> {
        Self::new(&(self.0 * other.0))
    }

    /// The mapping back. None if it cannot be scaled.
    pub fn inverse(&self) -> Option<Self> {
        self.0.try_inverse().and_then(|inverse| Self::new(&inverse))
    }
}

impl PosedCamera {
    fn matrix(&self) -> Matrix3 {
        let [x, y] = self.centre_px;
        Matrix3::new(self.focal_px, 0.0, x, 0.0, self.focal_px, y, 0.0, 0.0, 1.0)
    }

    fn inverse_matrix(&self) -> Matrix3 {
        let [x, y] = self.centre_px;
        let f = self.focal_px;
        Matrix3::new(1.0 / f, 0.0, -x / f, 0.0, 1.0 / f, -y / f, 0.0, 0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Rotation;
    use nalgebra::{Point3, Translation3};

    fn camera(position: [f64; 3], angles: [f64; 3], focal_px: f64) -> PosedCamera {
        let rotation = Rotation::from_euler_angles(angles[0], angles[1], angles[2]);
        let [x, y, z] = position;
        let map_from_camera = Isometry::from_parts(Translation3::new(x, y, z), rotation);
        PosedCamera { focal_px, centre_px: [319.5, 239.5], map_from_camera }
    }

    #[test]
    fn points_of_the_plane_are_mapped_as_the_cameras_see_them() {
        let before = camera([0.0; 3], [0.0; 3], 1_200.0);
        let after = camera([0.03, -0.02, 0.05], [0.02, -0.01, 0.03], 1_500.0);
        let homography = Homography::predicted(&before, &after, 1.5).expect("a mapping");
        for [x, y] in [[0.0, 0.0], [0.2, -0.1], [-0.3, 0.25]] {
            let point = Point3::new(x, y, 1.5);
            let seen = |camera: &PosedCamera| {
                let local = camera.map_from_camera.inverse() * point;
                [0, 1].map(|axis| camera.focal_px * local[axis] / local.z + camera.centre_px[axis])
            };
            let mapped = homography.map(seen(&before)).expect("ahead");
            let expected = seen(&after);
            assert!(
                (0..2).all(|axis| (mapped[axis] - expected[axis]).abs() < 1e-6),
                "{mapped:?} {expected:?}"
            );
            let back = homography.inverse().and_then(|inverse| inverse.map(mapped)).expect("ahead");
            assert!((0..2).all(|axis| (back[axis] - seen(&before)[axis]).abs() < 1e-6));
        }
    }

    #[test]
    fn a_plane_that_cannot_be_seen_has_no_mapping() {
        let before = camera([0.0; 3], [0.0; 3], 1_200.0);
        let beyond = camera([0.0, 0.0, 2.0], [0.0; 3], 1_200.0);
        assert_eq!(Homography::predicted(&before, &beyond, 1.5), None);
        assert_eq!(Homography::predicted(&before, &before, 0.0), None);
        assert_eq!(Homography::predicted(&before, &before, f64::NAN), None);
        assert_eq!(Homography::new(&Matrix3::zeros()), None);
    }
}
