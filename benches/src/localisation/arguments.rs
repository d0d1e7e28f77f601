//! The command line.

use benches::stack_walk::WalkPlan;
use clap::Parser;
use std::path::PathBuf;

/// Localisation in prior maps of the simulated sites.
///
/// Example: cargo xtask bench localisation --sites b1,twins --places 50
#[derive(Parser)]
pub struct Arguments {
    /// Sites, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant,twins")]
    pub sites: Vec<String>,
    /// Seed of the walk that makes the map. All other seeds follow from it.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Length of the walk that makes the map, minutes.
    #[arg(long, default_value_t = 10.0)]
    pub minutes: f64,
    /// LiDAR columns per sweep; 2000 is full resolution.
    #[arg(long, default_value_t = 1000)]
    pub columns: u32,
    /// Number of people who walk on the site while it is mapped.
    #[arg(long, default_value_t = 4)]
    pub people: u32,
    /// Number of random poses at which a standing robot localises globally from one scan.
    #[arg(long, default_value_t = 200)]
    pub places: usize,
    /// Number of other days on which the robot is localised in the map while it walks its round, each with its own seed.
    #[arg(long, default_value_t = 1)]
    pub days: u64,
    /// Length of each such day, minutes.
    #[arg(long, default_value_t = 60.0)]
    pub day_minutes: f64,
    /// Share of the furniture that is moved or removed on another day.
    #[arg(long, default_value_t = 0.25)]
    pub changed_share: f64,
    /// Number of people who walk on the site on another day.
    #[arg(long, default_value_t = 10)]
    pub day_people: u32,
    /// Number of times that, on another day, the LiDAR is covered for 20 s, and the robot is carried 15 to 25 m away and back.
    #[arg(long, default_value_t = 5)]
    pub fault_recoveries: u32,
    /// Fail if a recovery takes longer than 15 s or a wrong pose was claimed.
    #[arg(long)]
    pub bar: bool,
    /// Sizes of maps (points) in which the CPU time of a scan is measured. Such a map consists of copies of the site's map side by side.
    #[arg(long, value_delimiter = ',', value_name = "POINTS")]
    pub sizes: Vec<u64>,
    /// Recorded scans with their poses, instead of the sites. The even ones make the map, and the odd ones are localised in it.
    #[arg(long, value_name = "FOLDER")]
    pub scans: Option<PathBuf>,
    /// Print one line for each pose and each recovery.
    #[arg(long)]
    pub verbose: bool,
}

impl Arguments {
    /// The walk that makes the map.
    pub fn walk_plan(&self) -> WalkPlan {
        WalkPlan { seed: self.seed, columns: self.columns, people: self.people, keep_ground_truth: true }
    }
}
