//! `autoinspect info`: describes a recording and its missing inputs, or a saved map.

use crate::failure::Failure;
use crate::{output, summaries};
use api::MapSummary;
use clap::Args;
use recorder::{Recording, RecordingInfo, TopicSelection};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Describe a recording and its missing inputs, or a saved map.
#[derive(Args, Debug)]
#[command(after_help = "EXAMPLES:
  autoinspect info recording.mcap
  autoinspect info bag_folder --json
  autoinspect info scans/            a folder of PCD, PLY or KITTI .bin files")]
pub struct InfoArgs {
    /// A recording (MCAP, ROS 1 bag, rosbag2), a folder of scans, or a map made by `map` or `up`.
    file: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs `autoinspect info`.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let map = args.file.join("map.json");
    if map.is_file() {
        return describe_map(args, &map);
    }
    let recording = Recording::open(&args.file, &TopicSelection::default()).map_err(Failure::usage)?;
    let info = recording.info();
    output::print_human(args.json, &describe(&info));
    output::print_json(args.json, &info)
}

fn describe_map(args: &InfoArgs, path: &Path) -> Result<(), Failure> {
    let bytes = std::fs::read(path).map_err(|error| Failure::unreadable(path, error))?;
    let map: MapSummary = serde_json::from_slice(&bytes).map_err(|error| Failure::unreadable(path, error))?;
    output::print_human(args.json, &summaries::map(&args.file, &map));
    output::print_json(args.json, &map)
}

fn describe(info: &RecordingInfo) -> String {
    let mut text = summaries::recording(&info.path, &info.format, info.duration) + "\n";
    let width = info.topics.iter().map(|topic| topic.name.len()).max().unwrap_or(0);
    // Writing to a string cannot fail.
    for topic in &info.topics {
        let rate = topic.hz.map_or_else(String::new, |hz| format!("{hz:.1} Hz"));
        let role = topic.role.map_or("-", |role| role.name());
        let _ = writeln!(
            text,
            "  {:width$}  {:>8} {:>10}  {:<9} {}",
            topic.name, topic.count, rate, role, topic.type_name
        );
    }
    let sections = [
        (summaries::SENSORS, &info.sensors),
        (summaries::MISSING, &info.missing),
        (summaries::WARNINGS, &info.warnings),
    ];
    for (title, lines) in sections {
        if !lines.is_empty() {
            let _ = writeln!(text, "{title}:\n  {}", lines.join("\n  "));
        }
    }
    text.trim_end().to_owned()
}
