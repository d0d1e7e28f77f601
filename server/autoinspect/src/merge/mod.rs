//! `autoinspect merge`: several maps of one site as one.

mod joined_graph;

use crate::failure::Failure;
use crate::{map, output};
use clap::Args;
use geometry::{Isometry, pose_from_isometry};
use joined_graph::JoinedGraph;
use mapping::{AlignmentError, MapAlignment, MapMatcher, VerificationConfig};
use serde::Serialize;
use std::collections::VecDeque;
use std::fs;
use std::path::{Path, PathBuf};
use store::{MapFileOptions, SavedMap, TileFiles, map_clouds_and_sensors, write_map_files};
use vocab::Pose;

/// Join maps of one site: those of several walks, or of a part that was added.
#[derive(Args, Debug)]
#[command(
    after_help = "Each map is found in those before it by what it looks like; nothing has to be known of where the walks began. The first
map's frame is kept; a map that is not recognised in those before it is tried again once others have joined. OUT gets what `autoinspect map` writes: one graph with the loops between the walks, all clouds, tiles.

EXAMPLES:
  autoinspect merge monday friday --out site
  autoinspect merge site annex --out larger --json"
)]
pub struct MergeArgs {
    /// Folders of maps: what `autoinspect map --out` or `merge --out` wrote, or folders in a data directory's maps/.
    #[arg(required = true, num_args = 2.., value_name = "MAP")]
    maps: Vec<PathBuf>,
    /// Folder for the results; what an earlier run left there is replaced.
    #[arg(long)]
    out: PathBuf,
    /// Name of the map.
    #[arg(long, default_value = "Map")]
    name: String,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What was made of the maps.
#[derive(Debug, Serialize)]
struct Report {
    out: PathBuf,
    keyframes: u64,
    points: u64,
    /// Of each map after the first.
    joins: Vec<Join>,
}

/// How a map was joined to those before it.
#[derive(Debug, Serialize)]
struct Join {
    map: PathBuf,
    /// Keyframes recognised that agree on where it lies, and those that agree on the best other way.
    recognised: u64,
    recognised_elsewhere: u64,
    /// Loops between it and those before.
    loops: u64,
    /// Where its frame lies in the first one's.
    first_from_map: Pose,
}

/// Runs `autoinspect merge`.
pub fn run(args: &MergeArgs) -> Result<(), Failure> {
    let maps = args.maps.iter().map(|path| SavedMap::read(path)).collect::<Result<Vec<_>, _>>();
    let maps = maps.map_err(Failure::usage)?;
    if args.maps.iter().any(|map| map::is_same_folder(&args.out, map)) {
        return Err(Failure::usage(format!(
            "{} is one of the maps; choose another folder",
            args.out.display()
        )));
    }
    let charts = maps.iter().map(chart_of).collect::<Result<Vec<_>, _>>()?;
    let (joined, joins) = join(&maps, charts)?;

    map::prepare(&args.out)?;
    let clouds = args.out.join("clouds");
    for (index, first) in joined.firsts() {
        store::copy_clouds(&maps[*index].path, &clouds, *first).map_err(Failure::failed)?;
    }
    let tiles = TileFiles::new(args.out.join("tiles"));
    let finished = joined.finish(&maps, &args.name);
    let has_pose_graph = maps.iter().any(|map| map.summary.has_pose_graph);
    let options = MapFileOptions { ply: true, has_pose_graph };
    let files = write_map_files(&args.out, &tiles, &finished, options).map_err(Failure::failed)?;
    let report = Report {
        out: args.out.clone(),
        keyframes: u64::from(files.summary.keyframes),
        points: files.summary.points,
        joins,
    };
    write_summary(&args.out, &report)?;
    output::print_human(args.json, &describe(&report));
    output::print_json(args.json, &report)
}

/// Joins every map with those before it; what is not recognised there may be in one that comes later.
fn join(maps: &[SavedMap], charts: Vec<MapMatcher>) -> Result<(JoinedGraph, Vec<Join>), Failure> {
    let mut waiting: VecDeque<(usize, MapMatcher)> = charts.into_iter().enumerate().collect();
    let (mut joined, mut joins) = (JoinedGraph::default(), Vec::new());
    let Some((first, mut chart)) = waiting.pop_front() else { return Ok((joined, joins)) };
    joined.begin(first, &maps[first]);
    let mut refused = 0;
    while let Some((index, mut own)) = waiting.pop_front() {
        let map = &maps[index];
        match chart.align(&mut own, &VerificationConfig::default()) {
            Ok(found) => {
                joined.add(index, map, &found)?;
                joins.push(Join::new(map, &found));
                chart.append(own, joined.poses());
                refused = 0;
            }
            Err(unrelated) if refused >= waiting.len() => {
                return Err(Failure::failed(words(&unrelated, &map.path, &maps[first].path)));
            }
            Err(_) => {
                refused += 1;
                waiting.push_back((index, own));
            }
        }
    }
    Ok((joined, joins))
}

impl Join {
    fn new(map: &SavedMap, found: &MapAlignment) -> Self {
        Self {
            map: map.path.clone(),
            recognised: found.support as u64,
            recognised_elsewhere: found.runner_up_support as u64,
            loops: found.links.len() as u64,
            first_from_map: pose_from_isometry(&found.first_from_second),
        }
    }
}

/// The keyframes of a map with what they saw.
fn chart_of(map: &SavedMap) -> Result<MapMatcher, Failure> {
    let mut chart = MapMatcher::default();
    for read in map_clouds_and_sensors(&map.path).map_err(Failure::usage)? {
        let (cloud, sensor) = read.map_err(Failure::usage)?;
        let pose = geometry::isometry_from_pose(&cloud.map_from_keyframe).unwrap_or_else(Isometry::identity);
        chart.push_cloud(&pose, &cloud.xyz, sensor);
    }
    if chart.len() != map.poses.len() {
        return Err(Failure::usage(format!(
            "{} has {} keyframes but clouds of {}; make the map again",
            map.path.display(),
            map.poses.len(),
            chart.len()
        )));
    }
    Ok(chart)
}

fn words(unrelated: &AlignmentError, map: &Path, first: &Path) -> String {
    let (map, first) = (map.display(), first.display());
    match unrelated {
        AlignmentError::TooFew(0) => {
            format!("nothing of {map} was recognised in {first}; are they of the same site?")
        }
        AlignmentError::TooFew(count) => format!(
            "only {count} places of {map} were recognised in {first}, or all in one spot; walk some 15 m of the known part on the next round"
        ),
        AlignmentError::Ambiguous(count, rival) => format!(
            "{map} fits into {first} in two ways, with {count} and {rival} places recognised; walk a part on which they differ"
        ),
    }
}

fn describe(report: &Report) -> String {
    let mut lines =
        vec![format!("{}: {} keyframes, {} points", report.out.display(), report.keyframes, report.points)];
    for join in &report.joins {
        let place = join.first_from_map.position;
        lines.push(format!(
            "{}: {} places recognised, {} loops; its origin lies at {:.2} {:.2} {:.2} m",
            join.map.display(),
            join.recognised,
            join.loops,
            place.x,
            place.y,
            place.z
        ));
    }
    lines.join("\n")
}

fn write_summary(out: &Path, report: &Report) -> Result<(), Failure> {
    let path = out.join("summary.json");
    let text = serde_json::to_string_pretty(report).map_err(Failure::failed)?;
    fs::write(&path, text + "\n")
        .map_err(|error| Failure::failed(format!("{} cannot be written: {error}", path.display())))
}
