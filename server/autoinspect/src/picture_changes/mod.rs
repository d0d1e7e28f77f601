//! `autoinspect picture-changes`: what has changed between two pictures of one thing.

mod document;
mod texts;

use crate::failure::Failure;
use crate::{output, picture_file};
use ::picture_changes::{
    PictureAlignmentConfig, PictureAlignmentError, PictureChangesConfig, align_pictures, find_picture_changes,
};
use clap::Args;
use document::Document;
use std::path::PathBuf;

/// Find what has changed between two pictures that were taken from nearly the same place.
#[derive(Args, Debug)]
#[command(
    after_help = "BEFORE and AFTER are JPEG, PNG or BMP files of one size, of one thing, from nearly the same place: displaced by up to a quarter of their width and turned by a few degrees.
They are aligned first. Other light is no change, nor is what is only displaced because it is before or behind the plane that is aligned. Regions are rectangles of BEFORE in
pixels from the top left; their score is 0.5 to 1.

Pictures that cannot be aligned are no error: \"aligned\" is then false, with the reason.

EXAMPLES:
  autoinspect picture-changes monday.jpg tuesday.jpg
  autoinspect picture-changes monday.jpg tuesday.jpg --json"
)]
pub struct PictureChangesArgs {
    /// The earlier picture.
    before: PathBuf,
    /// The later picture.
    after: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs `autoinspect picture-changes`.
pub fn run(args: &PictureChangesArgs) -> Result<(), Failure> {
    let before = picture_file::read(&args.before)?;
    let after = picture_file::read(&args.after)?;
    if before.size_px() != after.size_px() {
        let sentence = texts::other_size(&args.before, before.size_px(), &args.after, after.size_px());
        return Err(Failure::usage(sentence));
    }
    let document = match align_pictures(&before, &after, None, &PictureAlignmentConfig::default()) {
        Ok(alignment) => {
            let regions = find_picture_changes(&before, &after, &alignment, &PictureChangesConfig::default());
            Document::aligned(&alignment, &regions)
        }
        Err(PictureAlignmentError::TooSmall { size_px, least_px }) => {
            return Err(Failure::usage(texts::too_small(&args.before, size_px, least_px)));
        }
        Err(reason) => Document::not_aligned(&reason),
    };
    output::print_human(args.json, &document.describe());
    output::print_json(args.json, &document)
}
