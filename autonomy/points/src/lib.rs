//! Point clouds: thinning, filters, maps made of Gaussians in hashed cells, and what a sensor saw through.
//!
//! Knows nothing of time or robots, and of sensors where they are. Points are `f32` around an origin that the caller keeps in `f64`.

pub mod downsample;
pub mod filter;
pub mod gaussian_map;
pub mod hash;
pub mod range_image;
pub mod surface_map;
pub mod symmetric;

pub use downsample::{Centroid, Downsampler};
pub use gaussian_map::{GaussianMap, GaussianMapConfig, Surface};
pub use surface_map::SurfaceMap;
