//! CPU times of a walk's steps, for each minute.

use crate::step_times::StepTimes;
use anyhow::{Context, Result};
use benches::quantile;
use benches::stack_walk::{StepKind, has_estimate, made_keyframe, reanchorings};
use geometry::{Isometry, isometry_from_pose};
use messages::{EdgeKind, Publication, StackEffect};

/// One minute of a walk.
#[derive(Clone, Copy, Debug)]
pub struct Minute {
    /// Number of the minute, from 1.
    pub number: u32,
    /// Number of times that the route was walked to its end.
    pub rounds: u32,
    /// Distance between the estimated and the true position at the end of the minute, millimetres.
    pub position_error_mm: f64,
    /// Number of revisits of mapped areas that were confirmed in this minute.
    pub revisits: usize,
    /// Scans that gave an estimate.
    pub scans: usize,
    /// Mean CPU time of a step that takes a scan, milliseconds.
    pub mean_ms: f64,
    /// Its 99th percentile, milliseconds.
    pub p99_ms: f64,
    /// Resident memory of the process at the end of the minute, megabytes.
    pub resident_mb: f64,
    /// Keyframes so far.
    pub keyframes: u64,
    /// Median CPU time of steps that make a keyframe, milliseconds.
    pub keyframe_median_ms: f64,
    /// Greatest CPU time of such a step, milliseconds.
    pub max_keyframe_ms: f64,
    /// Median CPU time of steps that take the result of a job, milliseconds.
    pub job_result_median_ms: f64,
    /// Greatest CPU time of such a step, milliseconds.
    pub max_job_result_ms: f64,
    /// Loops closed so far.
    pub loops: usize,
}

/// CPU times of steps, and state that the stack published.
#[derive(Default)]
pub struct Measurement {
    /// CPU times of all steps of the walk that took a scan, milliseconds.
    all_scan_ms: Vec<f64>,
    /// For each of them, the longest step from then until the next one, milliseconds.
    longest_between_ms: Vec<f64>,
    /// For each of them, the sum of its time and that of all steps until the next one, milliseconds.
    sum_ms: Vec<f64>,
    /// Number of those before the present minute.
    scans_before: usize,
    /// CPU times of the steps of this minute that made a keyframe, milliseconds.
    keyframe_ms: Vec<f64>,
    /// CPU times of the steps of this minute that took the result of a job, milliseconds.
    job_result_ms: Vec<f64>,
    keyframes: u64,
    loops: usize,
    revisits: usize,
    map_from_base: Option<Isometry>,
}

impl Measurement {
    /// Adds one step. A scan is processed once IMU samples reach its end, so this may be the step on a message of any sensor.
    pub fn update(&mut self, kind: StepKind, ms: f64, effects: &[StackEffect]) {
        if kind == StepKind::Sensor && has_estimate(effects) {
            self.all_scan_ms.push(ms);
            self.longest_between_ms.push(0.0);
            self.sum_ms.push(ms);
        } else if let (Some(longest_ms), Some(sum_ms)) =
            (self.longest_between_ms.last_mut(), self.sum_ms.last_mut())
        {
            *longest_ms = longest_ms.max(ms);
            *sum_ms += ms;
        }
        if made_keyframe(effects) {
            self.keyframes += 1;
            self.keyframe_ms.push(ms);
        }
        if kind == StepKind::JobResult {
            self.job_result_ms.push(ms);
        }
        self.revisits += reanchorings(effects).count();
        for effect in effects {
            match effect {
                StackEffect::Publish(Publication::Graph { graph, .. }) => {
                    self.loops = graph.edges.iter().filter(|edge| edge.kind == EdgeKind::Loop).count();
                }
                StackEffect::Publish(Publication::GraphDelta(delta)) => {
                    let added = delta.edges.iter().filter(|edge| edge.kind == EdgeKind::Loop).count();
                    self.loops = (self.loops + added).saturating_sub(delta.removed_loops.len());
                }
                StackEffect::Publish(Publication::Estimate(estimate)) => {
                    self.map_from_base = isometry_from_pose(&estimate.map_from_base);
                }
                _ => {}
            }
        }
    }

    /// Distance between the last estimate and the truth, millimetres.
    pub fn position_error_mm(&self, site_from_map: &Isometry, site_from_base: &Isometry) -> f64 {
        self.map_from_base.map_or(f64::NAN, |map_from_base| {
            let estimated = site_from_map * map_from_base;
            (estimated.translation.vector - site_from_base.translation.vector).norm() * 1e3
        })
    }

    /// Ends a minute.
    ///
    /// # Errors
    /// When no scan gave an estimate in it, or memory cannot be read.
    pub fn end_minute(&mut self, number: u32, rounds: u32, position_error_mm: f64) -> Result<Minute> {
        let mut scan_ms = self.all_scan_ms[self.scans_before..].to_vec();
        self.scans_before = self.all_scan_ms.len();
        anyhow::ensure!(!scan_ms.is_empty(), "no scan gave an estimate for a whole minute");
        scan_ms.sort_by(f64::total_cmp);
        let take_sorted = |times: &mut Vec<f64>| {
            let mut times = std::mem::take(times);
            times.sort_by(f64::total_cmp);
            [0.5, 1.0].map(|share| if times.is_empty() { 0.0 } else { quantile(&times, share) })
        };
        let [keyframe_median_ms, max_keyframe_ms] = take_sorted(&mut self.keyframe_ms);
        let [job_result_median_ms, max_job_result_ms] = take_sorted(&mut self.job_result_ms);
        Ok(Minute {
            number,
            rounds,
            position_error_mm,
            revisits: std::mem::take(&mut self.revisits),
            scans: scan_ms.len(),
            mean_ms: scan_ms.iter().sum::<f64>() / scan_ms.len() as f64,
            p99_ms: quantile(&scan_ms, 0.99),
            resident_mb: resident_mb()?,
            keyframes: self.keyframes,
            keyframe_median_ms,
            max_keyframe_ms,
            job_result_median_ms,
            max_job_result_ms,
            loops: self.loops,
        })
    }

    /// CPU times of the steps of the walk.
    pub fn into_step_times(self) -> StepTimes {
        StepTimes::new(self.all_scan_ms, self.longest_between_ms, self.sum_ms)
    }
}

/// Resident memory of this process, megabytes.
fn resident_mb() -> Result<f64> {
    let statm =
        std::fs::read_to_string("/proc/self/statm").context("memory is read from /proc/self/statm")?;
    let pages: f64 = statm
        .split(' ')
        .nth(1)
        .and_then(|pages| pages.parse().ok())
        .context("/proc/self/statm has no number of pages")?;
    Ok(pages * rustix::param::page_size() as f64 * 1e-6)
}
