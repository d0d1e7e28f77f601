//! File and message formats of other tools: bytes in, typed data or a typed error out.
//!
//! Nothing here knows the command line, the network or the clock. No reader allocates from a count in a header
//! without checking that the bytes are there, and none panics on any input. Point formats meet in
//! [`PointTable`], which [`PointTable::to_scan`] turns into the one scan type of the stack.

pub mod cdr;
pub mod e57;
mod error;
pub mod g2o;
pub mod kitti;
pub mod las;
mod lzf;
pub mod natural;
pub mod pcd;
pub mod ply;
mod point_table;
pub mod ros;
pub mod rosbag1;
pub mod rosbag2;
pub mod scan_file;
pub mod survey;
pub mod tum;

pub use error::{FormatError, legible};
pub use point_table::{Dropped, PointField, PointTable, ScalarType, ScanReport};
