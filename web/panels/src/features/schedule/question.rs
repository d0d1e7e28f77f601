//! The question which occurrences of a schedule are meant: one, it and those after it, or all.

use super::drag::apply_move;
use super::plan_cache::CachedPlan;
use super::state::{Question, SchedulePanel};
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::theme::{self, Weight, font};
use crate::{layout, widgets};
use client_model::{ChangeScope, ClientCommand};
use egui::{Align2, Context, Key, Order, Ui};
use site_model::{Object, Schedule};

/// Width of the question, points.
const WIDTH: f32 = 340.0;

impl SchedulePanel {
    /// Shows the question while it is open.
    pub(super) fn show_question(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        let (Some(question), Some(plan)) = (self.question, &self.plan) else { return };
        let site = cx.model.site.site();
        let Some(schedule) = site.and_then(|site| site.schedule(question.schedule())) else {
            self.question = None;
            return;
        };
        cx.frame.is_escape_consumed = true;
        if ctx.input(|input| input.key_pressed(Key::Escape)) {
            self.question = None;
            return;
        }
        let schedule = schedule.clone();
        let centre = cx.layout.free.center();
        let area = layout::area(texts::QUESTION, Order::Foreground).pivot(Align2::CENTER_CENTER);
        let shown = area.fixed_pos(centre).show(ctx, |ui| {
            let card = theme::card(cx.tokens).fill(cx.tokens.card.to_opaque()).inner_margin(20);
            card.show(ui, |ui| {
                ui.set_width(WIDTH.min(ctx.content_rect().width() - 72.0));
                show_choices(ui, cx, plan, &schedule, question)
            })
            .inner
        });
        if shown.inner {
            self.question = None;
        }
    }
}

/// Shows the choices. Returns whether one was taken.
fn show_choices(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    plan: &CachedPlan,
    schedule: &Schedule,
    question: Question,
) -> bool {
    let tokens = cx.tokens;
    let (head, sentence) = match question {
        Question::Move { from, to, .. } => (texts::move_head(&schedule.name), texts::moving(from, to)),
        Question::Remove { slot, .. } => (texts::delete_head(&schedule.name), texts::day_and_time(slot)),
    };
    ui.label(egui::RichText::new(head).font(font(theme::LARGE, Weight::SemiBold)).color(tokens.text));
    widgets::sentence(ui, tokens, &sentence);
    ui.add_space(4.0);
    let mut is_taken = false;
    for scope in ChangeScope::ALL {
        let Some(result) = result_of(cx, plan, schedule, question, scope) else { continue };
        let kind = match (question, scope) {
            (Question::Remove { .. }, _) => Kind::Danger,
            (Question::Move { .. }, ChangeScope::This) => Kind::Primary,
            (Question::Move { .. }, _) => Kind::Plain,
        };
        if Button::new(texts::scope(scope)).kind(kind).wide(ui).show(ui, tokens).clicked() {
            apply(cx, question, scope);
            is_taken = true;
        }
        if let Some(result) = result {
            widgets::remark(ui, tokens, &result);
        }
    }
    let is_past = matches!(question, Question::Move { to, .. } if plan.is_local_past(to));
    if is_past {
        widgets::remark(ui, tokens, texts::PAST_REMARK);
    }
    is_taken | Button::new(texts::CANCEL).kind(Kind::Quiet).wide(ui).show(ui, tokens).clicked()
}

/// Whether a scope is offered, and a sentence that says what it leads to.
fn result_of(
    cx: &PanelContext<'_>,
    plan: &CachedPlan,
    schedule: &Schedule,
    question: Question,
    scope: ChangeScope,
) -> Option<Option<String>> {
    match question {
        Question::Move { to, .. } if scope == ChangeScope::This && plan.is_local_past(to) => None,
        Question::Move { from, to, .. } => {
            let (moved, edit) = cx.model.site.moving_slot(schedule.id, from, to, scope)?;
            let put = edit.put.iter().find_map(|object| match object {
                Object::Schedule(put) if put.id == moved => Some(texts::recurrence(&put.recurrence)),
                _ => None,
            });
            Some(put.filter(|_| scope != ChangeScope::This))
        }
        Question::Remove { slot, .. } => cx.model.site.removing_slots(schedule.id, slot, scope).map(|_| None),
    }
}

fn apply(cx: &mut PanelContext<'_>, question: Question, scope: ChangeScope) {
    match question {
        Question::Move { schedule, from, to } => apply_move(cx, schedule, from, to, scope),
        Question::Remove { schedule, slot } => {
            if let Some(edit) = cx.model.site.removing_slots(schedule, slot, scope) {
                cx.commands.push(ClientCommand::EditSite(edit));
                if scope != ChangeScope::This {
                    cx.commands.push(ClientCommand::SelectSchedule(None));
                }
            }
        }
    }
}
