//! `autoinspect example`: a site to try at once. A simulated robot walks through the test hall faster than time, the stack makes the map of what it sees, and
//! the ordinary generator makes the topological map of that. Inspection points, a mission and a schedule come with it.
//!
//! The same seed gives the same map. Nothing of the stack differs from that of a robot.

mod inspection;
mod plan;
mod walk;

use crate::failure::Failure;
use crate::map::offline_mapper::{MappingRun, OfflineMapper, SESSION};
use crate::process::peak_memory;
use crate::progress::{Progress, run_in_background};
use crate::{map, output, summaries, texts};
use api::ImportStage;
use clap::Args;
use geometry::{Isometry, Rotation};
use messages::{BootRecord, RobotProfile};
use missions::SiteZone;
use plan::Calendar;
use serde::{Deserialize, Serialize};
use sim::{CameraScene, InstrumentEnvironment, STANDING_HEIGHT, SimulatedSite, SiteName, Start};
use site_model::Object;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Instant, SystemTime, UNIX_EPOCH};
use store::{MapFileOptions, TileFiles, TopomapSource, write_map_files};
use topomap::{GeneratedMap, TopomapConfig};
use vocab::{Pose, Stamp};
use walk::ExampleWalkConfig;

/// The simulated site that the example is of.
pub const SITE_NAME: &str = "b1";

/// Name of the file with the objects of the site, in the folder of the map.
pub const OBJECTS_FILE: &str = "example.json";

/// Make a site to try: map, topological map, inspection points, a mission and a schedule.
#[derive(Args, Debug)]
#[command(
    after_help = "A simulated robot walks through the test hall b1 and maps it. OUT gets the files of a map, as of `autoinspect map`, and example.json with the
objects of the site. A running platform does the same on request: the first screen of the browser offers it, and POST /api/v1/example.

EXAMPLES:
  autoinspect example --out m
  autoinspect example --out m --time-zone Europe/London --json"
)]
pub struct ExampleArgs {
    /// Folder for the results; those of an earlier run are replaced.
    #[arg(long)]
    out: PathBuf,
    /// Name of the map and the site.
    #[arg(long, default_value = "Example hall")]
    name: String,
    /// Time zone of the schedule, a name of the IANA database.
    #[arg(long, default_value = "UTC")]
    time_zone: String,
    /// Seed of the simulation.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Length of the walk, minutes of the robot.
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// Columns of a LiDAR sweep; 2000 is full resolution.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(50..=2_000))]
    columns: u32,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Run with low priority, and print the progress as lines of JSON.
    #[arg(long)]
    background: bool,
}

/// The file [`OBJECTS_FILE`].
#[derive(Debug, Serialize, Deserialize)]
pub struct ExampleDocument {
    /// What the site gets, in the order in which the objects refer to each other.
    pub objects: Vec<Object>,
}

/// The result, for people and programs.
#[derive(Debug, Serialize)]
struct Report {
    out: PathBuf,
    keyframes: usize,
    nodes: usize,
    edges: usize,
    inspection_points: usize,
    /// Length of the walk, robot time.
    walk_s: f64,
    seconds: Seconds,
    /// Peak memory of the process, bytes.
    memory_bytes: u64,
}

/// Wall time of each stage.
#[derive(Debug, Default, Serialize)]
struct Seconds {
    walk: f64,
    write: f64,
    topomap: f64,
}

/// Runs `autoinspect example`.
pub fn run(args: &ExampleArgs) -> Result<(), Failure> {
    if args.background {
        run_in_background();
    }
    let zone = SiteZone::new(&args.time_zone).map_err(Failure::usage)?;
    map::prepare(&args.out)?;
    let began = now();
    let mut seconds = Seconds::default();

    let started = Instant::now();
    let site = Arc::new(SimulatedSite::new(SiteName::B1));
    let (boot, mapped) = walk(args, &site, began)?;
    seconds.walk = started.elapsed().as_secs_f64();

    let started = Instant::now();
    Progress::new(args.background, ImportStage::Writing).set_share(0.0);
    let tiles = TileFiles::new(args.out.join("tiles"));
    write_map_files(&args.out, &tiles, &mapped.finished, MapFileOptions::default())
        .map_err(Failure::failed)?;
    seconds.write = started.elapsed().as_secs_f64();

    let started = Instant::now();
    Progress::new(args.background, ImportStage::MakingTopomap).set_share(0.0);
    let made = make_topomap(&args.out, &boot)?;
    let scene = CameraScene::new(Arc::clone(&site));
    let surroundings = InstrumentEnvironment::new(&scene);
    let inspected = inspection::InspectedSite {
        site: &site,
        scene: &scene,
        gamma: surroundings.gamma(),
        site_from_map: pose_of_start(&site.start()),
    };
    let calendar = Calendar {
        time_zone: args.time_zone.clone(),
        today: zone.to_local(site_model::Utc(began.nanos())).date,
    };
    let objects = plan::objects(&args.name, mapped.finished.map, &made, &inspected, &calendar)?;
    let is_point = |object: &&Object| matches!(object, Object::InspectionPoint(_));
    let inspection_points = objects.iter().filter(is_point).count();
    let document = ExampleDocument { objects };
    store::write_json(&args.out.join(OBJECTS_FILE), &document).map_err(Failure::failed)?;
    seconds.topomap = started.elapsed().as_secs_f64();

    let report = Report {
        out: args.out.clone(),
        keyframes: mapped.finished.graph.nodes.len(),
        nodes: made.nodes.len(),
        edges: made.edges.len(),
        inspection_points,
        walk_s: mapped.last.zip(mapped.first).map_or(0.0, |(last, first)| (last - first).secs_f64()),
        seconds,
        memory_bytes: peak_memory(),
    };
    output::print_human(args.json, &describe(&report));
    output::print_json(args.json, &report)
}

/// Walks, and maps what the robot sees.
fn walk(
    args: &ExampleArgs,
    site: &Arc<SimulatedSite>,
    began: Stamp,
) -> Result<(BootRecord, MappingRun), Failure> {
    let config =
        ExampleWalkConfig { seed: args.seed, columns: args.columns, minutes: args.minutes, epoch: began };
    let progress = Progress::new(args.background, ImportStage::Walking);
    let (boot, reader) = walk::start(site, &config, progress)?;
    let boot = BootRecord { start_mapping: Some(SESSION), ..boot };
    let mapper = OfflineMapper::new(args.out.join("clouds"), None);
    let mapped = mapper.run(boot.clone(), reader, args.name.clone(), 60.0 * args.minutes)?;
    Ok((boot, mapped))
}

/// The topological map, by the generator that the platform uses. The walk begins on the dock, so the dock is where the map begins.
fn make_topomap(out: &Path, boot: &BootRecord) -> Result<GeneratedMap, Failure> {
    let standing_height_m = boot.mounting.standing_height_m.unwrap_or(boot.profile.standing_height_m);
    let profile = RobotProfile { standing_height_m, ..boot.profile.clone() };
    let source = TopomapSource::read(out, &[Pose::default()], &profile, TopomapConfig::default());
    let made = source.map_err(Failure::failed)?.generate();
    if made.nodes.is_empty() { Err(Failure::failed(texts::EXAMPLE_HAS_NO_NODES)) } else { Ok(made) }
}

/// Pose of the base where the walk begins, which is where the map has its origin.
fn pose_of_start(start: &Start) -> Isometry {
    let position = geometry::vec_from_plain(start.position) + geometry::Vector3::z() * STANDING_HEIGHT;
    Isometry::from_parts(position.into(), Rotation::from_euler_angles(0.0, 0.0, start.yaw))
}

/// Time of this computer's clock. A time before 1970 counts as 1970.
fn now() -> Stamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Stamp::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}

fn describe(report: &Report) -> String {
    let Report { out, keyframes, nodes, edges, inspection_points, walk_s, seconds, .. } = report;
    let Seconds { walk, write, topomap } = seconds;
    let made = summaries::example_made(out, *walk_s, *keyframes, *nodes, *edges, *inspection_points);
    [made, summaries::example_times(*walk, *write, *topomap)].join("; ")
}
