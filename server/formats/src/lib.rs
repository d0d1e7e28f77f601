//! File and message formats of other tools: bytes in, typed data or a typed error out.
//!
//! The crate does not know the command line, the network or the clock. No reader allocates by a count in a header before it has checked that the
//! bytes are there, and none panics on any input. All formats of points become a [`PointTable`], and [`PointTable::to_scan`] converts that to the
//! stack's scan. Texts of errors stand in `texts.rs`.

pub mod cdr;
pub mod e57;
mod error;
pub mod g2o;
pub mod kitti;
pub mod las;
mod limits;
mod lzf;
pub mod natural;
pub mod pcd;
pub mod picture;
pub mod ply;
mod point_table;
pub mod ros;
pub mod rosbag1;
pub mod rosbag2;
pub mod scan_file;
pub mod survey;
mod texts;
pub mod tum;

pub use error::FormatError;
pub use limits::{MAX_CHUNK_BYTES, SurveyLimits};
pub use point_table::{Dropped, PointField, PointTable, ScalarType, ScanReport};
