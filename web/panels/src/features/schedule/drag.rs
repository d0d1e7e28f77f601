//! Drags: a mission from the list into the week, or an occurrence to another time; with the pointer or by keys.

use super::plan_cache::CachedPlan;
use super::state::{Drag, Dragged, Question, SchedulePanel};
use crate::feature_panel::PanelContext;
use client_model::{ChangeScope, ClientCommand, ScheduleSelection};
use missions::{date_of, day_number, local_of, minute_number};
use site_model::{LocalDateTime, MissionId, Recurrence, ScheduleId};

impl SchedulePanel {
    /// What is dragged is let go.
    pub(super) fn drop_dragged(&mut self, cx: &mut PanelContext<'_>, plan: &CachedPlan) {
        let Some(Drag { dragged, target: Some(to), .. }) = self.drag.take() else { return };
        match dragged {
            Dragged::Mission(mission) => add_schedule(cx, mission, to),
            Dragged::Slot(_, from) if from == to => {}
            Dragged::Slot(schedule, from) => self.move_slot(cx, plan, schedule, from, to),
        }
    }

    /// Moves a slot, or asks which ones are meant.
    pub(super) fn move_slot(
        &mut self,
        cx: &mut PanelContext<'_>,
        plan: &CachedPlan,
        schedule: ScheduleId,
        from: LocalDateTime,
        to: LocalDateTime,
    ) {
        let recurrence = cx.model.site.site().and_then(|site| Some(&site.schedule(schedule)?.recurrence));
        match recurrence {
            Some(Recurrence::Once(_)) if plan.is_local_past(to) => {}
            Some(Recurrence::Once(_)) => apply_move(cx, schedule, from, to, ChangeScope::All),
            Some(_) => self.question = Some(Question::Move { schedule, from, to }),
            None => {}
        }
    }
}

/// Makes a weekly schedule of a mission.
pub(super) fn add_schedule(cx: &mut PanelContext<'_>, mission: MissionId, at: LocalDateTime) {
    if let Some((schedule, edit)) = cx.model.site.adding_schedule(mission, at) {
        cx.commands.push(ClientCommand::EditSite(edit));
        select(cx, schedule, Some(at));
    }
}

/// Moves a slot, with others by `scope`, and selects it where it is then.
pub(super) fn apply_move(
    cx: &mut PanelContext<'_>,
    schedule: ScheduleId,
    from: LocalDateTime,
    to: LocalDateTime,
    scope: ChangeScope,
) {
    if let Some((moved, edit)) = cx.model.site.moving_slot(schedule, from, to, scope) {
        cx.commands.push(ClientCommand::EditSite(edit));
        select(cx, moved, Some(to));
    }
}

/// Selects a schedule.
pub(super) fn select(cx: &mut PanelContext<'_>, schedule: ScheduleId, slot: Option<LocalDateTime>) {
    cx.commands.push(ClientCommand::SelectSchedule(Some(ScheduleSelection { schedule, slot })));
}

/// The next whole hour, for a schedule that is made without a drag.
pub(super) fn next_hour(plan: &CachedPlan) -> LocalDateTime {
    let now = minute_number(plan.zone.to_local(plan.now));
    let hour = local_of(now.div_euclid(60) * 60 + 60);
    LocalDateTime { date: date_of(day_number(hour.date)), ..hour }
}
