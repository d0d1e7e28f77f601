//! Points on the way to the screen: scans and map tiles as compact bytes, encoded on the robot and decoded in
//! the browser.
//!
//! Everything that travels is a [`PointChunk`]: points on a 16-bit lattice with an origin and a step, in the
//! eight-byte form that the GPU reads as it is. A scan is one chunk (`encode_scan`); a map is many, chosen so
//! that coarse levels arrive first and finer ones add to them:
//!
//! - while mapping, [`LevelSplitter`] takes one keyframe at a time and says which of its points are new on which
//!   level. Tiles stay in their keyframe's frame, so a loop closure moves poses and no points;
//! - a finished map is baked (`bake`) into one additive octree in the map frame.
//!
//! [`chunk`] describes the bytes. Decoding is total: any input gives points or a [`DecodeError`], and it allocates
//! at most [`EXPANSION_MAX`] times the bytes that are present. Whatever encodes is absent from the browser's
//! build, because its zstd is C.

#[cfg(not(target_arch = "wasm32"))]
mod bake;
mod cells;
pub mod chunk;
#[cfg(not(target_arch = "wasm32"))]
mod encode;
mod levels;
#[cfg(not(target_arch = "wasm32"))]
mod morton;
mod octree;
#[cfg(test)]
mod tests;

#[cfg(not(target_arch = "wasm32"))]
pub use bake::{BakeConfig, BakedTile, bake};
pub use chunk::{DecodeError, EXPANSION_MAX, GpuPoint, PointChunk, decode};
#[cfg(not(target_arch = "wasm32"))]
pub use encode::{encode, encode_scan, quantise};
pub use levels::{LevelPoints, LevelSplitter, SplitConfig};
pub use octree::NodeId;
