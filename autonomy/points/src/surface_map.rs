//! What scans are matched with, however it is kept.

use crate::{GaussianMap, Surface};

/// Surfaces in a map's frame, metres.
pub trait SurfaceMap {
    /// As [`GaussianMap::surface`].
    fn find_surface(&self, point: &[f64; 3], gate: f32) -> Option<Surface>;

    /// As [`GaussianMap::find_surface_facing`].
    fn find_surface_facing(&self, point: &[f64; 3], from: &[f64; 3], gate: f32) -> Option<Surface>;
}

impl SurfaceMap for GaussianMap {
    #[inline]
    fn find_surface(&self, point: &[f64; 3], gate: f32) -> Option<Surface> {
        Self::find_surface(self, point, gate)
    }

    #[inline]
    fn find_surface_facing(&self, point: &[f64; 3], from: &[f64; 3], gate: f32) -> Option<Surface> {
        Self::find_surface_facing(self, point, from, gate)
    }
}
