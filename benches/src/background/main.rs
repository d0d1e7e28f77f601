//! Weeks of missions on one site, each compared with the running background: what was last seen of each place on earlier runs of any mission. Scored by what was changed, with the time that each comparison takes.
//!
//! Three missions take turns: the first part of the round, the last part, and the whole round. Every morning things are put, taken, moved or turned. What a run sees is cast, as `bench changes --cast` does, and kept as the
//! clouds of runs are. The background is that of the robot (`runtime::find_baseline`), and the comparison is the program's, `autoinspect changes`, in a process of its own with low priority.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod comparison;
mod days;
mod news;

use anyhow::{Result, ensure};
use benches::quantile;
use clap::Parser;
use days::{Days, DaysPlan};
use sim::SiteName;
use std::path::PathBuf;

/// How long a comparison with the background may take on the clock, seconds.
const BAR_S: f64 = 2.0;
/// Shares of the changes that have to be named by the first run that passes them, and of those named that have to be right.
const BAR_SHARE: f64 = 0.97;

/// Missions compared with the running background, for days.
///
/// Examples: cargo xtask bench background
///           cargo xtask bench background --sites b1,torus,plant --days 14 --explain
#[derive(Parser)]
struct Arguments {
    /// Sites, one after the other.
    #[arg(long, value_delimiter = ',', default_value = "torus")]
    sites: Vec<SiteName>,
    /// Days. On the first one the whole round is seen, and nothing is compared.
    #[arg(long, default_value_t = 14)]
    days: u32,
    /// Changes every morning.
    #[arg(long, default_value_t = 2)]
    changes: usize,
    /// Columns of a sweep.
    #[arg(long, default_value_t = 505)]
    columns: u32,
    /// People who walk about.
    #[arg(long, default_value_t = 3)]
    people: u32,
    /// Seed of all that is random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The program.
    #[arg(long, default_value = "target/release/autoinspect")]
    program: PathBuf,
    /// Say what is named late, not named or wrong.
    #[arg(long)]
    explain: bool,
    /// Fails if a share is below its bar, or the median of the times is above 2 s.
    #[arg(long)]
    bar: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    println!(
        "| site | day | mission | points | of the background | runs in it | changes to name | named | late | repeated | wrong | s | s of processor time |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let (mut score, mut times_s) = (news::NewsScore::default(), Vec::new());
    for site in &arguments.sites {
        let plan = DaysPlan {
            site: *site,
            days: arguments.days,
            changes: arguments.changes,
            columns: arguments.columns,
            people: arguments.people,
            seed: arguments.seed,
            program: arguments.program.clone(),
        };
        Days::new(&plan)?.run(|row| {
            println!("{row}");
            for note in row.notes.iter().filter(|_| arguments.explain) {
                println!("  {note}");
            }
            score.add(&row.score);
            times_s.push([row.seconds, row.processor_s]);
        })?;
    }
    let median = |index: usize| {
        let mut of_all: Vec<f64> = times_s.iter().map(|times| times[index]).collect();
        of_all.sort_by(f64::total_cmp);
        quantile(&of_all, 0.5)
    };
    let (median_s, processor_s) = (median(0), median(1));
    let slow = times_s.iter().filter(|times| times[0] > BAR_S).count();
    let most_s = times_s.iter().map(|times| times[0]).fold(0.0, f64::max);
    println!(
        "\n{} comparisons, the median took {median_s:.2} s and {processor_s:.2} s of processor time; the slowest took {most_s:.2} s, and {slow} of them took more than {BAR_S} s",
        times_s.len()
    );
    println!("{score}");
    let is_met = score.named_share() >= BAR_SHARE && score.right_share() >= BAR_SHARE && median_s <= BAR_S;
    ensure!(!arguments.bar || is_met, "BAR MISSED");
    Ok(())
}
