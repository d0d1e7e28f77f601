//! Alerts of results and of failed tasks: the edit of the site that raises them. It is applied in the transaction that stores what led to it, and its id follows from that, so that
//! each counts once.

use super::reading_limits::PointReport;
use api::StoredResult;
use messages::StepRecord;
use serde::Deserialize;
use site_model::{
    Alert, AlertCause, AlertId, AlertKey, AlertSeverity, AlertState, Change, Edit, EditId, MissionId, Object,
    ObjectId, OutsideLimits, OutsideReading, Reading, ReadingLimits, RunId, Site, TaskId, TaskState,
    TaskStep, Utc,
};
use std::cmp::Reverse;
use uuid::Uuid;
use vocab::Stamp;

/// Parameters of alerts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct AlertsConfig {
    /// Alerts that a site has at most. Beyond it, closed ones go, the one that was not raised for longest first; the ledger keeps their revisions. Open and acknowledged ones stay.
    /// Chosen: more than people look through, and a tenth of the objects that a site may have.
    pub max_alerts: usize,
}

impl Default for AlertsConfig {
    fn default() -> Self {
        Self { max_alerts: 5_000 }
    }
}

/// What something that was stored says of alerts.
#[derive(Default)]
struct Findings<'a> {
    raised: Vec<(AlertCause, AlertSeverity)>,
    /// What is as it should be again, if it was not.
    recovered: Vec<AlertKey<'a>>,
}

/// What the findings are of. Edits and new alerts have ids that follow from it.
#[derive(Clone, Copy)]
struct Origin {
    run: RunId,
    step: u32,
    attempt: u32,
    kind: OriginKind,
}

/// Kinds of what is stored. The numbers are part of ids.
#[derive(Clone, Copy)]
enum OriginKind {
    Result = 1,
    Step = 2,
}

impl Origin {
    /// An id for each number; 0 is that of the edit.
    fn id(self, number: usize) -> Uuid {
        let (high, low) = self.run.0.as_u64_pair();
        let place = (u64::from(self.step) << 32) | u64::from(self.attempt);
        // Odd factors spread the numbers over all bits; those of the golden ratio, as for changes of the scene, and of the square root of two.
        let number = (number as u64 * 4 + self.kind as u64).wrapping_mul(0x6a09_e667_f3bc_c909);
        Uuid::from_u64_pair(high ^ (place + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15), low ^ number)
    }
}

/// The edit that a result leads to; without changes if it leads to none. Linear in the objects of the site.
pub(super) fn edit_of_result(site: &Site, result: &StoredResult, config: &AlertsConfig) -> Edit {
    let origin =
        Origin { run: result.run, step: result.step, attempt: result.attempt, kind: OriginKind::Result };
    let report = PointReport::of(result, site);
    let findings = report.as_ref().map(|report| judge(result, report)).unwrap_or_default();
    edit_with(site, origin, &findings, Utc(result.at.nanos()), config)
}

/// The edit that a step of a task leads to; without changes if it leads to none. Linear in the objects of the site.
pub(super) fn edit_of_step(site: &Site, step: &StepRecord, at: Stamp, config: &AlertsConfig) -> Edit {
    let origin = Origin { run: step.run, step: step.step, attempt: step.attempt, kind: OriginKind::Step };
    let findings = judge_step(site, step).unwrap_or_default();
    edit_with(site, origin, &findings, Utc(at.nanos()), config)
}

fn judge<'a>(result: &StoredResult, of: &'a PointReport<'_>) -> Findings<'a> {
    let (point, run, number) = (of.point.id, result.run, result.number);
    let mut findings = Findings::default();
    if let Some(limits) = &of.point.limits {
        for reading in of.report.readings.iter().filter(|reading| reading.unit == limits.unit) {
            let Some(outside) = limits.outside(reading) else {
                findings.recovered.push(AlertKey::Reading(point, &reading.name));
                continue;
            };
            let severity = severity_of(reading, limits, outside);
            let Reading { name, value, unit, .. } = reading.clone();
            let reading = OutsideReading { name, value, unit, outside };
            findings
                .raised
                .push((AlertCause::OutsideLimits { point, run, result: number, reading }, severity));
        }
    }
    match (&of.report.gauge, of.gauge_problem()) {
        (Some(_), Some(reason)) => {
            let cause = AlertCause::GaugeNotRead { point, run, result: number, reason: reason.to_owned() };
            findings.raised.push((cause, AlertSeverity::Information));
        }
        (Some(_), None) => findings.recovered.push(AlertKey::Gauge(point)),
        (None, _) => {}
    }
    findings
}

/// A reading that is farther outside than the whole span of its limits is critical. Limits on one side have no span.
fn severity_of(reading: &Reading, limits: &ReadingLimits, outside: OutsideLimits) -> AlertSeverity {
    let (OutsideLimits::Below(limit) | OutsideLimits::Above(limit)) = outside;
    match (limits.min, limits.max) {
        (Some(min), Some(max)) if (reading.value - limit).abs() > max - min => AlertSeverity::Critical,
        _ => AlertSeverity::Warning,
    }
}

/// What the body of a step says of its task. Steps of actions on the way have a `place`.
#[derive(Deserialize)]
struct StepDetails {
    task: TaskId,
    step: TaskStep,
    #[serde(default)]
    place: Option<serde_json::Value>,
}

/// None if it says nothing of a task: most steps are on the way to an outcome.
fn judge_step(site: &Site, record: &StepRecord) -> Option<Findings<'static>> {
    if !record.is_done {
        return None;
    }
    let StepDetails { task, step, place: None } = serde_json::from_str(&record.body).ok()? else {
        return None;
    };
    let mut findings = Findings::default();
    match (step.state(), step.failure()) {
        (TaskState::Failed, Some(failure)) => {
            let mission = mission_of(site, task);
            let reason = missions::task_failure(failure);
            let cause = AlertCause::TaskFailed { mission, task, run: record.run, reason };
            findings.raised.push((cause, AlertSeverity::Warning));
        }
        (TaskState::Succeeded, _) => findings.recovered.push(AlertKey::Task(task)),
        _ => {}
    }
    Some(findings)
}

fn mission_of(site: &Site, task: TaskId) -> Option<MissionId> {
    let has_task = |tasks: &[site_model::Task]| tasks.iter().any(|known| known.id == task);
    site.missions().find(|mission| has_task(&mission.tasks)).map(|mission| mission.id)
}

fn edit_with(site: &Site, origin: Origin, findings: &Findings<'_>, at: Utc, config: &AlertsConfig) -> Edit {
    let mut edit = Edit { id: EditId(origin.id(0)), changes: Vec::new() };
    let known = |key| open_alert(site, key);
    let mut changed: Vec<Alert> = Vec::new();
    // Readings of one name in one result are one cause.
    let is_changed =
        |changed: &[Alert], key: Option<AlertKey<'_>>| changed.iter().any(|alert| alert.cause.key() == key);
    let mut new = 0;
    for (number, (cause, severity)) in (1..).zip(&findings.raised) {
        if is_changed(&changed, cause.key()) {
            continue;
        }
        new += usize::from(known(cause.key()).is_none());
        changed.push(raised(site, AlertId(origin.id(number)), cause, *severity, at));
    }
    for key in &findings.recovered {
        if let Some(alert) = known(Some(*key)).filter(|alert| alert.recovered.is_none())
            && !is_changed(&changed, Some(*key))
        {
            changed.push(Alert { recovered: Some(at), ..alert.clone() });
        }
    }
    for alert in changed {
        edit.changes.extend(site.put(edit.id, Object::Alert(alert)).changes);
    }
    edit.changes.extend(removals(site, new, config));
    edit
}

/// The alert of a cause: the one that nobody has closed yet, raised again, or a new one with this id. Linear in the alerts of the site.
pub(crate) fn raised(
    site: &Site,
    id: AlertId,
    cause: &AlertCause,
    severity: AlertSeverity,
    at: Utc,
) -> Alert {
    if let Some(alert) = open_alert(site, cause.key()) {
        return raised_again(alert, cause, severity, at);
    }
    Alert {
        id,
        severity,
        state: AlertState::Open,
        cause: cause.clone(),
        owner: String::new(),
        work_order: String::new(),
        comment: String::new(),
        first_raised: at,
        last_raised: at,
        times_raised: 1,
        recovered: None,
    }
}

fn open_alert<'a>(site: &'a Site, key: Option<AlertKey<'_>>) -> Option<&'a Alert> {
    key.and_then(|key| site.alerts().find(|alert| !alert.state.is_closed() && alert.cause.key() == Some(key)))
}

/// An alert whose cause was there once more. One that becomes worse is to be looked at again.
fn raised_again(alert: &Alert, cause: &AlertCause, severity: AlertSeverity, at: Utc) -> Alert {
    let is_worse = severity > alert.severity;
    Alert {
        severity: severity.max(alert.severity),
        state: if is_worse { AlertState::Open } else { alert.state.clone() },
        cause: cause.clone(),
        last_raised: at,
        times_raised: alert.times_raised.saturating_add(1),
        recovered: None,
        ..alert.clone()
    }
}

/// Removals of closed alerts: as many as the site would have too many with these new ones.
fn removals(site: &Site, new: usize, config: &AlertsConfig) -> Vec<Change> {
    if new == 0 {
        return Vec::new();
    }
    let excess = (site.alerts().count() + new).saturating_sub(config.max_alerts);
    let mut closed: Vec<&Alert> = site.alerts().filter(|alert| alert.state.is_closed()).collect();
    closed.sort_by_key(|alert| Reverse(alert.last_raised));
    let oldest = closed.into_iter().rev().take(excess);
    oldest.flat_map(|alert| site.removal(EditId(Uuid::nil()), ObjectId::Alert(alert.id)).changes).collect()
}

#[cfg(test)]
#[path = "alerts_tests.rs"]
mod tests;
