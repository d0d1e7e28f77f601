//! Odometry on simulated walks, compared with other programs on the same recordings.
//!
//! For each site and seed: record a walk with `autoinspect sim record`, map it with `autoinspect map`, compare with the
//! ground truth, and (with `--peers`) run other programs over the same sensor data. One row is
//! printed for each program.

mod arguments;
mod commands;
mod peers;
mod sequence;
mod table;

use anyhow::{Context, Result};
use arguments::Arguments;
use clap::Parser;
use table::Row;

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

/// Makes one recording and prints the row of each program when it ends, because a walk with all programs takes an hour.
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
