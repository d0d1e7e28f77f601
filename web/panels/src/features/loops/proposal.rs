//! Adding a loop by hand: two keyframes are picked, then compared from an initial guess.

use super::{evidence, obstacle, texts};
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::{format, icon, widgets};
use client_model::{ClientCommand, LoopInitialGuess, LoopPair, LoopPick, Model};
use egui::Ui;

/// The section that takes the place of the list while keyframes are picked.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, pick: LoopPick) {
    let tokens = cx.tokens;
    widgets::rule(ui, tokens);
    widgets::head(ui, tokens, texts::ADD);
    let step = texts::step(pick);
    widgets::tinted_box(ui, tokens, tokens.accent, |ui| widgets::sentence(ui, tokens, &step));
    if let LoopPick::Both(pair) = pick {
        show_guess(ui, cx, pair);
        evidence::show_legend(ui, cx, pair);
        show_propose(ui, cx, pair);
    }
    let cancel = Button::new(texts::CANCEL).text(texts::CANCEL_SHORT).icon(icon::X);
    if cancel.wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::PickLoopKeyframes(false));
    }
}

/// The pose from which the comparison starts.
fn show_guess(ui: &mut Ui, cx: &mut PanelContext<'_>, pair: LoopPair) {
    let (model, tokens) = (cx.model, cx.tokens);
    widgets::fact(ui, tokens, texts::GRAPH_DISTANCE, &format::distance(graph_distance_m(model, pair)));
    widgets::remark(ui, tokens, texts::INITIAL_GUESS);
    let choices = [
        (texts::GUESS_GRAPH, LoopInitialGuess::Graph),
        (texts::GUESS_SAME_POSITION, LoopInitialGuess::SamePosition),
    ];
    widgets::choice(ui, tokens, &choices, model.loops.initial_guess(), |guess| {
        cx.commands.push(ClientCommand::SetLoopInitialGuess(guess));
    });
}

/// Distance of two keyframes as the graph has them, metres. 0 if the graph does not have them.
fn graph_distance_m(model: &Model, pair: LoopPair) -> f64 {
    let guess = model.loop_initial_guess(pair, LoopInitialGuess::Graph);
    guess.map_or(0.0, |from_from_to| {
        let p = from_from_to.position;
        p.x.hypot(p.y).hypot(p.z)
    })
}

fn show_propose(ui: &mut Ui, cx: &mut PanelContext<'_>, pair: LoopPair) {
    let tokens = cx.tokens;
    let obstacle = if pair.is_adjacent() { Some(texts::ADJACENT.to_owned()) } else { obstacle(cx.model) };
    let button = Button::new(texts::PROPOSE).icon(icon::CHECK_CIRCLE).kind(Kind::Primary);
    if button.enabled(obstacle.is_none()).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::ProposeLoop);
    }
    widgets::remark(ui, tokens, obstacle.as_deref().unwrap_or(texts::PROPOSE_HINT));
}
