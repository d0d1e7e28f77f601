//! The side card while a schedule is open: its name, mission, times and policies, and the occurrence that is selected.

use super::fields::{StepperField, StepperInput};
use super::plan_cache::{CachedPlan, MINUTE_NS};
use super::state::{Question, SchedulePanel};
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::name_field::MAX_NAME_CHARS;
use crate::theme::{self, Weight, font};
use crate::{TextInput, icon, widgets};
use client_model::{ClientCommand, ScheduleSelection};
use egui::Ui;
use site_model::{LocalDateTime, LocalTime, ObjectId, Recurrence, Schedule, Site};
use vocab::Span;

impl SchedulePanel {
    /// Shows the schedule that is open.
    pub(super) fn show_form(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        plan: &CachedPlan,
        site: &Site,
        open: ScheduleSelection,
    ) {
        let Some(schedule) = site.schedule(open.schedule) else { return };
        let tokens = cx.tokens;
        if Button::new(texts::ALL_SCHEDULES)
            .icon(icon::CARET_LEFT)
            .kind(Kind::Quiet)
            .left()
            .show(ui, tokens)
            .clicked()
        {
            self.typed.clear();
            cx.commands.push(ClientCommand::SelectSchedule(None));
        }
        let name = egui::RichText::new(&schedule.name).font(font(theme::LARGE, Weight::SemiBold));
        ui.add(egui::Label::new(name.color(tokens.text)).wrap());
        let sentence = texts::in_zone(&texts::recurrence(&schedule.recurrence), &plan.zone_name);
        let sentence = if schedule.is_paused { texts::paused(&sentence) } else { sentence };
        widgets::sentence(ui, tokens, &sentence);
        let next = plan.next_of(schedule.id);
        widgets::remark(ui, tokens, &texts::next(next.map(|next| plan.local(next))));
        self.show_actions(ui, cx, plan, schedule, open.slot);
        if let Some(slot) = open.slot {
            self.show_occurrence(ui, cx, plan, schedule, slot);
        }
        self.show_when(ui, cx, plan, schedule);
        self.show_policies(ui, cx, schedule);
        self.show_names(ui, cx, site, schedule);
    }

    /// Pause, skip the next one, delete.
    fn show_actions(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        plan: &CachedPlan,
        schedule: &Schedule,
        slot: Option<LocalDateTime>,
    ) {
        let tokens = cx.tokens;
        let width = ((ui.available_width() - 16.0) / 3.0).floor();
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            let (name, text) = if schedule.is_paused {
                (texts::RESUME, texts::RESUME_SHORT)
            } else {
                (texts::PAUSE, texts::PAUSE_SHORT)
            };
            let pause = Button::new(name).text(text).on(schedule.is_paused).size(width, theme::TOUCH).slim();
            if pause.show(ui, tokens).clicked() {
                change(cx, schedule, |it| it.is_paused = !schedule.is_paused);
            }
            let next = plan.next_of(schedule.id).map(|next| next.slot);
            let skip = Button::new(texts::SKIP_NEXT).enabled(next.is_some()).size(width, theme::TOUCH).slim();
            if skip.show(ui, tokens).clicked()
                && let Some(next) = next
            {
                let edit = cx.model.site.skipping_slot(schedule.id, next, true);
                cx.commands.push(ClientCommand::EditSite(edit));
            }
            let delete = Button::new(texts::DELETE).text(texts::DELETE_SHORT).kind(Kind::Danger);
            if delete.size(width, theme::TOUCH).slim().show(ui, tokens).clicked() {
                let is_once = matches!(schedule.recurrence, Recurrence::Once(_));
                match slot.filter(|_| !is_once) {
                    Some(slot) => self.question = Some(Question::Remove { schedule: schedule.id, slot }),
                    None => delete_all(cx, schedule),
                }
            }
        });
    }

    /// What becomes of slots that are missed or meet another run.
    fn show_policies(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, schedule: &Schedule) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::POLICY_HEAD);
        widgets::remark(ui, tokens, texts::OVERLAP_REMARK);
        let mut overlap = schedule.overlap;
        widgets::choice(ui, tokens, &texts::OVERLAP_CHOICES, overlap, |chosen| overlap = chosen);
        widgets::remark(ui, tokens, texts::MISSED_REMARK);
        let mut missed = schedule.missed;
        // Both rows offer "Skip".
        ui.push_id(texts::MISSED, |ui| {
            widgets::choice(ui, tokens, &texts::MISSED_CHOICES, missed, |chosen| missed = chosen);
        });
        widgets::remark(ui, tokens, texts::GRACE);
        let mut grace_min = schedule.grace.nanos() / MINUTE_NS;
        widgets::choice(ui, tokens, &texts::GRACES_MIN, grace_min, |chosen| grace_min = chosen);
        let grace = Span::from_nanos(grace_min * MINUTE_NS);
        if (overlap, missed, grace_min)
            != (schedule.overlap, schedule.missed, schedule.grace.nanos() / MINUTE_NS)
        {
            change(cx, schedule, |it| {
                it.overlap = overlap;
                it.missed = missed;
                it.grace = grace;
            });
        }
        let shown = schedule.priority.to_string();
        let stepper =
            StepperField { key: "priority", name: texts::PRIORITY, caption: texts::PRIORITY, shown: &shown };
        let step = ui.horizontal(|ui| stepper.show(ui, cx, &mut self.typed, 0.0)).inner;
        let priority = step.and_then(|step| match step {
            StepperInput::Earlier => Some(schedule.priority.saturating_sub(1)),
            StepperInput::Later => Some(schedule.priority.saturating_add(1)),
            StepperInput::Typed(text) => text.trim().parse().ok(),
        });
        if let Some(priority) = priority {
            change(cx, schedule, |it| it.priority = priority);
        }
    }

    /// The name of the schedule, and what runs.
    fn show_names(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, schedule: &Schedule) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::NAME);
        let text = self.typed.text("name", &schedule.name);
        let field = TextInput::new(("schedule name", schedule.id.0), texts::NAME).max_length(MAX_NAME_CHARS);
        let response = field.show(ui, tokens, cx.text_inputs, text);
        let typed = text.trim().to_owned();
        if (response.submitted || response.lost_focus) && typed != schedule.name && !typed.is_empty() {
            change(cx, schedule, |it| it.name = typed);
        }
        widgets::section_head(ui, tokens, texts::MISSION);
        for mission in site.missions() {
            let is_chosen = mission.id == schedule.mission;
            if Button::new(&mission.name).on(is_chosen).left().wide(ui).show(ui, tokens).clicked()
                && !is_chosen
            {
                change(cx, schedule, |it| it.mission = mission.id);
            }
        }
    }
}

/// Changes the schedule as a whole.
pub(super) fn change(cx: &mut PanelContext<'_>, schedule: &Schedule, change: impl FnOnce(&mut Schedule)) {
    let edit = cx.model.site.changing_schedule(schedule.id, change);
    cx.commands.push(ClientCommand::EditSite(edit));
}

fn delete_all(cx: &mut PanelContext<'_>, schedule: &Schedule) {
    let removed = vec![ObjectId::Schedule(schedule.id)];
    cx.commands.push(ClientCommand::EditSite(client_model::SiteEdit { put: Vec::new(), removed }));
    cx.commands.push(ClientCommand::SelectSchedule(None));
}

/// Where times begin that nobody has chosen yet.
pub(super) const FIRST_TIME: LocalTime = LocalTime { hour: 11, minute: 0 };
