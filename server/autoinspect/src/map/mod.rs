//! `autoinspect map`: makes a map from recordings with the stack that runs on the robot, as fast as possible.

pub mod offline_mapper;
mod summary;

use crate::failure::Failure;
use crate::inputs::{self, InputArgs, InputReader};
use crate::journal::McapJournal;
use crate::process;
use crate::{output, texts};
use clap::Args;
use messages::BootRecord;
use offline_mapper::{MappingRun, OfflineMapper, SESSION};
use ports::Journal;
use recorder::{RecordingMeta, RecordingWriter};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;
use store::{MapFileOptions, MapFilesReport, TileFiles, write_map_files};
use summary::{MappingReport, Stage};

/// Make a map from recordings or folders of scans.
#[derive(Args, Debug)]
#[command(
    after_help = "INPUT is a recording (MCAP, ROS 1 bag, rosbag2) or a folder of scans (PCD, PLY, KITTI .bin) in
name order. OUT gets trajectory.tum, graph.g2o, loops.json, clouds/, map.ply, tiles/, tiles.json and summary.json.

EXAMPLES:
  autoinspect map recording.mcap --out m
  autoinspect map recording.mcap --out m --sources lidar,imu --json
  autoinspect map scans/ --out m
  autoinspect map bag/ --out m --topic lidar=/os_cloud_node/points"
)]
pub struct MapArgs {
    #[command(flatten)]
    inputs: InputArgs,
    /// Folder for the results; those of an earlier run are replaced.
    #[arg(long)]
    out: PathBuf,
    /// Close no loops: the map is made by odometry alone.
    #[arg(long)]
    no_loops: bool,
    /// Name of the map.
    #[arg(long, default_value = "Map")]
    name: String,
    /// Also write every input of the stack to this file, for `autoinspect replay`, and print the fingerprint.
    #[arg(long)]
    journal: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs `autoinspect map`.
pub fn run(args: &MapArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let recordings = args.inputs.open()?;
    let mut boot = args.inputs.boot(&recordings)?;
    (boot.start_mapping, boot.leave_loops_open) = (Some(SESSION), args.no_loops);
    let journal = args.journal.as_deref().map(|path| journal(path, &boot)).transpose()?;
    prepare(&args.out)?;

    process::reset_peak_memory();
    let duration = inputs::duration(&recordings);
    let offline = OfflineMapper::new(args.out.join("clouds"), journal);
    let mapped = offline.run(boot, InputReader::start(recordings)?, args.name.clone(), duration)?;
    let mapping_memory = process::peak_memory();

    process::reset_peak_memory();
    let tiles = TileFiles::new(args.out.join("tiles"));
    let files = write_map_files(
        &args.out,
        &tiles,
        &mapped.finished,
        MapFileOptions { ply: true, ..MapFileOptions::default() },
    )
    .map_err(Failure::failed)?;
    let stages = stages(&mapped, &files, mapping_memory, process::peak_memory());
    let summary = MappingReport::new(&args.inputs.inputs, &mapped, &files, stages, start.elapsed());
    summary.write(&args.out.join("summary.json"))?;
    output::print_human(args.json, &summary.describe(&args.out));
    output::print_json(args.json, &summary)
}

fn journal(path: &Path, boot: &BootRecord) -> Result<Box<dyn Journal>, Failure> {
    let meta = RecordingMeta {
        robot: boot.profile.name.clone(),
        origin: "autoinspect map".to_owned(),
        segment: None,
    };
    let writer = RecordingWriter::create(path, &meta, &boot.mounting).map_err(Failure::failed)?;
    Ok(Box::new(McapJournal(writer)))
}

/// Whether both paths exist and are the same folder.
pub(crate) fn is_same_folder(a: &Path, b: &Path) -> bool {
    fs::canonicalize(a).is_ok_and(|a| Some(a) == fs::canonicalize(b).ok())
}

/// Creates the folder for the results. Removes only the results of an earlier run.
pub(crate) fn prepare(out: &Path) -> Result<(), Failure> {
    let cannot = |error: std::io::Error| Failure::failed(texts::cannot_write(out, &error));
    let foreign = out.is_dir()
        && !out.join("summary.json").exists()
        && fs::read_dir(out)
            .map_err(cannot)?
            .any(|entry| entry.is_ok_and(|entry| entry.file_name() != "clouds"));
    if foreign {
        return Err(Failure::usage(texts::folder_in_use(out)));
    }
    // map.json is removed first, because it marks a map as complete.
    match fs::remove_file(out.join("map.json")) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(cannot(error)),
        _ => {}
    }
    for name in ["clouds", "tiles"] {
        match fs::remove_dir_all(out.join(name)) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(cannot(error)),
            _ => {}
        }
    }
    fs::create_dir_all(out.join("clouds")).map_err(cannot)
}

fn stages(
    mapped: &MappingRun,
    files: &MapFilesReport,
    mapping_memory: u64,
    saving_memory: u64,
) -> Vec<Stage> {
    let stage = |name, seconds: std::time::Duration, peak_memory_bytes| Stage {
        name,
        seconds: seconds.as_secs_f64(),
        peak_memory_bytes,
    };
    vec![
        stage("read", mapped.read_time, mapping_memory),
        stage("map", mapped.step_time, mapping_memory),
        stage("loops", mapped.loop_time, mapping_memory),
        stage("clouds", mapped.cloud_time, mapping_memory),
        stage("merge", files.merge_time, saving_memory),
        stage("tiles", files.tile_time, saving_memory),
        stage("write", files.write_time, saving_memory),
    ]
}
