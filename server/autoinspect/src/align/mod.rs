//! `autoinspect align`: gives a saved map the frame of another one of the same site.

pub mod frame_alignment;

use crate::failure::Failure;
use crate::keyframe_descriptors::read_keyframe_descriptors;
use crate::limited_command::LimitedCommand;
use crate::process_limits::ProcessLimits;
use crate::progress::{Progress, run_in_background};
use crate::{map, output, summaries, texts};
use api::ImportStage;
use clap::Args;
use frame_alignment::{AlignmentConfig, FrameAlignment, PointPair, parse_point_pair};
use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use messages::{FinishedMap, GraphNode, PoseGraph, RevisitCounts};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use store::{MapFileOptions, MapPoints, SavedMap, TileFiles, copy_clouds, write_map_files_of};
use uuid::Uuid;
use vocab::{MapId, Pose, SessionId};

/// Give a saved map the frame of another one of the same site.
#[derive(Args, Debug)]
#[command(
    after_help = "MAP and OTHER are folders that `autoinspect map`, `import`, `merge`, `patch` or `align` wrote, or folders in a data directory's maps/.
The new map is MAP, moved; it holds nothing of OTHER (`autoinspect merge` joins two maps). What a robot was taught in OTHER (goals, docks)
is then valid in it. The alignment is found by places that look alike in both, or computed from points picked in both (--pair). align.json
in the new map's folder says how many places or points agree.

EXAMPLES:
  autoinspect align survey --onto walked --out aligned
  autoinspect align data/maps/1f0c… --onto data/maps/77ab… --out aligned --name \"Hall, aligned\"
  autoinspect align survey --onto walked --out aligned --pair 81.2,40,1=0.3,-2.1,0.4 --pair 97,38.5,1=16.1,-3.6,0.4"
)]
pub struct AlignArgs {
    /// Folder of the map to move.
    map: PathBuf,
    /// Folder of the map whose frame it gets.
    #[arg(long, value_name = "OTHER")]
    onto: PathBuf,
    /// A point of MAP, and the same point in OTHER, metres; give two or more.
    #[arg(long, value_name = "X,Y,Z=X,Y,Z", value_parser = parse_point_pair, allow_hyphen_values = true)]
    pair: Vec<PointPair>,
    /// Folder for the results; those of an earlier run are replaced.
    #[arg(long)]
    out: PathBuf,
    /// Name of the new map [default: composed of the names of MAP and OTHER].
    #[arg(long)]
    name: Option<String>,
    #[command(flatten)]
    limits: ProcessLimits,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Run with low priority, and print the progress as lines of JSON.
    #[arg(long)]
    background: bool,
}

/// The result, written to align.json in the new map's folder.
#[derive(Debug, Serialize)]
struct Report {
    /// The map that was moved.
    map: MapId,
    /// The map whose frame it has got.
    onto: MapId,
    name: String,
    points: u64,
    keyframes: u64,
    #[serde(rename = "aligned")]
    alignment: FrameAlignment,
}

/// Runs `autoinspect align`.
pub fn run(args: &AlignArgs) -> Result<(), Failure> {
    if let Some(result) = args.limits.enter(LimitedCommand::Align) {
        return result;
    }
    if args.background {
        run_in_background();
    }
    if [&args.map, &args.onto].iter().any(|map| map::is_same_folder(&args.out, map)) {
        return Err(Failure::usage(texts::result_is_input(&args.out)));
    }
    let saved = SavedMap::read(&args.map).map_err(Failure::usage)?;
    let onto = SavedMap::read(&args.onto).map_err(Failure::usage)?;
    let mut progress = Progress::new(args.background, ImportStage::ComputingViewpoints);
    progress.set_share(0.0);
    let config = AlignmentConfig::default();
    let alignment = match args.pair.as_slice() {
        [] => frame_alignment::find_alignment(
            read_keyframe_descriptors(&args.map, |_| true)?,
            &args.onto,
            &config,
            &mut |share| progress.set_share(share),
        )?,
        pairs => frame_alignment::align_point_pairs(pairs, &config)?,
    };
    progress.finish();
    let name = args.name.clone();
    let name = name.unwrap_or_else(|| summaries::aligned_map_name(&saved.summary.name, &onto.summary.name));

    let mut progress = Progress::new(args.background, ImportStage::Writing);
    progress.set_share(0.0);
    // The tiles of an imported map have all points, its clouds only a part.
    let mut points = MapPoints::from_tiles(&args.map).map_err(Failure::usage)?;
    alignment.transform_points(&mut points.xyz);
    map::prepare(&args.out)?;
    copy_clouds(&args.map, &args.out.join("clouds"), 0).map_err(Failure::failed)?;
    let finished = moved(&saved, alignment.map_from_cloud(), &name);
    let tiles = TileFiles::new(args.out.join("tiles"));
    let options =
        MapFileOptions { has_pose_graph: saved.summary.has_pose_graph, ..MapFileOptions::default() };
    progress.set_share(0.2);
    let files = write_map_files_of(&args.out, &tiles, &finished, options, points).map_err(Failure::failed)?;
    progress.finish();
    let report = Report {
        map: saved.summary.id,
        onto: onto.summary.id,
        name,
        points: files.summary.points,
        keyframes: u64::from(files.summary.keyframes),
        alignment,
    };
    for name in ["align.json", "summary.json"] {
        store::write_json(&args.out.join(name), &report).map_err(Failure::failed)?;
    }
    output::print_human(args.json, &describe(&report, &args.out));
    output::print_json(args.json, &report)
}

/// The map with all poses moved. The same map and alignment give the same id.
fn moved(saved: &SavedMap, onto_from_map: &Isometry, name: &str) -> FinishedMap {
    let move_pose = |pose: &Isometry| pose_from_isometry(&(onto_from_map * pose));
    let Pose { position, orientation } = pose_from_isometry(onto_from_map);
    let bits = position.to_array().into_iter().chain([orientation.z, orientation.w]).map(f64::to_bits);
    let id = bits.fold(saved.summary.id.0.as_u128(), |id, bits| id.rotate_left(7) ^ u128::from(bits));
    let nodes = saved.graph().nodes.into_iter().zip(&saved.poses);
    let nodes = nodes.map(|(node, pose)| GraphNode { map_from_keyframe: move_pose(pose), ..node });
    let trajectory = saved.trajectory.iter();
    let trajectory = trajectory.filter_map(|(at, pose)| Some((*at, move_pose(&isometry_from_pose(pose)?))));
    FinishedMap {
        map: MapId(Uuid::from_u128(id)),
        name: name.to_owned(),
        session: SessionId(Uuid::nil()),
        extends: None,
        at: saved.summary.created,
        distance_m: saved.summary.distance_m,
        trajectory: trajectory.collect(),
        graph: Arc::new(PoseGraph { revision: 1, nodes: nodes.collect(), edges: saved.edges.clone() }),
        degenerate: Vec::new(),
        decisions: saved.decisions.clone(),
        unverified: 0,
        revisits: RevisitCounts::default(),
    }
}

fn describe(report: &Report, out: &Path) -> String {
    let aligned = summaries::map_aligned(&report.name, out, report.points, report.keyframes);
    [aligned, report.alignment.describe()].join("\n")
}
