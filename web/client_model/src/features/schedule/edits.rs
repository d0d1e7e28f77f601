//! Edits of schedules as operators make them: each a step of undo.

use super::super::site::{SiteEdit, SiteFeature};
use super::recurrence::{moved_recurrence, split_schedule, weekday, with_last_day};
use crate::texts;
use missions::{SiteZone, Slots, date_of, day_number};
use site_model::{LocalDateTime, MissionId, Object, ObjectId, Recurrence, Schedule, ScheduleId, Utc};
use std::collections::BTreeSet;

/// Which occurrences of a schedule a change is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChangeScope {
    /// One.
    This,
    /// One, and those after it.
    Following,
    /// All.
    All,
}

impl ChangeScope {
    /// All, in the order in which they are offered.
    pub const ALL: [Self; 3] = [Self::This, Self::Following, Self::All];
}

impl SiteFeature {
    fn schedule(&self, id: ScheduleId) -> Option<&Schedule> {
        self.site()?.schedule(id)
    }

    /// A schedule that runs a mission every week at this time, from this day on.
    pub fn adding_schedule(&self, mission: MissionId, at: LocalDateTime) -> Option<(ScheduleId, SiteEdit)> {
        let name = self.site()?.mission(mission)?.name.clone();
        let id = ScheduleId(self.new_id(0));
        let recurrence = Recurrence::Weekly {
            days: BTreeSet::from([weekday(at.date)]),
            times: vec![at.time],
            first_day: at.date,
            last_day: None,
        };
        Some((id, put([Schedule::new(id, name, mission, recurrence)])))
    }

    /// A schedule after a change of it as a whole.
    pub fn changing_schedule(&self, id: ScheduleId, change: impl FnOnce(&mut Schedule)) -> SiteEdit {
        let Some(mut schedule) = self.schedule(id).cloned() else { return SiteEdit::default() };
        change(&mut schedule);
        put([schedule])
    }

    /// The slot `from` of a schedule is at `to` from now on; with those after it, or with all. None where that has no meaning. Returns also the schedule that
    /// has the slot afterwards.
    pub fn moving_slot(
        &self,
        id: ScheduleId,
        from: LocalDateTime,
        to: LocalDateTime,
        scope: ChangeScope,
    ) -> Option<(ScheduleId, SiteEdit)> {
        let schedule = self.schedule(id)?;
        let is_once = matches!(schedule.recurrence, Recurrence::Once(_));
        match scope {
            ChangeScope::This if is_once => None,
            ChangeScope::This => {
                let mut rest = schedule.clone();
                skip(&mut rest, from);
                let once = Schedule {
                    id: ScheduleId(self.new_id(0)),
                    name: texts::single_occurrence(&schedule.name, from.date),
                    recurrence: Recurrence::Once(to),
                    skipped: Vec::new(),
                    ..schedule.clone()
                };
                Some((once.id, put([rest, once])))
            }
            ChangeScope::Following => {
                let (earlier, mut later) = split_schedule(schedule, from, ScheduleId(self.new_id(0)))?;
                move_all(&mut later, from, to)?;
                skip_before(&mut later, from, to);
                Some((later.id, put([earlier, later])))
            }
            ChangeScope::All => {
                let mut moved = schedule.clone();
                move_all(&mut moved, from, to)?;
                Some((id, put([moved])))
            }
        }
    }

    /// A slot of a schedule does not run, or runs after all.
    pub fn skipping_slot(&self, id: ScheduleId, slot: LocalDateTime, is_skipped: bool) -> SiteEdit {
        self.changing_schedule(id, |schedule| {
            if is_skipped {
                skip(schedule, slot);
            } else {
                schedule.skipped.retain(|skipped| *skipped != slot);
            }
        })
    }

    /// Ends a schedule before one of its slots, or removes it. None where that has no meaning.
    pub fn removing_slots(
        &self,
        id: ScheduleId,
        slot: LocalDateTime,
        scope: ChangeScope,
    ) -> Option<SiteEdit> {
        match scope {
            ChangeScope::This => Some(self.skipping_slot(id, slot, true)),
            ChangeScope::Following => {
                let (earlier, _) = split_schedule(self.schedule(id)?, slot, id)?;
                Some(put([earlier]))
            }
            ChangeScope::All => Some(SiteEdit { put: Vec::new(), removed: vec![ObjectId::Schedule(id)] }),
        }
    }

    /// Makes a schedule of its own of a slot and those after it. None where that has no meaning.
    pub fn splitting_schedule(&self, id: ScheduleId, slot: LocalDateTime) -> Option<(ScheduleId, SiteEdit)> {
        let (earlier, later) = split_schedule(self.schedule(id)?, slot, ScheduleId(self.new_id(0)))?;
        Some((later.id, put([earlier, later])))
    }

    /// A schedule with another last day; `None`: without an end. None where its rule cannot have one.
    pub fn ending_schedule(
        &self,
        id: ScheduleId,
        last_day: Option<site_model::LocalDate>,
    ) -> Option<SiteEdit> {
        let recurrence = with_last_day(&self.schedule(id)?.recurrence, last_day)?;
        Some(self.changing_schedule(id, |schedule| schedule.recurrence = recurrence))
    }
}

fn put<const N: usize>(schedules: [Schedule; N]) -> SiteEdit {
    SiteEdit { put: schedules.into_iter().map(Object::Schedule).collect(), removed: Vec::new() }
}

fn skip(schedule: &mut Schedule, slot: LocalDateTime) {
    if !schedule.skipped.contains(&slot) {
        schedule.skipped.push(slot);
        schedule.skipped.sort_unstable();
    }
}

/// Skips the slots before `from` except the one at `to`: the schedule that ends before `from` has those.
fn skip_before(schedule: &mut Schedule, from: LocalDateTime, to: LocalDateTime) {
    let Ok(slots) = Slots::new(&schedule.recurrence, &SiteZone::utc()) else { return };
    let earlier = slots.after(Utc(i64::MIN / 2)).map(|slot| slot.slot).take_while(|slot| *slot < from);
    for slot in earlier.filter(|slot| *slot != to).collect::<Vec<_>>() {
        skip(schedule, slot);
    }
}

/// Moves all slots of a schedule, with those that are skipped.
fn move_all(schedule: &mut Schedule, from: LocalDateTime, to: LocalDateTime) -> Option<()> {
    schedule.recurrence = moved_recurrence(&schedule.recurrence, from, to)?;
    let days = day_number(to.date) - day_number(from.date);
    let is_weekly = matches!(schedule.recurrence, Recurrence::Weekly { .. });
    for skipped in &mut schedule.skipped {
        let is_moved = !is_weekly || weekday(skipped.date) == weekday(from.date);
        if skipped.time == from.time {
            skipped.time = to.time;
        }
        if is_moved {
            skipped.date = date_of(day_number(skipped.date) + days);
        }
    }
    // The slot that was moved runs: that is why it was moved.
    schedule.skipped.retain(|skipped| *skipped != to);
    schedule.skipped.sort_unstable();
    schedule.skipped.dedup();
    Some(())
}
