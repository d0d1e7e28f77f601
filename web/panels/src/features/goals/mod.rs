//! Goals: what the robot is doing, how far it is, what it waits for, what came of it, and where it can be sent.

mod destinations;
#[cfg(test)]
mod tests;
mod texts;

pub(crate) use destinations::show_send_button;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::site_graph::show_closures;
use crate::features::{robot, tabs};
use crate::message::show_message;
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets::{self, fact};
use crate::{format, icon};
use api::{ExecutiveState, Goal, GoalStatus, Motion};
use client_model::{ClientCommand, GoalOutcome, Model};
use egui::{Color32, Role, Ui};

/// Parameters of the list of goals.
struct GoalListConfig {
    /// Age of an outcome from which it is shown, seconds. Chosen: a second; below, "0 s ago" says nothing.
    min_shown_age_s: f64,
}

const CONFIG: GoalListConfig = GoalListConfig { min_shown_age_s: 1.0 };

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct GoalsPanel;

impl FeaturePanel for GoalsPanel {
    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        if cx.model.is_picking_goal() {
            show_message(ui, cx.tokens, cx.tokens.accent, icon::MAP_PIN, texts::PICK_HINT, |_| {});
        }
    }

    fn tabs(&self) -> &'static [Tab] {
        &[tabs::ROBOT]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        let Some(executive) = model.goals.executive() else { return };
        widgets::section_head(ui, tokens, texts::HEAD);
        show_state_chip(ui, tokens, executive.state);
        if let Some(goal) = model.goals.active() {
            show_active(ui, cx, goal);
        } else {
            destinations::show(ui, cx);
        }
        if let Some(outcome) = model.goals.outcome() {
            show_outcome(ui, cx, outcome);
        }
        if let Some(site) = model.site.site() {
            show_closures(ui, cx, site);
        }
    }
}

/// What the robot does, in a few words: the state of the executive; while it executes a goal or stands, the state of motion, which says more.
pub(crate) fn heading(model: &Model) -> &'static str {
    match model.goals.executive() {
        Some(executive) if !matches!(executive.state, ExecutiveState::Executing | ExecutiveState::Idle) => {
            texts::state(executive.state)
        }
        _ => robot::motion_text(model),
    }
}

/// Shows the button that cancels the walk, or the one with which the operator picks where to walk.
pub(crate) fn show_walk_button(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    if matches!(model.motion(), Motion::Walking { .. } | Motion::Waiting { .. } | Motion::Relocalising { .. })
    {
        if Button::new(texts::CANCEL_WALK).icon(icon::X).wide(ui).show(ui, tokens).clicked() {
            cx.commands.extend(model.goals.active().map(|goal| ClientCommand::CancelGoal(goal.id)));
        }
        return;
    }
    let is_picking = model.is_picking_goal();
    let walk = Button::new(texts::WALK_TO_POINT).icon(icon::MAP_PIN).on(is_picking);
    let enabled = !model.is_stopped() && model.is_connected();
    if walk.enabled(enabled).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::PickGoal(!is_picking));
    }
}

/// Icon, colour and word of the executive's state.
fn show_state_chip(ui: &mut Ui, tokens: &Tokens, state: ExecutiveState) {
    let (sign, colour) = match state {
        ExecutiveState::Stopped => (icon::STOP, tokens.bad),
        ExecutiveState::ManualDriving => (icon::USER, tokens.accent),
        ExecutiveState::Recovering => (icon::GPS_SLASH, tokens.warn),
        ExecutiveState::Executing => (icon::NAVIGATION_ARROW, tokens.accent),
        ExecutiveState::Idle => (icon::CHECK_CIRCLE, tokens.good),
    };
    let word = texts::state(state);
    let parts =
        [(sign, theme::ICON, Weight::Regular, colour), (word, theme::BODY, Weight::SemiBold, tokens.text)];
    widgets::status_line(ui, texts::STATE, word, &parts);
}

fn show_active(ui: &mut Ui, cx: &mut PanelContext<'_>, goal: &Goal) {
    let (model, tokens) = (cx.model, cx.tokens);
    fact(ui, tokens, texts::GOAL, &texts::goal(goal.kind, model.site.site()));
    if let GoalStatus::Running(progress) = &goal.status {
        if let Some(remaining_m) = progress.remaining_m {
            fact(ui, tokens, texts::REMAINING, &format::distance(remaining_m));
        }
        if let Some(share) = model.goals.progress(goal) {
            show_progress(ui, tokens, share);
        }
        if let Some(reason) = progress.waits_for {
            widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
                let sentence = texts::wait(reason);
                let text = egui::RichText::new(sentence).size(theme::BODY).color(tokens.text);
                let response = ui.add(egui::Label::new(text).wrap());
                widgets::status_node(&response, texts::WAITS, sentence);
            });
        }
    }
    let cancel = Button::new(texts::CANCEL).text(texts::CANCEL_SHORT).icon(icon::X);
    let enabled = model.is_connected() && !model.is_controlled_by_other();
    if cancel.enabled(enabled).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::CancelGoal(goal.id));
    }
}

/// How much of the goal is done: `share`, 0 to 1.
fn show_progress(ui: &mut Ui, tokens: &Tokens, share: f32) {
    let response = widgets::progress_bar(ui, tokens, share);
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(Role::ProgressIndicator);
        node.set_label(texts::PROGRESS);
        node.set_value(format::share(share));
    });
}

fn show_outcome(ui: &mut Ui, cx: &mut PanelContext<'_>, outcome: GoalOutcome<'_>) {
    let tokens = cx.tokens;
    let goal = outcome.goal;
    let (sign, colour) = sign_of(&goal.status, tokens);
    let sentence = texts::outcome(goal);
    let tried = texts::tried(&goal.status);
    let age_s = cx.model.now().since(outcome.ended);
    let age = (age_s > CONFIG.min_shown_age_s).then(|| texts::ago(&format::duration(age_s)));
    let response = widgets::tinted_box(ui, tokens, colour, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        ui.horizontal(|ui| {
            ui.label(egui::RichText::new(sign).size(theme::ICON).color(colour));
            let word = egui::RichText::new(texts::outcome_word(&goal.status));
            ui.label(word.font(font(theme::BODY, Weight::SemiBold)).color(tokens.text));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let dismiss = Button::icon_only(texts::DISMISS, icon::X).kind(Kind::Quiet);
                if dismiss.size(36.0, 36.0).show(ui, tokens).clicked() {
                    cx.commands.push(ClientCommand::DismissGoal(goal.id));
                }
            });
        });
        let text = egui::RichText::new(&sentence).size(theme::BODY).color(tokens.text);
        let response = ui.add(egui::Label::new(text).wrap());
        for remark in tried.as_deref().into_iter().chain(age.as_deref()) {
            widgets::remark(ui, tokens, remark);
        }
        response
    });
    let parts = [Some(sentence.as_str()), tried.as_deref(), age.as_deref()];
    let value: Vec<&str> = parts.into_iter().flatten().collect();
    widgets::status_node(&response, texts::OUTCOME, &value.join(" "));
}

fn sign_of(status: &GoalStatus, tokens: &Tokens) -> (&'static str, Color32) {
    match status {
        GoalStatus::Succeeded { .. } => (icon::CHECK_CIRCLE, tokens.good),
        GoalStatus::Failed { .. } => (icon::X_CIRCLE, tokens.bad),
        GoalStatus::Cancelled { .. } | GoalStatus::Accepted | GoalStatus::Running(_) => {
            (icon::INFO, tokens.dim)
        }
    }
}
