//! The occurrence that is selected: when it is due, moved by date and time, skipped, or the first of a schedule of its own.

use super::fields::{StepperField, stepped_date, stepped_time};
use super::plan_cache::CachedPlan;
use super::state::SchedulePanel;
use super::{drag, texts};
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::features::runs::skip_reason;
use crate::{icon, widgets};
use client_model::ClientCommand;
use egui::Ui;
use site_model::{LocalDateTime, Recurrence, Schedule};

impl SchedulePanel {
    /// Shows the occurrence.
    pub(super) fn show_occurrence(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        plan: &CachedPlan,
        schedule: &Schedule,
        slot: LocalDateTime,
    ) {
        // That of a schedule that runs once is the schedule itself.
        if matches!(schedule.recurrence, Recurrence::Once(_)) {
            return;
        }
        let Some((due, change)) = plan.zone.to_utc(slot) else { return };
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::OCCURRENCE_HEAD);
        widgets::sentence(ui, tokens, &texts::day_and_time(slot));
        if let Some(yours) = &plan.your_zone {
            widgets::remark(ui, tokens, &texts::for_you(yours.to_local(due)));
        }
        if let Some(sentence) = texts::clock_change(slot, plan.zone.to_local(due), change) {
            widgets::remark(ui, tokens, &sentence);
        }
        let site = cx.model.site.site();
        if let (Some(reason), Some(site)) = (cx.model.runs.skipped_slot(schedule.id, slot), site) {
            return widgets::sentence(ui, tokens, &texts::was_skipped(&skip_reason(site, reason)));
        }
        if plan.is_past(due) {
            return widgets::remark(ui, tokens, texts::IN_THE_PAST);
        }
        if let Some(to) = self.show_slot_fields(ui, cx, slot) {
            self.move_slot(cx, plan, schedule.id, slot, to);
        }
        let is_skipped = schedule.skipped.contains(&slot);
        let (name, sign) = if is_skipped {
            (texts::UNSKIP_THIS, icon::PLAY)
        } else {
            (texts::SKIP_THIS, icon::SKIP_FORWARD)
        };
        if Button::new(name).icon(sign).wide(ui).show(ui, tokens).clicked() {
            let edit = cx.model.site.skipping_slot(schedule.id, slot, !is_skipped);
            cx.commands.push(ClientCommand::EditSite(edit));
        }
        if let Some((new, edit)) = cx.model.site.splitting_schedule(schedule.id, slot) {
            let split = Button::new(texts::SPLIT).icon(icon::CALENDAR_DOTS).hint(texts::SPLIT_HINT);
            if split.wide(ui).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::EditSite(edit));
                drag::select(cx, new, Some(slot));
            }
        }
    }

    /// Date and time of the occurrence. Returns where it is moved.
    fn show_slot_fields(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        slot: LocalDateTime,
    ) -> Option<LocalDateTime> {
        let mut moved = None;
        let date = texts::iso_date(slot.date);
        let stepper =
            StepperField { key: "slot date", name: texts::DATE, caption: texts::DATE, shown: &date };
        if let Some(step) = ui.horizontal(|ui| stepper.show(ui, cx, &mut self.typed, 0.0)).inner {
            moved = stepped_date(slot.date, &step).map(|date| LocalDateTime { date, ..slot });
        }
        let time = texts::time(slot.time);
        let stepper =
            StepperField { key: "slot time", name: texts::TIME, caption: texts::TIME, shown: &time };
        if let Some(step) = ui.horizontal(|ui| stepper.show(ui, cx, &mut self.typed, 0.0)).inner {
            moved = stepped_time(slot.time, &step).map(|time| LocalDateTime { time, ..slot });
        }
        moved.filter(|to| *to != slot)
    }
}
