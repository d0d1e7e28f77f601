//! The evidence of one loop: its verdict, both scans laid over each other, the quantities of the comparison, and deciding on it.

use super::texts::{self, Quantity};
use super::{obstacle, sign_of};
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::theme::{self, Tokens, Weight, font};
use crate::{format, icon, widgets};
use api::{Command, LoopDecision, LoopVerdict};
use client_model::{CameraMove, ClientCommand, CloudState, LoopPair, Model, ScanOverlay};
use egui::{Align, Layout, ScrollArea, Ui, vec2};

/// The section below the list, or in its place.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, pair: LoopPair) {
    let tokens = cx.tokens;
    ui.push_id("evidence", |ui| {
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 6.0;
            show_head(ui, cx, pair);
            if let Some(decision) = cx.model.loops.decisions().get(pair) {
                show_verdict(ui, tokens, decision);
                show_choices(ui, cx, decision);
                show_scans(ui, cx, pair);
                show_quantities(ui, tokens, decision);
            } else {
                widgets::remark(ui, tokens, texts::UNKNOWN_DECISION);
                show_scans(ui, cx, pair);
            }
        });
    });
}

fn show_head(ui: &mut Ui, cx: &mut PanelContext<'_>, pair: LoopPair) {
    let tokens = cx.tokens;
    ui.horizontal(|ui| {
        ui.set_min_height(32.0);
        widgets::head(ui, tokens, &texts::head(pair));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let close = Button::icon_only(texts::CLOSE, icon::X).kind(Kind::Quiet).size(36.0, 36.0);
            if close.show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::Select(None));
            }
            let find = Button::icon_only(texts::SHOW_IN_SCENE, icon::GPS_FIX).kind(Kind::Quiet);
            if find.size(36.0, 36.0).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::MoveCamera(CameraMove::Loop(pair)));
            }
        });
    });
}

fn show_verdict(ui: &mut Ui, tokens: &Tokens, decision: &LoopDecision) {
    let (sign, colour) = sign_of(decision.verdict, tokens);
    let verdict = texts::verdict_and_author(decision.verdict, decision.by_hand);
    let response = widgets::tinted_box(ui, tokens, colour, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            ui.label(egui::RichText::new(sign).size(theme::ICON).color(colour));
            let text = egui::RichText::new(&verdict).font(font(theme::BODY, Weight::SemiBold));
            ui.label(text.color(tokens.text));
        });
        let reason = egui::RichText::new(&decision.reason).size(theme::BODY).color(tokens.text);
        ui.add(egui::Label::new(reason).wrap())
    });
    widgets::status_node(&response, texts::VERDICT, &texts::verdict_value(&verdict, &decision.reason));
}

/// The buttons that accept and reject a loop, and what they do.
fn show_choices(ui: &mut Ui, cx: &mut PanelContext<'_>, decision: &LoopDecision) {
    let (model, tokens) = (cx.model, cx.tokens);
    let pair = LoopPair::of_decision(decision);
    let choices = Choices::of(decision);
    let obstacle = obstacle(model);
    let can_decide = obstacle.is_none() && !is_pending(model, pair);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let width = (ui.available_width() - 8.0) * 0.5;
        let accept = Button::new(texts::ACCEPT).text(texts::ACCEPT_SHORT).icon(icon::CHECK_CIRCLE);
        let accept = accept.size(width, theme::TOUCH).enabled(can_decide && choices.accept);
        if accept.show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::AcceptLoop(pair));
        }
        let reject = Button::new(texts::REJECT).text(texts::REJECT_SHORT).icon(icon::X_CIRCLE);
        let reject = reject.size(width, theme::TOUCH).enabled(can_decide && choices.reject);
        if reject.show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::RejectLoop(pair));
        }
    });
    widgets::remark(ui, tokens, obstacle.as_deref().unwrap_or(choices.effect));
}

/// Whether a decision on this loop has not been answered yet.
fn is_pending(model: &Model, pair: LoopPair) -> bool {
    model.is_pending(|command| match command {
        Command::AcceptLoop { from, to } | Command::RejectLoop { from, to } => {
            LoopPair::of(*from, *to) == pair
        }
        _ => false,
    })
}

/// What can be decided on a loop.
struct Choices {
    accept: bool,
    reject: bool,
    /// What the decision will do to the map.
    effect: &'static str,
}

impl Choices {
    fn of(decision: &LoopDecision) -> Self {
        match decision.verdict {
            LoopVerdict::Accepted => Self { accept: false, reject: true, effect: texts::EFFECT_OF_REJECTING },
            LoopVerdict::Held => Self { accept: true, reject: true, effect: texts::EFFECT_OF_DECIDING },
            LoopVerdict::Rejected | LoopVerdict::Dropped if client_model::is_registered(decision) => {
                Self { accept: true, reject: false, effect: texts::EFFECT_OF_ACCEPTING }
            }
            LoopVerdict::Rejected | LoopVerdict::Dropped => {
                Self { accept: false, reject: false, effect: texts::NOT_REGISTERED }
            }
        }
    }
}

/// How the two scans are laid over each other, and their colours.
fn show_scans(ui: &mut Ui, cx: &mut PanelContext<'_>, pair: LoopPair) {
    let (model, tokens) = (cx.model, cx.tokens);
    ui.add_space(2.0);
    widgets::head(ui, tokens, texts::SCANS);
    let choices = [
        (texts::OVERLAY_REGISTERED, ScanOverlay::Registered),
        (texts::OVERLAY_GRAPH, ScanOverlay::Graph),
        (texts::OVERLAY_OFF, ScanOverlay::Off),
    ];
    widgets::choice(ui, tokens, &choices, model.loops.overlay(), |overlay| {
        cx.commands.push(ClientCommand::SetScanOverlay(overlay));
    });
    if model.loops.overlay() != ScanOverlay::Off {
        show_legend(ui, cx, pair);
    }
}

/// The colours of the two scans, and whether their points have arrived.
pub(super) fn show_legend(ui: &mut Ui, cx: &PanelContext<'_>, pair: LoopPair) {
    let (model, tokens) = (cx.model, cx.tokens);
    ui.horizontal(|ui| {
        let scans = [(pair.from, texts::OLDER, tokens.older), (pair.to, texts::NEWER, tokens.newer)];
        for (keyframe, age, colour) in scans {
            let (dot, _) = ui.allocate_exact_size(vec2(12.0, 20.0), egui::Sense::hover());
            ui.painter().circle_filled(dot.center(), 5.0, colour);
            let text = texts::keyframe(keyframe, age);
            ui.label(egui::RichText::new(text).size(theme::SMALL).color(tokens.text));
        }
    });
    let clouds = [model.cloud(pair.from), model.cloud(pair.to)];
    let failure = clouds.iter().find_map(|cloud| match cloud {
        Some(CloudState::Failed(sentence)) => Some(sentence.as_str()),
        _ => None,
    });
    if let Some(sentence) = failure {
        widgets::tinted_box(ui, tokens, tokens.warn, |ui| widgets::sentence(ui, tokens, sentence));
    } else if clouds.contains(&Some(&CloudState::Loading)) {
        widgets::remark(ui, tokens, texts::SCANS_LOADING);
    }
}

/// Every quantity of the comparison with its unit, and its meaning on hover.
fn show_quantities(ui: &mut Ui, tokens: &Tokens, decision: &LoopDecision) {
    widgets::rule(ui, tokens);
    ui.spacing_mut().item_spacing.y = 2.0;
    let (distance_m, angle_rad) = client_model::correction_of(decision);
    let measured: [(Quantity, String); 5] = [
        (texts::OVERLAP, texts::two_shares(decision.overlap)),
        (texts::RESIDUAL, format::accuracy(f64::from(decision.residual_m))),
        (texts::FREE_SPACE_VIOLATION, texts::two_shares(decision.free_space_violation)),
        (texts::RUNNER_UP, texts::runner_up(decision.runner_up_ratio)),
        (texts::CORRECTION, texts::correction(distance_m, angle_rad)),
    ];
    let is_registered = client_model::is_registered(decision);
    for (quantity, value) in measured {
        show_quantity(ui, tokens, quantity, if is_registered { &value } else { texts::NO_VALUE });
    }
    show_quantity(ui, tokens, texts::SOURCE, &texts::source(decision.source));
}

fn show_quantity(ui: &mut Ui, tokens: &Tokens, (name, meaning): Quantity, value: &str) {
    widgets::fact(ui, tokens, name, value).on_hover_text(meaning);
}
