//! Changes between two visits: sessions of a recorded hall into which boxes are put, for many seeds, and depth images of a table.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod score;
mod sessions;
mod table;

use anyhow::{Result, ensure};
use changes::{ChangesConfig, detect_changes};
use clap::Parser;
use score::{POINTS_REQUIRED, Score, score};
use std::path::PathBuf;

/// Changes between two visits, scored by what is known to have changed.
///
/// Examples: cargo xtask bench changes
///           cargo xtask bench changes --seeds 30 --explain
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
    /// Fail if less than 90 % of the boxes that have to be found are, or an unchanged box is named.
    #[arg(long)]
    bar: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
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
    println!(
        "| things on a table, {} pairs of images | {} | {} | {} | {} | – |",
        tabletop.pairs, tabletop.changed, tabletop.found, tabletop.named, tabletop.right
    );
    let is_met = 10 * total.required_found >= 9 * total.required && total.unchanged_named == 0;
    ensure!(is_met || !arguments.bar, "the bar is missed");
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
