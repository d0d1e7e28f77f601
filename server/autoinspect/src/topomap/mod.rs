//! `autoinspect topomap`: makes a topological map from a saved map.

mod document;
mod geojson;
mod svg;

use crate::export::map_summary;
use crate::failure::Failure;
use crate::{output, summaries, texts};
use api::MapSummary;
use clap::{Args, ValueEnum};
use messages::RobotProfile;
use serde::Serialize;
use site_model::Traversal;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;
use store::TopomapSource;
use topomap::{GeneratedMap, TopomapConfig};
use vocab::{MapId, Pose, Quat, Vec3};

/// Make a topological map, nodes and edges, from a saved map.
#[derive(Args, Debug)]
#[command(after_help = "FILE's ending says the format:
  .json .yaml .yml   the objects of the site: nodes, edges and docks
  .geojson           a route graph for Nav2

EXAMPLES:
  autoinspect topomap m --out hall.yaml
  autoinspect topomap m --svg hall.svg                  a picture of each floor with its nodes and edges
  autoinspect topomap m --dock 0,0,0,0 --out hall.json  with the dock at which the walk began")]
pub struct TopomapArgs {
    /// Folder of the map: the result of `autoinspect map --out` or `import`, or one of the folders in a data directory's maps/.
    map: PathBuf,
    /// The file to write.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Format of that file [default: by FILE's ending].
    #[arg(long, value_enum, requires = "out")]
    format: Option<Format>,
    /// Also draw it into this SVG file.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Pose of the robot on a dock: position in the map, metres, and heading, degrees [default: those known of the map].
    #[arg(long = "dock", value_name = "X,Y,Z,HEADING", value_parser = dock_pose, allow_hyphen_values = true)]
    docks: Vec<Pose>,
    /// Radius in which the robot turns, metres.
    #[arg(long, value_parser = length)]
    radius: Option<f64>,
    /// Height of the highest step that it takes, metres.
    #[arg(long, value_parser = length)]
    step: Option<f64>,
    /// Height above the ground that must be free, metres.
    #[arg(long, value_parser = length)]
    clearance: Option<f64>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// File formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Json,
    #[value(alias = "yml")]
    Yaml,
    Geojson,
}

/// The result, for people and programs.
#[derive(Debug, Serialize)]
struct Report {
    map: MapId,
    nodes: usize,
    edges: usize,
    stairs: usize,
    docks: usize,
    floors: usize,
    /// Of one direction of each edge.
    length_m: f64,
    blocked: usize,
    pieces: usize,
    read_s: f64,
    generate_s: f64,
}

/// Runs `autoinspect topomap`.
pub fn run(args: &TopomapArgs) -> Result<(), Failure> {
    let format = args.out.as_deref().map(|out| {
        let format = args.format.or_else(|| format_of(out));
        format.ok_or_else(|| Failure::usage(texts::unknown_topomap_format(out)))
    });
    let format = format.transpose()?;
    let summary = map_summary(&args.map)?;
    let docks =
        if args.docks.is_empty() { TopomapSource::known_docks(&args.map) } else { args.docks.clone() };
    let start = Instant::now();
    let source = TopomapSource::read(&args.map, &docks, &profile(args), TopomapConfig::default())
        .map_err(Failure::usage)?;
    let read_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let made = source.generate();
    let generate_s = start.elapsed().as_secs_f64();
    if let (Some(out), Some(format)) = (&args.out, format) {
        let text = match format {
            Format::Json => document::json(&summary, &made)?,
            Format::Yaml => document::yaml(&summary, &made)?,
            Format::Geojson => geojson::geojson(&made)?,
        };
        fs::write(out, text).map_err(|error| Failure::failed(texts::cannot_write(out, &error)))?;
    }
    if let Some(out) = &args.svg {
        let text = svg::draw(&args.map, &made)?;
        fs::write(out, text).map_err(|error| Failure::failed(texts::cannot_write(out, &error)))?;
    }
    let report = report(&summary, &made, read_s, generate_s);
    output::print_human(args.json, &texts::topomap_made(&args.map, &report.describe()));
    output::print_json(args.json, &report)
}

/// The robot's shape.
fn profile(args: &TopomapArgs) -> RobotProfile {
    let usual = RobotProfile::default();
    RobotProfile {
        footprint_radius_m: args.radius.unwrap_or(usual.footprint_radius_m),
        step_height_m: args.step.unwrap_or(usual.step_height_m),
        clearance_height_m: args.clearance.unwrap_or(usual.clearance_height_m),
        ..usual
    }
}

fn report(summary: &MapSummary, made: &GeneratedMap, read_s: f64, generate_s: f64) -> Report {
    let floors: std::collections::BTreeSet<i32> = made.nodes.iter().map(|node| node.floor).collect();
    Report {
        map: summary.id,
        nodes: made.nodes.len(),
        edges: made.edges.len(),
        stairs: made.edges.iter().filter(|edge| edge.traversal == Traversal::Stairs).count(),
        docks: made.docks.len(),
        floors: floors.len(),
        length_m: made.length_m(),
        blocked: made.blocked.len(),
        pieces: made.pieces,
        read_s,
        generate_s,
    }
}

impl Report {
    fn describe(&self) -> String {
        let Self { nodes, edges, stairs, floors, length_m, docks, .. } = *self;
        let made = summaries::topomap(nodes, edges, stairs, floors, length_m, docks);
        let making = summaries::topomap_making(self.blocked, self.pieces, self.read_s, self.generate_s);
        [made, making].join("; ")
    }
}

/// Positions of the nodes of an edge.
fn ends(made: &GeneratedMap, edge: &site_model::Edge) -> Option<[Vec3; 2]> {
    let position = |id| made.nodes.iter().find(|node| node.id == id).map(|node| node.map_from_node.position);
    Some([position(edge.from)?, position(edge.to)?])
}

fn edge_length_m(made: &GeneratedMap, edge: &site_model::Edge) -> Option<f64> {
    let [a, b] = ends(made, edge)?;
    Some(((a.x - b.x).powi(2) + (a.y - b.y).powi(2) + (a.z - b.z).powi(2)).sqrt())
}

/// Heading of a pose, radians.
fn heading_rad(q: &Quat) -> f64 {
    (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z))
}

fn format_of(path: &Path) -> Option<Format> {
    Format::from_str(&path.extension()?.to_string_lossy(), true).ok()
}

fn dock_pose(text: &str) -> Result<Pose, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|word| word.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, z, degrees] if numbers.iter().all(|number| number.is_finite()) => {
            let half = degrees.to_radians() / 2.0;
            let orientation = Quat { w: half.cos(), x: 0.0, y: 0.0, z: half.sin() };
            Ok(Pose { position: Vec3::new(x, y, z), orientation })
        }
        _ => Err(texts::DOCK_EXPECTED.to_owned()),
    }
}

fn length(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| texts::METRES_EXPECTED.to_owned())?;
    if value > 0.0 && value <= 10.0 { Ok(value) } else { Err(texts::ROBOT_LENGTH_EXPECTED.to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dock_has_a_position_and_a_heading() {
        let pose = dock_pose("1,-2.5, 0,90").expect("a pose");
        assert_eq!(pose.position, Vec3::new(1.0, -2.5, 0.0));
        assert!((heading_rad(&pose.orientation) - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        for wrong in ["", "1,2,3", "1,2,3,4,5", "a,b,c,d", "1,2,3,inf"] {
            assert!(dock_pose(wrong).is_err(), "{wrong}");
        }
    }
}
