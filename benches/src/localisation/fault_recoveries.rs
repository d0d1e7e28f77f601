//! Prints how soon a localised robot recovers from faults.

use crate::arguments::Arguments;
use anyhow::Result;
use benches::fault_recovery::{FaultPlan, Recovery, walk_with_faults};
use benches::mapped_site::MappedSite;
use benches::quantile;

/// Limit of the duration of a recovery, seconds.
const MAX_RECOVERY_S: f64 = 15.0;
/// Least distance over which the robot is carried, metres.
const MIN_CARRY_DISTANCE_M: f64 = 15.0;

/// Prints the names of the columns. For each kind of fault: the number of faults; the least distance over which the robot moved or was carried
/// meanwhile (straight line, metres); the number of recoveries within the bar; their median and greatest duration. Then the number of scans
/// after which the robot claimed a pose, and the number of those with a wrong pose.
pub fn print_header() {
    println!(
        "{:<8}{:>12}{:>8}{:>9}{:>11}{:>11}{:>9}",
        "site", "fault", "number", "least m", "in 15 s", "median s", "worst s"
    );
}

/// Walks on another day with faults; returns whether every recovery took at most 15 s and no wrong pose was claimed.
pub fn run(mapped: &MappedSite, arguments: &Arguments) -> Result<bool> {
    let plan = FaultPlan {
        faults: arguments.fault_recoveries,
        seed: 100 * arguments.seed + 77,
        columns: arguments.columns,
        people: arguments.day_people,
        changed_share: arguments.changed_share,
        carry_distance_min_m: MIN_CARRY_DISTANCE_M,
        verbose: arguments.verbose,
    };
    let found = walk_with_faults(mapped, &plan)?;
    for (fault, recoveries) in [("covered", &found.covered), ("carried", &found.carried)] {
        print_recoveries(mapped, fault, recoveries);
    }
    println!(
        "{:<8}{:>12}{:>8}{:>20}",
        mapped.site.name(),
        "wrong scans",
        found.claimed_scans,
        found.wrong_scans
    );
    let in_time =
        found.covered.iter().chain(&found.carried).all(|recovery| recovery.duration_s <= MAX_RECOVERY_S);
    Ok(in_time && found.wrong_scans == 0)
}

fn print_recoveries(mapped: &MappedSite, fault: &str, recoveries: &[Recovery]) {
    let mut durations: Vec<f64> = recoveries.iter().map(|recovery| recovery.duration_s).collect();
    durations.sort_by(f64::total_cmp);
    let in_time = durations.iter().filter(|seconds| **seconds <= MAX_RECOVERY_S).count();
    let least_m = recoveries.iter().map(|recovery| recovery.distance_m).fold(f64::INFINITY, f64::min);
    println!(
        "{:<8}{:>12}{:>8}{:>9.1}{:>11}{:>11.1}{:>9.1}",
        mapped.site.name(),
        fault,
        durations.len(),
        least_m,
        in_time,
        quantile(&durations, 0.5),
        quantile(&durations, 1.0)
    );
}
