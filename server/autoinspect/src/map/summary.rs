//! The summary of a run: `summary.json`, and the same as text for people.

use super::offline_mapper::MappingRun;
use crate::failure::Failure;
use crate::summaries;
use messages::{EdgeKind, FinishedMap, LoopVerdict};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;
use store::MapFilesReport;

/// Results and costs of a run.
#[derive(Debug, Serialize)]
pub struct MappingReport {
    pub inputs: Vec<String>,
    /// Duration in robot time, seconds.
    pub duration_s: f64,
    pub scans: u64,
    pub points: u64,
    /// Points without a return, left out while reading.
    pub dropped_points: u64,
    /// Messages that could not be read.
    pub unreadable_messages: u64,
    pub distance_m: f64,
    pub keyframes: usize,
    pub map_points: u64,
    pub loops: LoopSummary,
    pub degenerate: Vec<Degenerate>,
    /// Warnings of the stack, in order.
    pub notices: Vec<String>,
    pub stages: Vec<Stage>,
    /// CPU time of the stack for a scan and all inputs since the previous one, milliseconds.
    pub scan_ms: CostStatistics,
    /// Wall time from start to end.
    pub seconds: f64,
    /// Robot time over wall time.
    pub times_real_time: f64,
    pub peak_memory_bytes: u64,
    /// BLAKE3 of all effects of the stack, if a journal was written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<String>,
}

/// Loop closures.
#[derive(Debug, Default, Serialize)]
pub struct LoopSummary {
    /// Pairs of keyframes that were proposed.
    pub proposed: u64,
    /// Loops that became edges of the graph.
    pub accepted: u64,
    pub rejected: u64,
    /// Loops that were verified, but too few others are consistent with them.
    pub held: u64,
    /// Loops that were not verified for lack of time.
    pub unverified: u64,
    /// Comparisons with old keyframes in mapped areas. The next field counts those that found the robot near its expected pose.
    pub visits_compared: u64,
    pub visits_confirmed: u64,
}

/// A segment in which LiDAR alone does not determine the motion.
#[derive(Debug, Serialize)]
pub struct Degenerate {
    /// Seconds from the start.
    pub from_s: f64,
    pub until_s: f64,
    pub distance_m: f64,
}

/// One stage of the run. `read` overlaps with `map`.
#[derive(Debug, Serialize)]
pub struct Stage {
    pub name: &'static str,
    /// CPU time of its thread for reading and mapping, wall time for the other stages.
    pub seconds: f64,
    pub peak_memory_bytes: u64,
}

/// Distribution of a cost.
#[derive(Debug, Default, Serialize)]
pub struct CostStatistics {
    pub mean: f64,
    pub median: f64,
    pub p99: f64,
    pub max: f64,
}

impl MappingReport {
    pub fn new(
        inputs: &[PathBuf],
        mapped: &MappingRun,
        files: &MapFilesReport,
        stages: Vec<Stage>,
        took: Duration,
    ) -> Self {
        let (first, last) = (mapped.first.unwrap_or_default(), mapped.last.unwrap_or_default());
        let (duration_s, seconds) = ((last - first).secs_f64(), took.as_secs_f64());
        let degenerate = mapped.finished.degenerate.iter().map(|segment| Degenerate {
            from_s: (segment.from - first).secs_f64(),
            until_s: (segment.until - first).secs_f64(),
            distance_m: segment.distance_m,
        });
        Self {
            inputs: inputs.iter().map(|path| path.display().to_string()).collect(),
            duration_s,
            scans: mapped.scans,
            points: mapped.points,
            dropped_points: mapped.dropped_points,
            unreadable_messages: mapped.unreadable,
            distance_m: mapped.finished.distance_m,
            keyframes: mapped.finished.graph.nodes.len(),
            map_points: files.summary.points,
            loops: loops(&mapped.finished),
            degenerate: degenerate.collect(),
            notices: mapped.notices.clone(),
            peak_memory_bytes: stages.iter().map(|stage| stage.peak_memory_bytes).max().unwrap_or(0),
            stages,
            scan_ms: milliseconds(&mapped.scan_seconds),
            seconds,
            times_real_time: duration_s / seconds.max(1e-9),
            fingerprint: mapped.fingerprint.clone(),
        }
    }

    /// Writes the file.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let text = serde_json::to_vec_pretty(self).map_err(Failure::failed)?;
        std::fs::write(path, text).map_err(|error| Failure::failed(crate::texts::cannot_write(path, &error)))
    }

    /// The summary for people.
    pub fn describe(&self, out: &Path) -> String {
        let mut lines = vec![
            summaries::mapped(
                out,
                self.scans,
                self.points,
                self.distance_m,
                self.duration_s,
                self.keyframes,
                self.map_points,
            ),
            summaries::map_times(
                self.seconds,
                self.times_real_time,
                self.scan_ms.mean,
                self.scan_ms.p99,
                self.peak_memory_bytes,
            ),
        ];
        if self.loops.proposed > 0 {
            lines.push(summaries::loops_closed(self.loops.accepted, self.loops.proposed));
        }
        if !self.degenerate.is_empty() {
            let distance_m: f64 = self.degenerate.iter().map(|segment| segment.distance_m).sum();
            lines.push(summaries::degenerate_segments(self.degenerate.len(), distance_m));
        }
        if self.unreadable_messages > 0 {
            lines.push(summaries::unreadable_messages(self.unreadable_messages));
        }
        lines.join("\n")
    }
}

/// Counts pairs by their latest decision.
fn loops(finished: &FinishedMap) -> LoopSummary {
    let decisions = finished.decisions.iter();
    let last: BTreeMap<_, _> = decisions.map(|d| ((d.task.from, d.task.to), d.verdict)).collect();
    let count = |verdict| last.values().filter(|&&v| v == verdict).count() as u64;
    LoopSummary {
        proposed: last.len() as u64 + finished.unverified,
        accepted: finished.graph.edges.iter().filter(|edge| edge.kind == EdgeKind::Loop).count() as u64,
        rejected: count(LoopVerdict::Rejected),
        held: count(LoopVerdict::Held) + count(LoopVerdict::Dropped),
        unverified: finished.unverified,
        visits_compared: finished.revisits.compared,
        visits_confirmed: finished.revisits.confirmed,
    }
}

/// The distribution; zeros without values.
fn milliseconds(seconds: &[f64]) -> CostStatistics {
    let mut sorted: Vec<f64> = seconds.iter().map(|seconds| seconds * 1e3).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return CostStatistics::default();
    };
    // The quantile by nearest rank.
    let quantile = |fraction: f64| {
        sorted[((fraction * sorted.len() as f64).ceil() as usize).saturating_sub(1).min(last)]
    };
    CostStatistics {
        mean: sorted.iter().sum::<f64>() / sorted.len() as f64,
        median: quantile(0.5),
        p99: quantile(0.99),
        max: sorted[last],
    }
}
