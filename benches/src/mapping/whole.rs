//! The whole stack on a walk: the map that it hands over against the truth.

use crate::score::{
    Judged, Outcome, Score, claimed_error, is_closed, is_far, is_wrong, revisits, score, walked,
};
use anyhow::{Context, Result};
use benches::stack_walk::{Plan, StackWalk, StepOf, Truth, made_keyframe, ties};
use geometry::{Isometry, Matrix6, aligned_rmse, isometry_from_pose};
use messages::{FinishedMap, Reanchored};
use sim::Site;
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Where the walk is asked whether it is back at an old place, metres.
const ASKED_EVERY: f64 = 1.0;

/// What came of a walk.
pub struct Whole {
    pub score: Score,
    /// Metres walked.
    pub distance: f64,
    /// Root mean square error of the map's keyframes after the best rigid alignment, metres.
    pub error: f64,
    /// The same of the trajectory.
    pub track_error: f64,
    /// Revisits to known ground that were confirmed, and those among them that are wrong.
    pub ties: usize,
    pub wrong_ties: usize,
    /// CPU time of steps that made a keyframe and of steps that took a verified pair in, milliseconds.
    pub keyframe_ms: Vec<f64>,
    pub loop_ms: Vec<f64>,
    /// Pairs that there was no time to look at.
    pub unverified: u64,
}

/// Walks for so long, finishes the map and judges it.
pub fn walk(site: &Arc<Site>, plan: &Plan, length: Span) -> Result<Whole> {
    let (mut keyframe_ms, mut loop_ms, mut tied) = (Vec::new(), Vec::new(), Vec::new());
    let mut heard = |of: StepOf, ms: f64, said: &[messages::StackEffect]| {
        match of {
            StepOf::Sensor if made_keyframe(said) => keyframe_ms.push(ms),
            StepOf::Verified => loop_ms.push(ms),
            _ => {}
        }
        tied.extend(ties(said).copied());
    };
    let mut walk = StackWalk::new(site, "round", plan, &mut heard)?;
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
    let judged: Vec<Judged> = map
        .decisions
        .iter()
        .map(|decision| Judged::told(decision, &map.graph.edges))
        .collect::<Option<_>>()
        .context("a loop's pose is none")?;
    let mut whole = Whole {
        score: score(site, &true_poses, &judged),
        distance: map.distance,
        error: rmse(found.iter().copied().zip(true_poses.iter().copied())),
        track_error: track_error(&map, &truth)?,
        ties: tied.len(),
        wrong_ties: 0,
        keyframe_ms,
        loop_ms,
        unverified: map.unverified,
    };
    let closed = judged
        .iter()
        .filter(|judged| judged.outcome == Outcome::Accepted && !is_wrong(judged, &true_poses))
        .map(|judged| nodes[judged.to].stamp);
    let mut closed: Vec<Stamp> = closed.collect();
    for tied in &tied {
        if tie_is_wrong(tied, &true_poses, &truth)? {
            whole.wrong_ties += 1;
        } else {
            closed.push(tied.stamp);
        }
    }
    closed.sort();
    (whole.score.revisits, whole.score.closed) = count_revisits(site, &truth, &closed);
    Ok(whole)
}

/// True revisits along the whole walk, and those near which one of the moments given lies.
fn count_revisits(site: &Site, truth: &Truth, closed: &[Stamp]) -> (usize, usize) {
    let samples = truth.every(ASKED_EVERY);
    let (stamps, poses): (Vec<Stamp>, Vec<Isometry>) = samples.into_iter().unzip();
    let walked = walked(&poses);
    let at = |stamp: &Stamp| walked.get(stamps.partition_point(|s| s < stamp)).copied().unwrap_or(f64::MAX);
    let closed_at: Vec<f64> = closed.iter().map(at).collect();
    let revisits = revisits(site, &poses);
    let closed = revisits.iter().filter(|&&revisit| is_closed(walked[revisit], &closed_at)).count();
    (revisits.len(), closed)
}

fn tie_is_wrong(tied: &Reanchored, keyframes: &[Isometry], truth: &Truth) -> Result<bool> {
    let keyframe = keyframes.get(tied.keyframe.0 as usize).context("a visit to no keyframe")?;
    let base = truth.at(tied.stamp).context("there is no truth")?;
    let found = isometry_from_pose(&tied.keyframe_from_base).context("a visit's pose is none")?;
    let off = (keyframe.inverse() * base).inverse() * found;
    let information = Matrix6::from_fn(|row, column| tied.information[row][column]);
    Ok(is_far(claimed_error(&off, &information)))
}

fn track_error(map: &FinishedMap, truth: &Truth) -> Result<f64> {
    let pairs: Vec<(Isometry, Isometry)> = map
        .trajectory
        .iter()
        .map(|(stamp, pose)| Some((isometry_from_pose(pose)?, truth.at(*stamp)?)))
        .collect::<Option<_>>()
        .context("a pose of the trajectory is none")?;
    Ok(rmse(pairs.into_iter()))
}

fn rmse(pairs: impl Iterator<Item = (Isometry, Isometry)>) -> f64 {
    let places: Vec<_> =
        pairs.map(|(found, truth)| (truth.translation.vector, found.translation.vector)).collect();
    aligned_rmse(&places).unwrap_or(f64::NAN)
}
