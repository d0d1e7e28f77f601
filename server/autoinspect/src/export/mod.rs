//! `autoinspect export`: writes a saved map as a file for other programs, or as a picture from above.

pub(crate) mod picture;

use crate::failure::Failure;
use crate::{output, summaries, texts};
use api::MapSummary;
use clap::{Args, ValueEnum};
use formats::{e57::E57File, las, pcd, ply};
use picture::{Heights, MapPicture, Settings};
use serde::Serialize;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use store::{CloudSelection, MapClouds, MapPoints, map_clouds};
use vocab::MapId;

/// Write a saved map as one file for other programs, or as a picture from above.
#[derive(Args, Debug)]
#[command(after_help = "FILE's ending says the format:
  .ply .pcd    all points in the map frame, metres and sensor units, binary
  .las .laz    the same for survey programs: millimetres, intensity over 16 bits; .laz is compressed
  .e57         one scan for each keyframe, with its pose
  .png         seen from above, coloured by height; beside it FILE.pgw says where each pixel lies

EXAMPLES:
  autoinspect export m --out hall.laz
  autoinspect export m --out hall.e57 --spacing 0 --moving            every point of every keyframe
  autoinspect export m --out upper.png --heights 3.0,5.5              one floor
  autoinspect export m --out hall.png --pixel 0.02 --above-robot 4    finer, and more of what hangs above")]
pub struct ExportArgs {
    /// Folder of the map: the result of `autoinspect map --out`, or one of the folders in a data directory's maps/.
    map: PathBuf,
    /// The file to write.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Format [default: by FILE's ending].
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// One point in each cell of this size, metres; 0 keeps all.
    #[arg(long, default_value_t = 0.03, value_parser = not_negative)]
    spacing: f32,
    /// Keep points of people and other moving objects, which later or earlier scans saw through.
    #[arg(long)]
    moving: bool,
    /// Edge of a pixel of the picture, metres.
    #[arg(long, default_value_t = 0.05, value_parser = pixel_size)]
    pixel: f64,
    /// The picture leaves out points higher than this above the keyframe that saw them, metres; these are mostly ceilings.
    #[arg(long, default_value_t = 1.5)]
    above_robot: f64,
    /// The picture shows only these heights of the map, metres.
    #[arg(long, value_name = "FROM,TO", value_parser = heights, allow_hyphen_values = true)]
    heights: Option<Heights>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// File formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
enum Format {
    Ply,
    Pcd,
    Las,
    Laz,
    E57,
    Png,
}

/// The result, for people and programs.
#[derive(Debug, Serialize)]
struct Report {
    file: PathBuf,
    format: Format,
    points: u64,
    bytes: u64,
}

/// Runs `autoinspect export`.
pub fn run(args: &ExportArgs) -> Result<(), Failure> {
    let format = args
        .format
        .or_else(|| format_of(&args.out))
        .ok_or_else(|| Failure::usage(texts::unknown_format(&args.out)))?;
    let map = map_summary(&args.map)?;
    let clouds =
        map_clouds(&args.map, CloudSelection { spacing_m: args.spacing, include_dynamic: args.moving })
            .map_err(Failure::usage)?;
    // Written under another name first, so that a file with the given name is always complete.
    let unfinished = unfinished(&args.out);
    let written = write(args, format, map.id, clouds, &unfinished).and_then(|points| {
        fs::rename(&unfinished, &args.out).map_err(|error| cannot_write(&args.out, &error))?;
        Ok(points)
    });
    let points = written.inspect_err(|_| {
        // The file may not exist if it could not be created.
        let _ = fs::remove_file(&unfinished);
    })?;
    let bytes = fs::metadata(&args.out).map_err(|error| cannot_write(&args.out, &error))?.len();
    output::print_human(args.json, &summaries::exported(&args.out, points, bytes));
    output::print_json(args.json, &Report { file: args.out.clone(), format, points, bytes })
}

/// The map's summary, which is written last: a map without it is incomplete.
pub(crate) fn map_summary(map: &Path) -> Result<MapSummary, Failure> {
    let bytes = fs::read(map.join("map.json")).map_err(|error| Failure::usage(texts::no_map(map, &error)))?;
    serde_json::from_slice(&bytes).map_err(|error| Failure::unreadable(&map.join("map.json"), error))
}

/// Writes the map to `path` and returns the number of its points.
fn write(
    args: &ExportArgs,
    format: Format,
    map: MapId,
    clouds: MapClouds,
    path: &Path,
) -> Result<u64, Failure> {
    let writing = |error: io::Error| cannot_write(&args.out, &error);
    if format == Format::E57 {
        return write_e57(&args.out, map, clouds, path);
    }
    if format == Format::Png {
        let settings = Settings { pixel: args.pixel, above_robot: args.above_robot, heights: args.heights };
        let picture = MapPicture::of(clouds, settings)
            .map_err(Failure::failed)?
            .ok_or_else(|| Failure::usage(texts::EMPTY_PICTURE))?;
        save(path, |file| picture.write_png(file)).map_err(writing)?;
        save(&world_file(&args.out), |file| file.write_all(picture.world_file().as_bytes()))
            .map_err(writing)?;
        return Ok(picture.points());
    }
    let points = MapPoints::read(clouds).map_err(Failure::failed)?;
    let (xyz, intensity) = (&points.xyz, &points.intensity);
    match format {
        Format::Ply => save(path, |file| ply::write(file, xyz, intensity)),
        Format::Pcd => save(path, |file| pcd::write(file, [0.0; 3], xyz, intensity)),
        _ => File::create(path)
            .and_then(|file| las::write(BufWriter::new(file), xyz, intensity, format == Format::Laz)),
    }
    .map_err(writing)?;
    Ok(xyz.len() as u64)
}

fn write_e57(out: &Path, map: MapId, clouds: MapClouds, path: &Path) -> Result<u64, Failure> {
    let writing = |error: io::Error| cannot_write(out, &error);
    // The format reads and writes at several positions of its file.
    let file = OpenOptions::new().read(true).write(true).create(true).truncate(true).open(path);
    let mut file = E57File::new(file.map_err(writing)?, map.0.as_u128()).map_err(writing)?;
    let mut points = 0;
    for cloud in clouds {
        let cloud = cloud.map_err(Failure::failed)?;
        let name = summaries::keyframe_name(cloud.keyframe.0);
        file.add(&name, &cloud.map_from_keyframe, &cloud.xyz, &cloud.intensity).map_err(writing)?;
        points += cloud.xyz.len() as u64;
    }
    file.finish().map_err(writing)?;
    Ok(points)
}

fn save(path: &Path, content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    content(&mut file)?;
    file.flush()
}

fn cannot_write(path: &Path, error: &io::Error) -> Failure {
    Failure::failed(texts::cannot_write(path, error))
}

fn unfinished(out: &Path) -> PathBuf {
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    out.with_file_name(format!(".{name}.unfinished"))
}

/// Path of the world file, from which geographic programs read the position of a PNG's pixels.
fn world_file(out: &Path) -> PathBuf {
    out.with_extension("pgw")
}

fn format_of(path: &Path) -> Option<Format> {
    let ending = path.extension()?.to_string_lossy();
    Format::from_str(&ending, true).ok()
}

fn not_negative(text: &str) -> Result<f32, String> {
    let value: f32 = text.parse().map_err(|_| texts::METRES_EXPECTED.to_owned())?;
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(texts::POSITIVE_METRES_EXPECTED.to_owned())
    }
}

fn pixel_size(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| texts::METRES_EXPECTED.to_owned())?;
    let sizes = 0.001..=100.0;
    if sizes.contains(&value) { Ok(value) } else { Err(texts::PIXEL_SIZE_EXPECTED.to_owned()) }
}

fn heights(text: &str) -> Result<Heights, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|word| word.trim().parse().ok()).collect();
    match numbers[..] {
        [from, to] if from < to => Ok(Heights { from, to }),
        _ => Err(texts::HEIGHTS_EXPECTED.to_owned()),
    }
}
