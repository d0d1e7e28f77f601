//! The command line.

use clap::Parser;

/// Mapping, localisation and fault recovery on sites that no value was tuned on.
///
/// Examples: cargo xtask bench sites --generated 20
///           cargo xtask bench sites --sites hall.glb --faults 0
#[derive(Parser)]
pub struct Arguments {
    /// Number of generated sites.
    #[arg(long, default_value_t = 0)]
    pub generated: u64,
    /// Seed of the first generated site.
    #[arg(long, default_value_t = 0)]
    pub first: u64,
    /// Further sites, separated by commas: names, or buildings as FILE.glb.
    #[arg(long, value_delimiter = ',')]
    pub sites: Vec<String>,
    /// Seed of the walk that makes the map. All other seeds follow from it.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Length of that walk, minutes.
    #[arg(long, default_value_t = 10.0)]
    pub minutes: f64,
    /// LiDAR columns per sweep; 2000 is full resolution.
    #[arg(long, default_value_t = 250)]
    pub columns: u32,
    /// Number of people who walk on the site while it is mapped, and at the places.
    #[arg(long, default_value_t = 4)]
    pub people: u32,
    /// Number of random places at which a standing robot localises globally from one scan.
    #[arg(long, default_value_t = 40)]
    pub places: usize,
    /// Number of times that, on another day, the LiDAR is covered for 20 s, and the robot is carried away and back.
    #[arg(long, default_value_t = 4)]
    pub faults: u32,
    /// Least distance over which the robot is carried, metres; at most 25.
    #[arg(long, default_value_t = 8.0)]
    pub carry_distance_min: f64,
    /// Share of the furniture that is moved or removed on that other day.
    #[arg(long, default_value_t = 0.25)]
    pub changed_share: f64,
    /// Number of people on that other day.
    #[arg(long, default_value_t = 6)]
    pub day_people: u32,
    /// Fail if a bar is missed.
    #[arg(long)]
    pub bar: bool,
    /// Print one line for each place and each place to which the robot was carried.
    #[arg(long)]
    pub verbose: bool,
}
