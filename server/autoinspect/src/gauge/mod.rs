//! `autoinspect gauge`: reads the needle of a gauge from a picture.

mod document;
mod texts;

use crate::failure::Failure;
use crate::limited_command::LimitedCommand;
use crate::process_limits::ProcessLimits;
use crate::{output, picture_file};
use clap::Args;
use gauge_file::Gauge;
use gauges::{GaugeConfig, Picture, read_gauge, read_slanted_gauge};
use picture_changes::{PictureAlignmentConfig, align_pictures, mapped_dial, mapped_marks};
use std::path::{Path, PathBuf};
use std::{fs, io};

pub use document::{Document, Reading};

/// Read the needle of a gauge from a picture.
#[derive(Args, Debug)]
#[command(
    after_help = "IMAGE is a JPEG, PNG or BMP file. FILE says for each gauge what was found once in the pictures of its camera; pixels count from the top left, angles are degrees
clockwise from up:

  {\"dials\": {\"boiler\": {
    \"centre\": [93.9, 97.1],       centre of the scale
    \"zero_tick\": [30.1, 160.9],   lower end of the scale
    \"mid_tick\": [93.9, 6.9],      half way between both ends; with it, a dial that is seen from the side is read as if from the front
    \"end_tick\": [157.7, 160.9],   upper end; without one the scale is a full turn
    \"range\": [0, 6],              values at both ends
    \"direction\": \"clockwise\",     or counterclockwise
    \"unit\": \"bar\",
    \"image_size\": [193, 193],     if given, pictures of other sizes are refused
    \"needle_axis\": [93.9, 97.1]}}}  where the needle turns, if that is not the centre

zero_angle_deg and end_angle_deg go before the directions of the ticks. The result is JSON: \"result\" is \"read\" with value and uncertainty (one standard
deviation), \"unsure\" with the reason, \"too_small\", or \"not_aligned\" with the reason.

With --described-in, the pixels of FILE are those of another picture of the gauge, PICTURE, with which IMAGE is aligned first, as `autoinspect picture-changes` does. So a
camera that a robot carries needs one description for all its visits.

EXAMPLES:
  autoinspect gauge boiler.jpg --gauge gauge.json --name boiler
  autoinspect gauge boiler.jpg --gauge gauge.json --name boiler --json
  autoinspect gauge tuesday.jpg --gauge gauge.json --described-in monday.jpg"
)]
pub struct GaugeArgs {
    /// The picture.
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// File that describes the gauges; - is standard input.
    #[arg(long, value_name = "FILE")]
    gauge: PathBuf,
    /// Name of the gauge in FILE; not needed if there is only one.
    #[arg(long)]
    name: Option<String>,
    /// Picture in which the gauge was described, if that is not IMAGE.
    #[arg(long, value_name = "PICTURE")]
    described_in: Option<PathBuf>,
    /// Print the JSON object in one line.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: ProcessLimits,
}

/// Runs `autoinspect gauge`.
pub fn run(args: &GaugeArgs) -> Result<(), Failure> {
    if let Some(result) = args.limits.enter(LimitedCommand::Gauge) {
        return result;
    }
    let gauge = description(&args.gauge, args.name.as_deref())?;
    let picture = picture_file::read(&args.image)?;
    let document = match &args.described_in {
        None => {
            check_size(&args.image, &picture, &gauge)?;
            read(&args.gauge, &gauge, &picture)?
        }
        Some(described_in) => read_aligned(args, &gauge, &picture, described_in)?,
    };
    let pretty = serde_json::to_string_pretty(&document).map_err(Failure::failed)?;
    output::print_human(args.json, &pretty);
    output::print_json(args.json, &document)
}

/// The gauge of this name in a file, or its only one. `-` is the standard input.
fn description(path: &Path, name: Option<&str>) -> Result<Gauge, Failure> {
    let text =
        if path == Path::new("-") { io::read_to_string(io::stdin()) } else { fs::read_to_string(path) };
    let text = text.map_err(|error| Failure::unreadable(path, error))?;
    gauge_file::parse(&text, name).map_err(|error| Failure::usage(texts::no_gauge(path, &error)))
}

/// Reads a gauge that was described in this picture, or mapped to it.
fn read(description: &Path, gauge: &Gauge, picture: &Picture) -> Result<Document, Failure> {
    let config = GaugeConfig::default();
    let reading = match &gauge.marks {
        Some(marks) => read_slanted_gauge(picture, marks, &config),
        None => read_gauge(picture, &gauge.dial, &config),
    };
    let reading =
        reading.map_err(|error| Failure::usage(texts::no_dial(description, &gauge.name, &error)))?;
    Ok(Document::new(gauge, &reading))
}

/// Reads a gauge that was described in another picture.
fn read_aligned(
    args: &GaugeArgs,
    gauge: &Gauge,
    picture: &Picture,
    described_in: &Path,
) -> Result<Document, Failure> {
    let before = picture_file::read(described_in)?;
    check_size(described_in, &before, gauge)?;
    if before.size_px() != picture.size_px() {
        let size_px = before.size_px();
        return Err(Failure::usage(texts::other_size(&args.image, picture.size_px(), &gauge.name, size_px)));
    }
    let alignment = match align_pictures(&before, picture, None, &PictureAlignmentConfig::default()) {
        Ok(alignment) => alignment,
        Err(reason) => return Ok(Document::not_aligned(gauge, &reason)),
    };
    let mapping = &alignment.after_from_before;
    let marks = gauge.marks.as_ref().map(|marks| mapped_marks(marks, mapping));
    let (Some(dial), Some(marks)) =
        (mapped_dial(&gauge.dial, mapping), marks.map_or(Some(None), |it| it.map(Some)))
    else {
        return Ok(Document::not_aligned(gauge, &texts::DIAL_BEHIND_CAMERA));
    };
    let mapped = Gauge { dial, marks, ..gauge.clone() };
    Ok(read(&args.gauge, &mapped, picture)?.with_residual(alignment.residual_px))
}

/// Refuses a picture of another size than those in which the gauge was described.
fn check_size(path: &Path, picture: &Picture, gauge: &Gauge) -> Result<(), Failure> {
    match gauge.image_size_px.filter(|expected_px| *expected_px != picture.size_px()) {
        Some(expected_px) => {
            let sentence = texts::other_size(path, picture.size_px(), &gauge.name, expected_px);
            Err(Failure::usage(sentence))
        }
        None => Ok(()),
    }
}
