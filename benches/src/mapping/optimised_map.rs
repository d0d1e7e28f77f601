//! Keyframe positions after optimisation with the accepted loops, compared with the ground truth.

use crate::find_loops::LoopFinderRun;
use crate::recorded_walk::RecordedKeyframe;
use anyhow::Result;
use factors::{BatchConfig, Between, FactorGraph, Key, Prior, Value, Values, optimise};
use geometry::{Isometry, Matrix6, Vector3, aligned_rmse};
use mapping::Verdict;

/// Root mean square errors of keyframes after the best rigid alignment, metres.
#[derive(Clone, Copy, Debug)]
pub struct MapError {
    pub odometry: f64,
    pub closed: f64,
}

/// Optimises the walk with the accepted loops and compares the keyframes before and after with the ground truth.
pub fn error(recorded: &[RecordedKeyframe], found: &LoopFinderRun) -> Result<MapError> {
    let mut values = Values::default();
    let mut graph = FactorGraph::default();
    let mut pose = Isometry::identity();
    let mut keys: Vec<Key> = vec![values.insert(Value::Pose(pose))];
    for edge in &found.edges {
        pose *= edge.from_from_to;
        keys.push(values.insert(Value::Pose(pose)));
    }
    graph.add(Prior::new(keys[0], &Isometry::identity(), &(Matrix6::identity() * 1e8))?, &values)?;
    let accepted = found.decisions.iter().filter(|decision| decision.verdict == Verdict::Accepted);
    for edge in found.edges.iter().chain(accepted.map(|decision| &decision.edge)) {
        let (from, to) = (keys[edge.from.0 as usize], keys[edge.to.0 as usize]);
        graph.add(Between::new(from, to, &edge.from_from_to, &edge.information)?, &values)?;
    }
    let solved = optimise(&graph, &values, &BatchConfig::default())?.values;
    let positions = |values: &Values| -> Result<Vec<Vector3>> {
        keys.iter().map(|&key| Ok(values.pose(key)?.translation.vector)).collect()
    };
    let truth: Vec<Vector3> = recorded.iter().map(|k| k.site_from_base.translation.vector).collect();
    Ok(MapError { odometry: rmse(&positions(&values)?, &truth), closed: rmse(&positions(&solved)?, &truth) })
}

/// Root mean square error after the best rigid alignment, metres.
fn rmse(found: &[Vector3], truth: &[Vector3]) -> f64 {
    let pairs: Vec<_> = truth.iter().copied().zip(found.iter().copied()).collect();
    aligned_rmse(&pairs).unwrap_or(f64::NAN)
}
