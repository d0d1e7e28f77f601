//! The whole stack on a walk: the map that it hands over against the truth.

use crate::score::{Judged, Score, score};
use anyhow::{Context, Result};
use benches::stack_walk::{Plan, StackWalk, StepOf, made_keyframe};
use geometry::{Isometry, aligned_rmse, isometry_from_pose};
use sim::Site;
use std::sync::Arc;
use vocab::Span;

/// What came of a walk.
pub struct Whole {
    pub score: Score,
    /// Metres walked.
    pub distance: f64,
    /// Root mean square error of the map's keyframes after the best rigid alignment, metres.
    pub error: f64,
    /// CPU time of steps that made a keyframe and of steps that took a verified pair in, milliseconds.
    pub keyframe_ms: Vec<f64>,
    pub loop_ms: Vec<f64>,
    /// Pairs that there was no time to look at.
    pub unverified: u64,
}

/// Walks for so long, finishes the map and judges it.
pub fn walk(site: &Arc<Site>, plan: &Plan, length: Span) -> Result<Whole> {
    let (mut keyframe_ms, mut loop_ms) = (Vec::new(), Vec::new());
    let mut heard = |of: StepOf, ms: f64, said: &[messages::Effect]| match of {
        StepOf::Sensor if made_keyframe(said) => keyframe_ms.push(ms),
        StepOf::Verified => loop_ms.push(ms),
        _ => {}
    };
    let mut walk = StackWalk::new(site, plan, &mut heard)?;
    walk.walk(length, &mut heard)?;
    let (map, truth) = walk.finish(&mut heard)?;

    let nodes = &map.graph.nodes;
    let true_poses: Vec<Isometry> =
        nodes.iter().map(|node| truth.at(node.stamp)).collect::<Option<_>>().context("there is no truth")?;
    let found: Vec<Isometry> = nodes
        .iter()
        .map(|node| isometry_from_pose(&node.map_from_keyframe))
        .collect::<Option<_>>()
        .context("a keyframe's pose is none")?;
    let place = |pose: &Isometry| pose.translation.vector;
    let pairs: Vec<_> = true_poses.iter().map(place).zip(found.iter().map(place)).collect();
    let judged: Vec<Judged> = map
        .decisions
        .iter()
        .map(|decision| Judged::told(decision, &map.graph.edges))
        .collect::<Option<_>>()
        .context("a loop's pose is none")?;
    Ok(Whole {
        score: score(site, &true_poses, &judged),
        distance: map.distance,
        error: aligned_rmse(&pairs).unwrap_or(f64::NAN),
        keyframe_ms,
        loop_ms,
        unverified: map.unverified,
    })
}
