//! CPU time of a scan in larger maps, which consist of copies of the map of a site side by side.

use crate::arguments::Arguments;
use anyhow::{Context, Result};
use benches::mapped_site::MappedSite;
use benches::quantile;
use benches::stack_walk::{StackWalk, StepKind, WalkPlan};
use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use messages::{LocalisationState, PriorMap, Publication, StackEffect};
use std::sync::Arc;
use std::time::Instant;
use vocab::{KeyframeId, Span};

/// Distance between neighbouring copies, metres. Nothing of one copy is visible from another.
const COPY_SPACING_M: f64 = 200.0;
/// Length of the walk.
const WALK_DURATION: Span = Span::from_millis(120_000);

/// Prints the names of the columns. *localised s* is the time from the command to the first localised scan: by then the map is loaded, and the
/// robot is localised near its pose prior. *confirmed s* is the time to the first scan without degradation: by then the whole map has been
/// searched for similar poses.
pub fn print_header() {
    println!(
        "{:<8}{:>12}{:>10}{:>13}{:>13}{:>12}{:>10}{:>10}{:>10}",
        "site", "points", "places", "localised s", "confirmed s", "median ms", "mean ms", "p99 ms", "max ms"
    );
}

/// A map of `count` copies of a map on a square grid. The first copy has the original poses.
fn tile_map(map: &PriorMap, count: usize) -> Result<PriorMap> {
    let side = (count as f64).sqrt().ceil() as usize;
    let mut large = PriorMap { map: map.map, graph: map.graph.clone(), keyframes: Vec::new() };
    large.graph.nodes.clear();
    large.graph.edges.clear();
    for copy in 0..count {
        let shift = Isometry::translation(
            COPY_SPACING_M * (copy % side) as f64,
            COPY_SPACING_M * (copy / side) as f64,
            0.0,
        );
        let first = large.graph.nodes.len() as u32;
        for node in &map.graph.nodes {
            let pose = isometry_from_pose(&node.map_from_keyframe).context("a keyframe has no pose")?;
            let mut node = *node;
            node.id = KeyframeId(first + node.id.0);
            node.map_from_keyframe = pose_from_isometry(&(shift * pose));
            large.graph.nodes.push(node);
        }
        for edge in &map.graph.edges {
            let mut edge = *edge;
            (edge.from, edge.to) = (KeyframeId(first + edge.from.0), KeyframeId(first + edge.to.0));
            large.graph.edges.push(edge);
        }
        large.keyframes.extend_from_slice(&map.keyframes);
    }
    Ok(large)
}

/// Walks in a map of at least `points` points.
pub fn run(mapped: &MappedSite, arguments: &Arguments, points: u64) -> Result<()> {
    let of_one: u64 = mapped.prior_map.keyframes.iter().map(|place| place.points.len() as u64).sum();
    let count = points.div_ceil(of_one.max(1)).max(1);
    let large = Arc::new(tile_map(&mapped.prior_map, count as usize)?);
    let places = large.keyframes.len();
    let plan = WalkPlan {
        seed: 100 * arguments.seed + 55,
        columns: arguments.columns,
        people: arguments.people,
        keep_ground_truth: false,
    };
    let start = mapped.site.route("round").context("the site has no round")?.start;
    let site_from_base = Isometry::from_parts(
        geometry::vec_from_plain(start.position).into(),
        geometry::so3::exp(&(geometry::Vector3::z() * start.yaw)),
    );
    let pose_prior = pose_from_isometry(&(mapped.site_from_map.inverse() * site_from_base));
    let (mut scan_ms, mut is_confirmed, mut reached_after_s) = (Vec::new(), false, [None; 2]);
    let begun = Instant::now();
    let mut observer = |kind: StepKind, ms: f64, effects: &[StackEffect]| {
        let mut scanned = false;
        for effect in effects {
            match effect {
                StackEffect::Publish(Publication::Localisation(state)) => {
                    is_confirmed = matches!(state, LocalisationState::Localised { degradation: None, .. });
                    let is_localised = matches!(state, LocalisationState::Localised { .. });
                    for (reached, after_s) in
                        [is_localised, is_confirmed].into_iter().zip(&mut reached_after_s)
                    {
                        if reached {
                            after_s.get_or_insert_with(|| begun.elapsed().as_secs_f64());
                        }
                    }
                }
                StackEffect::Publish(Publication::Scan(_)) => scanned = true,
                _ => {}
            }
        }
        if is_confirmed && scanned && kind == StepKind::Sensor {
            scan_ms.push(ms);
        }
    };
    let mut walk =
        StackWalk::localised(&mapped.site, "round", &plan, large, Some(pose_prior), &mut observer)?;
    walk.walk_until(WALK_DURATION, &mut observer)?;
    scan_ms.sort_by(f64::total_cmp);
    println!(
        "{:<8}{:>12}{:>10}{:>13.2}{:>13.2}{:>12.2}{:>10.2}{:>10.2}{:>10.1}",
        mapped.site.name(),
        of_one * count,
        places,
        reached_after_s[0].unwrap_or(f64::NAN),
        reached_after_s[1].unwrap_or(f64::NAN),
        quantile(&scan_ms, 0.5),
        scan_ms.iter().sum::<f64>() / scan_ms.len().max(1) as f64,
        quantile(&scan_ms, 0.99),
        quantile(&scan_ms, 1.0)
    );
    Ok(())
}
