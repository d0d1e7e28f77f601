//! Odometry on simulated walks, compared with other programs on the same recordings.
//!
//! For each site and seed: record a walk with `autoinspect sim record`, map it with `autoinspect map`, compare with the
//! ground truth, and (with `--peers`) run the peers' programs over the same sensor data. One row each.

mod commands;
mod peers;
mod sequence;
mod table;

use anyhow::{Context, Result};
use clap::Parser;
use std::path::PathBuf;
use table::Row;

/// Drift, speed and memory of odometry on the simulated sites.
///
/// Example: cargo xtask bench odometry --sites b1 --minutes 2 --peers kiss-icp,rko-lio
#[derive(Parser)]
struct Arguments {
    /// Sites, separated by commas.
    #[arg(long, value_delimiter = ',', default_value = "b1,torus,plant")]
    sites: Vec<String>,
    /// Seeds, separated by commas; one walk each.
    #[arg(long, value_delimiter = ',', default_value = "1,2,3")]
    seeds: Vec<u64>,
    /// Longest walk, minutes.
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// LiDAR columns per sweep; 2000 is full resolution, 64,000 points.
    #[arg(long, default_value_t = 2000)]
    columns: u32,
    /// Number of people who walk on the site.
    #[arg(long, default_value_t = 4)]
    people: u32,
    /// Our variants: combinations of sources, separated by commas: all, lidar, blind (20 s without LiDAR in the middle).
    #[arg(long, value_delimiter = ',', default_value = "all")]
    variants: Vec<String>,
    /// Peers to run on the same data, separated by commas: kiss-icp, genz-icp, rko-lio, genz-lio, se3-lio, evalio:dlio…
    #[arg(long, value_delimiter = ',')]
    peers: Vec<String>,
    /// Python with the peers installed.
    #[arg(long, default_value = "python3")]
    python: PathBuf,
    /// The script that runs a peer over an .npz sequence.
    #[arg(long, default_value = "../shared/peers/lio_peers.py")]
    peer_script: PathBuf,
    /// Folder for recordings and results; each recording is deleted after its walk unless --keep is given.
    #[arg(long, default_value = "target/bench-odometry")]
    work: PathBuf,
    /// Keep recordings and sequences.
    #[arg(long)]
    keep: bool,
    /// The program to measure.
    #[arg(long, default_value = "target/release/autoinspect")]
    program: PathBuf,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    std::fs::create_dir_all(&arguments.work)
        .with_context(|| format!("{} cannot be made", arguments.work.display()))?;
    table::print_header();
    for site in &arguments.sites {
        for &seed in &arguments.seeds {
            walk(&arguments, site, seed)?;
        }
    }
    Ok(())
}

/// Makes one recording and prints a row for each program as soon as it is known: a walk with all peers takes an hour.
fn walk(arguments: &Arguments, site: &str, seed: u64) -> Result<()> {
    let case = format!("{site}-{seed}");
    let recording = arguments.work.join(format!("{case}.mcap"));
    commands::record(arguments, site, seed, None, &recording)?;
    for variant in &arguments.variants {
        table::print(&ours(arguments, site, seed, variant, &recording)?);
    }
    if !arguments.peers.is_empty() {
        let sequence = arguments.work.join(format!("{case}.npz"));
        sequence::convert(&recording, &sequence)?;
        for peer in &arguments.peers {
            table::print(&peers::run(arguments, site, seed, peer, &sequence));
        }
        if !arguments.keep {
            std::fs::remove_file(&sequence)?;
        }
    }
    if !arguments.keep {
        std::fs::remove_file(&recording)?;
    }
    Ok(())
}

fn ours(
    arguments: &Arguments,
    site: &str,
    seed: u64,
    variant: &str,
    recording: &std::path::Path,
) -> Result<Row> {
    let blind = arguments.work.join(format!("{site}-{seed}-blind.mcap"));
    let (input, sources) = match variant {
        "all" => (recording, "lidar,imu,legs"),
        "lidar" => (recording, "lidar"),
        "lidar-imu" => (recording, "lidar,imu"),
        "blind" => {
            let from = (arguments.minutes * 30.0).max(20.0);
            commands::record(arguments, site, seed, Some((from, from + 20.0)), &blind)?;
            (blind.as_path(), "lidar,imu,legs")
        }
        other => anyhow::bail!("there is no variant '{other}'; choose all, lidar-imu, lidar or blind"),
    };
    let out = arguments.work.join(format!("{site}-{seed}-{variant}"));
    let row = commands::map_and_compare(arguments, input, &out, sources)?;
    if !arguments.keep {
        std::fs::remove_dir_all(&out)?;
        let _ = std::fs::remove_file(&blind);
    }
    Ok(Row { site: site.to_owned(), seed, who: format!("ours ({variant})"), ..row })
}
