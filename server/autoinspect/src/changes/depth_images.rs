//! Reads images of depth cameras: organised PCD files.

use super::texts;
use crate::failure::Failure;
use changes::DepthImage;
use formats::pcd;
use std::fs;
use std::path::Path;

/// Whether a path names a PCD file.
pub fn is_image(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pcd")) && !path.is_dir()
}

/// Reads the image of a depth camera. Only its points and colours are used.
pub fn read(path: &Path) -> Result<DepthImage, Failure> {
    let bytes = fs::read(path).map_err(|error| Failure::unreadable(path, error))?;
    let table = pcd::read(&bytes).map_err(|error| Failure::unreadable(path, error))?;
    let [columns, rows] = table.grid();
    if columns < 2 || rows < 2 {
        return Err(Failure::usage(texts::not_organised(path, table.len())));
    }
    let points = table.positions().map_err(|error| Failure::unreadable(path, error))?;
    DepthImage::new([columns, rows], points, table.colours())
        .map_err(|error| Failure::usage(texts::no_depth_image(path, &error)))
}
