//! Compact encoding of scans and map tiles for display. They are encoded on the robot and decoded in the browser.
//!
//! All points are sent as a [`PointChunk`]: points on a 16-bit lattice with an origin and a step, in the eight-byte form that the GPU reads
//! without conversion. A scan is one chunk (`encode_scan`). A map is many chunks, in levels: coarse ones are sent first, and finer ones
//! add points to them.
//!
//! - While mapping, [`LevelSplitter`] takes one keyframe at a time and returns its new points on each level. Tiles stay in their keyframe's
//!   frame, so a loop closure moves poses and no points;
//! - A finished map is baked (`bake`) into one additive octree in the map frame.
//!
//! [`chunk`] describes the bytes. Any input of the decoder gives points or a [`ChunkDecodeError`], and it allocates at most
//! [`MAX_EXPANSION`] times the input's bytes. The browser's build has no encoder, because that uses the C library of zstd.

#[cfg(not(target_arch = "wasm32"))]
mod bake;
mod cells;
pub mod chunk;
#[cfg(not(target_arch = "wasm32"))]
mod encode;
#[cfg(test)]
mod layout_tests;
mod levels;
#[cfg(not(target_arch = "wasm32"))]
mod morton;
mod octree;
#[cfg(test)]
mod tests;

/// Greatest step of the lattice of points for clients, metres: of live scans, of the running session's tiles and of finished maps.
pub const POINT_RESOLUTION_M: f32 = 0.01;

#[cfg(not(target_arch = "wasm32"))]
pub use bake::{BakeConfig, BakedTile, bake};
pub use chunk::{ChunkDecodeError, GpuPoint, MAX_EXPANSION, PointChunk, decode};
#[cfg(not(target_arch = "wasm32"))]
pub use encode::{encode, encode_scan, quantise};
pub use levels::{LevelPoints, LevelSplitter, SplitConfig};
pub use octree::NodeId;
