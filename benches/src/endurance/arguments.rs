//! The command line.

use clap::{Parser, ValueEnum};
use std::path::PathBuf;

/// CPU time per scan and memory over a long walk. Fails if the steps that take a scan exceed their limits.
///
/// Examples: cargo xtask bench endurance --site b1 --minutes 60
///           cargo xtask bench endurance --site b1 --phases mapping --minutes 60 --svg hour.svg
///           cargo xtask bench endurance --site b1 --phases mapping --route short --minutes 90 --columns 250 --svg hundred-rounds.svg
#[derive(Parser)]
pub struct Arguments {
    /// Site: b1, torus, plant or twins.
    #[arg(long, default_value = "b1")]
    pub site: sim::SiteName,
    /// Route: round or short.
    #[arg(long, default_value = "round")]
    pub route: String,
    /// Phases, separated by commas. The second one needs the first one's map.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "mapping,localised")]
    pub phases: Vec<Phase>,
    /// Minutes of walking in each phase; the route is walked again and again.
    #[arg(long, default_value_t = 60)]
    pub minutes: u32,
    /// Seed of the simulation.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// LiDAR columns per sweep; 2000 is full resolution, 64,000 points.
    #[arg(long, default_value_t = sim::FULL_COLUMNS)]
    pub columns: u32,
    /// Number of people who walk on the site.
    #[arg(long, default_value_t = 4)]
    pub people: u32,
    /// Where to draw the plot of the mapping phase.
    #[arg(long)]
    pub svg: Option<PathBuf>,
}

/// Task of the robot while it walks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Phase {
    /// It makes a map.
    Mapping,
    /// It is localised in the map of the mapping phase.
    Localised,
}

impl Phase {
    /// Name in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mapping => "mapping",
            Self::Localised => "localised",
        }
    }
}
