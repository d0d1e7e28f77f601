//! `autoinspect patch`: makes a new version of a map with the changes in later recordings. It is kept if localisation in it is not worse.

mod check;
mod distance_trigger;
mod revisits;

use crate::failure::Failure;
use crate::inputs::{self, InputArgs, InputReader};
use crate::localise::offline_localiser::OfflineLocaliser;
use crate::map_version::{
    ChangeCounts, Fitness, NewVersion, RegressionConfig, find_regression, write_version,
};
use crate::{map, output, summaries, texts};
use check::measure_fitness;
use clap::Args;
use distance_trigger::DistanceTrigger;
use geometry::{Isometry, isometry_from_pose};
use mapping::map_changes::{MapChangesConfig, RevisitScan};
use messages::CorrectedScan;
use points::Downsampler;
use revisits::Revisits;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use store::SavedMap;
use vocab::MapId;

/// Make a new version of a map with the changes that later recordings show: racks removed or moved, new walls, open doors.
#[derive(Args, Debug)]
#[command(
    after_help = "INPUT is what `autoinspect map` takes: later walks through the map. Each is localised in it. Points that several scans saw through are removed
from the map's keyframes; points that several scans saw in free space are added. People who walk by are neither removed nor added. Keyframes keep their
poses. Then the robot of every recording is localised in both versions. If it is localised worse in the new version, the new version is removed again and the
exit code is 1. Patching adds no ground that the map does not show; extending the map does.

EXAMPLES:
  autoinspect patch monday.mcap tuesday.mcap --map m --out m2
  autoinspect patch monday.mcap --check tuesday.mcap --map m --out m2 --json"
)]
pub struct PatchArgs {
    #[command(flatten)]
    inputs: InputArgs,
    /// Folder of the map: the result of `autoinspect map`, `merge` or `import`, or one of the folders in a data directory's maps/.
    #[arg(long)]
    map: PathBuf,
    /// Folder for the new version; the results of an earlier run are replaced.
    #[arg(long)]
    out: PathBuf,
    /// Name of the new version [default: the map's name].
    #[arg(long)]
    name: Option<String>,
    /// Another recording to compare the versions with. The new version is not made of it.
    #[arg(long, value_name = "RECORDING")]
    check: Vec<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// The changes, and the quality of localisation before and after them.
#[derive(Debug, Serialize)]
struct Report {
    out: PathBuf,
    map: MapId,
    /// The version that was patched.
    patched: MapId,
    /// Number of scans that were compared with the map, one for each metre walked.
    compared_scans: u64,
    #[serde(flatten)]
    changes: ChangeCounts,
    points: u64,
    /// Localisation of all recordings in the patched version.
    before: Fitness,
    /// Localisation of all recordings in the new version.
    after: Fitness,
}

/// Runs `autoinspect patch`.
pub fn run(args: &PatchArgs) -> Result<(), Failure> {
    let saved = SavedMap::read(&args.map).map_err(Failure::usage)?;
    if map::is_same_folder(&args.out, &args.map) {
        return Err(Failure::usage(texts::result_is_input(&args.out)));
    }
    args.inputs.open_these(&args.check)?;
    let scans = localised_scans(args)?;
    if scans.is_empty() {
        return Err(Failure::failed(texts::robot_not_found(&args.map)));
    }
    map::prepare(&args.out)?;
    let name = args.name.as_deref().unwrap_or(&saved.summary.name);
    let coordinates = scans.iter().flat_map(|scan| scan.map_from_base.translation.vector.data.0[0]);
    let version = NewVersion::new(&saved, name, saved.summary.created, coordinates);
    let (files, changes) = write_version(&saved, &mut Revisits::new(&saved, &scans), &version, &args.out)?;
    let compared = compare_versions(args);
    if compared.is_err() {
        fs::remove_dir_all(&args.out).map_err(Failure::failed)?;
    }
    let (before, after) = compared?;
    let report = Report {
        out: args.out.clone(),
        map: files.id,
        patched: saved.summary.id,
        compared_scans: scans.len() as u64,
        changes,
        points: files.points,
        before,
        after,
    };
    store::write_json(&args.out.join("summary.json"), &report).map_err(Failure::failed)?;
    output::print_human(args.json, &describe(&report));
    output::print_json(args.json, &report)
}

/// Quality of localisation of all recordings in both versions.
///
/// # Errors
/// When the new version is worse, or a file cannot be read.
fn compare_versions(args: &PatchArgs) -> Result<(Fitness, Fitness), Failure> {
    let recordings: Vec<PathBuf> = args.inputs.inputs.iter().chain(&args.check).cloned().collect();
    let measure = |map: &Path| measure_fitness(map, &args.inputs, &recordings);
    let (before, after) = (measure(&args.map)?, measure(&args.out)?);
    match find_regression(&before, &after, &RegressionConfig::default()) {
        Some(reason) => Err(Failure::failed(texts::version_is_worse(&reason))),
        None => Ok((before, after)),
    }
}

/// Scans of all recordings that were localised, chosen by a [`DistanceTrigger`].
fn localised_scans(args: &PatchArgs) -> Result<Vec<RevisitScan>, Failure> {
    let known = Arc::new(runtime::known_map(&args.map).map_err(Failure::usage)?);
    let config = MapChangesConfig::default();
    let (mut scans, mut downsampler) = (Vec::new(), Downsampler::default());
    for path in &args.inputs.inputs {
        let recordings = args.inputs.open_these(std::slice::from_ref(path))?;
        let (boot, duration) = (args.inputs.boot(&recordings)?, inputs::duration(&recordings));
        let lidar = boot.mounting.base_from_lidar.as_ref().and_then(isometry_from_pose);
        let sensor = lidar.unwrap_or_else(Isometry::identity).translation.vector.map(|c| c as f32).into();
        let mut distance_trigger = DistanceTrigger::default();
        let mut on_scan = |scan: &CorrectedScan| {
            let Some(pose) = isometry_from_pose(&scan.map_from_base) else { return };
            if distance_trigger.is_due(&pose) {
                let (xyz, intensity) = (&scan.cloud.xyz, &scan.cloud.intensity);
                scans.push(RevisitScan::new(pose, xyz, intensity, sensor, &mut downsampler, &config));
            }
        };
        OfflineLocaliser::new(Arc::clone(&known), None, &mut on_scan).run(
            boot,
            InputReader::start(recordings)?,
            duration,
        );
    }
    Ok(scans)
}

fn describe(report: &Report) -> String {
    let Report { out, changes, before, after, .. } = report;
    let fitness = |fitness: &Fitness| {
        let Fitness { scans, localised, lost, fit, contradicted, .. } = *fitness;
        summaries::fit(scans, localised, lost, fit, contradicted)
    };
    let ChangeCounts { removed, added, keyframes_changed, keyframes, .. } = *changes;
    let patched = summaries::patched(out, removed, added, keyframes_changed, keyframes);
    [patched, summaries::fits(&fitness(before), &fitness(after))].join("\n")
}
