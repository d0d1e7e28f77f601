//! Finds the slots of schedules that are due, and says which of them may run.

use super::records::Records;
use crate::calendar::{SiteZone, Slot, Slots};
use site_model::{LocalDateTime, MissedSlots, Schedule, ScheduleId, Site, SkipReason, Utc};
use std::collections::{BTreeMap, BTreeSet};
use vocab::Span;

/// Parameters of [`Scheduler`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SchedulerConfig {
    /// A slot that is noticed within this time is on time. Longer than the pauses between two values of the clock. Chosen: the shortest interval is a minute, and half of
    /// it is added for a busy computer.
    pub on_time: Span,
    /// Slots of a schedule that are decided in one update at most. Chosen: two weeks of a schedule by the minute.
    pub max_slots: usize,
    /// Of more missed slots than this, only the newest are recorded one by one. Chosen: a list that a person still reads.
    pub max_missed: usize,
}

impl Default for SchedulerConfig {
    fn default() -> Self {
        Self { on_time: Span::from_millis(90_000), max_slots: 20_000, max_missed: 100 }
    }
}

/// A slot that is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DueSlot {
    /// Its schedule.
    pub schedule: ScheduleId,
    /// The slot.
    pub slot: LocalDateTime,
    /// When it was due.
    pub due: Utc,
    /// Why it does not run, if it does not.
    pub skip: Option<SkipReason>,
    /// Whether it may wait a while for a monitor that blocks missions: its grace has not passed.
    pub may_wait: bool,
}

/// What is due of one schedule.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DueSlots {
    /// Slots that were missed for long: the first, the last, and their number.
    pub missed: Option<(DueSlot, DueSlot, u32)>,
    /// The others, in the order in which they are due.
    pub slots: Vec<DueSlot>,
}

/// The slots of all schedules of a site.
#[derive(Clone, Debug)]
pub struct Scheduler {
    config: SchedulerConfig,
    zone: Option<(String, SiteZone)>,
    plans: BTreeMap<ScheduleId, SchedulePlan>,
    /// Whether the schedules of the site were read since it last changed.
    is_current: bool,
    /// Slots that were noticed on time, and wait for a monitor.
    waiting: BTreeSet<(ScheduleId, LocalDateTime)>,
}

#[derive(Clone, Debug)]
struct SchedulePlan {
    schedule: Schedule,
    slots: Slots,
    /// The next slot that is not decided, once it was looked for.
    next: Option<Option<Slot>>,
}

impl Scheduler {
    /// Without schedules.
    pub fn new(config: SchedulerConfig) -> Self {
        Self { config, zone: None, plans: BTreeMap::new(), is_current: false, waiting: BTreeSet::new() }
    }

    /// The site has changed: its schedules are read again.
    pub fn forget(&mut self) {
        self.is_current = false;
    }

    /// Reads the schedules of the site, if it has changed. Returns those that cannot be used.
    pub fn read(&mut self, site: &Site) -> Vec<ScheduleId> {
        if std::mem::replace(&mut self.is_current, true) {
            return Vec::new();
        }
        let name = site.settings().map(|settings| settings.time_zone.as_str()).unwrap_or_default();
        if self.zone.as_ref().is_none_or(|(known, _)| known != name) {
            self.zone = SiteZone::new(name).ok().map(|zone| (name.to_owned(), zone));
        }
        self.plans.clear();
        let mut unusable = Vec::new();
        for schedule in site.schedules() {
            let slots = self.zone.as_ref().map(|(_, zone)| Slots::new(&schedule.recurrence, zone));
            match slots {
                Some(Ok(slots)) => {
                    let plan = SchedulePlan { schedule: schedule.clone(), slots, next: None };
                    self.plans.insert(schedule.id, plan);
                }
                _ => unusable.push(schedule.id),
            }
        }
        self.waiting.retain(|(schedule, _)| self.plans.contains_key(schedule));
        unusable
    }

    /// Time of day in the site's zone. None before the zone is known.
    pub fn time_of_day(&self, utc: Utc) -> Option<site_model::LocalTime> {
        self.zone.as_ref().map(|(_, zone)| zone.to_local(utc).time)
    }

    /// The schedules that can be used, in the order of their ids.
    pub fn schedules(&self) -> impl Iterator<Item = &Schedule> {
        self.plans.values().map(|plan| &plan.schedule)
    }

    /// The next slots of a schedule after an instant, for a preview. Those that were left out are there too.
    pub fn preview(&self, schedule: ScheduleId, after: Utc, count: usize) -> Vec<Slot> {
        let plan = self.plans.get(&schedule);
        plan.into_iter().flat_map(|plan| plan.slots.after(after).take(count)).collect()
    }

    /// Whether a slot waits, that was noticed on time.
    pub fn has_waiting(&self, schedule: ScheduleId) -> bool {
        self.waiting.iter().any(|(waiting, _)| *waiting == schedule)
    }

    /// A slot waits for a monitor that blocks missions.
    pub fn wait(&mut self, slot: &DueSlot) {
        self.waiting.insert((slot.schedule, slot.slot));
    }

    /// A schedule is followed in another state: its next slot is looked for.
    pub fn changed(&mut self, schedule: ScheduleId) {
        if let Some(plan) = self.plans.get_mut(&schedule) {
            plan.next = None;
        }
    }

    /// A slot was decided: the next one is looked for.
    pub fn decided(&mut self, schedule: ScheduleId, slot: LocalDateTime) {
        self.waiting.remove(&(schedule, slot));
        if let Some(plan) = self.plans.get_mut(&schedule) {
            plan.next = None;
        }
    }

    /// The slots of a schedule that are due and not decided, with what becomes of each.
    pub fn due(&mut self, id: ScheduleId, now: Utc, records: &Records) -> DueSlots {
        let Some((_, since)) = records.adopted.get(&id) else { return DueSlots::default() };
        let (Some(plan), Some((_, zone))) = (self.plans.get_mut(&id), &self.zone) else {
            return DueSlots::default();
        };
        let decided = records.decided.get(&id);
        let newest = decided.and_then(|decided| decided.newest_due);
        // Another slot can be due at the same instant as the newest one.
        let after = newest.map_or(*since, |newest| Utc(newest.0 - 1).max(*since));
        let is_open = |slot: &Slot| decided.is_none_or(|decided| !decided.contains(slot.slot));
        let next = *plan.next.get_or_insert_with(|| plan.slots.after(after).find(is_open));
        if next.is_none_or(|slot| slot.due > now) {
            return DueSlots::default();
        }
        let due = plan.slots.after(after).filter(is_open).take_while(|slot| slot.due <= now);
        let due: Vec<Slot> = due.take(self.config.max_slots).collect();
        let policy = SlotPolicy {
            schedule: &plan.schedule,
            now,
            today: zone.to_local(now).date,
            on_time: self.config.on_time,
            waiting: &self.waiting,
        };
        policy.evaluate(&due, self.config.max_missed)
    }
}

/// What decides whether the slots of one schedule run.
struct SlotPolicy<'a> {
    schedule: &'a Schedule,
    now: Utc,
    today: site_model::LocalDate,
    on_time: Span,
    waiting: &'a BTreeSet<(ScheduleId, LocalDateTime)>,
}

impl SlotPolicy<'_> {
    fn evaluate(&self, due: &[Slot], max_missed: usize) -> DueSlots {
        // Old ones in a row that were missed and need no further reason.
        let is_missed = |slot: &&Slot| self.skip(slot, true) == Some(SkipReason::Missed);
        let missed_in_a_row = due.iter().take_while(is_missed).count();
        let (missed, slots) = match missed_in_a_row > max_missed {
            true => due.split_at(missed_in_a_row),
            false => due.split_at(0),
        };
        let last = slots.len().saturating_sub(1);
        let slots = slots.iter().enumerate().map(|(index, slot)| self.due_slot(slot, index == last));
        let first_and_last = missed.first().zip(missed.last());
        DueSlots {
            missed: first_and_last.map(|(first, last)| {
                (self.due_slot(first, false), self.due_slot(last, false), missed.len() as u32)
            }),
            slots: slots.collect(),
        }
    }

    fn due_slot(&self, slot: &Slot, is_last: bool) -> DueSlot {
        DueSlot {
            schedule: self.schedule.id,
            slot: slot.slot,
            due: slot.due,
            skip: self.skip(slot, is_last),
            may_wait: self.is_in_grace(slot),
        }
    }

    /// Why a slot does not run. `is_last`: no later one is due.
    fn skip(&self, slot: &Slot, is_last: bool) -> Option<SkipReason> {
        let lateness = self.now.0 - slot.due.0;
        let was_noticed =
            lateness <= self.on_time.nanos() || self.waiting.contains(&(self.schedule.id, slot.slot));
        if slot.is_same_instant {
            Some(SkipReason::SameInstant)
        } else if self.schedule.skipped.contains(&slot.slot) {
            Some(SkipReason::Requested)
        } else if self.schedule.is_paused {
            Some(SkipReason::SchedulePaused)
        } else if was_noticed {
            // Of a schedule by the minute, the newest counts.
            (!is_last && lateness > self.on_time.nanos()).then_some(SkipReason::LaterSlotRuns)
        } else if !self.is_in_grace(slot) {
            Some(SkipReason::Missed)
        } else {
            match self.schedule.missed {
                MissedSlots::Skip => Some(SkipReason::Missed),
                MissedSlots::RunOnce => (!is_last).then_some(SkipReason::LaterSlotRuns),
                MissedSlots::RunAll => None,
            }
        }
    }

    /// Whether a slot may still begin. One that was missed runs on its own day only.
    fn is_in_grace(&self, slot: &Slot) -> bool {
        let lateness = self.now.0 - slot.due.0;
        let is_on_time = lateness <= self.on_time.nanos();
        is_on_time || (lateness <= self.schedule.grace.nanos() && slot.slot.date == self.today)
    }
}
