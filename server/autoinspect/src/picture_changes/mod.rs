//! `autoinspect picture-changes`: what has changed between two pictures of one thing.

mod aligned_picture;
mod document;
mod texts;

use crate::failure::Failure;
use crate::limited_command::LimitedCommand;
use crate::process_limits::ProcessLimits;
use crate::progress::run_in_background;
use crate::{output, picture_file, texts as shared_texts};
use ::picture_changes::{
    Homography, PictureAlignment, PictureAlignmentConfig, PictureAlignmentError, PictureChangesConfig,
    align_pictures, find_picture_changes,
};
use clap::Args;
use gauges::Picture;
use geometry::Matrix3;
use std::fs;
use std::path::PathBuf;

pub use document::Document;

/// Names of the files in the folder of the results.
const RESULT: &str = "picture-changes.json";
const ALIGNED: &str = "aligned.png";

/// Find what has changed between two pictures that were taken from nearly the same place.
#[derive(Args, Debug)]
#[command(
    after_help = "BEFORE and AFTER are JPEG, PNG or BMP files of one size, of one thing, from nearly the same place: displaced by up to a quarter of their width and turned by a few degrees.
They are aligned first. Other light is no change, nor is what is only displaced because it is before or behind the plane that is aligned. Regions are rectangles of BEFORE in
pixels from the top left; their score is 0.5 to 1.

Pictures that cannot be aligned are no error: \"aligned\" is then false, with the reason.

With --out, the folder gets picture-changes.json, the JSON object, and, if the pictures are aligned, aligned.png: BEFORE as AFTER sees it, with a frame round each region.

EXAMPLES:
  autoinspect picture-changes monday.jpg tuesday.jpg
  autoinspect picture-changes monday.jpg tuesday.jpg --json
  autoinspect picture-changes monday.jpg tuesday.jpg --out compared"
)]
pub struct PictureChangesArgs {
    /// The earlier picture.
    before: PathBuf,
    /// The later picture.
    after: PathBuf,
    /// Folder for the results; those of an earlier comparison are replaced.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Rows of the matrix that the poses of the camera predict for the mapping from BEFORE to AFTER.
    #[arg(long, hide = true, value_delimiter = ',', allow_hyphen_values = true)]
    predicted: Option<Vec<f64>>,
    /// Limits, which hold with --background.
    #[command(flatten)]
    limits: ProcessLimits,
    /// Run with low priority and within limits of memory and processor time.
    #[arg(long)]
    background: bool,
}

/// Runs `autoinspect picture-changes`.
pub fn run(args: &PictureChangesArgs) -> Result<(), Failure> {
    if args.background {
        if let Some(result) = args.limits.enter(LimitedCommand::PictureChanges) {
            return result;
        }
        run_in_background();
    }
    let before = picture_file::read(&args.before)?;
    let after = picture_file::read(&args.after)?;
    if before.size_px() != after.size_px() {
        let sentence = texts::other_size(&args.before, before.size_px(), &args.after, after.size_px());
        return Err(Failure::usage(sentence));
    }
    let predicted = args.predicted.as_deref().map(predicted).transpose()?;
    let mut aligned_png = None;
    let document = match align(&before, &after, predicted.as_ref()) {
        Ok(alignment) => {
            let regions = find_picture_changes(&before, &after, &alignment, &PictureChangesConfig::default());
            let document = Document::aligned(&alignment, &regions, [&before, &after].map(Picture::size_px));
            if args.out.is_some() {
                aligned_png = aligned_picture::png(&before, &after, &alignment.after_from_before, &regions);
            }
            document
        }
        Err(PictureAlignmentError::TooSmall { size_px, least_px }) => {
            return Err(Failure::usage(texts::too_small(&args.before, size_px, least_px)));
        }
        Err(reason) => Document::not_aligned(&reason),
    };
    if let Some(out) = &args.out {
        fs::create_dir_all(out).map_err(|error| Failure::failed(shared_texts::cannot_create(out, &error)))?;
        let write = |name: &str, bytes: &[u8]| {
            let path = out.join(name);
            fs::write(&path, bytes)
                .map_err(|error| Failure::failed(shared_texts::cannot_write(&path, &error)))
        };
        write(RESULT, &serde_json::to_vec_pretty(&document).map_err(Failure::failed)?)?;
        // That of an earlier comparison must not stay.
        let _ = fs::remove_file(out.join(ALIGNED));
        if let Some(png) = aligned_png {
            write(ALIGNED, &png)?;
        }
    }
    output::print_human(args.json, &document.describe());
    output::print_json(args.json, &document)
}

/// Aligns two pictures. Where the predicted mapping leads nowhere, the poses were wrong: then without it.
fn align(
    before: &Picture,
    after: &Picture,
    predicted: Option<&Homography>,
) -> Result<PictureAlignment, PictureAlignmentError> {
    let config = PictureAlignmentConfig::default();
    let with_poses = predicted.map(|predicted| align_pictures(before, after, Some(predicted), &config));
    match with_poses {
        Some(Ok(alignment)) => Ok(alignment),
        _ => align_pictures(before, after, None, &config),
    }
}

fn predicted(rows: &[f64]) -> Result<Homography, Failure> {
    let mapping = (rows.len() == 9).then(|| Homography::new(&Matrix3::from_row_slice(rows))).flatten();
    mapping.ok_or_else(|| Failure::usage(texts::PREDICTED_NO_MAPPING))
}
