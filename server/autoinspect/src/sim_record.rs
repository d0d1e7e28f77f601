//! `autoinspect sim record`: records a walk of the simulated robot as a standard recording with ground truth.

mod faults;

use crate::failure::Failure;
use crate::site_changes::SiteChangeArgs;
use crate::{output, summaries, texts};
use clap::Args;
use faults::FaultName;
use messages::Input;
use recorder::{RecordingMeta, RecordingWriter};
use serde::Serialize;
use sim::{FULL_COLUMNS, RouteFollower, SimConfig, SimEvent, Simulator, SiteRoute};
use site_files::SiteSource;
use std::path::PathBuf;
use std::sync::Arc;
use vocab::Span;

/// Fixed parameters of a simulated recording.
#[derive(Clone, Copy, Debug)]
struct SimRecordConfig {
    /// Time between commands to the robot: 10 Hz, as of a person who drives it.
    command_period: Span,
}

const CONFIG: SimRecordConfig = SimRecordConfig { command_period: Span::from_millis(100) };

/// Let the simulated robot walk a route, and record its sensors.
#[derive(Args, Debug)]
#[command(
    after_help = "The recording is an MCAP file of ROS 2 messages; /truth says where the robot really was.

EXAMPLES:
  autoinspect sim record --site b1 --out b1.mcap
  autoinspect sim record --site plant --route short --seed 7 --columns 500 --out plant.mcap
  autoinspect sim record --site hall.glb --minutes 5 --out hall.mcap
  autoinspect sim record --site b1 --day 2 --moved 0.3 --out tuesday.mcap
  autoinspect sim record --site b1 --out dark.mcap --faults blind-lidar@60-80,leg-slip@30-40:0.2,0,0
  autoinspect sim record --site b1 --changes leak.json --out leak.mcap
  autoinspect sim record --site b1 --day 3 --random-changes 8 --truth-changes truth.json --out wednesday.mcap

CHANGES (leak.json; `autoinspect sim list --site b1` lists doors, gauges and lamps):
  { \"version\": 1, \"changes\": [
    { \"kind\": \"door\", \"hinge_m\": [50.1, 6.7, 0], \"turn_deg\": 60 },
    { \"kind\": \"leak\", \"at_m\": [5, 5, 0], \"radius_m\": 0.4, \"liquid\": \"water\", \"warmer_k\": 12 },
    { \"kind\": \"gauge-drift\", \"tag\": \"PI-101\", \"per_day\": 0.05, \"begun_days_ago\": 30 },
    { \"kind\": \"gauge-stuck\", \"tag\": \"TI-104\", \"value\": 61 },
    { \"kind\": \"lamp-out\", \"at_m\": [1.5, 5.0, 3.05] },
    { \"kind\": \"object-put\", \"foot_m\": [7, 5, 0], \"size_m\": [0.6, 0.4, 1], \"material\": \"wood\" } ] }

FAULTS (seconds from the start):
  blind-lidar@FROM-UNTIL  silent-lidar@FROM-UNTIL  silent-imu@FROM-UNTIL  leg-slip@FROM-UNTIL:X,Y,Z (m/s)"
)]
pub struct RecordArgs {
    /// Site: b1, torus, plant, twins, generated:SEED, or a building as FILE.glb.
    #[arg(long)]
    site: SiteSource,
    /// The file to write.
    #[arg(long)]
    out: PathBuf,
    /// Route: round or short.
    #[arg(long, default_value = "round")]
    route: String,
    /// Seed of the simulation.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Columns of a LiDAR sweep; 2000 is full resolution.
    #[arg(long, default_value_t = FULL_COLUMNS, value_parser = clap::value_parser!(u32).range(10..=20_000))]
    columns: u32,
    /// Number of people who walk on the site.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(0..=50))]
    people: u32,
    /// End after this many minutes; a shorter route is walked again.
    #[arg(long)]
    minutes: Option<f64>,
    /// Number of another day: some furniture is moved or removed, and doors are open or shut. The same number gives the same day.
    #[arg(long)]
    day: Option<u64>,
    /// Share of the furniture that is moved or removed on that day.
    #[arg(long, default_value_t = 0.25, value_parser = share, requires = "day")]
    moved: f64,
    #[command(flatten)]
    changes: SiteChangeArgs,
    /// Faults and their times.
    #[arg(long, value_delimiter = ';')]
    faults: Vec<String>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// The result, for people and programs.
#[derive(Debug, Default, Serialize)]
struct Recorded {
    seconds: f64,
    scans: u64,
    points: u64,
    messages: u64,
    distance_m: f64,
}

/// Runs `autoinspect sim record`.
pub fn run(args: &RecordArgs) -> Result<(), Failure> {
    let mut site = args.site.load().map_err(Failure::usage)?;
    if let Some(day) = args.day {
        site = Arc::new(site.on_another_day(day, args.moved));
    }
    site = args.changes.apply(site, args.day.unwrap_or(args.seed))?;
    let Some(route) = site.route(&args.route).cloned() else {
        let names: Vec<_> = site.routes().iter().map(|route| route.name).collect();
        return Err(Failure::usage(texts::no_such_route(&args.site, &args.route, &names)));
    };
    let faults = faults::parse(&args.faults.join(","))?;
    let config = SimConfig {
        lidar_columns: args.columns,
        people: args.people,
        start: Some(route.start),
        faults: faults.iter().map(FaultName::fault).collect(),
        ..SimConfig::new(site, args.seed)
    };
    let mut simulator = Simulator::new(config);
    let meta = RecordingMeta {
        robot: simulator.boot().profile.name,
        origin: summaries::simulated_origin(&args.site.to_string(), &args.route, args.seed),
        segment: None,
    };
    let mut writer =
        RecordingWriter::create(&args.out, &meta, &simulator.boot().mounting).map_err(Failure::failed)?;
    let recorded = walk(&mut simulator, &route, args.minutes, &mut writer)?;
    writer.finish().map_err(Failure::failed)?;
    output::print_human(
        args.json,
        &summaries::recorded(
            &args.out,
            recorded.seconds,
            recorded.scans,
            recorded.points,
            recorded.distance_m,
        ),
    );
    output::print_json(args.json, &recorded)
}

fn share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|_| texts::NUMBER_EXPECTED.to_owned())?;
    if (0.0..=1.0).contains(&share) { Ok(share) } else { Err(texts::SHARE_EXPECTED.to_owned()) }
}

/// Walks to the end of the route, or for `minutes`.
fn walk(
    simulator: &mut Simulator,
    route: &SiteRoute,
    minutes: Option<f64>,
    writer: &mut RecordingWriter,
) -> Result<Recorded, Failure> {
    let end = minutes.map(|minutes| Span::from_secs_f64(minutes * 60.0));
    let mut walker = RouteFollower::new(route.clone());
    let mut tally = Recorded::default();
    let mut last = simulator.truth();
    let mut events = Vec::new();
    let (_, legs) = walker.progress();
    let bar = output::progress_bar(legs as f64);
    while end.is_none_or(|end| simulator.elapsed() < end) {
        let truth = simulator.truth();
        let drive = match (walker.drive(&truth), end) {
            (Some(drive), _) => drive,
            (None, None) => break,
            (None, Some(_)) => {
                walker = RouteFollower::new(route.clone());
                continue;
            }
        };
        simulator.command(drive);
        simulator.advance(simulator.now() + CONFIG.command_period, &mut events);
        for event in events.drain(..) {
            record(event, writer, &mut tally)?;
        }
        for truth in simulator.take_ground_truth() {
            writer.truth(truth.stamp, &truth.site_from_base).map_err(Failure::failed)?;
        }
        let now = simulator.truth();
        let step = geometry::vec_from_plain(now.site_from_base.position)
            - geometry::vec_from_plain(last.site_from_base.position);
        tally.distance_m += step.norm();
        last = now;
        bar.set_position(walker.progress().0 as u64);
    }
    bar.finish_and_clear();
    tally.seconds = simulator.elapsed().secs_f64();
    Ok(tally)
}

fn record(event: SimEvent, writer: &mut RecordingWriter, tally: &mut Recorded) -> Result<(), Failure> {
    if let messages::Sensor::Scan(scan) = &event.sensor {
        tally.scans += 1;
        tally.points += scan.xyz.len() as u64;
    }
    tally.messages += 1;
    writer.input(event.at, &Input::Sensor(event.sensor)).map_err(Failure::failed)
}
