//! Whether a scan costs more in a larger map: the map of a site, again and again, side by side.

use crate::Arguments;
use crate::known::KnownSite;
use anyhow::{Context, Result};
use benches::stack_walk::{Plan, StackWalk, StepOf};
use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use messages::{LocalisationState, PriorMap, Publication, StackEffect};
use std::sync::Arc;
use std::time::Instant;
use vocab::{KeyframeId, Span};

/// From one copy to the next, metres: nothing of one is seen from the other.
const APART: f64 = 200.0;
/// How long is walked.
const WALKED: Span = Span::from_millis(120_000);

/// Names of the columns. *placed s* is the time from the order to be localised to the first scan that is: the map is taken in then, and
/// the robot, which is told roughly where it is, found there; *sure s* to the first one without a doubt, when the whole map has been
/// searched for places that look alike.
pub fn print_header() {
    println!(
        "{:<8}{:>12}{:>10}{:>10}{:>10}{:>12}{:>10}{:>10}{:>10}",
        "site", "points", "places", "placed s", "sure s", "median ms", "mean ms", "p99 ms", "max ms"
    );
}

/// So many copies of a map on a square grid, the first where it is.
fn copies(known: &PriorMap, count: usize) -> Result<PriorMap> {
    let side = (count as f64).sqrt().ceil() as usize;
    let mut large = PriorMap { map: known.map, graph: known.graph.clone(), places: Vec::new() };
    large.graph.nodes.clear();
    large.graph.edges.clear();
    for copy in 0..count {
        let shift = Isometry::translation(APART * (copy % side) as f64, APART * (copy / side) as f64, 0.0);
        let first = large.graph.nodes.len() as u32;
        for node in &known.graph.nodes {
            let pose = isometry_from_pose(&node.map_from_keyframe).context("a keyframe has no pose")?;
            let mut node = *node;
            node.id = KeyframeId(first + node.id.0);
            node.map_from_keyframe = pose_from_isometry(&(shift * pose));
            large.graph.nodes.push(node);
        }
        for edge in &known.graph.edges {
            let mut edge = *edge;
            (edge.from, edge.to) = (KeyframeId(first + edge.from.0), KeyframeId(first + edge.to.0));
            large.graph.edges.push(edge);
        }
        large.places.extend_from_slice(&known.places);
    }
    Ok(large)
}

/// Walks by a map of at least so many points.
pub fn run(known: &KnownSite, arguments: &Arguments, points: u64) -> Result<()> {
    let of_one: u64 = known.known.places.iter().map(|place| place.points.len() as u64).sum();
    let count = points.div_ceil(of_one.max(1)).max(1);
    let large = Arc::new(copies(&known.known, count as usize)?);
    let places = large.places.len();
    let plan = Plan {
        seed: 100 * arguments.seed + 55,
        columns: arguments.columns,
        people: arguments.people,
        keep_truth: false,
    };
    let start = known.site.route("round").context("the site has no round")?.start;
    let site_from_base = Isometry::from_parts(
        geometry::vec_from_plain(start.position).into(),
        geometry::so3::exp(&(geometry::Vector3::z() * start.yaw)),
    );
    let told = pose_from_isometry(&(known.site_from_map.inverse() * site_from_base));
    let (mut costs, mut sure, mut since_order) = (Vec::new(), false, [None; 2]);
    let begun = Instant::now();
    let mut hear = |of: StepOf, ms: f64, effects: &[StackEffect]| {
        let mut scanned = false;
        for effect in effects {
            match effect {
                StackEffect::Publish(Publication::Localisation(state)) => {
                    sure = matches!(state, LocalisationState::Localised { degradation: None, .. });
                    let placed = matches!(state, LocalisationState::Localised { .. });
                    for (reached, since) in [placed, sure].into_iter().zip(&mut since_order) {
                        if reached {
                            since.get_or_insert_with(|| begun.elapsed().as_secs_f64());
                        }
                    }
                }
                StackEffect::Publish(Publication::Scan(_)) => scanned = true,
                _ => {}
            }
        }
        if sure && scanned && of == StepOf::Sensor {
            costs.push(ms);
        }
    };
    let mut walk = StackWalk::localised(&known.site, "round", &plan, large, Some(told), &mut hear)?;
    walk.walk(WALKED, &mut hear)?;
    costs.sort_by(f64::total_cmp);
    let at = |share: f64| {
        costs.get((share * (costs.len().max(1) - 1) as f64) as usize).copied().unwrap_or(f64::NAN)
    };
    println!(
        "{:<8}{:>12}{:>10}{:>10.2}{:>10.2}{:>12.2}{:>10.2}{:>10.2}{:>10.1}",
        known.site.name(),
        of_one * count,
        places,
        since_order[0].unwrap_or(f64::NAN),
        since_order[1].unwrap_or(f64::NAN),
        at(0.5),
        costs.iter().sum::<f64>() / costs.len().max(1) as f64,
        at(0.99),
        at(1.0)
    );
    Ok(())
}
