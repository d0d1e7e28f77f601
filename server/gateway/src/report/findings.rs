//! The first look at a run: what is counted at the head of a report, and what needs attention. Lists have a greatest length, so that memory is bounded.

use super::compared::comparison;
use super::context::{ReportContext, legible_name};
use super::rows::{Attempt, ResultContent, ResultRow, RunRow, for_each_task, reason};
use super::texts;
use crate::runs::{CoreQueries, for_each_result};
use site_model::{ActionReport, Alert, NodeId, OutsideLimits, Reading, SceneChange, TaskState, Utc};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use vocab::legible;

/// Entries of each list of one run at most. All are counted. Chosen: more than people read, and 500 runs with full lists take some 30 MB.
const MAX_LISTED: usize = 100;

/// What a run has brought.
#[derive(Default)]
pub(super) struct Findings {
    pub(super) counts: Counts,
    pub(super) readings: BoundedList<OutsideReading>,
    pub(super) gauges: BoundedList<GaugeNotRead>,
    pub(super) not_done: BoundedList<TaskNotDone>,
    /// Steps with a reading outside its limits, a gauge that was not read or a photo that has changed, and nodes where that was.
    steps: BTreeSet<u32>,
    nodes: BTreeSet<NodeId>,
}

/// Numbers for the head of a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// Tasks.
    pub(super) tasks: usize,
    pub(super) done: usize,
    pub(super) failed: usize,
    pub(super) skipped: usize,
    /// Readings outside their limits.
    pub(super) outside: usize,
    /// Changes of the scene.
    pub(super) changes: usize,
}

impl Counts {
    /// Tasks that were neither done nor failed nor skipped.
    pub(super) fn open(&self) -> usize {
        self.tasks.saturating_sub(self.done + self.failed + self.skipped)
    }

    /// Of both.
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            tasks: self.tasks + other.tasks,
            done: self.done + other.done,
            failed: self.failed + other.failed,
            skipped: self.skipped + other.skipped,
            outside: self.outside + other.outside,
            changes: self.changes + other.changes,
        }
    }
}

/// A list of which only the first entries are kept.
pub(super) struct BoundedList<T> {
    pub(super) entries: Vec<T>,
    /// Entries that were not kept.
    pub(super) more: usize,
}

impl<T> Default for BoundedList<T> {
    fn default() -> Self {
        Self { entries: Vec::new(), more: 0 }
    }
}

impl<T> BoundedList<T> {
    fn push(&mut self, entry: T) {
        if self.entries.len() < MAX_LISTED {
            self.entries.push(entry);
        } else {
            self.more += 1;
        }
    }
}

/// A reading that does not keep the limits of its inspection point.
pub(super) struct OutsideReading {
    pub(super) place: String,
    pub(super) reading: Reading,
    pub(super) outside: OutsideLimits,
    pub(super) at: Utc,
}

/// A gauge in a picture that gave no value.
pub(super) struct GaugeNotRead {
    pub(super) place: String,
    pub(super) reason: String,
    pub(super) at: Utc,
}

/// A task that has failed or was skipped, or an action on the way that has failed.
pub(super) struct TaskNotDone {
    pub(super) place: String,
    pub(super) action: String,
    pub(super) state: &'static str,
    pub(super) reason: String,
    pub(super) at: Utc,
}

impl Findings {
    /// Reads all attempts and results of a run once.
    ///
    /// # Errors
    /// When the core fails.
    pub(super) fn read(cx: &ReportContext, core: &dyn CoreQueries, run: &RunRow) -> io::Result<Self> {
        let mut findings = Self::default();
        let mut places = BTreeMap::new();
        for_each_task(core, run.run, |attempts| {
            findings.add_task(cx, run, attempts, &mut places);
            Ok(())
        })?;
        for_each_result(core, run.run, |stored| {
            let row = ResultRow::of(&stored);
            if comparison(&stored).is_some_and(|comparison| !comparison.changes().is_empty()) {
                findings.note_place(&row);
            }
            findings.add_result(cx, &row, &places);
            Ok(())
        })?;
        let counts = &mut findings.counts;
        counts.tasks = counts.tasks.max(run.tasks as usize);
        counts.changes = changes_found(cx, run).count();
        Ok(findings)
    }

    /// Whether nothing of the run needs attention.
    pub(super) fn is_empty(&self) -> bool {
        self.readings.entries.is_empty()
            && self.gauges.entries.is_empty()
            && self.not_done.entries.is_empty()
            && self.counts.changes == 0
    }

    /// Whether pictures of a task belong to what needs attention: it was not done, it has a reading outside its limits, a gauge that was not
    /// read or a photo that differs from the one before, or another task has where it is done.
    pub(super) fn needs_attention(&self, attempts: &[Attempt]) -> bool {
        attempts.last().is_some_and(|last| {
            last.is_failed_or_skipped()
                || self.steps.contains(&last.step)
                || last.node.is_some_and(|node| self.nodes.contains(&node))
        })
    }

    fn add_task(
        &mut self,
        cx: &ReportContext,
        run: &RunRow,
        attempts: &[Attempt],
        places: &mut BTreeMap<u32, String>,
    ) {
        let Some(last) = attempts.last() else { return };
        if last.is_of_task() {
            self.counts.tasks += 1;
            match last.state {
                Some(TaskState::Succeeded) => self.counts.done += 1,
                Some(TaskState::Failed) => self.counts.failed += 1,
                Some(TaskState::Skipped) => self.counts.skipped += 1,
                _ => {}
            }
        }
        let place = cx.place_of(run.mission, last);
        if let Some(state) = last.state.filter(|_| last.is_failed_or_skipped()) {
            self.not_done.push(TaskNotDone {
                place: place.clone(),
                action: cx.action_of(last),
                state: texts::task_state(state),
                reason: reason(attempts).unwrap_or_default(),
                at: last.ended.unwrap_or(last.began),
            });
        }
        places.insert(last.step, place);
    }

    fn add_result(&mut self, cx: &ReportContext, result: &ResultRow, places: &BTreeMap<u32, String>) {
        let ResultContent::Report(report) = &result.content else { return };
        let unnamed = || texts::DELETED_PLACE.to_owned();
        let place = || places.get(&result.step).cloned().unwrap_or_else(unnamed);
        if let Some(reason) = gauge_problem(report) {
            self.note_place(result);
            self.gauges.push(GaugeNotRead { place: place(), reason, at: result.at });
        }
        let Some(limits) = cx.limits(result.point) else { return };
        for reading in &report.readings {
            let Some(outside) = limits.outside(reading) else { continue };
            self.counts.outside += 1;
            self.note_place(result);
            let (name, unit) = (legible_name(&reading.name), legible_name(&reading.unit));
            let reading = Reading { name, unit, ..reading.clone() };
            self.readings.push(OutsideReading { place: place(), reading, outside, at: result.at });
        }
    }

    /// Notes where a result needs attention.
    fn note_place(&mut self, result: &ResultRow) {
        self.steps.insert(result.step);
        self.nodes.extend(result.node);
    }
}

/// Why the gauge of a picture gave no value; none if it did, or there is none.
pub(super) fn gauge_problem(report: &ActionReport) -> Option<String> {
    let problem = report.gauge.as_ref()?.problem.as_ref()?;
    Some(legible(problem, texts::MAX_SENTENCE_CHARS))
}

/// Alerts that nobody has closed, of those that were raised before the last of these runs had ended: the worst first, and then those raised last.
pub(super) fn open_alerts<'a>(cx: &'a ReportContext, ended: &[Option<Utc>]) -> BoundedList<&'a Alert> {
    // A run that goes on ends after all that has been.
    let until = ended.iter().map(|ended| ended.unwrap_or(Utc(i64::MAX))).max();
    let is_open =
        |alert: &&Alert| !alert.state.is_closed() && until.is_some_and(|until| alert.first_raised <= until);
    let mut alerts: Vec<&Alert> = cx.site().alerts().filter(is_open).collect();
    alerts.sort_by_key(|alert| (Reverse(alert.severity), Reverse(alert.last_raised), alert.id));
    let mut listed = BoundedList::default();
    alerts.into_iter().for_each(|alert| listed.push(alert));
    listed
}

/// Changes of the scene that this run has found last.
pub(super) fn changes_found<'a>(
    cx: &'a ReportContext,
    run: &RunRow,
) -> impl Iterator<Item = &'a SceneChange> {
    let run = run.run;
    cx.site().scene_changes().filter(move |change| change.after == run)
}
