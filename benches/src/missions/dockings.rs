//! Dockings one after the other, each from another node, with docks where the map has them, docks that were moved, and contacts that fail. Scored by the truth.

use super::Arguments;
use anyhow::{Context, Result, ensure};
use benches::mission_runs::{MissionDay, MissionSite, docked_error};
use benches::quantile;
use geometry::RngTree;
use messages::{GoalKind, GoalStatus};
use sim::{SimConfig, Start};
use site_model::{NodeId, NodeKind};
use std::sync::Arc;

/// What is the matter with the dock.
struct Scenario {
    name: &'static str,
    /// Forward, left (m) and turn (rad), as a docked robot looks.
    moved: [f64; 3],
    /// Share of the attempts at which no current flows.
    contact_failure_share: f64,
}

const SCENARIOS: [Scenario; 3] = [
    Scenario { name: "as mapped", moved: [0.0; 3], contact_failure_share: 0.0 },
    Scenario { name: "moved by 15 cm and 8°", moved: [0.06, 0.137, 0.14], contact_failure_share: 0.0 },
    Scenario { name: "half of the contacts fail", moved: [0.0; 3], contact_failure_share: 0.5 },
];

/// Longest time for a goal, robot time.
const GOAL_LIMIT_S: f64 = 240.0;
/// Nodes from which the robot comes are this near to the dock, metres.
const MAX_START_DISTANCE_M: f64 = 15.0;

/// Prints a row for each scenario.
pub(super) fn print(name: &str, mapped: &MissionSite, arguments: &Arguments) -> Result<()> {
    println!("| site | dock | docked | position: mean, worst | heading: mean, worst | time: median, worst |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for (number, scenario) in SCENARIOS.iter().enumerate() {
        let mut errors = Vec::new();
        let mut times_s = Vec::new();
        let mut failures = Vec::new();
        for outcome in dock_again_and_again(mapped, scenario, number as u64 + 1, arguments)? {
            match outcome {
                Ok((error, duration_s)) => {
                    errors.push(error);
                    times_s.push(duration_s);
                }
                Err(failure) => failures.push(failure),
            }
        }
        times_s.sort_by(f64::total_cmp);
        let column = |pick: &dyn Fn(&(f64, f64)) -> f64| {
            let values: Vec<f64> = errors.iter().map(pick).collect();
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            (mean, values.iter().copied().fold(0.0, f64::max))
        };
        let (mean_cm, worst_cm) = column(&|error| 100.0 * error.0);
        let (mean_deg, worst_deg) = column(&|error| error.1.to_degrees());
        println!(
            "| {name} | {} | {} of {} | {mean_cm:.1}, {worst_cm:.1} cm | {mean_deg:.2}, {worst_deg:.2}° | {:.0}, {:.0} s |",
            scenario.name,
            errors.len(),
            errors.len() + failures.len(),
            quantile(&times_s, 0.5),
            quantile(&times_s, 1.0),
        );
        failures.iter().for_each(|failure| println!("not docked: {failure}"));
    }
    Ok(())
}

/// For each docking, the error by the truth (m, rad) and its time (s), or how it failed.
type Docking = Result<((f64, f64), f64), String>;

fn dock_again_and_again(
    mapped: &MissionSite,
    scenario: &Scenario,
    seed: u64,
    arguments: &Arguments,
) -> Result<Vec<Docking>> {
    let [forward_m, left_m, turn_rad] = scenario.moved;
    let site = Arc::new(mapped.site.with_moved_dock(0, forward_m, left_m, turn_rad));
    let place = site.docks().first().context("the site has no dock")?;
    let config = SimConfig {
        lidar_columns: arguments.columns,
        people: arguments.people,
        start: Some(Start { position: place.position, yaw: place.yaw }),
        dock_contact_failure_share: scenario.contact_failure_share,
        ..SimConfig::new(Arc::clone(&site), seed)
    };
    let mut day = MissionDay::begin(config, mapped, mapped.graph.clone())?;
    let dock = mapped.graph.docks().next().context("the topological map has no dock")?.clone();
    let nodes = near_nodes(mapped, dock.node)?;
    let mut rng = RngTree::new(seed).child("dockings").rng();
    let mut dockings = Vec::new();
    for number in 0..arguments.dockings {
        let node = nodes[((rng.uniform() * nodes.len() as f64) as usize).min(nodes.len() - 1)];
        day.go(GoalKind::GoToNode(node), GOAL_LIMIT_S);
        let began = day.lockstep.now();
        let outcome = day.go(GoalKind::GoToDock(dock.id), GOAL_LIMIT_S);
        let docking = match outcome {
            Some(GoalStatus::Succeeded(_)) => {
                let error = docked_error(day.lockstep.simulator()).context("the site has a dock")?;
                Ok((error, (day.lockstep.now() - began).secs_f64()))
            }
            other => Err(format!("{other:?}")),
        };
        if arguments.verbose {
            println!("{}: docking {}: {docking:?}", scenario.name, number + 1);
        }
        dockings.push(docking);
    }
    Ok(dockings)
}

fn near_nodes(mapped: &MissionSite, dock: NodeId) -> Result<Vec<NodeId>> {
    let graph = &mapped.graph;
    let place = graph.node(dock).context("the dock has a node")?.map_from_node.position;
    let is_near = |node: &&site_model::Node| {
        let at = node.map_from_node.position;
        let is_start_candidate =
            !matches!(node.kind, NodeKind::Dock | NodeKind::DockApproach | NodeKind::Portal);
        is_start_candidate && (at.x - place.x).hypot(at.y - place.y) <= MAX_START_DISTANCE_M
    };
    let nodes: Vec<NodeId> = graph.nodes().filter(is_near).map(|node| node.id).collect();
    ensure!(!nodes.is_empty(), "no node is within {MAX_START_DISTANCE_M} m of the dock");
    Ok(nodes)
}
