//! The sentences about files of pictures.

use std::fmt::Display;
use std::path::Path;

/// A file that is no picture.
pub fn no_picture(path: &Path) -> String {
    format!("{} is neither a JPEG nor a PNG nor a BMP file", path.display())
}

/// A BMP file of a kind that is not read.
pub fn other_bmp(path: &Path) -> String {
    format!(
        "{} is a BMP file without a size, or not of 24 or 32 bits without compression; save it as JPEG or PNG",
        path.display()
    )
}

/// A picture that ends early.
pub fn picture_cut_short(path: &Path) -> String {
    format!("{} is cut short: the end of the picture is missing; copy or take it again", path.display())
}

/// A picture that cannot be decoded.
pub fn damaged_picture(path: &Path, reason: &dyn Display) -> String {
    format!("{} is a damaged picture ({reason}); copy or take it again", path.display())
}
