//! Pictures in files, as the commands that look at pictures read them.

use crate::failure::Failure;
use crate::texts;
use formats::picture::PictureFileError;
use gauges::Picture;
use std::fs;
use std::path::Path;

/// Reads a JPEG, PNG or BMP file.
pub fn read(path: &Path) -> Result<Picture, Failure> {
    let bytes = fs::read(path).map_err(|error| Failure::unreadable(path, error))?;
    let decoded = formats::picture::read(&bytes).map_err(|error| {
        Failure::usage(match error {
            PictureFileError::OtherFormat => texts::no_picture(path),
            PictureFileError::CutShort => texts::picture_cut_short(path),
            PictureFileError::OtherBmp => texts::other_bmp(path),
            PictureFileError::Damaged(reason) => texts::damaged_picture(path, &reason),
        })
    })?;
    let picture = Picture::new(decoded.size_px, decoded.pixels);
    picture.map_err(|error| Failure::usage(texts::damaged_picture(path, &error)))
}
