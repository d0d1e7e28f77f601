//! Changes between two visits: sessions of a recorded hall into which boxes are put, for many seeds, depth images of a table, and visits of simulated sites.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod score;
mod sessions;
mod simulated;
mod table;
mod visit_cache;
mod visit_score;

use anyhow::{Result, ensure};
use changes::{ChangesConfig, detect_changes};
use clap::Parser;
use score::{POINTS_REQUIRED, SIZE_LIMITS_M, Score, score};
use sim::SiteName;
use std::path::PathBuf;

/// Changes between two visits, scored by what is known to have changed.
///
/// Examples: cargo xtask bench changes
///           cargo xtask bench changes --seeds 30 --explain
///           cargo xtask bench changes --simulated --visits 20 --sites b1,torus,plant
#[derive(Parser)]
struct Arguments {
    /// Folder with the data sets hilti-uzh-run2 and change-rgbd-tabletop.
    #[arg(long, default_value = "../shared/data")]
    data: PathBuf,
    /// First seed of the sessions.
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
    /// Number of pairs of sessions.
    #[arg(long, default_value_t = 10)]
    seeds: u64,
    /// Name what was not found and what should not have been named.
    #[arg(long)]
    explain: bool,
    /// Walk simulated sites instead.
    #[arg(long)]
    simulated: bool,
    /// Visits of each simulated site.
    #[arg(long, default_value_t = 5)]
    visits: u32,
    /// Simulated sites.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant")]
    sites: Vec<SiteName>,
    /// Changes between two simulated visits; 0 counts what is named although nothing has changed.
    #[arg(long, default_value_t = 5)]
    changes: usize,
    /// LiDAR columns per sweep of the simulated robot.
    #[arg(long, default_value_t = 2_000)]
    columns: u32,
    /// People who walk on simulated sites.
    #[arg(long, default_value_t = 3)]
    people: u32,
    /// Time of a simulated walk, seconds; left out, the robot walks the whole round of the site.
    #[arg(long)]
    walk_s: Option<f64>,
    /// Cast the sweeps of simulated visits from places along the whole round instead of running the stack, which takes seconds a visit.
    #[arg(long)]
    cast: bool,
    /// Folder in which the clouds of simulated walks are kept, so that they are walked once.
    #[arg(long)]
    cache: Option<PathBuf>,
    /// Fail if less than 90 % of the boxes that have to be found are, or an unchanged box is named.
    #[arg(long)]
    bar: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if arguments.simulated {
        return simulated(&arguments);
    }
    let total = lidar(&arguments)?;
    let tabletop = table::score(&arguments.data.join("change-rgbd-tabletop"))?;
    println!("\n| data set | have to be found | found | named | of them right | unchanged and named |");
    println!("| --- | --- | --- | --- | --- | --- |");
    println!(
        "| boxes in a hall, {} pairs of sessions | {} of at least {POINTS_REQUIRED} points | {} | {} | {} | {} of {} |",
        arguments.seeds,
        total.required,
        total.required_found,
        total.found + total.wrong,
        total.found,
        total.unchanged_named,
        total.unchanged
    );
    let [least_m, most_m] = SIZE_LIMITS_M;
    let names = [
        format!("below {least_m:.1} m"),
        format!("{least_m:.1} to {most_m:.1} m"),
        format!("{most_m:.1} m and more"),
    ];
    for (name, of_size) in names.iter().zip(&total.by_size) {
        println!("| – longest side {name} | {} | {} | – | – | – |", of_size.required, of_size.required_found);
    }
    println!(
        "| things on a table, {} pairs of images | {} | {} | {} | {} | – |",
        tabletop.pairs, tabletop.changed, tabletop.found, tabletop.named, tabletop.right
    );
    let is_met = 10 * total.required_found >= 9 * total.required && total.unchanged_named == 0;
    ensure!(is_met || !arguments.bar, "the bar is missed");
    Ok(())
}

/// The visits of all simulated sites.
fn simulated(arguments: &Arguments) -> Result<()> {
    let total = simulated::run(&simulated::Plan {
        sites: arguments.sites.clone(),
        visits: arguments.visits,
        changes: arguments.changes,
        seed: arguments.first_seed,
        columns: arguments.columns,
        people: arguments.people,
        walk_s: arguments.walk_s,
        explain: arguments.explain,
        cast: arguments.cast,
        cache: arguments.cache.clone(),
    })?;
    let share = |found: usize, of: usize| {
        format!("{found} of {of} ({:.1} %)", 100.0 * found as f64 / of.max(1) as f64)
    };
    println!(
        "\n| comparisons | found of 0.3 m and more | with those that were turned | named ones that are right | found of 0.15 m | moved ones matched | different ones named as moved | wrong a visit |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    println!(
        "| {} | {} | {} | {} | {} | {} | {} | {:.2} |",
        total.visits,
        share(total.large_found, total.large),
        share(total.large_found + total.turned_found, total.large + total.turned),
        share(total.right, total.right + total.wrong),
        share(total.small_found, total.small),
        share(total.matched, total.moved),
        total.wrongly_matched,
        total.wrong as f64 / total.visits.max(1) as f64
    );
    Ok(())
}

/// The sessions of all seeds, a row each.
fn lidar(arguments: &Arguments) -> Result<Score> {
    let hall = arguments.data.join("hilti-uzh-run2");
    let views = sessions::read_views(&hall.join("bag"), &hall.join("poses_refined_lidar.tum"))?;
    println!(
        "| seed | changed boxes | found | of those with {POINTS_REQUIRED} points | found | wrong | unchanged named |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    let mut total = Score::default();
    for seed in arguments.first_seed..arguments.first_seed + arguments.seeds {
        let sessions = sessions::make(&views, seed)?;
        let changes = detect_changes(&sessions.before, &sessions.after, &ChangesConfig::default());
        let mut notes = Vec::new();
        let of_seed = score(&changes.objects, &sessions.truth, |note| notes.push(note));
        println!(
            "| {seed} | {} | {} | {} | {} | {} | {} |",
            of_seed.changed,
            of_seed.found,
            of_seed.required,
            of_seed.required_found,
            of_seed.wrong,
            of_seed.unchanged_named
        );
        for note in notes.iter().filter(|_| arguments.explain) {
            println!("  {note}");
        }
        total.add(&of_seed);
    }
    Ok(total)
}
