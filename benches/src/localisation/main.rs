//! Finding and keeping the robot's place in a known map of the simulated sites, judged by the truth.

#![allow(clippy::print_stdout, reason = "the table is the point")]

mod known;
mod recorded;
mod rounds;
mod sizes;
mod standing;
mod troubles;

use anyhow::Result;
use clap::Parser;
use known::KnownSite;
use sim::SiteName;
use std::path::PathBuf;

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
    /// Rounds walked by the map on other days, each with its own seed.
    #[arg(long, default_value_t = 1)]
    days: u64,
    /// How long each is, minutes.
    #[arg(long, default_value_t = 60.0)]
    day_minutes: f64,
    /// Share of the furniture that stands elsewhere then, or is gone.
    #[arg(long, default_value_t = 0.25)]
    moved: f64,
    /// People walking about then.
    #[arg(long, default_value_t = 10)]
    day_people: u32,
    /// How often, on another day, the LiDAR is covered for 20 s and the robot is carried 20 m away and back.
    #[arg(long, default_value_t = 5)]
    troubles: u32,
    /// Sizes of maps, points, in which the cost of a scan is measured: the site's own map again and again, side by side.
    #[arg(long, value_delimiter = ',', value_name = "POINTS")]
    sizes: Vec<u64>,
    /// Instead of the sites: recorded scans with their poses, of which the even ones make the map and the odd ones are looked for in it.
    #[arg(long, value_name = "FOLDER")]
    scans: Option<PathBuf>,
    /// One line for each place.
    #[arg(long)]
    each: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some(folder) = &arguments.scans {
        return recorded::run(folder);
    }
    for name in &arguments.sites {
        let name: SiteName = name.parse()?;
        let known = KnownSite::map(name, &arguments)?;
        if arguments.places > 0 {
            standing::print_header();
            standing::run(&known, &arguments)?;
        }
        if arguments.days > 0 {
            rounds::print_header();
        }
        for day in 1..=arguments.days {
            rounds::run(&known, &arguments, day)?;
        }
        if !arguments.sizes.is_empty() {
            sizes::print_header();
        }
        for points in &arguments.sizes {
            sizes::run(&known, &arguments, *points)?;
        }
        if arguments.troubles > 0 {
            troubles::print_header();
            troubles::run(&known, &arguments)?;
        }
    }
    Ok(())
}
