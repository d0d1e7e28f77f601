//! What scans are matched with, however it is kept.

use crate::{GaussianMap, Surface};

/// Surfaces in a map's frame, metres.
pub trait Surfaces {
    /// As [`GaussianMap::surface`].
    fn surface(&self, point: &[f64; 3], gate: f32) -> Option<Surface>;

    /// As [`GaussianMap::surface_facing`].
    fn surface_facing(&self, point: &[f64; 3], from: &[f64; 3], gate: f32) -> Option<Surface>;
}

impl Surfaces for GaussianMap {
    #[inline]
    fn surface(&self, point: &[f64; 3], gate: f32) -> Option<Surface> {
        Self::surface(self, point, gate)
    }

    #[inline]
    fn surface_facing(&self, point: &[f64; 3], from: &[f64; 3], gate: f32) -> Option<Surface> {
        Self::surface_facing(self, point, from, gate)
    }
}
