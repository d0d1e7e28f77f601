//! Compares the finished map of a walk of the whole stack with the ground truth.

use crate::loop_score::{
    JudgedLoop, Outcome, Score, claimed_error, exceeds_tolerance, is_closed, is_wrong, revisits, score,
    walked,
};
use crate::stack_walk::GroundTruthTrack;
use anyhow::{Context, Result};
use geometry::{Isometry, Matrix6, Vector3, aligned_rmse, isometry_from_pose};
use messages::{FinishedMap, Reanchored};
use sim::SimulatedSite;
use vocab::Stamp;

/// Spacing of the points of the walk that are checked for revisits, metres.
const CHECK_SPACING_M: f64 = 1.0;

/// The score of a walk and its map.
#[derive(Clone, Debug)]
pub struct MapScore {
    /// Score of the loops.
    pub loops: Score,
    /// Distance walked, metres.
    pub distance_m: f64,
    /// Root mean square error of the map's keyframes after the best rigid alignment, metres.
    pub map_rmse_m: f64,
    /// Root mean square error of the trajectory, metres.
    pub trajectory_rmse_m: f64,
    /// Number of confirmed revisits of mapped areas.
    pub reanchorings: usize,
    /// Number of wrong ones among them.
    pub wrong_reanchorings: usize,
    /// Number of pairs that were dropped without verification.
    pub unverified: u64,
    /// The keyframes: true position in the site, and error of the aligned map there, metres.
    pub keyframe_errors: Vec<(Vector3, Vector3)>,
}

/// Scores the map of a walk.
///
/// - `reanchored`: the confirmed revisits of the walk.
///
/// # Errors
/// When a pose is invalid, or there is no ground truth.
pub fn score_map(
    site: &SimulatedSite,
    map: &FinishedMap,
    truth: &GroundTruthTrack,
    reanchored: &[Reanchored],
) -> Result<MapScore> {
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
    let mut whole = MapScore {
        loops: score(site, &true_poses, &judged),
        distance_m: map.distance_m,
        map_rmse_m: rmse(found.iter().copied().zip(true_poses.iter().copied())),
        trajectory_rmse_m: trajectory_error(map, truth)?,
        reanchorings: reanchored.len(),
        wrong_reanchorings: 0,
        unverified: map.unverified,
        keyframe_errors: keyframe_errors(&found, &true_poses),
    };
    let closed = judged
        .iter()
        .filter(|judged| judged.outcome == Outcome::Accepted && !is_wrong(judged, &true_poses))
        .map(|judged| nodes[judged.to].stamp);
    let mut closed: Vec<Stamp> = closed.collect();
    for one in reanchored {
        if is_wrong_reanchoring(one, &true_poses, truth)? {
            whole.wrong_reanchorings += 1;
        } else {
            closed.push(one.stamp);
        }
    }
    closed.sort();
    (whole.loops.revisits, whole.loops.closed) = count_revisits(site, truth, &closed);
    Ok(whole)
}

/// The number of true revisits along the walk, and the number of those that a loop at one of the given times closes.
fn count_revisits(site: &SimulatedSite, truth: &GroundTruthTrack, closed: &[Stamp]) -> (usize, usize) {
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

fn keyframe_errors(found: &[Isometry], truth: &[Isometry]) -> Vec<(Vector3, Vector3)> {
    let places = truth.iter().zip(found).map(|(a, b)| (a.translation.vector, b.translation.vector));
    let places: Vec<(Vector3, Vector3)> = places.collect();
    let Some(alignment) = geometry::umeyama(&places, false) else { return Vec::new() };
    let aligned = |place: &Vector3| (alignment.truth_from_estimate * nalgebra::Point3::from(*place)).coords;
    places.iter().map(|(truth, found)| (*truth, aligned(found) - truth)).collect()
}

fn rmse(pairs: impl Iterator<Item = (Isometry, Isometry)>) -> f64 {
    let places: Vec<_> =
        pairs.map(|(found, truth)| (truth.translation.vector, found.translation.vector)).collect();
    aligned_rmse(&places).unwrap_or(f64::NAN)
}
