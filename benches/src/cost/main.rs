//! What the platform costs while a mission runs and a browser is connected: processor time of core, gateway and simulated robot, and whether the robot lives in real time.
//!
//! The program makes the example site, runs its mission again and again, and reads the processor times of its processes from /proc. A client with both sockets stands
//! for the browser: it gets what a page gets, all state and ten scans a second. What a browser draws is its own cost.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod client;
mod platform;

use anyhow::{Context, Result, ensure};
use benches::quantile;
use clap::Parser;
use client::PageClient;
use platform::{MeasuredPlatform, PROCESSES};
use std::time::{Duration, Instant};

/// Cores that core, gateway and simulated robot take while a mission runs.
///
/// Example: cargo xtask bench cost --minutes 5
#[derive(Parser)]
struct Arguments {
    /// Length of the measurement, minutes.
    #[arg(long, default_value_t = 5.0)]
    minutes: f64,
    /// The simulated site.
    #[arg(long, default_value = "b1")]
    site: String,
    /// LiDAR columns per sweep; 2000 is full resolution.
    #[arg(long, default_value_t = 2000)]
    columns: u32,
    /// Address on which the platform listens.
    #[arg(long, default_value = "127.0.0.1:0")]
    listen: String,
    /// Fail if a bar is missed.
    #[arg(long)]
    bar: bool,
}

/// Bar: processor time of the three processes together, cores.
const MAX_CORES: f64 = 1.3;
/// Bar: robot time over real time.
const MIN_REAL_TIME_FACTOR: f64 = 0.99;
/// Longest time until the example is made, and until a mission begins.
const PATIENCE: Duration = Duration::from_secs(900);
/// Time between two looks at the state of the mission.
const PERIOD: Duration = Duration::from_millis(500);

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let data = tempfile::tempdir()?;
    let columns = arguments.columns.to_string();
    let platform = MeasuredPlatform::start(&arguments.site, data.path(), &arguments.listen, &columns)?;
    platform.make_example(PATIENCE)?;
    let mission = platform.first_mission()?;
    let page = PageClient::connect(platform.address())?;

    platform.start_run(&mission)?;
    wait_until("the mission runs", || platform.is_running())?;
    let (began, cpu_before) = (Instant::now(), platform.cpu_s()?);
    let clock_before = page.robot_clock().context("no estimate has come")?;
    let mut runs = 1;
    while began.elapsed().as_secs_f64() < 60.0 * arguments.minutes {
        std::thread::sleep(PERIOD);
        if !platform.is_running()? {
            platform.start_run(&mission)?;
            wait_until("the next mission runs", || platform.is_running())?;
            runs += 1;
        }
    }
    let duration_s = began.elapsed().as_secs_f64();
    let (cpu_after, clock_after) = (platform.cpu_s()?, page.robot_clock().context("no estimate has come")?);
    let real_time_factor = (clock_after - clock_before).secs_f64() / duration_s;
    let cores: Vec<f64> =
        cpu_after.iter().zip(cpu_before).map(|(after, before)| (after - before) / duration_s).collect();
    let together: f64 = cores.iter().sum();
    let page = page.end();
    ensure!(page.scans > 0, "no scan has come to the client");

    println!("| process | cores |\n| --- | ---: |");
    for (process, cores) in PROCESSES.iter().zip(&cores) {
        println!("| {process} | {cores:.2} |");
    }
    println!("| together | {together:.2} |");
    println!(
        "{runs} missions in {duration_s:.0} s; real-time factor {real_time_factor:.3} (worst second {:.2}); the client got {:.1} scans and {:.0} kB a second",
        quantile(&page.real_time_factors, 0.0),
        page.scans as f64 / duration_s,
        page.bytes as f64 / duration_s / 1e3,
    );
    let mut missed = Vec::new();
    if together > MAX_CORES {
        missed.push(format!("core, gateway and simulated robot take {together:.2} cores"));
    }
    if real_time_factor < MIN_REAL_TIME_FACTOR {
        missed.push(format!("the real-time factor is {real_time_factor:.3}"));
    }
    missed.iter().for_each(|bar| println!("BAR MISSED: {bar}"));
    if missed.is_empty() {
        println!("all bars met");
    }
    ensure!(missed.is_empty() || !arguments.bar, "{} bars are missed", missed.len());
    Ok(())
}

/// Waits for a condition, looking twice a second.
fn wait_until(what: &str, condition: impl Fn() -> Result<bool>) -> Result<()> {
    let started = Instant::now();
    while !condition()? {
        ensure!(started.elapsed() < PATIENCE, "did not happen within {} s: {what}", PATIENCE.as_secs());
        std::thread::sleep(PERIOD);
    }
    Ok(())
}
