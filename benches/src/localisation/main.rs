//! Global localisation, tracking and fault recovery in prior maps of the simulated sites, compared with the ground truth.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod arguments;
mod fault_recoveries;
mod map_size;
mod other_day;
mod recorded_scans;
mod single_scan;

use anyhow::{Error, Result, ensure};
use arguments::Arguments;
use benches::mapped_site::MappedSite;
use benches::stack_walk::WalkExtent;
use clap::Parser;
use site_files::SiteSource;
use vocab::Span;

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some(folder) = &arguments.scans {
        return recorded_scans::run(folder);
    }
    let mut meets_bar = true;
    for name in &arguments.sites {
        let source: SiteSource = name.parse().map_err(Error::msg)?;
        let duration = Span::from_secs_f64(arguments.minutes * 60.0);
        let mapped = MappedSite::new(source.load()?, &arguments.walk_plan(), WalkExtent::Time(duration))?;
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
            fault_recoveries::print_header();
            meets_bar &= fault_recoveries::run(&mapped, &arguments)?;
        }
    }
    if arguments.fault_recoveries > 0 {
        let verdict = if meets_bar { "bar met" } else { "BAR MISSED" };
        println!("{verdict}: every recovery within 15 s, and no wrong pose claimed");
    }
    ensure!(meets_bar || !arguments.bar, "a recovery took longer than 15 s, or a wrong pose was claimed");
    Ok(())
}
