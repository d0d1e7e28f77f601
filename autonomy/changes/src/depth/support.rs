//! The plane on which things stand.

use super::config::DepthChangesConfig;
use super::image::{DepthImage, DepthImageError};
use geometry::{Isometry, Matrix3, RngTree, Rotation, Vector3};
use nalgebra::{Rotation3, Translation3};

/// Seed of the trials: any number, always the same, so that the same images give the same plane.
const SEED: u64 = 1;

/// A plane: the points `p` with `up . p = offset_m`, in the camera's frame. The camera is on the side of `up`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Support {
    pub(crate) up: Vector3,
    pub(crate) offset_m: f64,
}

impl Support {
    /// The plane with most points of both images (RANSAC), fitted to them by least squares with the weights of their noise. Source: Fischler and Bolles, *Random Sample
    /// Consensus*, 1981. `support_trials x support_points` steps.
    ///
    /// # Errors
    /// When no plane holds enough points.
    pub(crate) fn find(
        images: [&DepthImage; 2],
        config: &DepthChangesConfig,
    ) -> Result<Self, DepthImageError> {
        let all: Vec<Vector3> =
            images.iter().flat_map(|image| (0..image.len()).filter_map(|pixel| image.point(pixel))).collect();
        let step = all.len().div_ceil(config.support_points.max(1)).max(1);
        let points: Vec<Vector3> = all.into_iter().step_by(step).collect();
        let mut rng = RngTree::new(SEED).child("support").rng();
        let mut pick = || points[(rng.uniform() * points.len() as f64) as usize];
        let mut best: Option<(usize, Self)> = None;
        for _ in 0..config.support_trials {
            let Some(plane) = Self::through(pick(), pick(), pick()) else { continue };
            let count = points.iter().filter(|point| plane.is_on(point, config)).count();
            if best.is_none_or(|(most, _)| count > most) {
                best = Some((count, plane));
            }
        }
        let (_, mut plane) = best.ok_or(DepthImageError::NoSupport)?;
        for _ in 0..config.support_refits {
            plane = plane.refitted(&points, config).unwrap_or(plane);
        }
        let count = points.iter().filter(|point| plane.is_on(point, config)).count();
        let is_enough = count as f64 >= config.min_support_share * points.len() as f64;
        is_enough.then_some(plane).ok_or(DepthImageError::NoSupport)
    }

    /// Height of a point above the plane, metres.
    pub(crate) fn height_m(&self, point: &Vector3) -> f64 {
        self.up.dot(point) - self.offset_m
    }

    /// The frame of the plane in the camera's: third axis up, first axis along the camera's first axis as seen from above, origin below the camera.
    pub(crate) fn camera_from_support(&self) -> Isometry {
        let along = |axis: Vector3| axis - self.up * self.up.dot(&axis);
        let (first, second) = (along(Vector3::x()), along(Vector3::y()));
        // A camera whose first axis is nearly upright: its second axis serves.
        let first = if first.norm() >= 0.5 { first } else { second }.normalize();
        let axes = Matrix3::from_columns(&[first, self.up.cross(&first), self.up]);
        let rotation = Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        Isometry::from_parts(Translation3::from(self.up * self.offset_m), rotation)
    }

    fn is_on(&self, point: &Vector3, config: &DepthChangesConfig) -> bool {
        self.height_m(point).abs()
            <= (3.0 * config.noise_m(point.norm())).max(config.min_same_surface_m / 2.0)
    }

    /// The plane through three points; none if they are in a line, or the camera is in it.
    fn through(a: Vector3, b: Vector3, c: Vector3) -> Option<Self> {
        let normal = (b - a).cross(&(c - a)).try_normalize(1e-9)?;
        Self::facing(normal, &a)
    }

    /// The plane through a point, with its normal turned towards the camera.
    fn facing(normal: Vector3, point: &Vector3) -> Option<Self> {
        let offset_m = normal.dot(point);
        if offset_m.abs() < 1e-6 {
            return None;
        }
        let sign = -offset_m.signum();
        Some(Self { up: normal * sign, offset_m: offset_m * sign })
    }

    fn refitted(&self, points: &[Vector3], config: &DepthChangesConfig) -> Option<Self> {
        let on = || points.iter().filter(|point| self.is_on(point, config));
        let weight = |point: &Vector3| config.noise_m(point.norm()).max(1e-6).powi(-2);
        let (sum, total) = on().fold((Vector3::zeros(), 0.0), |(sum, total), point| {
            (sum + point * weight(point), total + weight(point))
        });
        let mean = sum / total;
        let spread = on().fold(Matrix3::zeros(), |spread, point| {
            spread + (point - mean) * (point - mean).transpose() * weight(point)
        });
        let eigen = spread.try_symmetric_eigen(1e-15, 1_000)?;
        let least = (0..3).min_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]))?;
        Self::facing(eigen.eigenvectors.column(least).into_owned(), &mean)
    }
}
