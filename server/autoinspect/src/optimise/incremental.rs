//! Incremental optimisation, pose by pose, as on a robot.

use super::problem::GraphProblem;
use crate::process;
use factors::{FactorId, Incremental, IncrementalConfig, Key, RelativePose, SolveError, Value, Values};
use serde::Serialize;

/// CPU time of a step, milliseconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct UpdateTimes {
    pub median: f64,
    pub p99: f64,
    pub max: f64,
}

/// Result of [`solve_incrementally`].
pub struct IncrementalSolution {
    pub values: Values,
    /// Number of updates, one for each pose.
    pub updates: usize,
    /// None without poses.
    pub step_ms: Option<UpdateTimes>,
}

/// Adds the poses one by one, each with its edges to earlier ones.
pub fn solve_incrementally(problem: &GraphProblem) -> Result<IncrementalSolution, SolveError> {
    let mut factors_of: Vec<Vec<FactorId>> = vec![Vec::new(); problem.values.len()];
    for (id, entry) in problem.graph.iter() {
        let newest = entry.factor.keys().iter().map(|key| key.index()).max().unwrap_or(0);
        factors_of[newest].push(id);
    }
    let mut solver = Incremental::new(IncrementalConfig::default());
    let mut times = Vec::with_capacity(factors_of.len());
    for (index, factors) in factors_of.iter().enumerate() {
        let before = process::thread_cpu_time();
        let start = predict(problem, &solver, Key(index as u32), factors)?;
        solver.insert(start);
        for &id in factors {
            let Some(entry) = problem.graph.get(id) else { continue };
            solver.add_shared(entry).map_err(|source| SolveError::Factor { factor: id, source })?;
        }
        solver.update()?;
        times.push((process::thread_cpu_time() - before).as_secs_f64() * 1e3);
    }
    let values = solver.estimates();
    let step_ms = step_times(&mut times);
    Ok(IncrementalSolution { values, updates: factors_of.len(), step_ms })
}

/// Initial value of a new pose: from its predecessor or another earlier pose and their edge, else the file's value.
fn predict(
    problem: &GraphProblem,
    solver: &Incremental,
    key: Key,
    factors: &[FactorId],
) -> Result<Value, SolveError> {
    let other = |id: &FactorId| {
        let keys = problem.graph.get(*id)?.factor.keys();
        keys.iter().find(|other| **other != key).copied()
    };
    let previous = factors.iter().find(|id| other(id).is_some_and(|other| other.index() + 1 == key.index()));
    let chosen = previous.or_else(|| factors.iter().find(|id| other(id).is_some()));
    let (Some(entry), Some(known)) = (chosen.and_then(|id| problem.graph.get(*id)), chosen.and_then(other))
    else {
        return problem.values.get(key).copied().ok_or(SolveError::UnknownVariable { key });
    };
    let forwards = entry.factor.keys().first() == Some(&known);
    Ok(match (solver.estimate(known)?, entry.factor.relative_pose()) {
        (Value::Pose(pose), Some(RelativePose::Space(measured, _))) => {
            Value::Pose(pose * if forwards { measured } else { measured.inverse() })
        }
        (Value::Planar(pose), Some(RelativePose::Plane(measured, _))) => {
            Value::Planar(pose * if forwards { measured } else { measured.inverse() })
        }
        (value, _) => value,
    })
}

fn step_times(times: &mut [f64]) -> Option<UpdateTimes> {
    times.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| times.get((times.len() as f64 * share) as usize).copied();
    Some(UpdateTimes { median: at(0.5)?, p99: at(0.99)?, max: *times.last()? })
}
