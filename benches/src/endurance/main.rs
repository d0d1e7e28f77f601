//! A long walk that repeats its route. The robot first maps and then is localised in the map of that walk.
//!
//! For each minute it prints the CPU time of a scan, the memory of the process, the size of the graph and the position error, to show whether any
//! of them grows. At the end it prints the CPU time of the steps that take a scan, which must meet the limits of a real-time control thread. So must the
//! steps in between, because a waypoint is added to the map by the step after that of its scan.
//!
//! Simulator and stack run in one process, faster than real time. CPU time is that of the stack's thread in [`stack::Stack::step`] only. Steps that
//! make a keyframe, and steps that take the result of a job, are also listed separately. The jobs themselves are not counted. Memory is that
//! of the whole process, including the simulated site and, while the robot maps, the keyframes that are kept for the second phase.

mod arguments;
mod measure;
mod plot;
mod step_times;
mod walk;

use anyhow::{Result, ensure};
use arguments::{Arguments, Phase};
use clap::Parser;
use measure::Minute;
use step_times::StepTimes;

#[allow(clippy::print_stdout, reason = "the table is this program's output")]
fn main() -> Result<()> {
    let arguments = Arguments::parse();
    ensure!(arguments.minutes > 0, "a walk takes at least a minute");
    ensure!(arguments.phases.contains(&Phase::Mapping), "there is no map without the mapping phase");
    let keep_map = arguments.phases.contains(&Phase::Localised);

    let mut steps = Vec::new();
    print_header(Phase::Mapping);
    let mapped = walk::map(&arguments, keep_map, print_minute)?;
    print_growth(&mapped.minutes);
    if let Some(path) = &arguments.svg {
        let title = format!("{}, seed {}, {} columns", arguments.site, arguments.seed, arguments.columns);
        plot::draw(path, &title, &mapped.minutes)?;
    }
    steps.push((Phase::Mapping, mapped.step_times));
    if let Some(map) = mapped.prior_map {
        print_header(Phase::Localised);
        let localised = walk::localise(&arguments, map, print_minute)?;
        print_growth(&localised.minutes);
        steps.push((Phase::Localised, localised.step_times));
    }

    StepTimes::print_header();
    for (phase, times) in &steps {
        times.print(phase.name());
    }
    let meets_bar = steps.iter().all(|(_, times)| times.meets_bar());
    println!("{}", step_times::verdict(meets_bar));
    ensure!(meets_bar, "steps that take a scan are too slow");
    Ok(())
}

#[allow(clippy::print_stdout, reason = "the table is this program's output")]
fn print_header(phase: Phase) {
    println!("{}:", phase.name());
    println!(
        "{:>7}{:>8}{:>7}{:>9}{:>9}{:>8}{:>8}{:>11}{:>16}{:>7}{:>10}{:>16}",
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
        "revisits",
        "jobs' ms (max)"
    );
}

#[allow(clippy::print_stdout, reason = "the table is this program's output")]
fn print_minute(minute: &Minute) {
    let span = |median: f64, max: f64| format!("{median:.2} ({max:.1})");
    println!(
        "{:>7}{:>8}{:>7}{:>9.2}{:>9.2}{:>8.0}{:>8.1}{:>11}{:>16}{:>7}{:>10}{:>16}",
        minute.number,
        minute.rounds,
        minute.scans,
        minute.mean_ms,
        minute.p99_ms,
        minute.resident_mb,
        minute.position_error_mm,
        minute.keyframes,
        span(minute.keyframe_median_ms, minute.max_keyframe_ms),
        minute.loops,
        minute.revisits,
        span(minute.job_result_median_ms, minute.max_job_result_ms)
    );
}

/// Compares the second half of a walk with the first.
#[allow(clippy::print_stdout, reason = "the table is this program's output")]
fn print_growth(minutes: &[Minute]) {
    if minutes.len() < 2 {
        return;
    }
    let (early, late) = minutes.split_at(minutes.len() / 2);
    let mean =
        |half: &[Minute], value: fn(&Minute) -> f64| half.iter().map(value).sum::<f64>() / half.len() as f64;
    println!(
        "second half compared with the first: {:.3} times the cost, {:+.1} MB, {:+.0} keyframes",
        mean(late, |m| m.mean_ms) / mean(early, |m| m.mean_ms),
        mean(late, |m| m.resident_mb) - mean(early, |m| m.resident_mb),
        mean(late, |m| m.keyframes as f64) - mean(early, |m| m.keyframes as f64)
    );
}
