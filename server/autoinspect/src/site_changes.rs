//! What is changed at a simulated site: a script, random changes, and the truth for scorers. And `autoinspect sim list`, which says what can change.

use crate::failure::Failure;
use crate::{output, summaries, texts};
use clap::Args;
use serde::Serialize;
use sim::{ConditionChangesConfig, SimulatedSite};
use site_files::{SiteChanges, SiteSource};
use std::path::PathBuf;
use std::sync::Arc;

/// Which changes are made.
#[derive(Args, Clone, Debug, Default)]
pub struct SiteChangeArgs {
    /// Make the changes of this JSON file at the simulated site: doors at other angles, leaks, gauges that drift or are stuck, lamps that are out, objects that are put.
    #[arg(long, value_name = "FILE")]
    pub changes: Option<PathBuf>,
    /// Make this many random changes of doors, floors, gauges and lamps at the simulated site. The same day gives the same changes; without --day, the same seed.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    pub random_changes: Option<u32>,
    /// Write what was changed to this JSON file, for scoring. It can be given to --changes again.
    #[arg(long, value_name = "FILE")]
    pub truth_changes: Option<PathBuf>,
}

impl SiteChangeArgs {
    /// Whether something is to be changed, or told.
    pub fn is_given(&self) -> bool {
        self.changes.is_some() || self.random_changes.is_some() || self.truth_changes.is_some()
    }

    /// The same as arguments of a child process.
    pub fn to_arguments(&self) -> impl Iterator<Item = (&'static str, String)> {
        let path = |path: &PathBuf| path.display().to_string();
        let changes = self.changes.as_ref().map(|file| ("--changes", path(file)));
        let random = self.random_changes.map(|count| ("--random-changes", count.to_string()));
        let truth = self.truth_changes.as_ref().map(|file| ("--truth-changes", path(file)));
        [changes, random, truth].into_iter().flatten()
    }

    /// The changed site; the truth is written if it is asked for.
    pub fn apply(&self, site: Arc<SimulatedSite>, seed: u64) -> Result<Arc<SimulatedSite>, Failure> {
        if !self.is_given() {
            return Ok(site);
        }
        let mut changed = (*site).clone();
        if let Some(file) = &self.changes {
            let changes = SiteChanges::read(file).map_err(Failure::usage)?;
            let explain = |reason: String| Failure::usage(texts::unreadable_input(file, &reason));
            changed = changes.apply(&changed).map_err(explain)?;
        }
        if let Some(count) = self.random_changes {
            let config = ConditionChangesConfig::default();
            let random = changed.random_condition_changes(seed, count as usize, &config);
            changed = changed.with_condition_changes(&random).map_err(Failure::failed)?;
        }
        if let Some(file) = &self.truth_changes {
            SiteChanges::of(&changed).write(file).map_err(Failure::failed)?;
        }
        Ok(Arc::new(changed))
    }
}

/// List what can change at a simulated site: doors, gauges and lamps.
#[derive(Args, Debug)]
#[command(after_help = "EXAMPLE:\n  autoinspect sim list --site b1")]
pub struct ListArgs {
    /// Site: b1, torus, plant, twins, generated:SEED, or a building as FILE.glb.
    #[arg(long)]
    site: SiteSource,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What can change, for people and programs. Site frame, metres.
#[derive(Debug, Serialize)]
struct Listed {
    /// Hinges.
    doors: Vec<[f64; 3]>,
    gauges: Vec<ListedGauge>,
    lamps: Vec<[f64; 3]>,
}

/// A gauge that can drift or be stuck.
#[derive(Debug, Serialize)]
struct ListedGauge {
    tag: String,
    unit: &'static str,
    /// Values at the ends of its scale.
    scale: [f64; 2],
    at_m: [f64; 3],
}

/// Runs `autoinspect sim list`.
pub fn list(args: &ListArgs) -> Result<(), Failure> {
    let things = args.site.load().map_err(Failure::usage)?.changeable_things();
    let gauges = things.gauges.into_iter().map(|gauge| ListedGauge {
        tag: gauge.tag,
        unit: gauge.unit,
        scale: gauge.scale,
        at_m: gauge.place.to_array(),
    });
    let listed = Listed {
        gauges: gauges.collect(),
        doors: things.doors.iter().map(|hinge| hinge.to_array()).collect(),
        lamps: things.lamps.iter().map(|lamp| lamp.to_array()).collect(),
    };
    let doors = listed.doors.iter().map(|hinge| summaries::changeable_door(*hinge));
    let gauges = listed.gauges.iter();
    let gauges = gauges.map(|it| summaries::changeable_gauge(&it.tag, it.at_m, it.scale, it.unit));
    let lamps = listed.lamps.iter().map(|lamp| summaries::changeable_lamp(*lamp));
    let lines: Vec<String> = doors.chain(gauges).chain(lamps).collect();
    output::print_human(args.json, &lines.join("\n"));
    output::print_json(args.json, &listed)
}
