//! The command line.

use clap::Parser;
use std::path::PathBuf;

/// Speed and accuracy of pose-graph optimisation.
///
/// Example: cargo xtask bench graphs --graphs sphere2500,intel --repeats 3
#[derive(Parser)]
pub struct Arguments {
    /// Published graphs, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "sphere2500,parking-garage,intel")]
    pub graphs: Vec<String>,
    /// Folder of the published graphs.
    #[arg(long, default_value = "../shared/data/pose-graphs")]
    pub data: PathBuf,
    /// Number of poses of the patrol; 0 leaves it out.
    #[arg(long, default_value_t = 30_000)]
    pub patrol: u32,
    /// Runs of each program.
    #[arg(long, default_value_t = 5)]
    pub repeats: u32,
    /// Python with GTSAM, NumPy and SciPy; without it, one is made in the work folder.
    #[arg(long)]
    pub python: Option<PathBuf>,
    /// Folder of the scripts that run GTSAM and make the patrol.
    #[arg(long, default_value = "../shared/peers")]
    pub scripts: PathBuf,
    /// Folder for results.
    #[arg(long, default_value = "target/bench-graphs")]
    pub work: PathBuf,
    /// The program to measure.
    #[arg(long, default_value = "target/release/autoinspect")]
    pub program: PathBuf,
}
