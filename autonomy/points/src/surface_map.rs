//! The interface through which scan registration reads any kind of map.

use crate::{GaussianMap, Surface};

/// A map that can be asked for the surface near a point. Positions are in the map's frame, metres.
pub trait SurfaceMap {
    /// The surface near a point, see [`GaussianMap::find_surface`].
    fn find_surface(&self, point: &[f64; 3], gate_m: f32) -> Option<Surface>;

    /// The surface near a point whose front side faces a viewpoint, see [`GaussianMap::find_surface_facing`].
    fn find_surface_facing(&self, point: &[f64; 3], viewpoint: &[f64; 3], gate_m: f32) -> Option<Surface>;
}

impl SurfaceMap for GaussianMap {
    #[inline]
    fn find_surface(&self, point: &[f64; 3], gate_m: f32) -> Option<Surface> {
        Self::find_surface(self, point, gate_m)
    }

    #[inline]
    fn find_surface_facing(&self, point: &[f64; 3], viewpoint: &[f64; 3], gate_m: f32) -> Option<Surface> {
        Self::find_surface_facing(self, point, viewpoint, gate_m)
    }
}
