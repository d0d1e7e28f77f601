//! The next two weeks as a list, a day after the other.

use super::plan_cache::{CachedPlan, MINUTE_NS};
use super::state::SchedulePanel;
use super::{drag, texts};
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::widgets;
use client_model::{Occurrence, ScheduleSelection};
use egui::{ScrollArea, Ui};
use missions::day_number;
use site_model::{LocalDate, Site};

/// What the agenda lists.
#[derive(Clone, Copy, Debug)]
struct AgendaConfig {
    /// Days that are listed. Chosen: two weeks, this one and the next.
    days: i64,
    /// Occurrences of a day that are listed; a schedule by the minute has more. Chosen: one an hour; more of them would hide the next day.
    max_of_one_day: usize,
}

const AGENDA: AgendaConfig = AgendaConfig { days: 14, max_of_one_day: 24 };

impl SchedulePanel {
    /// Shows the list.
    pub(super) fn show_agenda(&self, ui: &mut Ui, cx: &mut PanelContext<'_>, plan: &CachedPlan, site: &Site) {
        let last = day_number(plan.zone.to_local(plan.now).date) + AGENDA.days;
        let due: Vec<&Occurrence> =
            plan.outlook.occurrences.iter().take_while(|it| day_number(plan.local(it).date) < last).collect();
        ScrollArea::vertical().id_salt("agenda").auto_shrink([false, false]).show(ui, |ui| {
            if due.is_empty() {
                widgets::remark(ui, cx.tokens, texts::NOTHING_DUE);
            }
            let mut rest = due.as_slice();
            while let Some(first) = rest.first() {
                let day = plan.local(first).date;
                let (of_day, later) = rest.split_at(rest.partition_point(|it| plan.local(it).date <= day));
                rest = later;
                show_day(ui, cx, plan, site, day, of_day);
            }
        });
    }
}

fn show_day(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    plan: &CachedPlan,
    site: &Site,
    day: LocalDate,
    of_day: &[&Occurrence],
) {
    let tokens = cx.tokens;
    widgets::section_head(ui, tokens, &texts::day(day));
    for occurrence in of_day.iter().take(AGENDA.max_of_one_day) {
        let Some(schedule) = site.schedule(occurrence.schedule) else { continue };
        let at = plan.local(occurrence);
        let state = texts::state(occurrence.state, false);
        let selection = ScheduleSelection { schedule: schedule.id, slot: Some(occurrence.slot) };
        let name = texts::occurrence(&schedule.name, at, state);
        let minutes = plan.duration(occurrence.mission).nanos() / MINUTE_NS;
        let yours = plan.your_zone.as_ref().map(|zone| zone.to_local(occurrence.due));
        let row = texts::agenda_row(at.time, yours.map(|at| at.time), &schedule.name, minutes, state);
        let button =
            Button::new(&name).text(&row).left().on(cx.model.schedule.selection() == Some(selection));
        if button.wide(ui).show(ui, tokens).clicked() {
            drag::select(cx, schedule.id, Some(occurrence.slot));
        }
    }
    if of_day.len() > AGENDA.max_of_one_day {
        widgets::remark(ui, tokens, &texts::more(of_day.len() - AGENDA.max_of_one_day));
    }
}
