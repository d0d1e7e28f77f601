//! The events that a runner needs after a restart.

use super::records::CONFIG;
use site_model::{MissionEvent, MissionEventKind, MonitorId, RunId, ScheduleId, Utc};
use std::collections::{BTreeMap, BTreeSet};

/// Slots that were due before the newest one of their schedule by this time are not needed.
const SLOTS_FOR_NS: i64 = 8 * 24 * 3_600 * 1_000_000_000;

/// Of all events that were committed, those that the next runner needs: of runs that have not ended, of the last days of schedules, and of monitors that hold. In
/// their order. The records that follow from them are those of all events, but for what has ended.
pub fn events_for_restart<'a>(
    events: impl IntoIterator<Item = &'a MissionEvent> + Clone,
) -> Vec<MissionEvent> {
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
    let remembered: BTreeSet<RunId> = ended.iter().rev().take(CONFIG.ended_max).copied().collect();
    let ended: BTreeSet<RunId> = ended.into_iter().collect();
    let is_needed = |(index, event): (usize, &MissionEvent)| match &event.kind {
        MissionEventKind::SlotDecided { schedule, due, .. }
        | MissionEventKind::SlotsMissed { schedule, last_due: due, .. } => {
            newest.get(schedule).is_none_or(|newest| newest.0 - due.0 <= SLOTS_FOR_NS)
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
