//! The sentences of `autoinspect changes` about depth images.

use std::fmt::Display;
use std::path::Path;

/// A depth image is compared with something else.
pub fn image_and_visit(image: &Path, other: &Path) -> String {
    format!(
        "{} is a point cloud, and {} is not; give two organised PCD files of one depth camera, or two recordings or maps",
        image.display(),
        other.display()
    )
}

/// A file that is no point network.
pub fn no_network(path: &Path, reason: &dyn Display) -> String {
    format!(
        "{} cannot be used: {reason}; give a file that `cargo xtask bench object_identity --train` has written",
        path.display()
    )
}

/// A cloud that is not an image.
pub fn not_organised(path: &Path, points: usize) -> String {
    format!(
        "{} is not organised: its {points} points stand in one row, without columns and rows of a depth camera; give organised PCD files, or recordings or maps that say where the sensor was",
        path.display()
    )
}

/// A cloud whose points are not those of a depth camera.
pub fn no_depth_image(path: &Path, reason: &dyn Display) -> String {
    format!("{} is not the image of a depth camera: {reason}", path.display())
}

/// Two depth images that cannot be compared.
pub fn images_not_comparable(before: &Path, after: &Path, reason: &dyn Display) -> String {
    format!("{} and {} cannot be compared: {reason}", before.display(), after.display())
}
