//! A scan in a file of its own: PCD, PLY or KITTI.

use crate::{FormatError, PointTable, kitti, pcd, ply};
use std::path::Path;

/// Formats of single scans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the names are the formats")]
pub enum ScanFormat {
    Pcd,
    Ply,
    Kitti,
}

impl ScanFormat {
    /// By the end of the name.
    pub fn of_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "pcd" => Some(Self::Pcd),
            "ply" => Some(Self::Ply),
            "bin" => Some(Self::Kitti),
            _ => None,
        }
    }

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pcd => "PCD",
            Self::Ply => "PLY",
            Self::Kitti => "KITTI",
        }
    }

    /// Reads a whole file of this format.
    ///
    /// # Errors
    /// As the format's own reader.
    pub fn read(self, bytes: &[u8]) -> Result<PointTable<'_>, FormatError> {
        match self {
            Self::Pcd => pcd::read(bytes),
            Self::Ply => ply::read(bytes),
            Self::Kitti => kitti::read(bytes),
        }
    }
}
