//! `autoinspect localise`: localises a recorded robot in a known map with the stack that runs on the robot.

pub(crate) mod offline_localiser;

use crate::failure::Failure;
use crate::inputs::{self, InputArgs, InputReader};
use crate::{output, summaries, texts};
use clap::Args;
use messages::CorrectedScan;
use offline_localiser::OfflineLocaliser;
use serde::Serialize;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::{Pose, Quat, Stamp, Vec3};

/// Localise a recorded robot in a known map.
#[derive(Args, Debug)]
#[command(
    after_help = "INPUT is what `autoinspect map` takes. Without --initial the robot is localised by its scans alone. FILE gets a line for every localised
scan: stamp, then the pose of the base in the map.

EXAMPLES:
  autoinspect localise monday.mcap --map m --out monday.tum
  autoinspect localise monday.mcap --map m --out monday.tum --initial 2.5,-1,0,90 --json
  autoinspect trajectory compare truth.tum monday.tum"
)]
pub struct LocaliseArgs {
    #[command(flatten)]
    inputs: InputArgs,
    /// Folder of the map: the result of `autoinspect map`, `merge` or `import`, or one of the folders in a data directory's maps/.
    #[arg(long)]
    map: PathBuf,
    /// The trajectory to write, TUM.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Initial pose of the base in the map, metres and degrees of heading; within 1 m and 20 degrees of the truth.
    #[arg(long, value_name = "X,Y,Z,YAW", value_parser = initial, allow_hyphen_values = true)]
    initial: Option<Initial>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Initial pose of the base in the map.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Initial(Pose);

/// The result, for people and programs.
#[derive(Debug, Serialize)]
struct Report {
    out: PathBuf,
    scans: u64,
    /// Number of localised scans.
    localised: u64,
    /// Number of those with low confidence.
    #[serde(rename = "doubted")]
    low_confidence: u64,
    /// Number of times that tracking was lost.
    lost: u64,
    /// Time from the first scan to the first localised one, seconds; `None` if no scan was localised.
    found_after: Option<f64>,
    /// CPU time of the stack for each scan, odometry included, milliseconds.
    ms_per_scan: f64,
    ms_per_scan_p99: f64,
    /// CPU time of all global searches, milliseconds.
    ms_searching: f64,
}

/// Runs `autoinspect localise`.
pub fn run(args: &LocaliseArgs) -> Result<(), Failure> {
    let recordings = args.inputs.open()?;
    let known = runtime::known_map(&args.map).map_err(Failure::usage)?;
    let (boot, duration) = (args.inputs.boot(&recordings)?, inputs::duration(&recordings));
    let mut ignore = |_: &CorrectedScan| ();
    let localiser =
        OfflineLocaliser::new(Arc::new(known), args.initial.map(|Initial(pose)| pose), &mut ignore);
    let run = localiser.run(boot, InputReader::start(recordings)?, duration);
    write(&args.out, &run.trajectory)?;
    let mut ms: Vec<f64> = run.scan_seconds.iter().map(|seconds| seconds * 1e3).collect();
    ms.sort_by(f64::total_cmp);
    let report = Report {
        out: args.out.clone(),
        scans: run.scans,
        localised: run.trajectory.len() as u64,
        low_confidence: run.low_confidence,
        lost: run.lost,
        found_after: run.found_after,
        ms_per_scan: ms.iter().sum::<f64>() / ms.len().max(1) as f64,
        ms_per_scan_p99: ms.get(ms.len() * 99 / 100).copied().unwrap_or(0.0),
        ms_searching: run.search_time.as_secs_f64() * 1e3,
    };
    output::print_human(args.json, &describe(&report));
    output::print_json(args.json, &report)?;
    if report.localised == 0 {
        return Err(Failure::failed(texts::robot_not_found(&args.map)));
    }
    Ok(())
}

fn write(path: &Path, trajectory: &[(Stamp, Pose)]) -> Result<(), Failure> {
    let write = || {
        let mut out = BufWriter::new(File::create(path)?);
        formats::tum::write(&mut out, trajectory)?;
        out.flush()
    };
    write().map_err(|error| Failure::failed(texts::cannot_write(path, &error)))
}

fn describe(report: &Report) -> String {
    let Report { scans, localised, found_after, low_confidence, lost, .. } = *report;
    let localised = summaries::localised(&report.out, scans, localised, found_after, low_confidence, lost);
    let times = summaries::localise_times(report.ms_per_scan, report.ms_per_scan_p99, report.ms_searching);
    [localised, times].join("\n")
}

fn initial(text: &str) -> Result<Initial, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    let Ok(&[x, y, z, yaw]) = numbers.as_deref() else {
        return Err(texts::POSE_EXPECTED.to_owned());
    };
    if ![x, y, z, yaw].iter().all(|number| number.is_finite()) {
        return Err(texts::FINITE_EXPECTED.to_owned());
    }
    let half = 0.5 * yaw.to_radians();
    let orientation = Quat { w: half.cos(), x: 0.0, y: 0.0, z: half.sin() };
    Ok(Initial(Pose { position: Vec3::new(x, y, z), orientation }))
}
