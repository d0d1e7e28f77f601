//! Point clouds: voxel downsampling, filters, hashed maps of running Gaussians, and range images for free-space checks.
//!
//! The crate knows neither time nor robots. Points are `f32` relative to an origin that the caller keeps in `f64`.

pub mod adaptive_voxel;
pub mod angle;
pub mod downsample;
pub mod filter;
pub mod free_space_image;
pub mod gaussian_map;
pub mod hash;
pub mod line_of_sight;
pub mod range_image;
pub mod surface_map;
pub mod symmetric;

pub use adaptive_voxel::AdaptiveVoxelConfig;
pub use downsample::{Centroid, Downsampler};
pub use free_space_image::FreeSpaceImage;
pub use gaussian_map::{GaussianMap, GaussianMapConfig, Surface};
pub use line_of_sight::{LineOfSightConfig, OccupiedVoxels};
pub use range_image::{Occupancy, RangeImage, RangeImageConfig};
pub use surface_map::SurfaceMap;
