//! Errors of `autoinspect export`.

use std::path::Path;

/// An export file without a known ending.
pub fn unknown_format(out: &Path) -> String {
    format!(
        "{} does not say its format; end it in .ply, .pcd, .las, .laz, .e57 or .png, or give --format",
        out.display()
    )
}

/// A picture without a pixel.
pub const EMPTY_PICTURE: &str =
    "no point of the map is within these heights; widen --heights or --above-robot";
