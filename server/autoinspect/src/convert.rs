//! `autoinspect convert`: writes a recording for other programs, or in less space.

use crate::failure::Failure;
use crate::{output, summaries};
use clap::{Args, ValueEnum};
use messages::{Input, Sensor};
use recorder::{Recording, RecordingMeta, RecordingWriter, ScanMessage, TopicSelection, WriterConfig};
use serde::Serialize;
use std::path::PathBuf;
use std::sync::Arc;

/// Write a recording as one MCAP file of ROS 2 messages, for other programs or in less space.
#[derive(Args, Debug)]
#[command(
    after_help = "The output holds the sensors, their mounting and the ground truth, but no journal, so it cannot be replayed.

EXAMPLES:
  autoinspect convert data/recordings/2026-11-21T10-36-22.000Z --out walk.mcap   PointCloud2 for ROS
  autoinspect convert walk.mcap --scans range-image --out small.mcap             a tenth of the size, 4 mm of range"
)]
pub struct ConvertArgs {
    /// A recording of any kind, or the folder of a run.
    file: PathBuf,
    /// The file to write.
    #[arg(long)]
    out: PathBuf,
    /// How scans are written.
    #[arg(long, value_enum, default_value_t = ScanKind::PointCloud2)]
    scans: ScanKind,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// How scans are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ScanKind {
    /// `sensor_msgs/PointCloud2`, which every ROS program reads.
    #[value(name = "pointcloud2")]
    PointCloud2,
    /// Compressed range images of this program, after moving each point onto the grid of the sensor.
    RangeImage,
}

/// The result.
#[derive(Debug, Default, Serialize)]
struct Converted {
    messages: u64,
    scans: u64,
    unreadable: u64,
    bytes: u64,
}

/// Runs `autoinspect convert`.
pub fn run(args: &ConvertArgs) -> Result<(), Failure> {
    let recording = Recording::open(&args.file, &TopicSelection::default()).map_err(Failure::usage)?;
    let meta = RecordingMeta { origin: args.file.display().to_string(), ..RecordingMeta::default() };
    let scans = match args.scans {
        ScanKind::PointCloud2 => ScanMessage::PointCloud2,
        ScanKind::RangeImage => ScanMessage::RangeImage,
    };
    let config = WriterConfig { scans, ..WriterConfig::default() };
    let truth = recording.truth().map_err(Failure::usage)?.unwrap_or_default();
    let mut writer = RecordingWriter::create_with(&args.out, &meta, &recording.mounting(), &config)
        .map_err(Failure::failed)?;
    let mut truth = truth.into_iter().peekable();
    let mut converted = Converted::default();
    for message in recording.inputs() {
        let Ok((at, mut sensor)) = message else {
            converted.unreadable += 1;
            continue;
        };
        while let Some((at, pose)) = truth.next_if(|(stamp, _)| *stamp <= at) {
            writer.truth(at, &pose).map_err(Failure::failed)?;
        }
        if let Sensor::Scan(scan) = &mut sensor {
            converted.scans += 1;
            if args.scans == ScanKind::RangeImage {
                scan_codec::quantise(Arc::make_mut(scan));
            }
        }
        converted.messages += 1;
        writer.input(at, &Input::Sensor(sensor)).map_err(Failure::failed)?;
    }
    writer.finish().map_err(Failure::failed)?;
    let written = std::fs::metadata(&args.out).map_err(|error| Failure::unreadable(&args.out, error))?;
    converted.bytes = written.len();
    let Converted { messages, scans, unreadable, bytes } = converted;
    output::print_human(args.json, &summaries::converted(&args.out, messages, scans, bytes, unreadable));
    output::print_json(args.json, &converted)
}
