//! Bytes of graph updates that a client receives during a session of thousands of keyframes, compared with the bytes of the whole graph for every
//! update. The session is synthetic: parallel lanes, with a loop to the previous lane at the end of each.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

use anyhow::{Context, Result};
use api::{Graph, GraphChanged, GraphNode};
use clap::Parser;
use geometry::{Isometry, Matrix6, RngTree, Vector3, Vector6, pose_from_isometry};
use mapping::{
    GraphChanges, GraphPublisher, KeyframePair, OptimiserConfig, PoseGraph, PoseGraphEdge, PoseGraphNode,
};
use plotters::prelude::*;
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, Stamp};

/// Keyframes of a lane, 1 m apart.
const LANE: u32 = 50;
/// Distance between lanes, metres.
const LANE_DISTANCE_M: f64 = 2.0;
/// Standard deviations of an odometry edge, radians and metres.
const STEP_STD: [f64; 2] = [1e-3, 5e-3];
/// The whole graph is encoded for one in this many updates, to save time.
const SAMPLED: u32 = 50;

/// Bytes of graph updates compared with whole graphs.
#[derive(Debug, Parser)]
#[command(about = "Bytes of graph updates over a long session")]
struct Arguments {
    /// Number of keyframes.
    #[arg(long, default_value_t = 5_000)]
    keyframes: u32,
    /// File of the plot.
    #[arg(long, default_value = "docs/benchmarks/graph-updates.svg")]
    svg: PathBuf,
}

/// Label, colour and value of a line of the plot.
type Curve = (&'static str, RGBColor, fn(&Row) -> f64);

/// The figures after a number of keyframes.
#[derive(Clone, Copy, Debug)]
struct Row {
    keyframes: u32,
    loops: usize,
    /// Sum of all updates so far, MB.
    changes_mb: f64,
    /// The sum if every update were the whole graph, MB.
    whole_mb: f64,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let rows = measure(arguments.keyframes);
    println!("| keyframes | loops | updates, MB | bytes a keyframe | whole graphs, MB |");
    println!("| --- | --- | --- | --- | --- |");
    for row in rows.iter().filter(|row| row.keyframes % (arguments.keyframes / 5).max(1) == 0) {
        println!(
            "| {} | {} | {:.2} | {:.0} | {:.0} |",
            row.keyframes,
            row.loops,
            row.changes_mb,
            row.changes_mb * 1e6 / f64::from(row.keyframes),
            row.whole_mb
        );
    }
    draw(&arguments.svg, &rows)
}

fn measure(keyframes: u32) -> Vec<Row> {
    let mut rng = RngTree::new(1).child("graph updates").rng();
    let mut graph = PoseGraph::new(OptimiserConfig::default());
    let mut publisher = GraphPublisher::default();
    let mut client = Graph::default();
    let (mut changes_bytes, mut whole_bytes, mut rows) = (0_usize, 0_usize, Vec::new());
    for number in 0..keyframes {
        let step = number.checked_sub(1).map(|last| {
            let deviations = Vector6::new(0.1, 0.1, 1.0, 0.0, 0.0, 0.0) * STEP_STD[0]
                + Vector6::new(0.0, 0.0, 0.0, 1.0, 1.0, 0.2) * STEP_STD[1];
            let error = deviations.map(|deviation| deviation * rng.normal());
            let relative = geometry::se3::retract(&(truth(last).inverse() * truth(number)), &error);
            edge((last, number), relative)
        });
        let last = graph.nodes().last().map_or_else(Isometry::identity, |node| node.map_from_keyframe);
        let pose = step.as_ref().map_or(last, |step| last * step.from_from_to);
        graph.add_distance(1.0);
        graph.add_keyframe(Stamp::EPOCH, &pose, step.as_ref());
        changes_bytes += send(publisher.update(&graph), &mut client);
        if number >= LANE && number % LANE == LANE - 1 {
            // The keyframe of the previous lane that is beside the end of this lane.
            let beside = number + 1 - 2 * LANE;
            graph.add_loop(&edge((beside, number), truth(beside).inverse() * truth(number)));
            graph.optimise();
            changes_bytes += send(publisher.update(&graph), &mut client);
        }
        if (number + 1) % SAMPLED == 0 {
            whole_bytes += api::encode(&client).len() * SAMPLED as usize;
            rows.push(Row {
                keyframes: number + 1,
                loops: graph.loops().len(),
                changes_mb: changes_bytes as f64 * 1e-6,
                whole_mb: whole_bytes as f64 * 1e-6,
            });
        }
    }
    rows
}

/// Pose of a keyframe on lanes that are walked back and forth.
fn truth(number: u32) -> Isometry {
    let (lane, along) = (number / LANE, number % LANE);
    let (x, yaw) = match lane % 2 {
        0 => (f64::from(along), 0.0),
        _ => (f64::from(LANE - 1 - along), std::f64::consts::PI),
    };
    Isometry::new(Vector3::new(x, f64::from(lane) * LANE_DISTANCE_M, 0.0), Vector3::z() * yaw)
}

fn edge((from, to): (u32, u32), from_from_to: Isometry) -> PoseGraphEdge {
    let [rotation, translation] = STEP_STD.map(|deviation| deviation.powi(-2));
    let information = Vector6::new(rotation, rotation, rotation, translation, translation, translation);
    PoseGraphEdge {
        from: KeyframeId(from),
        to: KeyframeId(to),
        from_from_to,
        information: Matrix6::from_diagonal(&information),
    }
}

/// Encodes an update, applies it in the client, and returns its size in bytes.
fn send(changes: Option<GraphChanges>, client: &mut Graph) -> usize {
    let Some(changes) = changes else { return 0 };
    let pairs =
        |edges: &[PoseGraphEdge]| -> Vec<KeyframePair> { edges.iter().map(|e| (e.from, e.to)).collect() };
    let node = |node: &PoseGraphNode| GraphNode {
        id: node.id,
        stamp: node.stamp,
        map_from_keyframe: pose_from_isometry(&node.map_from_keyframe),
    };
    let changed = GraphChanged {
        session: None,
        base_revision: changes.base_revision,
        revision: changes.revision,
        nodes: changes.nodes.iter().map(node).collect(),
        edges: pairs(&changes.edges),
        removed_loops: changes.removed_loops,
        loops: pairs(&changes.loops),
    };
    assert!(client.apply(&changed), "changes of another revision");
    api::encode(&changed).len()
}

fn draw(path: &Path, rows: &[Row]) -> Result<()> {
    let last = rows.last().context("fewer keyframes than one sample")?;
    let root = SVGBackend::new(path, (760, 320)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption("Bytes of graph updates to a client, MB", ("sans-serif", 15))
        .margin(10)
        .x_label_area_size(28)
        .y_label_area_size(46)
        .build_cartesian_2d(0.0..f64::from(last.keyframes), 0.0..last.changes_mb * 2.0)?;
    chart.configure_mesh().light_line_style(WHITE).x_desc("keyframes").draw()?;
    let curves: [Curve; 2] = [
        ("changes", RGBColor(31, 111, 178), |row| row.changes_mb),
        ("the whole graph every time", RGBColor(200, 120, 30), |row| row.whole_mb),
    ];
    for (label, colour, value) in curves {
        let top = last.changes_mb * 2.0;
        let line = rows.iter().map(|row| (f64::from(row.keyframes), value(row))).filter(|(_, y)| *y <= top);
        chart
            .draw_series(LineSeries::new(line, colour.stroke_width(2)))?
            .label(label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .border_style(BLACK.mix(0.2))
        .draw()?;
    root.present().with_context(|| format!("{} cannot be written", path.display()))
}
