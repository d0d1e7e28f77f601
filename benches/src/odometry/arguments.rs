//! The command line.

use clap::Parser;
use std::path::PathBuf;

/// Drift, speed and memory of odometry on the simulated sites.
///
/// Example: cargo xtask bench odometry --sites b1 --minutes 2 --peers kiss-icp,rko-lio
#[derive(Parser)]
pub struct Arguments {
    /// Sites, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant")]
    pub sites: Vec<String>,
    /// Seeds, separated by commas; one walk each.
    #[arg(long, value_delimiter = ',', default_value = "1,2,3")]
    pub seeds: Vec<u64>,
    /// Longest walk, minutes.
    #[arg(long, default_value_t = 10.0)]
    pub minutes: f64,
    /// LiDAR columns per sweep; 2000 is full resolution, 64,000 points.
    #[arg(long, default_value_t = 2000)]
    pub columns: u32,
    /// Number of people who walk on the site.
    #[arg(long, default_value_t = 4)]
    pub people: u32,
    /// Our variants: combinations of sources, separated by commas: all, lidar, blind (20 s without LiDAR in the middle).
    #[arg(long, value_delimiter = ',', default_value = "all")]
    pub variants: Vec<String>,
    /// Other programs to run on the same data, separated by commas: kiss-icp, genz-icp, rko-lio, genz-lio, se3-lio, evalio:dlio…
    #[arg(long, value_delimiter = ',')]
    pub peers: Vec<String>,
    /// Python in which the other programs are installed.
    #[arg(long, default_value = "python3")]
    pub python: PathBuf,
    /// Script that runs one of them over an .npz sequence.
    #[arg(long, default_value = "../shared/peers/lio_peers.py")]
    pub peer_script: PathBuf,
    /// Folder for recordings and results; each recording is deleted after its walk unless --keep is given.
    #[arg(long, default_value = "target/bench-odometry")]
    pub work: PathBuf,
    /// Keep recordings and sequences.
    #[arg(long)]
    pub keep: bool,
    /// The program to measure.
    #[arg(long, default_value = "target/release/autoinspect")]
    pub program: PathBuf,
}
