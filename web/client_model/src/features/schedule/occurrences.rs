//! The occurrences of schedules in a span of time, and where they meet.

use missions::{ClockChange, SiteZone, Slots};
use site_model::{LocalDateTime, MissionId, Schedule, ScheduleId, Site, Utc};
use vocab::Span;

/// Parameters of the occurrences that are listed.
struct OccurrencesConfig {
    /// Occurrences of one schedule that are shown at once. A schedule by the minute has more in a week; they would only hide each other. Chosen: a week has 672 quarters of an hour.
    max_of_one_schedule: usize,
}

const CONFIG: OccurrencesConfig = OccurrencesConfig { max_of_one_schedule: 700 };

/// What becomes of an occurrence by what the schedule says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OccurrenceState {
    /// It runs.
    Planned,
    /// A person left it out.
    Skipped,
    /// The schedule is paused.
    Paused,
    /// Another one of the schedule is due at the same instant, because clocks go forward.
    SameInstant,
}

/// A slot of a schedule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occurrence {
    /// The schedule.
    pub schedule: ScheduleId,
    /// What runs.
    pub mission: MissionId,
    /// Local time that names the slot.
    pub slot: LocalDateTime,
    /// When it is due.
    pub due: Utc,
    /// How it meets a change of the clocks.
    pub change: ClockChange,
    /// What becomes of it.
    pub state: OccurrenceState,
}

impl Occurrence {
    /// Whether it runs, by what is known now.
    pub fn is_planned(&self) -> bool {
        self.state == OccurrenceState::Planned
    }
}

/// Occurrences of all schedules.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SchedulePlan {
    /// In the order in which they are due.
    pub occurrences: Vec<Occurrence>,
    /// Schedules of which not all occurrences are listed, because they have too many.
    pub shortened: Vec<ScheduleId>,
    /// Schedules whose rule cannot be used, each with the reason.
    pub unusable: Vec<(ScheduleId, String)>,
}

/// The occurrences that are due from an instant on, before another one.
pub fn plan_schedules(site: &Site, zone: &SiteZone, from: Utc, until: Utc) -> SchedulePlan {
    let mut plan = SchedulePlan::default();
    for schedule in site.schedules() {
        let slots = match Slots::new(&schedule.recurrence, zone) {
            Ok(slots) => slots,
            Err(error) => {
                plan.unusable.push((schedule.id, error.to_string()));
                continue;
            }
        };
        let before = Utc(from.0.saturating_sub(1));
        let mut due = slots.after(before).take_while(|slot| slot.due < until);
        let listed = due.by_ref().take(CONFIG.max_of_one_schedule);
        plan.occurrences.extend(listed.map(|slot| Occurrence {
            schedule: schedule.id,
            mission: schedule.mission,
            slot: slot.slot,
            due: slot.due,
            change: slot.change,
            state: state_of(schedule, &slot),
        }));
        if due.next().is_some() {
            plan.shortened.push(schedule.id);
        }
    }
    plan.occurrences.sort_by_key(|occurrence| (occurrence.due, occurrence.schedule));
    plan
}

fn state_of(schedule: &Schedule, slot: &missions::Slot) -> OccurrenceState {
    if schedule.skipped.contains(&slot.slot) {
        OccurrenceState::Skipped
    } else if schedule.is_paused {
        OccurrenceState::Paused
    } else if slot.is_same_instant {
        OccurrenceState::SameInstant
    } else {
        OccurrenceState::Planned
    }
}

/// Pairs of planned occurrences of which the second is due while the first still runs: positions in `occurrences`, which are in the order in which they are due.
/// `duration` says how long a mission runs.
pub fn conflicts_of(occurrences: &[Occurrence], duration: impl Fn(MissionId) -> Span) -> Vec<(usize, usize)> {
    let mut conflicts = Vec::new();
    let mut running: Option<(usize, i64)> = None;
    for (index, occurrence) in occurrences.iter().enumerate().filter(|(_, it)| it.is_planned()) {
        let end = occurrence.due.0.saturating_add(duration(occurrence.mission).nanos().max(1));
        match running {
            Some((earlier, until)) if occurrence.due.0 < until => {
                conflicts.push((earlier, index));
                if end > until {
                    running = Some((index, end));
                }
            }
            _ => running = Some((index, end)),
        }
    }
    conflicts
}
