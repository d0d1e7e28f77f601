//! Finding and keeping the robot's place in a known map of the simulated sites, judged by the truth.

#![allow(clippy::print_stdout, reason = "the table is the point")]

mod known;
mod standing;

use anyhow::Result;
use clap::Parser;
use known::KnownSite;
use sim::SiteName;

/// Localisation in known maps of the simulated sites.
///
/// Example: cargo xtask bench localisation --sites b1,twins --places 50
#[derive(Parser)]
struct Arguments {
    /// Sites, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant,twins")]
    sites: Vec<String>,
    /// Seed of the walk that makes the map; all others follow from it.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Length of the walk that makes the map, minutes.
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// LiDAR columns per sweep; 2000 is full resolution.
    #[arg(long, default_value_t = 1000)]
    columns: u32,
    /// People walking about.
    #[arg(long, default_value_t = 4)]
    people: u32,
    /// Random places where the robot has to find itself, standing still.
    #[arg(long, default_value_t = 200)]
    places: usize,
    /// One line for each place.
    #[arg(long)]
    each: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    standing::print_header();
    for name in &arguments.sites {
        let name: SiteName = name.parse()?;
        let known = KnownSite::map(name, &arguments)?;
        standing::run(&known, &arguments)?;
    }
    Ok(())
}
