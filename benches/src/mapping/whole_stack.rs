//! Runs the whole stack on a walk and scores its finished map.

use anyhow::Result;
use benches::map_score::{MapScore, score_map};
use benches::stack_walk::{StackWalk, StepKind, WalkPlan, made_keyframe, reanchorings};
use sim::SimulatedSite;
use std::sync::Arc;
use vocab::Span;

/// The results of a walk.
pub struct WholeStackRun {
    pub score: MapScore,
    /// CPU time of steps that made a keyframe, milliseconds.
    pub keyframe_ms: Vec<f64>,
    /// CPU time of steps that took the result of a job, milliseconds.
    pub job_result_ms: Vec<f64>,
}

/// Walks for `duration`, finishes the map and scores it.
pub fn walk(site: &Arc<SimulatedSite>, plan: &WalkPlan, duration: Span) -> Result<WholeStackRun> {
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
    Ok(WholeStackRun { score: score_map(site, &map, &truth, &reanchored)?, keyframe_ms, job_result_ms })
}
