//! Loops of the map under construction: their numbers and list, the evidence of one, deciding on it, adding one by hand.

mod evidence;
mod list;
mod proposal;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::Button;
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::message::show_message;
use crate::theme::{self, Tokens, Weight, font};
use crate::{format, icon, paint, screens, widgets};
use api::LoopVerdict;
use client_model::{ClientCommand, LoopPair, Model, Selection};
use egui::{Align2, Color32, Context, CornerRadius, Sense, Ui, pos2, vec2};

/// When a loop can be added by hand.
#[derive(Clone, Copy, Debug)]
struct AddedLoopConfig {
    /// Keyframes that the graph needs: with fewer, all are connected already.
    min_keyframes: usize,
}

const ADDED_LOOP: AddedLoopConfig = AddedLoopConfig { min_keyframes: 3 };

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct LoopsPanel {
    /// The loop to which the list was scrolled last.
    scrolled_to: Option<LoopPair>,
    /// What was selected in the last frame. A newly selected loop opens its evidence.
    last_selection: Option<Selection>,
}

/// The tab of loops.
pub(crate) const TAB: Tab = Tab { screen: screens::MAP, name: texts::TAB, scrolls: false, row_spacing: 8.0 };

impl FeaturePanel for LoopsPanel {
    /// Opens the evidence of a loop that was selected since the last frame.
    fn update(&mut self, _ctx: &Context, cx: &mut PanelContext<'_>) {
        let selection = cx.model.selection();
        let last = std::mem::replace(&mut self.last_selection, selection);
        if selection != last && matches!(selection, Some(Selection::Loop(_))) {
            cx.frame.open_tab(TAB);
            cx.frame.drawer_open = true;
            if cx.screen() != TAB.screen {
                cx.commands.push(ClientCommand::ShowScreen(TAB.screen));
            }
        }
    }

    fn cancel(&mut self, cx: &mut PanelContext<'_>) -> bool {
        let is_picking = cx.model.loop_pick().is_some();
        if is_picking {
            cx.commands.push(ClientCommand::PickLoopKeyframes(false));
        }
        is_picking
    }

    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let Some(pick) = cx.model.loop_pick() else { return };
        let tokens = cx.tokens;
        show_message(ui, tokens, tokens.accent, icon::GRAPH, &texts::step(pick), |ui| {
            if Button::new(texts::CANCEL_SHORT).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::PickLoopKeyframes(false));
            }
        });
    }

    fn tabs(&self) -> &'static [Tab] {
        &[TAB]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        show_tab(ui, cx, self);
    }
}

/// The numbers, the list, and the evidence of the selected loop or the steps of adding one.
fn show_tab(ui: &mut Ui, cx: &mut PanelContext<'_>, panel: &mut LoopsPanel) {
    let (model, tokens) = (cx.model, cx.tokens);
    if model.viewed_map().is_some() {
        show_saved_map(ui, cx);
        return;
    }
    show_counts(ui, cx);
    if let Some(pick) = model.loop_pick() {
        proposal::show(ui, cx, pick);
        return;
    }
    show_actions(ui, cx);
    if let Some(proposed) = model.loops.proposal() {
        let text = texts::comparing(proposed.pair);
        widgets::tinted_box(ui, tokens, tokens.accent, |ui| widgets::sentence(ui, tokens, &text));
    }
    widgets::rule(ui, tokens);
    match selected_loop(model) {
        Some(pair) => {
            list::show_above_evidence(ui, cx, panel, pair);
            evidence::show(ui, cx, pair);
        }
        None => list::show(ui, cx, panel, None),
    }
}

fn selected_loop(model: &Model) -> Option<LoopPair> {
    match model.selection() {
        Some(Selection::Loop(pair)) => Some(pair),
        _ => None,
    }
}

/// A saved map has edges but no evidence.
fn show_saved_map(ui: &mut Ui, cx: &PanelContext<'_>) {
    let tokens = cx.tokens;
    let closed = format::count(cx.model.displayed_map().graph.loops.len() as u64);
    widgets::fact(ui, tokens, texts::SAVED_LOOPS, &closed);
    widgets::remark(ui, tokens, texts::SAVED_HINT);
}

/// The numbers of accepted, held and rejected loops, side by side.
fn show_counts(ui: &mut Ui, cx: &PanelContext<'_>) {
    let counts = cx.model.loops.decisions().counts();
    let width = (ui.available_width() - 16.0) / 3.0;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        for (verdict, number) in [
            (LoopVerdict::Accepted, counts.accepted),
            (LoopVerdict::Held, counts.held),
            (LoopVerdict::Rejected, counts.rejected),
        ] {
            show_count(ui, cx.tokens, width, verdict, number);
        }
    });
}

fn show_count(ui: &mut Ui, tokens: &Tokens, width: f32, verdict: LoopVerdict, number: usize) {
    let (rect, response) = ui.allocate_exact_size(vec2(width, 52.0), Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(rect, CornerRadius::same(theme::BUTTON_RADIUS), tokens.raised);
    let (sign, colour) = sign_of(verdict, tokens);
    let left = rect.left() + 10.0;
    paint::icon_at(ui, pos2(left + 8.0, rect.top() + 17.0), sign, theme::ICON, colour);
    let number = format::count(number as u64);
    let (large, small) = (font(theme::HEAD, Weight::SemiBold), font(theme::SMALL, Weight::Regular));
    painter.text(pos2(left + 24.0, rect.top() + 17.0), Align2::LEFT_CENTER, &number, large, tokens.text);
    let name = texts::verdict(verdict);
    painter.text(pos2(left, rect.bottom() - 14.0), Align2::LEFT_CENTER, name, small, tokens.dim);
    widgets::status_node(&response, &texts::count(verdict), &number);
}

/// The buttons that add a loop and undo the last decision.
fn show_actions(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    let obstacle = obstacle(model);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let width = (ui.available_width() - 8.0) * 0.5;
        let has_keyframes = model.live_map().graph.nodes.len() >= ADDED_LOOP.min_keyframes;
        let add = Button::new(texts::ADD).icon(icon::PLUS).size(width, theme::TOUCH);
        if add.enabled(obstacle.is_none() && has_keyframes).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::PickLoopKeyframes(true));
        }
        let last = model.last_loop_edit();
        let hint = last.map_or_else(
            || texts::UNDO_NOTHING.to_owned(),
            |step| texts::undo_hint(step.pair, step.accepted),
        );
        let undo = Button::new(texts::UNDO).text(texts::UNDO_SHORT).icon(icon::ARROW_COUNTER_CLOCKWISE);
        let undo = undo.hint(&hint).enabled(last.is_some() && obstacle.is_none());
        if undo.size(width, theme::TOUCH).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::UndoLoop);
        }
    });
    if let Some(sentence) = obstacle {
        widgets::remark(ui, tokens, &sentence);
    }
}

/// Why this client cannot decide on loops now, and what to do about it. None if it can.
fn obstacle(model: &Model) -> Option<String> {
    if !model.is_connected() {
        Some(texts::LINK_LOST.to_owned())
    } else if model.is_controlled_by_other() {
        Some(texts::control_needed(model.control().holder_name()))
    } else {
        None
    }
}

/// Icon and colour of a verdict. Its word always stands beside them.
fn sign_of(verdict: LoopVerdict, tokens: &Tokens) -> (&'static str, Color32) {
    match verdict {
        LoopVerdict::Accepted => (icon::CHECK_CIRCLE, tokens.closed),
        LoopVerdict::Held => (icon::CLOCK_COUNTDOWN, tokens.warn),
        LoopVerdict::Rejected | LoopVerdict::Dropped => (icon::X_CIRCLE, tokens.dim),
    }
}
