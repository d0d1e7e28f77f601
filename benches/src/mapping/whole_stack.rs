//! Runs the whole stack on a walk and compares its finished map with the ground truth.

use crate::score::{
    JudgedLoop, Outcome, Score, claimed_error, exceeds_tolerance, is_closed, is_wrong, revisits, score,
    walked,
};
use anyhow::{Context, Result};
use benches::stack_walk::{GroundTruthTrack, StackWalk, StepKind, WalkPlan, made_keyframe, reanchorings};
use geometry::{Isometry, Matrix6, aligned_rmse, isometry_from_pose};
use messages::{FinishedMap, Reanchored};
use sim::Site;
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Spacing of the points of the walk that are checked for revisits, metres.
const CHECK_SPACING_M: f64 = 1.0;

/// The results of a walk.
pub struct WholeStackRun {
    pub score: Score,
    /// Distance walked, metres.
    pub distance: f64,
    /// Root mean square error of the map's keyframes after the best rigid alignment, metres.
    pub error: f64,
    /// Root mean square error of the trajectory, metres.
    pub trajectory_error: f64,
    /// Number of confirmed revisits of mapped areas, and the number of wrong ones among them.
    pub reanchorings: usize,
    pub wrong_reanchorings: usize,
    /// CPU time of steps that made a keyframe, milliseconds.
    pub keyframe_ms: Vec<f64>,
    /// CPU time of steps that took the result of a job, milliseconds.
    pub job_result_ms: Vec<f64>,
    /// Number of pairs that were dropped without verification.
    pub unverified: u64,
}

/// Walks for `duration`, finishes the map and scores it.
pub fn walk(site: &Arc<Site>, plan: &WalkPlan, duration: Span) -> Result<WholeStackRun> {
    let (mut keyframe_ms, mut job_result_ms, mut reanchored) = (Vec::new(), Vec::new(), Vec::new());
    let mut observer = |kind: StepKind, ms: f64, effects: &[messages::StackEffect]| {
        match kind {
            StepKind::Sensor if made_keyframe(effects) => keyframe_ms.push(ms),
            StepKind::JobResult => job_result_ms.push(ms),
            _ => {}
        }
        reanchored.extend(reanchorings(effects).copied());
    };
    let mut walk = StackWalk::new(site, "round", plan, &mut observer)?;
    walk.walk_until(duration, &mut observer)?;
    let (map, truth) = walk.finish(&mut observer)?;

    let nodes = &map.graph.nodes;
    let true_poses: Vec<Isometry> = nodes
        .iter()
        .map(|node| truth.interpolate(node.stamp))
        .collect::<Option<_>>()
        .context("there is no truth")?;
    let found: Vec<Isometry> = nodes
        .iter()
        .map(|node| isometry_from_pose(&node.map_from_keyframe))
        .collect::<Option<_>>()
        .context("a keyframe's pose is none")?;
    let judged: Vec<JudgedLoop> = map
        .decisions
        .iter()
        .map(|decision| JudgedLoop::from_decision(decision, &map.graph.edges))
        .collect::<Option<_>>()
        .context("a loop's pose is none")?;
    let mut whole = WholeStackRun {
        score: score(site, &true_poses, &judged),
        distance: map.distance_m,
        error: rmse(found.iter().copied().zip(true_poses.iter().copied())),
        trajectory_error: trajectory_error(&map, &truth)?,
        reanchorings: reanchored.len(),
        wrong_reanchorings: 0,
        keyframe_ms,
        job_result_ms,
        unverified: map.unverified,
    };
    let closed = judged
        .iter()
        .filter(|judged| judged.outcome == Outcome::Accepted && !is_wrong(judged, &true_poses))
        .map(|judged| nodes[judged.to].stamp);
    let mut closed: Vec<Stamp> = closed.collect();
    for one in &reanchored {
        if is_wrong_reanchoring(one, &true_poses, &truth)? {
            whole.wrong_reanchorings += 1;
        } else {
            closed.push(one.stamp);
        }
    }
    closed.sort();
    (whole.score.revisits, whole.score.closed) = count_revisits(site, &truth, &closed);
    Ok(whole)
}

/// The number of true revisits along the walk, and the number of those that a loop at one of the given times closes.
fn count_revisits(site: &Site, truth: &GroundTruthTrack, closed: &[Stamp]) -> (usize, usize) {
    let samples = truth.sample(CHECK_SPACING_M);
    let (stamps, poses): (Vec<Stamp>, Vec<Isometry>) = samples.into_iter().unzip();
    let walked = walked(&poses);
    let at = |stamp: &Stamp| walked.get(stamps.partition_point(|s| s < stamp)).copied().unwrap_or(f64::MAX);
    let closed_at: Vec<f64> = closed.iter().map(at).collect();
    let revisits = revisits(site, &poses);
    let closed = revisits.iter().filter(|&&revisit| is_closed(walked[revisit], &closed_at)).count();
    (revisits.len(), closed)
}

fn is_wrong_reanchoring(
    reanchored: &Reanchored,
    keyframes: &[Isometry],
    truth: &GroundTruthTrack,
) -> Result<bool> {
    let keyframe = keyframes.get(reanchored.keyframe.0 as usize).context("a revisit of no keyframe")?;
    let base = truth.interpolate(reanchored.stamp).context("there is no truth")?;
    let found =
        isometry_from_pose(&reanchored.keyframe_from_base).context("the pose of a revisit is invalid")?;
    let off = (keyframe.inverse() * base).inverse() * found;
    let information = Matrix6::from_fn(|row, column| reanchored.information[row][column]);
    Ok(exceeds_tolerance(claimed_error(&off, &information)))
}

fn trajectory_error(map: &FinishedMap, truth: &GroundTruthTrack) -> Result<f64> {
    let pairs: Vec<(Isometry, Isometry)> = map
        .trajectory
        .iter()
        .map(|(stamp, pose)| Some((isometry_from_pose(pose)?, truth.interpolate(*stamp)?)))
        .collect::<Option<_>>()
        .context("a pose of the trajectory is none")?;
    Ok(rmse(pairs.into_iter()))
}

fn rmse(pairs: impl Iterator<Item = (Isometry, Isometry)>) -> f64 {
    let places: Vec<_> =
        pairs.map(|(found, truth)| (truth.translation.vector, found.translation.vector)).collect();
    aligned_rmse(&places).unwrap_or(f64::NAN)
}
