//! `autoinspect changes`: the objects that appeared, were removed or moved between two visits.

mod depth_images;
mod document;
mod texts;
mod visits;

use crate::failure::Failure;
use crate::{output, texts as shared_texts};
use changes::{Changes, ChangesConfig, DepthChangesConfig, detect_changes, detect_depth_changes};
use clap::Args;
use document::Document;
use formats::ply;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Name of the result in the folder that is written.
const RESULT: &str = "changes.json";

/// Find the objects that appeared, were removed or moved between two visits.
#[derive(Args, Debug)]
#[command(
    after_help = "BEFORE and AFTER are recordings that carry the robot's poses in the map (nav_msgs/Odometry), or folders of maps, as of `autoinspect map --out` and a data
directory's maps/. Both have one frame, with the third axis up: align maps first with `autoinspect align`. A place that one of the visits has not looked at is
unknown, and nothing is reported there.

Two organised PCD files of one depth camera that has not moved, with the camera's third axis forward, are compared pixel by pixel. The largest plane that they show,
such as a table, says where up is. Results are in the camera's frame: the height of an object is along the plane's normal, and its heading counts from the camera's
first axis.

DIR gets changes.json, and a cloud for each object: object-1.ply, object-2.ply and so on.

EXAMPLES:
  autoinspect changes monday.mcap tuesday.mcap --out changed
  autoinspect changes maps/monday maps/tuesday --json
  autoinspect changes table-monday.pcd table-tuesday.pcd --out changed"
)]
pub struct ChangesArgs {
    /// The earlier visit.
    before: PathBuf,
    /// The later visit.
    after: PathBuf,
    /// Folder for the results; those of an earlier run are replaced.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs `autoinspect changes`.
pub fn run(args: &ChangesArgs) -> Result<(), Failure> {
    let (document, changes) = compare(args)?;
    if let Some(out) = &args.out {
        write(out, &document, &changes)?;
    }
    output::print_human(args.json, &document.describe());
    output::print_json(args.json, &document)
}

/// The changes between two depth images, or between two visits.
fn compare(args: &ChangesArgs) -> Result<(Document, Changes), Failure> {
    let [is_before_image, is_after_image] =
        [&args.before, &args.after].map(|path| depth_images::is_image(path));
    if is_before_image != is_after_image {
        let (image, other) =
            if is_before_image { (&args.before, &args.after) } else { (&args.after, &args.before) };
        return Err(Failure::usage(texts::image_and_visit(image, other)));
    }
    if is_before_image {
        let [before, after] = [depth_images::read(&args.before)?, depth_images::read(&args.after)?];
        let found =
            detect_depth_changes(&before, &after, &DepthChangesConfig::default()).map_err(|error| {
                Failure::usage(texts::images_not_comparable(&args.before, &args.after, &error))
            })?;
        return Ok((Document::in_frame(&found.changes, &found.camera_from_support), found.changes));
    }
    let before = visits::read(&args.before)?;
    let after = visits::read(&args.after)?;
    let changes = detect_changes(&before, &after, &ChangesConfig::default());
    Ok((Document::new(&changes), changes))
}

/// Writes the results into a folder. Clouds of an earlier run are removed first.
fn write(out: &Path, document: &Document, changes: &Changes) -> Result<(), Failure> {
    fs::create_dir_all(out).map_err(|error| Failure::failed(shared_texts::cannot_create(out, &error)))?;
    let earlier = (1..).map(|number| object_file(out, number)).take_while(|file| file.exists());
    for file in earlier.collect::<Vec<_>>() {
        fs::remove_file(&file).map_err(|error| Failure::failed(shared_texts::cannot_write(&file, &error)))?;
    }
    for (number, object) in (1..).zip(&changes.objects) {
        let path = object_file(out, number);
        let failure = |error| Failure::failed(shared_texts::cannot_write(&path, &error));
        let mut file = BufWriter::new(File::create(&path).map_err(failure)?);
        ply::write(&mut file, &object.points, &[]).map_err(failure)?;
    }
    let path = out.join(RESULT);
    let text = serde_json::to_string_pretty(document).map_err(Failure::failed)?;
    fs::write(&path, text).map_err(|error| Failure::failed(shared_texts::cannot_write(&path, &error)))
}

/// The cloud of the object with this number, from 1.
fn object_file(out: &Path, number: usize) -> PathBuf {
    out.join(format!("object-{number}.ply"))
}
