//! The events that a runner needs after a restart.

use super::records::CONFIG;
use crate::calendar::MINUTES_A_DAY;
use site_model::{MissionEvent, MissionEventKind, MonitorId, RunId, ScheduleId, Utc};
use std::collections::{BTreeMap, BTreeSet};
use vocab::Span;

/// Selects the events that a runner needs after a restart from all that were committed, in their order. They are: all events of runs that have not ended; the first
/// and last event of the runs that ended last; the slots of the last days, and the last adoption, of each schedule; the last change of each monitor; and the last
/// docking. Records that are rebuilt from the selection equal those that are rebuilt from all events, except for details of runs that have ended.
pub fn events_for_restart<'a>(
    events: impl IntoIterator<Item = &'a MissionEvent> + Clone,
) -> Vec<MissionEvent> {
    let slots_kept_ns = CONFIG.slots_kept_days * MINUTES_A_DAY * Span::MINUTE.nanos();
    let mut ended: Vec<RunId> = Vec::new();
    let mut newest: BTreeMap<ScheduleId, Utc> = BTreeMap::new();
    let mut adopted: BTreeMap<ScheduleId, usize> = BTreeMap::new();
    let mut monitors: BTreeMap<MonitorId, usize> = BTreeMap::new();
    let mut last_docking = None;
    for (index, event) in events.clone().into_iter().enumerate() {
        match &event.kind {
            MissionEventKind::RunEnded { run, .. } => {
                ended.push(*run);
            }
            MissionEventKind::SlotDecided { schedule, due, .. }
            | MissionEventKind::SlotsMissed { schedule, last_due: due, .. } => {
                let newest = newest.entry(*schedule).or_insert(*due);
                *newest = (*newest).max(*due);
            }
            MissionEventKind::ScheduleAdopted { schedule, .. } => {
                adopted.insert(*schedule, index);
            }
            MissionEventKind::MonitorChanged { monitor, .. } => {
                monitors.insert(*monitor, index);
            }
            MissionEventKind::DockingBegan { .. } => last_docking = Some(index),
            _ => {}
        }
    }
    // Of runs that have ended lately, it is remembered that they were: a command that is repeated does not run them again.
    let remembered: BTreeSet<RunId> = ended.iter().rev().take(CONFIG.max_ended).copied().collect();
    let ended: BTreeSet<RunId> = ended.into_iter().collect();
    let is_needed = |(index, event): (usize, &MissionEvent)| match &event.kind {
        MissionEventKind::SlotDecided { schedule, due, .. }
        | MissionEventKind::SlotsMissed { schedule, last_due: due, .. } => {
            newest.get(schedule).is_none_or(|newest| newest.0 - due.0 <= slots_kept_ns)
        }
        MissionEventKind::ScheduleAdopted { schedule, .. } => adopted.get(schedule) == Some(&index),
        MissionEventKind::MonitorChanged { monitor, .. } => monitors.get(monitor) == Some(&index),
        MissionEventKind::DockingBegan { .. } => last_docking == Some(index),
        MissionEventKind::RunQueued { run, .. } | MissionEventKind::RunEnded { run, .. } => {
            !ended.contains(run) || remembered.contains(run)
        }
        kind => kind.run().is_none_or(|run| !ended.contains(&run)),
    };
    let kept = events.into_iter().enumerate().filter(|(index, event)| is_needed((*index, event)));
    kept.map(|(_, event)| event.clone()).collect()
}
