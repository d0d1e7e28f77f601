//! `autoinspect merge`: joins several maps of one site to one.

mod joined_graph;

use crate::failure::Failure;
use crate::{map, output, summaries, texts};
use clap::Args;
use geometry::{Isometry, pose_from_isometry};
use joined_graph::JoinedGraph;
use mapping::{MapAlignment, MapMatcher, VerificationConfig};
use serde::Serialize;
use std::collections::VecDeque;
use std::fs;
use std::path::{Path, PathBuf};
use store::{MapFileOptions, SavedMap, TileFiles, map_clouds_and_sensors, write_map_files};
use vocab::Pose;

/// Join maps of one site: of several walks, or of a part that was built later.
#[derive(Args, Debug)]
#[command(
    after_help = "Each map is aligned with those before it by places that look alike; the walks may have begun anywhere. The first map's
frame is kept. A map that is not recognised in those before it is tried again after the others. OUT gets the files of `autoinspect map`: one graph
with loops between the walks, all clouds, tiles.

EXAMPLES:
  autoinspect merge monday friday --out site
  autoinspect merge site annex --out larger --json"
)]
pub struct MergeArgs {
    /// Folders of maps: results of `autoinspect map --out` or `merge --out`, or folders in a data directory's maps/.
    #[arg(required = true, num_args = 2.., value_name = "MAP")]
    maps: Vec<PathBuf>,
    /// Folder for the results; those of an earlier run are replaced.
    #[arg(long)]
    out: PathBuf,
    /// Name of the map.
    #[arg(long, default_value = "Map")]
    name: String,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// The merged map.
#[derive(Debug, Serialize)]
struct Report {
    out: PathBuf,
    keyframes: u64,
    points: u64,
    /// The alignment of each map after the first.
    joins: Vec<Join>,
}

/// The alignment of a map with the previous ones.
#[derive(Debug, Serialize)]
struct Join {
    map: PathBuf,
    /// Recognised keyframes that agree on the alignment.
    recognised: u64,
    /// Recognised keyframes that agree on the best other alignment.
    recognised_elsewhere: u64,
    /// Loop closures between it and the previous maps.
    loops: u64,
    /// Pose of its frame in that of the first map.
    first_from_map: Pose,
}

/// Runs `autoinspect merge`.
pub fn run(args: &MergeArgs) -> Result<(), Failure> {
    let maps = args.maps.iter().map(|path| SavedMap::read(path)).collect::<Result<Vec<_>, _>>();
    let maps = maps.map_err(Failure::usage)?;
    if args.maps.iter().any(|map| map::is_same_folder(&args.out, map)) {
        return Err(Failure::usage(texts::result_is_input(&args.out)));
    }
    let matchers = maps.iter().map(matcher_of).collect::<Result<Vec<_>, _>>()?;
    let (joined, joins) = join(&maps, matchers)?;

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

/// Joins every map with the previous ones. A map that is not recognised in them is tried again after others were joined.
fn join(maps: &[SavedMap], matchers: Vec<MapMatcher>) -> Result<(JoinedGraph, Vec<Join>), Failure> {
    let mut waiting: VecDeque<(usize, MapMatcher)> = matchers.into_iter().enumerate().collect();
    let (mut joined, mut joins) = (JoinedGraph::default(), Vec::new());
    let Some((first, mut matcher)) = waiting.pop_front() else { return Ok((joined, joins)) };
    joined.begin(first, &maps[first]);
    let mut refused = 0;
    while let Some((index, mut own)) = waiting.pop_front() {
        let map = &maps[index];
        match matcher.align(&mut own, &VerificationConfig::default()) {
            Ok(found) => {
                joined.add(index, map, &found)?;
                joins.push(Join::new(map, &found));
                matcher.append(own, joined.poses());
                refused = 0;
            }
            Err(error) if refused >= waiting.len() => {
                return Err(Failure::failed(texts::alignment_error(&error, &map.path, &maps[first].path)));
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

/// A map's keyframes with their scans, to be matched with other maps.
fn matcher_of(map: &SavedMap) -> Result<MapMatcher, Failure> {
    let mut matcher = MapMatcher::default();
    for read in map_clouds_and_sensors(&map.path).map_err(Failure::usage)? {
        let (cloud, sensor) = read.map_err(Failure::usage)?;
        let pose = geometry::isometry_from_pose(&cloud.map_from_keyframe).unwrap_or_else(Isometry::identity);
        matcher.push_cloud(&pose, &cloud.xyz, sensor);
    }
    if matcher.len() != map.poses.len() {
        return Err(Failure::usage(texts::missing_clouds(&map.path)));
    }
    Ok(matcher)
}

fn describe(report: &Report) -> String {
    let mut lines = vec![summaries::merged(&report.out, report.keyframes, report.points)];
    for join in &report.joins {
        let place = join.first_from_map.position;
        let origin_m = [place.x, place.y, place.z];
        lines.push(summaries::joined(&join.map, join.recognised, join.loops, origin_m));
    }
    lines.join("\n")
}

fn write_summary(out: &Path, report: &Report) -> Result<(), Failure> {
    let path = out.join("summary.json");
    let text = serde_json::to_string_pretty(report).map_err(Failure::failed)?;
    fs::write(&path, text + "\n").map_err(|error| Failure::failed(texts::cannot_write(&path, &error)))
}
