//! `autoinspect import`: makes a map, in which a robot can localise, of another program's point cloud.

mod cloud;
mod graph;
mod upright;

use crate::align::frame_alignment::{self, AlignmentConfig, FrameAlignment, PointPair, parse_point_pair};
use crate::failure::Failure;
use crate::limited_command::LimitedCommand;
use crate::process::peak_memory;
use crate::process_limits::ProcessLimits;
use crate::progress::{Progress, run_in_background};
use crate::{map, output, summaries, texts};
use api::ImportStage;
use clap::Args;
use cloud::{bounds, describe_viewpoints, gather_points, stored_viewpoints, thin};
use formats::SurveyLimits;
use formats::survey::{self, Survey};
use graph::{ImportedGraphConfig, imported_map, map_id};
use mapping::virtual_viewpoint::{ViewpointConfig, VirtualViewpoints, find_viewpoints};
use messages::FinishedMap;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Instant, UNIX_EPOCH};
use store::{MapFileOptions, MapPoints, Store, TileFiles, write_map_files_of, write_viewpoint_clouds};
use upright::Up;
use vocab::{KeyframeId, Stamp};

/// Options of an imported map. Its keyframes are virtual viewpoints, not poses that a robot measured.
const IMPORTED: MapFileOptions = MapFileOptions { ply: false, has_pose_graph: false };

/// Parameters of an import, beside those of [`find_viewpoints`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportConfig {
    /// Edge of the voxels that keep one point each for the clouds of viewpoints, metres. Tiles keep all points. Chosen: a little less than the voxels of a keyframe's
    /// cloud (0.12 m, [`mapping::submap::ThinningConfig`]), so that nothing is lost there.
    pub cloud_spacing_m: f32,
    /// Edges of the graph.
    pub graph: ImportedGraphConfig,
}

impl Default for ImportConfig {
    fn default() -> Self {
        Self { cloud_spacing_m: 0.1, graph: ImportedGraphConfig::default() }
    }
}

/// Make a map of another program's point cloud, for a robot to localise in.
#[derive(Args, Debug)]
#[command(
    after_help = "FILE is PCD, PLY, LAS, LAZ, E57 or PTX; its first bytes say which. Scans with poses become one cloud. Coordinates far from the origin
are moved near it; import.json in the map's folder says by how much. The axis that points up is found by the floors, or given by --up.
--align-to gives the new map the frame of an existing map by recognising places, --pair by points picked in both. What a robot was taught in
the existing map (goals, docks) is then valid in the new one. The map has the same files as those of `autoinspect map`. Its keyframes are
virtual viewpoints: places where a robot could stand, with the points that are visible from there. A larger survey than the limits allow must be
thinned or cut into parts, or the limits raised.

EXAMPLES:
  autoinspect import site.laz --data data          for the robot whose platform keeps its maps there; stop it first
  autoinspect import site.laz --out m
  autoinspect import building.e57 --out m --name \"Building 4\" --json
  autoinspect import model.las --out m --up y
  autoinspect import survey.laz --out m --align-to data/maps/1f0c…    its frame becomes that map's
  autoinspect import survey.laz --out m --pair 81.2,40,1=0.3,-2.1,0.4 --pair 97,38.5,1=16.1,-3.6,0.4"
)]
pub struct ImportArgs {
    /// The file to read.
    file: PathBuf,
    /// Folder for the results; those of an earlier run are replaced.
    #[arg(long, required_unless_present = "data", conflicts_with = "data")]
    out: Option<PathBuf>,
    /// Data directory of a platform, to which the map is added.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Name of the map [default: the file's name].
    #[arg(long)]
    name: Option<String>,
    /// The file's axis that points up.
    #[arg(long, value_enum, default_value = "auto", allow_hyphen_values = true)]
    up: Up,
    /// Distance between neighbouring viewpoints, metres.
    #[arg(long, default_value_t = 1.5, value_parser = parse_spacing)]
    spacing: f32,
    /// Lowest and highest elevation that the robot's LiDAR sees, degrees from level.
    #[arg(long, value_name = "DOWN,UP", default_value = "-16,15", value_parser = parse_field_of_view, allow_hyphen_values = true)]
    field_of_view: FieldOfView,
    /// Folder of the map whose frame the new map gets; the alignment is found by place recognition.
    #[arg(long, value_name = "MAP")]
    align_to: Option<PathBuf>,
    /// A point of the file, and the same point in the frame that the map gets, metres; give two or more.
    #[arg(long, value_name = "X,Y,Z=X,Y,Z", value_parser = parse_point_pair, conflicts_with = "align_to", allow_hyphen_values = true)]
    pair: Vec<PointPair>,
    #[command(flatten)]
    limits: ProcessLimits,
    /// Most points of the survey.
    #[arg(long, value_name = "POINTS", default_value_t = 8_000_000)]
    max_points: usize,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Run with low priority, and print the progress as lines of JSON.
    #[arg(long)]
    background: bool,
}

/// Lowest and highest elevation, degrees from level.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FieldOfView([f32; 2]);

/// The result, for people and programs.
#[derive(Debug, Serialize)]
struct Report {
    /// Folder of the map.
    out: PathBuf,
    #[serde(flatten)]
    origin: Origin,
    /// Lowest and highest corner of the map, metres.
    bounds: [[f32; 3]; 2],
    /// Number of viewpoints.
    places: u64,
    seconds: Seconds,
    /// Peak memory of the process, bytes.
    memory_bytes: u64,
}

/// Origin of an imported map: import.json in the map's folder.
#[derive(Debug, Serialize)]
struct Origin {
    file: PathBuf,
    name: String,
    /// Usable points.
    points: u64,
    /// Points without a return, and coordinates that are not finite.
    unusable: u64,
    /// Number of scans in the file.
    scans: u64,
    /// Subtracted from the file's coordinates, metres.
    offset: [f64; 3],
    /// Axis of the file that is the map's z.
    up: Up,
    /// Distance between viewpoints, metres.
    spacing: f32,
    /// Elevations seen from them, degrees.
    field_of_view: [f32; 2],
    /// The alignment with another map's frame, if one was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(rename = "aligned")]
    alignment: Option<FrameAlignment>,
}

/// Wall time of each stage.
#[derive(Debug, Default, Serialize)]
struct Seconds {
    read: f64,
    places: f64,
    write: f64,
}

/// The points of a survey.
struct Cloud {
    /// All points.
    points: MapPoints,
    /// One point for each voxel of [`ImportConfig::cloud_spacing_m`].
    thinned: MapPoints,
}

/// Runs `autoinspect import`.
pub fn run(args: &ImportArgs) -> Result<(), Failure> {
    if let Some(result) = args.limits.enter(LimitedCommand::Import) {
        return result;
    }
    let config = ImportConfig::default();
    let mut seconds = Seconds::default();
    if args.background {
        run_in_background();
    }
    let started = Instant::now();
    let survey = read_survey(args)?;
    let mut origin = Origin::new(args, &survey);
    let points = gather_points(survey.stations);
    seconds.read = started.elapsed().as_secs_f64();

    let started = Instant::now();
    let thinned = thin(&points, config.cloud_spacing_m);
    let mut cloud = Cloud { points, thinned };
    origin.up = args.up.found(&cloud.thinned.xyz);
    cloud.transform(&|xyz| origin.up.turn(xyz));
    let viewpoint_config = ViewpointConfig {
        spacing_m: args.spacing,
        elevations_rad: args.field_of_view.0.map(f32::to_radians),
        ..ViewpointConfig::default()
    };
    let mut progress = Progress::new(args.background, ImportStage::ComputingViewpoints);
    let mut found =
        find_viewpoints(&cloud.thinned.xyz, &viewpoint_config, &mut |share| progress.set_share(share));
    progress.finish();
    origin.alignment = align(args, &origin, &found, &cloud, &viewpoint_config)?;
    if let Some(alignment) = &origin.alignment {
        cloud.transform(&|xyz| alignment.transform_points(xyz));
        for place in &mut found.viewpoints {
            place.map_from_base = alignment.map_from_cloud() * place.map_from_base;
        }
    }
    let bounds = bounds(&cloud.points.xyz);
    seconds.places = started.elapsed().as_secs_f64();

    let started = Instant::now();
    Progress::new(args.background, ImportStage::Writing).set_share(0.0);
    let id = map_id(&cloud.thinned, &viewpoint_config);
    let finished = imported_map(id, &origin.name, modified(&args.file), &found, &config.graph);
    let places = found.viewpoints.len() as u64;
    let out = write(args, &origin, &finished, found, cloud, &viewpoint_config)?;
    seconds.write = started.elapsed().as_secs_f64();
    let report = Report { out, origin, bounds, places, seconds, memory_bytes: peak_memory() };
    if args.data.is_none() {
        store::write_json(&report.out.join("summary.json"), &report).map_err(Failure::failed)?;
    }
    output::print_human(args.json, &describe(&report));
    output::print_json(args.json, &report)
}

fn read_survey(args: &ImportArgs) -> Result<Survey, Failure> {
    let mut progress = Progress::new(args.background, ImportStage::Reading);
    let survey = survey::read(&args.file, SurveyLimits { points: args.max_points }, &mut |share| {
        progress.set_share(share)
    });
    progress.finish();
    let survey = survey.map_err(|error| Failure::usage(texts::unreadable_input(&args.file, &error)))?;
    match survey.points() {
        0 => Err(Failure::usage(texts::no_points(&args.file))),
        _ => Ok(survey),
    }
}

impl Cloud {
    fn transform(&mut self, transform: &dyn Fn(&mut [[f32; 3]])) {
        transform(&mut self.points.xyz);
        transform(&mut self.thinned.xyz);
    }
}

/// Computes the requested alignment, if there is one.
fn align(
    args: &ImportArgs,
    origin: &Origin,
    found: &VirtualViewpoints,
    cloud: &Cloud,
    config: &ViewpointConfig,
) -> Result<Option<FrameAlignment>, Failure> {
    let alignment_config = AlignmentConfig::default();
    if let Some(map) = &args.align_to {
        let descriptors = describe_viewpoints(found, &cloud.thinned, config);
        let found = frame_alignment::find_alignment(descriptors, map, &alignment_config, &mut |_| ())?;
        return Ok(Some(found));
    }
    if args.pair.is_empty() {
        return Ok(None);
    }
    let pairs: Vec<PointPair> = args.pair.iter().map(|pair| origin.near_origin(pair)).collect();
    frame_alignment::align_point_pairs(&pairs, &alignment_config).map(Some)
}

/// Writes the map into the given data directory or folder; returns the map's folder.
fn write(
    args: &ImportArgs,
    origin: &Origin,
    finished: &FinishedMap,
    found: VirtualViewpoints,
    cloud: Cloud,
    config: &ViewpointConfig,
) -> Result<PathBuf, Failure> {
    let Cloud { points, thinned } = cloud;
    // The closure owns the viewpoints, so that their memory is free while tiles are made.
    let prepare = move |map: &Path| {
        let viewpoints = stored_viewpoints(&found, config);
        write_viewpoint_clouds(&map.join("clouds"), KeyframeId(0), &thinned, viewpoints)?;
        store::write_json(&map.join("import.json"), origin)
    };
    if let Some(data) = &args.data {
        let store = Store::open(data).map_err(Failure::usage)?;
        store.add_map(finished, IMPORTED, points, prepare).map_err(Failure::failed)?;
        return Ok(store.dir().map(finished.map));
    }
    let out = args.out.clone().unwrap_or_default();
    map::prepare(&out)?;
    prepare(&out).map_err(Failure::failed)?;
    drop(prepare);
    let tiles = TileFiles::new(out.join("tiles"));
    write_map_files_of(&out, &tiles, finished, IMPORTED, points).map_err(Failure::failed)?;
    Ok(out)
}

impl Origin {
    fn new(args: &ImportArgs, survey: &Survey) -> Self {
        Self {
            file: args.file.clone(),
            name: map_name(args),
            points: survey.points() as u64,
            unusable: survey.unusable as u64,
            scans: survey.stations.len() as u64,
            offset: survey.offset,
            up: args.up,
            spacing: args.spacing,
            field_of_view: args.field_of_view.0,
            alignment: None,
        }
    }

    /// The pair with its point of the file moved like the cloud: by the offset and the turn to z up.
    fn near_origin(&self, pair: &PointPair) -> PointPair {
        let mut near = [[0, 1, 2].map(|axis| (pair.cloud[axis] - self.offset[axis]) as f32)];
        self.up.turn(&mut near);
        PointPair { cloud: near[0].map(f64::from), ..*pair }
    }
}

/// The given name, or that of the file.
fn map_name(args: &ImportArgs) -> String {
    let file = args.file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    args.name.clone().or(file).unwrap_or_else(|| summaries::MAP_NAME.to_owned())
}

/// Time at which the file was last written; the epoch if the system does not know it.
fn modified(file: &Path) -> Stamp {
    let since = fs::metadata(file).and_then(|about| about.modified()).ok();
    let since = since.and_then(|at| at.duration_since(UNIX_EPOCH).ok()).unwrap_or_default();
    Stamp::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}

fn describe(report: &Report) -> String {
    let [min, max] = report.bounds;
    let size_m = std::array::from_fn(|axis| max[axis] - min[axis]);
    let Origin { name, points, scans, up, unusable, offset, alignment, .. } = &report.origin;
    let mut lines = vec![summaries::imported(name, &report.out, *points, *scans, size_m, &up.to_string())];
    if *unusable > 0 {
        lines.push(summaries::unusable_points(*unusable));
    }
    if *offset != [0.0; 3] {
        lines.push(summaries::coordinates_shifted(*offset));
    }
    lines.extend(alignment.as_ref().map(FrameAlignment::describe));
    lines.push(match report.places {
        0 => summaries::NO_FLOOR.to_owned(),
        viewpoints => summaries::virtual_viewpoints(viewpoints),
    });
    lines.join("\n")
}

fn parse_spacing(text: &str) -> Result<f32, String> {
    let metres: f32 = text.parse().map_err(|_| texts::METRES_EXPECTED.to_owned())?;
    if (0.5..=20.0).contains(&metres) { Ok(metres) } else { Err(texts::SPACING_EXPECTED.to_owned()) }
}

fn parse_field_of_view(text: &str) -> Result<FieldOfView, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[down, up]) if (-90.0..up).contains(&down) && up <= 90.0 => Ok(FieldOfView([down, up])),
        _ => Err(texts::FIELD_OF_VIEW_EXPECTED.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_arguments_are_rejected() {
        assert_eq!(parse_field_of_view("-16,15"), Ok(FieldOfView([-16.0, 15.0])));
        for text in ["", "1", "15,-16", "-100,0", "a,b", "0,NaN", "a,-16,15"] {
            assert!(parse_field_of_view(text).is_err(), "{text}");
        }
        assert!(
            parse_spacing("0").is_err() && parse_spacing("nan").is_err() && parse_spacing("1.5") == Ok(1.5)
        );
    }
}
