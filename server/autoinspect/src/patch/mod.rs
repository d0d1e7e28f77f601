//! `autoinspect patch`: a new version of a map, with what later recordings found changed, if the robot is localised by it no worse.

mod check;
mod version;

use crate::failure::Failure;
use crate::inputs::{self, InputArgs, Reader};
use crate::localise::offline_localiser::OfflineLocaliser;
use crate::{map, output};
use check::{Fitness, fitness, worse};
use clap::Args;
use geometry::{Isometry, isometry_from_pose};
use mapping::map_changes::{MapChangesConfig, RevisitScan};
use messages::CorrectedScan;
use points::Downsampler;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use store::SavedMap;
use version::{Changes, write_version};
use vocab::MapId;

/// A look for so many metres walked.
const LOOK_DISTANCE_M: f64 = 1.0;

/// Make a new version of a map with what later recordings found changed: racks gone or moved, new walls, open doors.
#[derive(Args, Debug)]
#[command(
    after_help = "INPUT is what `autoinspect map` takes: later walks through the map, each localised in it. What several scans looked through is taken
out of its keyframes, what several met where the map shows nothing is put in; people who walk by are neither. Keyframes stay where they are, and so does all
that is attached to them. Then the robot of every recording is localised in both versions: if it is localised less often, or by less, in the new one, that is
removed again and the exit code is 1. Ground that the map does not show is added by extending it instead.

EXAMPLES:
  autoinspect patch monday.mcap tuesday.mcap --map m --out m2
  autoinspect patch monday.mcap --check tuesday.mcap --map m --out m2 --json"
)]
pub struct PatchArgs {
    #[command(flatten)]
    inputs: InputArgs,
    /// Folder of the map: what `autoinspect map`, `merge` or `import` wrote, or one of the folders in a data directory's maps/.
    #[arg(long)]
    map: PathBuf,
    /// Folder for the new version; what an earlier run left there is replaced.
    #[arg(long)]
    out: PathBuf,
    /// Name of the new version; the map's if none is given.
    #[arg(long)]
    name: Option<String>,
    /// Another recording by which the versions are compared, and not made.
    #[arg(long, value_name = "RECORDING")]
    check: Vec<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What was changed, and what that is good for.
#[derive(Debug, Serialize)]
struct Report {
    out: PathBuf,
    map: MapId,
    /// The version before.
    patched: MapId,
    /// Scans by which was judged, one for each metre walked.
    looks: u64,
    #[serde(flatten)]
    changes: Changes,
    points: u64,
    /// The robot of all recordings, localised in the version before and in the new one.
    before: Fitness,
    after: Fitness,
}

/// Chooses scans that lie apart along a walk.
#[derive(Debug, Default)]
struct DistanceTrigger {
    last: Option<Isometry>,
}

impl DistanceTrigger {
    fn is_due(&mut self, pose: &Isometry) -> bool {
        let step = |last: &Isometry| (last.translation.vector - pose.translation.vector).norm();
        let due = self.last.as_ref().is_none_or(|last| step(last) >= LOOK_DISTANCE_M);
        if due {
            self.last = Some(*pose);
        }
        due
    }
}

/// Runs `autoinspect patch`.
pub fn run(args: &PatchArgs) -> Result<(), Failure> {
    let saved = SavedMap::read(&args.map).map_err(Failure::usage)?;
    if map::is_same_folder(&args.out, &args.map) {
        let sentence = format!("{} is the map itself; choose another folder", args.out.display());
        return Err(Failure::usage(sentence));
    }
    args.inputs.open_these(&args.check)?;
    let looks = looks(args)?;
    if looks.is_empty() {
        return Err(Failure::failed(format!("the robot was not found in {}", args.map.display())));
    }
    map::prepare(&args.out)?;
    let name = args.name.as_deref().unwrap_or(&saved.summary.name);
    let (files, changes) = write_version(&saved, &looks, &args.out, name)?;
    let judged = judge(args);
    if judged.is_err() {
        fs::remove_dir_all(&args.out).map_err(Failure::failed)?;
    }
    let (before, after) = judged?;
    let report = Report {
        out: args.out.clone(),
        map: files.id,
        patched: saved.summary.id,
        looks: looks.len() as u64,
        changes,
        points: files.points,
        before,
        after,
    };
    store::write_json(&args.out.join("summary.json"), &report).map_err(Failure::failed)?;
    output::print_human(args.json, &describe(&report));
    output::print_json(args.json, &report)
}

/// How well the robot of each recording is localised in the version before and in the new one, if that is no worse.
fn judge(args: &PatchArgs) -> Result<(Fitness, Fitness), Failure> {
    let recordings: Vec<PathBuf> = args.inputs.inputs.iter().chain(&args.check).cloned().collect();
    let compare = |map: &Path| fitness(map, &args.inputs, &recordings);
    let (before, after) = (compare(&args.map)?, compare(&args.out)?);
    match worse(&before, &after) {
        Some(reason) => Err(Failure::failed(format!("the new version is worse and was not kept: {reason}"))),
        None => Ok((before, after)),
    }
}

/// What the robots of all recordings saw where they were localised.
fn looks(args: &PatchArgs) -> Result<Vec<RevisitScan>, Failure> {
    let known = Arc::new(runtime::known_map(&args.map).map_err(Failure::usage)?);
    let (mut looks, mut downsampler) = (Vec::new(), Downsampler::default());
    for path in &args.inputs.inputs {
        let recordings = args.inputs.open_these(std::slice::from_ref(path))?;
        let (boot, duration) = (args.inputs.boot(&recordings)?, inputs::duration(&recordings));
        let lidar = boot.mounting.base_from_lidar.as_ref().and_then(isometry_from_pose);
        let sensor = lidar.unwrap_or_else(Isometry::identity).translation.vector.map(|c| c as f32).into();
        let mut look_trigger = DistanceTrigger::default();
        let mut witness = |scan: &CorrectedScan| {
            let Some(pose) = isometry_from_pose(&scan.map_from_base) else { return };
            if look_trigger.is_due(&pose) {
                let (xyz, intensity) = (&scan.cloud.xyz, &scan.cloud.intensity);
                let config = MapChangesConfig::default();
                looks.push(RevisitScan::new(pose, xyz, intensity, sensor, &mut downsampler, &config));
            }
        };
        OfflineLocaliser::new(Arc::clone(&known), None, &mut witness).run(
            boot,
            Reader::start(recordings)?,
            duration,
        );
    }
    Ok(looks)
}

fn describe(report: &Report) -> String {
    let Report { out, changes, before, after, .. } = report;
    let fitness = |fitness: &Fitness| {
        format!(
            "{} of {} scans localised, lost {} time(s), what is seen fits by {:.3} and is contradicted by {:.3}",
            fitness.localised, fitness.scans, fitness.lost, fitness.fit, fitness.contradicted
        )
    };
    format!(
        "{}: {} points gone and {} come, in {} of {} keyframes\nbefore: {}\nafter: {}",
        out.display(),
        changes.gone,
        changes.come,
        changes.keyframes_changed,
        changes.keyframes,
        fitness(before),
        fitness(after)
    )
}
