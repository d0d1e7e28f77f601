//! Global localisation, tracking and fault recovery in prior maps of the simulated sites, compared with the ground truth.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod fault_recovery;
mod map_size;
mod mapped_site;
mod other_day;
mod recorded_scans;
mod single_scan;

use anyhow::{Result, ensure};
use clap::Parser;
use mapped_site::MappedSite;
use sim::SiteName;
use std::path::PathBuf;

/// Localisation in prior maps of the simulated sites.
///
/// Example: cargo xtask bench localisation --sites b1,twins --places 50
#[derive(Parser)]
struct Arguments {
    /// Sites, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant,twins")]
    sites: Vec<String>,
    /// Seed of the walk that makes the map. All other seeds follow from it.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Length of the walk that makes the map, minutes.
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// LiDAR columns per sweep; 2000 is full resolution.
    #[arg(long, default_value_t = 1000)]
    columns: u32,
    /// Number of people who walk on the site while it is mapped.
    #[arg(long, default_value_t = 4)]
    people: u32,
    /// Number of random places at which a standing robot localises globally from one scan.
    #[arg(long, default_value_t = 200)]
    places: usize,
    /// Number of other days on which the robot is localised in the map while it walks its round, each with its own seed.
    #[arg(long, default_value_t = 1)]
    days: u64,
    /// Length of each such day, minutes.
    #[arg(long, default_value_t = 60.0)]
    day_minutes: f64,
    /// Share of the furniture that is moved or removed on another day.
    #[arg(long, default_value_t = 0.25)]
    changed_share: f64,
    /// Number of people who walk on the site on another day.
    #[arg(long, default_value_t = 10)]
    day_people: u32,
    /// Number of times that, on another day, the LiDAR is covered for 20 s, and the robot is carried 15 to 25 m away and back.
    #[arg(long, default_value_t = 5)]
    fault_recoveries: u32,
    /// Fail if a recovery takes longer than 15 s or a wrong pose was claimed.
    #[arg(long)]
    bar: bool,
    /// Sizes of maps (points) in which the cost of a scan is measured. Such a map consists of copies of the site's map side by side.
    #[arg(long, value_delimiter = ',', value_name = "POINTS")]
    sizes: Vec<u64>,
    /// Recorded scans with their poses, instead of the sites. The even ones make the map, and the odd ones are localised in it.
    #[arg(long, value_name = "FOLDER")]
    scans: Option<PathBuf>,
    /// Print one line for each place and each recovery.
    #[arg(long)]
    verbose: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some(folder) = &arguments.scans {
        return recorded_scans::run(folder);
    }
    let mut meets_bar = true;
    for name in &arguments.sites {
        let name: SiteName = name.parse()?;
        let mapped = MappedSite::new(name, &arguments)?;
        if arguments.places > 0 {
            single_scan::print_header();
            single_scan::run(&mapped, &arguments)?;
        }
        if arguments.days > 0 {
            other_day::print_header();
        }
        for day in 1..=arguments.days {
            other_day::run(&mapped, &arguments, day)?;
        }
        if !arguments.sizes.is_empty() {
            map_size::print_header();
        }
        for points in &arguments.sizes {
            map_size::run(&mapped, &arguments, *points)?;
        }
        if arguments.fault_recoveries > 0 {
            fault_recovery::print_header();
            meets_bar &= fault_recovery::run(&mapped, &arguments)?;
        }
    }
    if arguments.fault_recoveries > 0 {
        let verdict = if meets_bar { "bar met" } else { "BAR MISSED" };
        println!("{verdict}: every recovery within 15 s, and no wrong pose claimed");
    }
    ensure!(meets_bar || !arguments.bar, "a recovery took longer than 15 s, or a wrong pose was claimed");
    Ok(())
}
