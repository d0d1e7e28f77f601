//! A long walk, round after round: what a scan costs, what the process holds and how large the graph is, minute by minute, to see
//! that none of them grows; and how far the robot's estimate is from the truth.
//!
//! Simulator and stack run in one process, faster than time. Time is that of the stack's thread only, spent in
//! [`stack::Stack::step`] with a sweep that gave an estimate: odometry and mapping; of those, steps that made a keyframe are
//! listed apart, and so are steps that took the result of a loop's verification in, which itself is not counted. Memory is that of the whole process,
//! the simulated site included.

mod plot;
mod walk;

use anyhow::{Result, ensure};
use clap::Parser;
use plot::Minute;
use std::path::PathBuf;

/// Cost per scan and memory over a long walk.
///
/// Examples: cargo xtask bench endurance --site b1 --minutes 60 --svg hour.svg
///           cargo xtask bench endurance --site b1 --route short --minutes 90 --columns 250 --svg hundred-rounds.svg
#[derive(Parser)]
struct Arguments {
    /// Where: b1, torus, plant or twins.
    #[arg(long, default_value = "b1")]
    site: sim::SiteName,
    /// Which way: round or short.
    #[arg(long, default_value = "round")]
    route: String,
    /// Minutes of walking; the route is walked again and again.
    #[arg(long, default_value_t = 60)]
    minutes: u32,
    /// Seed of the simulation.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// LiDAR columns per sweep; 2000 is full resolution, 64,000 points.
    #[arg(long, default_value_t = sim::FULL_COLUMNS)]
    columns: u32,
    /// People walking about.
    #[arg(long, default_value_t = 4)]
    people: u32,
    /// Where to draw the plot.
    #[arg(long)]
    svg: Option<PathBuf>,
}

#[allow(clippy::print_stdout, reason = "the table is this program's output")]
fn main() -> Result<()> {
    let arguments = Arguments::parse();
    println!(
        "{:>7}{:>8}{:>7}{:>9}{:>9}{:>8}{:>8}{:>11}{:>16}{:>7}{:>7}{:>16}",
        "minute",
        "rounds",
        "scans",
        "mean ms",
        "p99 ms",
        "MB",
        "off mm",
        "keyframes",
        "each ms (max)",
        "loops",
        "ties",
        "each ms (max)"
    );
    let mut minutes = Vec::new();
    walk::walk(&arguments, |minute: Minute| {
        let span = |(median, max): (f64, f64)| format!("{median:.2} ({max:.1})");
        println!(
            "{:>7}{:>8}{:>7}{:>9.2}{:>9.2}{:>8.0}{:>8.1}{:>11}{:>16}{:>7}{:>7}{:>16}",
            minute.number,
            minute.rounds,
            minute.scans,
            minute.mean_ms,
            minute.p99_ms,
            minute.resident_mb,
            minute.off_mm,
            minute.keyframes,
            span(minute.keyframe_ms),
            minute.loops,
            minute.ties,
            span(minute.loop_ms)
        );
        minutes.push(minute);
    })?;
    ensure!(
        minutes.len() >= 2,
        "a walk of at least two minutes shows growth; this one had {}",
        minutes.len()
    );
    let (early, late) = minutes.split_at(minutes.len() / 2);
    let mean =
        |half: &[Minute], value: fn(&Minute) -> f64| half.iter().map(value).sum::<f64>() / half.len() as f64;
    println!(
        "second half beside the first: {:.3} times the cost, {:+.1} MB, {:+.0} keyframes",
        mean(late, |m| m.mean_ms) / mean(early, |m| m.mean_ms),
        mean(late, |m| m.resident_mb) - mean(early, |m| m.resident_mb),
        mean(late, |m| m.keyframes as f64) - mean(early, |m| m.keyframes as f64)
    );
    if let Some(path) = &arguments.svg {
        let title = format!("{}, seed {}, {} columns", arguments.site, arguments.seed, arguments.columns);
        plot::draw(path, &title, &minutes)?;
    }
    Ok(())
}
