//! `autoinspect info`: what a recording holds, and what is missing.

use crate::failure::Failure;
use crate::output;
use clap::Args;
use recorder::{Recording, RecordingInfo, TopicSelection};
use std::fmt::Write;
use std::path::PathBuf;

/// Say what a recording holds, and what is missing.
#[derive(Args, Debug)]
#[command(after_help = "EXAMPLES:
  autoinspect info recording.mcap
  autoinspect info bag_folder --json
  autoinspect info scans/            a folder of PCD, PLY or KITTI .bin files")]
pub struct InfoArgs {
    /// A recording (MCAP, ROS 1 bag, rosbag2) or a folder of scans.
    file: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs `autoinspect info`.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let recording = Recording::open(&args.file, &TopicSelection::default()).map_err(Failure::usage)?;
    let info = recording.info();
    output::print_human(args.json, &describe(&info));
    output::print_json(args.json, &info)
}

fn describe(info: &RecordingInfo) -> String {
    let mut text = format!("{}: {}, {:.1} s\n", info.path, info.format, info.duration);
    let width = info.topics.iter().map(|topic| topic.name.len()).max().unwrap_or(0);
    // Writing to a string does not fail.
    for topic in &info.topics {
        let rate = topic.hz.map_or_else(String::new, |hz| format!("{hz:.1} Hz"));
        let meaning = topic.meaning.map_or("-", |meaning| meaning.name());
        let _ = writeln!(
            text,
            "  {:width$}  {:>8} {:>10}  {:<9} {}",
            topic.name, topic.count, rate, meaning, topic.type_name
        );
    }
    for (title, lines) in
        [("Sensors", &info.sensors), ("Missing", &info.missing), ("Complaints", &info.complaints)]
    {
        if !lines.is_empty() {
            let _ = writeln!(text, "{title}:\n  {}", lines.join("\n  "));
        }
    }
    text.trim_end().to_owned()
}
