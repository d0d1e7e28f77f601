//! `autoinspect import`: a point cloud of somebody else's as a map that a robot can work by.

mod upright;

use crate::align::frame_alignment::{self, FrameAlignment, Pair, pair};
use crate::failure::Failure;
use crate::progress::{Progress, lower_priority};
use crate::{map, output};
use api::ImportStage;
use clap::Args;
use formats::FormatError;
use formats::survey::{self, Station, Survey};
use geometry::{Isometry, Vector3, isometry_from_pose, pose_from_isometry};
use mapping::KeyframeDescriptor;
use mapping::virtual_viewpoint::{ViewpointConfig, VirtualViewpoint, VirtualViewpoints, find_viewpoints};
use messages::{EdgeKind, FinishedMap, GraphEdge, GraphNode, PoseGraph, RevisitCounts};
use points::Downsampler;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Instant, UNIX_EPOCH};
use store::{
    MapFileOptions, MapPoints, Store, TileFiles, Viewpoint, visible_points, write_map_files_of,
    write_viewpoint_clouds,
};
use upright::Up;
use uuid::Uuid;
use vocab::{KeyframeId, MapId, SessionId, Stamp};

/// Its keyframes are no poses that a robot measured.
const IMPORTED: MapFileOptions = MapFileOptions { ply: false, has_pose_graph: false };
/// Keyframes' clouds are thinned to this, metres.
const THINNED: f32 = 0.1;
/// How well neighbouring places are known against each other: radians and metres.
const SETTLED: (f64, f64) = (1e-3, 5e-3);
/// And places on pieces of ground that no way joins.
const BRIDGED: (f64, f64) = (1e-2, 0.1);

/// Make a map of somebody else's point cloud, for a robot to work by.
#[derive(Args, Debug)]
#[command(
    after_help = "FILE is PCD, PLY, LAS, LAZ, E57 or PTX, told by how it begins; scans with poses become one cloud. Coordinates far from their
origin are moved near it, and import.json beside the map says by how much. Which axis points up is found by where the floors are; --up
says it. --align-to finds where the cloud lies in a map that is there already, and --pair says it by points picked in both; what a robot
was taught in that map is true in the new one then. The map is what `autoinspect map` writes; its keyframes are places that a robot could stand at, with what it would see from there.

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
    /// Folder for the results; what an earlier run left there is replaced.
    #[arg(long, required_unless_present = "data", conflicts_with = "data")]
    out: Option<PathBuf>,
    /// The data directory of a platform, whose maps this one joins.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Name of the map; the file's if none is given.
    #[arg(long)]
    name: Option<String>,
    /// Which axis of the file points up.
    #[arg(long, value_enum, default_value = "auto", allow_hyphen_values = true)]
    up: Up,
    /// Places to stand at are so far apart, metres.
    #[arg(long, default_value_t = 1.5, value_parser = spacing)]
    spacing: f32,
    /// How far down and up the robot's LiDAR sees, degrees from level.
    #[arg(long, value_name = "DOWN,UP", default_value = "-16,15", value_parser = field, allow_hyphen_values = true)]
    field_of_view: Field,
    /// Folder of a map whose frame the cloud is to be laid into, by what both look like.
    #[arg(long, value_name = "MAP")]
    align_to: Option<PathBuf>,
    /// A point of the file, and where it lies in the frame that the map is to have, metres; two or more.
    #[arg(long, value_name = "X,Y,Z=X,Y,Z", value_parser = pair, conflicts_with = "align_to", allow_hyphen_values = true)]
    pair: Vec<Pair>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Give way to other programs, and print a line of JSON now and then that says how far it is.
    #[arg(long)]
    background: bool,
}

/// Degrees from level, ascending.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Field([f32; 2]);

/// What was read and made of it.
#[derive(Debug, Serialize)]
struct Report {
    /// Where the map is.
    out: PathBuf,
    #[serde(flatten)]
    origin: Origin,
    /// Of the map, metres.
    bounds: [[f32; 3]; 2],
    /// Places to stand at.
    places: u64,
    seconds: Seconds,
}

/// Where a map came from: kept beside it as import.json.
#[derive(Debug, Serialize)]
struct Origin {
    file: PathBuf,
    name: String,
    /// Usable ones.
    points: u64,
    /// Directions in which nothing was hit, and coordinates that are no numbers.
    unusable: u64,
    /// Scans of the file.
    scans: u64,
    /// What was taken off the file's coordinates, metres.
    offset: [f64; 3],
    /// Axis of the file that is the map's z.
    up: Up,
    /// How far places are apart, metres, and how far down and up is seen from them, degrees.
    spacing: f32,
    field_of_view: [f32; 2],
    /// Where it was laid, if another map's frame was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    aligned: Option<FrameAlignment>,
}

#[derive(Debug, Default, Serialize)]
struct Seconds {
    read: f64,
    places: f64,
    write: f64,
}

/// Runs `autoinspect import`.
pub fn run(args: &ImportArgs) -> Result<(), Failure> {
    let mut seconds = Seconds::default();
    if args.background {
        lower_priority();
    }
    let began = Instant::now();
    let mut progress = Progress::new(args.background, ImportStage::Reading);
    let survey = survey::read(&args.file, &mut |share| progress.is(share));
    progress.ends();
    let survey = survey.map_err(|error| unreadable(&args.file, &error))?;
    let mut origin = Origin::of(args, &survey);
    if survey.points() == 0 {
        return Err(Failure::usage(format!("{} holds no points", args.file.display())));
    }
    let mut points = gather(survey.stations);
    seconds.read = began.elapsed().as_secs_f64();

    let began = Instant::now();
    let mut thinned = thin(&points);
    origin.up = args.up.found(&thinned.xyz);
    origin.up.turn(&mut points.xyz);
    origin.up.turn(&mut thinned.xyz);
    let options = ViewpointConfig {
        spacing_m: args.spacing,
        elevations_rad: args.field_of_view.0.map(f32::to_radians),
        ..ViewpointConfig::default()
    };
    let mut progress = Progress::new(args.background, ImportStage::Looking);
    let mut found = find_viewpoints(&thinned.xyz, &options, &mut |share| progress.is(share));
    progress.ends();
    origin.aligned = match &args.align_to {
        Some(map) => Some(frame_alignment::find(seen(&found, &thinned, &options), map, &mut |_| ())?),
        None if args.pair.is_empty() => None,
        None => Some(frame_alignment::align_by_point_pairs(
            &args.pair.iter().map(|pair| origin.as_read(pair)).collect::<Vec<_>>(),
        )?),
    };
    if let Some(aligned) = &origin.aligned {
        aligned.move_points(&mut points.xyz);
        aligned.move_points(&mut thinned.xyz);
        for place in &mut found.viewpoints {
            place.map_from_base = aligned.map_from_cloud() * place.map_from_base;
        }
    }
    let bounds = bounds(&points.xyz);
    seconds.places = began.elapsed().as_secs_f64();

    let began = Instant::now();
    Progress::new(args.background, ImportStage::Writing).is(0.0);
    let finished = finished(&args.file, &origin, &found, id(&thinned, &options));
    let viewpoints = viewpoints(&found, &options);
    let prepare = |map: &Path| {
        write_viewpoint_clouds(&map.join("clouds"), KeyframeId(0), &thinned, &viewpoints)?;
        store::write_json(&map.join("import.json"), &origin)
    };
    let out = if let Some(data) = &args.data {
        let store = Store::open(data).map_err(Failure::usage)?;
        store.add_map(&finished, IMPORTED, points, prepare).map_err(Failure::failed)?;
        store.dir().map(finished.map)
    } else {
        let out = args.out.clone().unwrap_or_default();
        map::prepare(&out)?;
        prepare(&out).map_err(Failure::failed)?;
        let tiles = TileFiles::new(out.join("tiles"));
        write_map_files_of(&out, &tiles, &finished, IMPORTED, points).map_err(Failure::failed)?;
        out
    };
    seconds.write = began.elapsed().as_secs_f64();
    let places = found.viewpoints.len() as u64;
    let report = Report { out, origin, bounds, places, seconds };
    if args.data.is_none() {
        store::write_json(&report.out.join("summary.json"), &report).map_err(Failure::failed)?;
    }
    output::print_human(args.json, &describe(&report));
    output::print_json(args.json, &report)
}

fn unreadable(file: &Path, error: &FormatError) -> Failure {
    Failure::usage(format!("{}: {error}", file.display()))
}

impl Origin {
    fn of(args: &ImportArgs, survey: &Survey) -> Self {
        Self {
            file: args.file.clone(),
            name: name_of(args),
            points: survey.points() as u64,
            unusable: survey.unusable as u64,
            scans: survey.stations.len() as u64,
            offset: survey.offset,
            up: args.up,
            spacing: args.spacing,
            field_of_view: args.field_of_view.0,
            aligned: None,
        }
    }

    /// A pair whose point of the file lies where it was read to.
    fn as_read(&self, pair: &Pair) -> Pair {
        let mut near = [[0, 1, 2].map(|axis| (pair.cloud[axis] - self.offset[axis]) as f32)];
        self.up.turn(&mut near);
        Pair { cloud: near[0].map(f64::from), ..*pair }
    }
}

/// The cloud as a robot would see it from each of its places.
fn seen(
    found: &VirtualViewpoints,
    thinned: &MapPoints,
    options: &ViewpointConfig,
) -> Vec<(Isometry, KeyframeDescriptor)> {
    let mut downsampler = Downsampler::default();
    let place_of = |place: &VirtualViewpoint| {
        let (rotation, sensor) = (&place.map_from_base.rotation, [0.0, 0.0, options.lidar_height_m]);
        (
            place.map_from_base,
            KeyframeDescriptor::new(
                &visible_points(&viewpoint(place, options), &thinned.xyz),
                rotation,
                sensor,
                &mut downsampler,
            ),
        )
    };
    found.viewpoints.iter().map(place_of).collect()
}

/// As asked for, or as the file is called.
fn name_of(args: &ImportArgs) -> String {
    let file = args.file.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    args.name.clone().or(file).unwrap_or_else(|| "Map".to_owned())
}

/// All points in the survey's frame.
fn gather(stations: Vec<Station>) -> MapPoints {
    let mut all = MapPoints::default();
    for Station { survey_from_station, mut xyz, mut intensity, .. } in stations {
        if let Some(pose) = survey_from_station.as_ref().and_then(isometry_from_pose) {
            for point in &mut xyz {
                let placed = pose.rotation * Vector3::from(point.map(f64::from)) + pose.translation.vector;
                *point = placed.map(|coordinate| coordinate as f32).into();
            }
        }
        intensity.resize(xyz.len(), 0.0);
        if all.xyz.is_empty() {
            all = MapPoints { xyz, intensity };
        } else {
            all.xyz.append(&mut xyz);
            all.intensity.append(&mut intensity);
        }
    }
    all
}

fn thin(points: &MapPoints) -> MapPoints {
    let mut centroids = Vec::new();
    Downsampler::default().downsample(&points.xyz, &points.intensity, THINNED, &mut centroids);
    MapPoints {
        xyz: centroids.iter().map(|centroid| centroid.xyz).collect(),
        // What is averaged along with the places.
        intensity: centroids.iter().map(|centroid| centroid.attribute).collect(),
    }
}

fn bounds(xyz: &[[f32; 3]]) -> [[f32; 3]; 2] {
    let of = |pick: fn(f32, f32) -> f32| {
        std::array::from_fn(|axis| xyz.iter().map(|point| point[axis]).reduce(pick).unwrap_or(0.0))
    };
    [of(f32::min), of(f32::max)]
}

/// The places as keyframes, and the ways between them.
fn finished(file: &Path, origin: &Origin, found: &VirtualViewpoints, id: Uuid) -> FinishedMap {
    let nodes = (0..).zip(&found.viewpoints).map(|(number, place)| GraphNode {
        id: KeyframeId(number),
        stamp: Stamp::EPOCH,
        map_from_keyframe: pose_from_isometry(&place.map_from_base),
    });
    let edge = |[from, to]: [usize; 2], (turn, place): (f64, f64)| {
        let mut information = [[0.0; 6]; 6];
        for (index, row) in information.iter_mut().enumerate() {
            row[index] = if index < 3 { turn } else { place }.powi(-2);
        }
        let [a, b] = [from, to].map(|index| found.viewpoints[index].map_from_base);
        GraphEdge {
            from: KeyframeId(from as u32),
            to: KeyframeId(to as u32),
            kind: EdgeKind::Odometry,
            from_from_to: pose_from_isometry(&(a.inverse() * b)),
            information,
        }
    };
    let ways = found.connections.iter().map(|way| edge(*way, SETTLED));
    let bridges = bridges(found).into_iter().map(|bridge| edge(bridge, BRIDGED));
    let edges: Vec<GraphEdge> = ways.chain(bridges).collect();
    FinishedMap {
        map: MapId(id),
        name: origin.name.clone(),
        session: SessionId(Uuid::nil()),
        extends: None,
        at: modified(file),
        distance: 0.0,
        graph: Arc::new(PoseGraph { revision: 1, nodes: nodes.collect(), edges }),
        trajectory: Vec::new(),
        degenerate: Vec::new(),
        decisions: Vec::new(),
        unverified: 0,
        visits: RevisitCounts::default(),
    }
}

/// What joins pieces of ground that no way joins: one graph needs to be one piece.
fn bridges(found: &VirtualViewpoints) -> Vec<[usize; 2]> {
    let mut neighbours = vec![Vec::new(); found.viewpoints.len()];
    for &[a, b] in &found.connections {
        neighbours[a].push(b);
        neighbours[b].push(a);
    }
    let mut reached = vec![false; found.viewpoints.len()];
    let mut bridges = Vec::new();
    for first in 0..found.viewpoints.len() {
        if reached[first] {
            continue;
        }
        if first > 0 {
            bridges.push([0, first]);
        }
        let mut waiting = vec![first];
        while let Some(place) = waiting.pop() {
            if !std::mem::replace(&mut reached[place], true) {
                waiting.extend(&neighbours[place]);
            }
        }
    }
    bridges
}

/// The same points, looked at from the same places, give the same id (FNV-1a of their bits).
fn id(points: &MapPoints, options: &ViewpointConfig) -> Uuid {
    let [down, up] = options.elevations_rad;
    let places = [options.spacing_m, down, up];
    let bits = points.xyz.iter().flatten().chain(&places).map(|number| number.to_bits());
    let mix = |sum: u128, bits: u32| (sum ^ u128::from(bits)).wrapping_mul(0x0100_0000_0000_0000_0000_013b);
    Uuid::from_u128(bits.fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d, mix))
}

/// When the file was last written, or long ago.
fn modified(file: &Path) -> Stamp {
    let since = fs::metadata(file).and_then(|about| about.modified()).ok();
    let since = since.and_then(|at| at.duration_since(UNIX_EPOCH).ok()).unwrap_or_default();
    Stamp::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}

/// The places with what is visible from them, as the store keeps them.
fn viewpoints<'a>(found: &'a VirtualViewpoints, options: &ViewpointConfig) -> Vec<Viewpoint<'a>> {
    found.viewpoints.iter().map(|place| viewpoint(place, options)).collect()
}

fn viewpoint<'a>(place: &'a VirtualViewpoint, options: &ViewpointConfig) -> Viewpoint<'a> {
    Viewpoint {
        cloud_from_base: place.map_from_base,
        lidar: [0.0, 0.0, options.lidar_height_m],
        visible: &place.visible,
    }
}

fn describe(report: &Report) -> String {
    let [min, max] = report.bounds;
    let size: [f32; 3] = std::array::from_fn(|axis| max[axis] - min[axis]);
    let mut lines = vec![format!(
        "{} in {}: {} points of {} scan(s), {:.1} x {:.1} x {:.1} m, {} of the file points up",
        report.origin.name,
        report.out.display(),
        report.origin.points,
        report.origin.scans,
        size[0],
        size[1],
        size[2],
        report.origin.up
    )];
    if report.origin.unusable > 0 {
        lines.push(format!("{} points without a place were left out", report.origin.unusable));
    }
    if report.origin.offset != [0.0; 3] {
        let [x, y, z] = report.origin.offset;
        lines.push(format!("{x:.0} {y:.0} {z:.0} m were taken off the coordinates"));
    }
    lines.extend(report.origin.aligned.as_ref().map(FrameAlignment::describe));
    lines.push(match report.places {
        0 => "no floor was found to stand on: it can be looked at, but no robot can work by it".to_owned(),
        places => format!("{places} places to stand at"),
    });
    lines.join("\n")
}

fn spacing(text: &str) -> Result<f32, String> {
    let metres: f32 = text.parse().map_err(|_| "a number of metres is expected".to_owned())?;
    if (0.5..=20.0).contains(&metres) { Ok(metres) } else { Err("0.5 to 20 m are possible".into()) }
}

fn field(text: &str) -> Result<Field, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|word| word.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[down, up]) if (-90.0..up).contains(&down) && up <= 90.0 => Ok(Field([down, up])),
        _ => Err("two angles are expected, the lower first, like -16,15".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::{Pose, Quat, Vec3};

    #[test]
    fn scans_with_poses_become_one_cloud() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turned = Pose {
            position: Vec3::new(10.0, 0.0, 0.0),
            orientation: Quat { w: half, x: 0.0, y: 0.0, z: half },
        };
        let station = |pose, intensity| Station {
            name: None,
            survey_from_station: pose,
            xyz: vec![[1.0, 2.0, 3.0]],
            intensity,
        };
        let all = gather(vec![station(None, vec![7.0]), station(Some(turned), Vec::new())]);
        assert_eq!(all.intensity, [7.0, 0.0]);
        let apart =
            |point: [f32; 3], wanted: [f32; 3]| (0..3).any(|axis| (point[axis] - wanted[axis]).abs() > 1e-5);
        assert!(!apart(all.xyz[0], [1.0, 2.0, 3.0]) && !apart(all.xyz[1], [8.0, 1.0, 3.0]), "{:?}", all.xyz);
        assert_eq!(bounds(&all.xyz)[0], [1.0, 1.0, 3.0]);
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        assert_eq!(field("-16,15"), Ok(Field([-16.0, 15.0])));
        for text in ["", "1", "15,-16", "-100,0", "a,b", "0,NaN", "a,-16,15"] {
            assert!(field(text).is_err(), "{text}");
        }
        assert!(spacing("0").is_err() && spacing("nan").is_err() && spacing("1.5") == Ok(1.5));
    }
}
