//! `autoinspect changes`: the objects that appeared, were removed or moved between two visits.

mod depth_images;
mod document;
mod known_things;
mod place;
mod run_visits;
mod texts;
mod thing;
mod two_threads;
mod view;
pub mod visits;

use crate::failure::Failure;
use crate::limited_command::LimitedCommand;
use crate::process_limits::ProcessLimits;
use crate::progress::run_in_background;
use crate::{output, texts as shared_texts};
use changes::{
    Changes, ChangesConfig, DepthChangesConfig, detect_changes_with, detect_depth_changes, shipped_descriptor,
};
use clap::Args;
pub use document::{Document, Kind};
use formats::ply;
use known_things::following;
use object_identity::{ObjectDescriptor, PointNetwork};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use two_threads::OnTwoThreads;

/// Name of the result in the folder that is written.
pub const RESULT: &str = "changes.json";
/// Name of the cloud of all objects.
pub const CHANGED: &str = "changed.ply";
/// Name of the cloud of what both visits saw.
pub const UNCHANGED: &str = "unchanged.ply";

/// Find the objects that appeared, were removed or moved between two visits.
#[derive(Args, Debug)]
#[command(
    after_help = "BEFORE and AFTER are recordings that carry the robot's poses in the map (nav_msgs/Odometry), or folders of maps, as of `autoinspect map --out` and a data
directory's maps/, or of the clouds of runs, as of its run-clouds/. Both have one frame, with the third axis up: align maps first with `autoinspect align`. A place that one of the visits has not looked at is
unknown, and nothing is reported there.

Two organised PCD files of one depth camera that has not moved, with the camera's third axis forward, are compared pixel by pixel. The largest plane that they show,
such as a table, says where up is. Results are in the camera's frame: the height of an object is along the plane's normal, and its heading counts from the camera's
first axis.

A thing that was taken away and is put elsewhere in a later comparison is one thing with a history: give the result of the comparison before with --earlier. Each identity has its
probability, because things of one make cannot be told apart.

DIR gets changes.json, a cloud for each object: object-1.ply, object-2.ply and so on; changed.ply with all of them, and unchanged.ply with what both visits saw.

EXAMPLES:
  autoinspect changes monday.mcap tuesday.mcap --out changed
  autoinspect changes maps/monday maps/tuesday --json
  autoinspect changes tuesday.mcap wednesday.mcap --earlier changed/changes.json --out changed-again
  autoinspect changes data/run-clouds/1f0c… data/run-clouds/77ab… --out changed
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
    /// The changes.json of the comparison before this one, which compared an earlier visit with BEFORE: what is known of its things is carried on.
    #[arg(long, value_name = "FILE")]
    earlier: Option<PathBuf>,
    /// Weights of a point network by which things are known again, instead of those that come with the program.
    #[arg(long, value_name = "FILE")]
    network: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Limits, which hold with --background.
    #[command(flatten)]
    limits: ProcessLimits,
    /// Run with low priority and within limits of memory and processor time.
    #[arg(long)]
    background: bool,
}

/// Runs `autoinspect changes`.
pub fn run(args: &ChangesArgs) -> Result<(), Failure> {
    if args.background {
        if let Some(result) = args.limits.enter(LimitedCommand::Changes) {
            return result;
        }
        run_in_background();
    }
    let (document, changes) = compare(args)?;
    if let Some(out) = &args.out {
        write(out, &document, &changes)?;
    }
    output::print_human(args.json, &document.describe());
    output::print_json(args.json, &document)
}

/// The changes between two depth images, or between two visits.
fn compare(args: &ChangesArgs) -> Result<(Document, Changes), Failure> {
    let earlier = args.earlier.as_deref().map(Document::read).transpose()?;
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
        let document = Document::in_frame(&found.changes, &found.camera_from_support);
        return Ok((following(document, earlier), found.changes));
    }
    let [before, after] = visits::read_both(&args.before, &args.after)?;
    let config = ChangesConfig::default();
    let descriptor: Box<dyn ObjectDescriptor> = match &args.network {
        None => shipped_descriptor(),
        Some(file) => Box::new(read_network(file)?),
    };
    let changes = detect_changes_with(&before, &after, &*descriptor, &OnTwoThreads, &config);
    Ok((following(Document::new(&changes), earlier), changes))
}

fn read_network(file: &Path) -> Result<PointNetwork, Failure> {
    let bytes = fs::read(file)
        .map_err(|error| Failure::usage(shared_texts::could_not_be_read(file, &error.to_string())))?;
    PointNetwork::from_bytes(&bytes).map_err(|error| Failure::usage(texts::no_network(file, &error)))
}

/// Writes the results into a folder. Clouds of an earlier run are removed first.
fn write(out: &Path, document: &Document, changes: &Changes) -> Result<(), Failure> {
    fs::create_dir_all(out).map_err(|error| Failure::failed(shared_texts::cannot_create(out, &error)))?;
    let earlier = (1..).map(|number| object_file(out, number)).take_while(|file| file.exists());
    for file in earlier.collect::<Vec<_>>() {
        fs::remove_file(&file).map_err(|error| Failure::failed(shared_texts::cannot_write(&file, &error)))?;
    }
    for (number, object) in (1..).zip(&changes.objects) {
        write_cloud(&object_file(out, number), &object.points)?;
    }
    let changed: Vec<[f32; 3]> = changes.objects.iter().flat_map(|object| &object.points).copied().collect();
    write_cloud(&out.join(CHANGED), &changed)?;
    write_cloud(&out.join(UNCHANGED), &changes.unchanged)?;
    let path = out.join(RESULT);
    let text = serde_json::to_string_pretty(document).map_err(Failure::failed)?;
    fs::write(&path, text).map_err(|error| Failure::failed(shared_texts::cannot_write(&path, &error)))
}

fn write_cloud(path: &Path, points: &[[f32; 3]]) -> Result<(), Failure> {
    let failure = |error: std::io::Error| Failure::failed(shared_texts::cannot_write(path, &error));
    let mut file = BufWriter::new(File::create(path).map_err(failure)?);
    ply::write(&mut file, points, &[]).and_then(|()| file.flush()).map_err(failure)
}

/// The cloud of the object with this number, from 1.
pub fn object_file(out: &Path, number: usize) -> PathBuf {
    out.join(format!("object-{number}.ply"))
}
