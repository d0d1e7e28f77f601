//! `autoinspect gauge`: reads the needle of a gauge from a picture.

mod dial_file;
mod document;
mod texts;

use crate::failure::Failure;
use crate::{output, picture_file};
use clap::Args;
use document::Document;
use gauges::{GaugeConfig, read_gauge};
use std::path::PathBuf;

/// Read the needle of a gauge from a picture.
#[derive(Args, Debug)]
#[command(
    after_help = "IMAGE is a JPEG, PNG or BMP file. FILE says for each gauge what was found once in the pictures of its camera; pixels count from the top left, angles are degrees
clockwise from up:

  {\"dials\": {\"boiler\": {
    \"centre\": [93.9, 97.1],       centre of the scale
    \"zero_tick\": [30.1, 160.9],   lower end of the scale
    \"end_tick\": [157.7, 160.9],   upper end; without one the scale is a full turn
    \"range\": [0, 6],              values at both ends
    \"direction\": \"clockwise\",     or counterclockwise
    \"unit\": \"bar\",
    \"image_size\": [193, 193],     if given, pictures of other sizes are refused
    \"needle_axis\": [93.9, 97.1]}}}  where the needle turns, if that is not the centre

zero_angle_deg and end_angle_deg go before the directions of the ticks. The result is JSON: \"result\" is \"read\" with value and uncertainty (one standard
deviation), \"unsure\" with the reason, or \"too_small\".

EXAMPLES:
  autoinspect gauge boiler.jpg --gauge gauge.json --name boiler
  autoinspect gauge boiler.jpg --gauge gauge.json --name boiler --json"
)]
pub struct GaugeArgs {
    /// The picture.
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// File that describes the gauges.
    #[arg(long, value_name = "FILE")]
    gauge: PathBuf,
    /// Name of the gauge in FILE; not needed if there is only one.
    #[arg(long)]
    name: Option<String>,
    /// Print the JSON object in one line.
    #[arg(long)]
    json: bool,
}

/// Runs `autoinspect gauge`.
pub fn run(args: &GaugeArgs) -> Result<(), Failure> {
    let gauge = dial_file::read(&args.gauge, args.name.as_deref())?;
    let picture = picture_file::read(&args.image)?;
    if let Some(expected_px) = gauge.image_size_px.filter(|expected_px| *expected_px != picture.size_px()) {
        let sentence = texts::other_size(&args.image, picture.size_px(), &gauge.name, expected_px);
        return Err(Failure::usage(sentence));
    }
    let reading = read_gauge(&picture, &gauge.dial, &GaugeConfig::default())
        .map_err(|error| Failure::usage(texts::no_dial(&args.gauge, &gauge.name, &error)))?;
    let document = Document::new(&gauge, &reading);
    let pretty = serde_json::to_string_pretty(&document).map_err(Failure::failed)?;
    output::print_human(args.json, &pretty);
    output::print_json(args.json, &document)
}
