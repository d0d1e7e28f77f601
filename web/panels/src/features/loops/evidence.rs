//! What is known of one loop, both scans laid over each other, and deciding on it.

use super::sign_of;
use crate::button::{Button, Kind};
use crate::theme::{self, Tokens, Weight, font};
use crate::{icon, widgets, words};
use api::{LoopDecision, LoopVerdict};
use client_model::{CameraMove, ClientCommand, CloudState, LoopPair, Model, ScanOverlay};
use egui::Ui;

pub(crate) fn show(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    pair: LoopPair,
    out: &mut Vec<ClientCommand>,
) {
    ui.push_id("evidence", |ui| {
        egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 6.0;
            head(ui, tokens, pair, out);
            match model.loops.decisions().get(pair) {
                Some(decision) => {
                    verdict(ui, tokens, decision);
                    decide(ui, model, tokens, decision, out);
                    overlay(ui, model, tokens, pair, out);
                    figures(ui, tokens, decision);
                }
                None => {
                    let text = "What was decided on this loop is too long ago to be known here.";
                    widgets::remark(ui, tokens, text);
                    overlay(ui, model, tokens, pair, out);
                }
            }
        });
    });
}

fn head(ui: &mut Ui, tokens: &Tokens, pair: LoopPair, out: &mut Vec<ClientCommand>) {
    ui.horizontal(|ui| {
        ui.set_min_height(32.0);
        let title = format!("Loop {}", words::pair(pair));
        widgets::head(ui, tokens, &title);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let close =
                Button::icon_only("Close the loop's evidence", icon::X).kind(Kind::Quiet).size(36.0, 36.0);
            if close.show(ui, tokens).clicked() {
                out.push(ClientCommand::Select(None));
            }
            let find =
                Button::icon_only("Show where it is", icon::GPS_FIX).kind(Kind::Quiet).size(36.0, 36.0);
            if find.show(ui, tokens).clicked() {
                out.push(ClientCommand::MoveCamera(CameraMove::Loop(pair)));
            }
        });
    });
}

fn verdict(ui: &mut Ui, tokens: &Tokens, decision: &LoopDecision) {
    let (sign, colour) = sign_of(decision.verdict, tokens);
    let word = words::verdict(decision.verdict);
    let by = if decision.by_hand { " by hand" } else { "" };
    let response = widgets::tinted_box(ui, tokens, colour, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            ui.label(egui::RichText::new(sign).size(theme::ICON).color(colour));
            let text = egui::RichText::new(format!("{word}{by}")).font(font(theme::BODY, Weight::SemiBold));
            ui.label(text.color(tokens.text));
        });
        ui.add(
            egui::Label::new(egui::RichText::new(&decision.reason).size(theme::BODY).color(tokens.text))
                .wrap(),
        )
    });
    widgets::status_node(&response, "Verdict", &format!("{word}{by}. {}", decision.reason));
}

/// Why nobody here may decide now, and what to do about it.
pub(crate) fn locked(model: &Model) -> Option<String> {
    if !model.is_connected() {
        Some("The link to the robot is lost. It comes back by itself.".to_owned())
    } else if model.is_controlled_by_other() {
        Some(format!(
            "{} controls the robot. Take control to decide on loops.",
            model.control().holder_name()
        ))
    } else {
        None
    }
}

/// Accept, reject, and what they will do.
fn decide(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    decision: &LoopDecision,
    out: &mut Vec<ClientCommand>,
) {
    let pair = LoopPair::of_decision(decision);
    let locked = locked(model);
    let waiting = model.is_pending(|order| match order {
        api::Command::AcceptLoop { from, to } | api::Command::RejectLoop { from, to } => {
            LoopPair::of(*from, *to) == pair
        }
        _ => false,
    });
    let free = locked.is_none() && !waiting;
    let (accept, reject, sentence) = choices(decision);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let width = (ui.available_width() - 8.0) * 0.5;
        let button =
            Button::new("Accept loop").text("Accept").icon(icon::CHECK_CIRCLE).size(width, theme::TOUCH);
        if button.enabled(free && accept).show(ui, tokens).clicked() {
            out.push(ClientCommand::AcceptLoop(pair));
        }
        let button = Button::new("Reject loop").text("Reject").icon(icon::X_CIRCLE).size(width, theme::TOUCH);
        if button.enabled(free && reject).show(ui, tokens).clicked() {
            out.push(ClientCommand::RejectLoop(pair));
        }
    });
    widgets::remark(ui, tokens, &locked.unwrap_or_else(|| sentence.to_owned()));
}

/// Whether a loop can be accepted and rejected, and what that will do.
fn choices(decision: &LoopDecision) -> (bool, bool, &'static str) {
    match decision.verdict {
        LoopVerdict::Accepted => {
            (false, true, "Reject takes the edge out, and the map moves back to fit without it.")
        }
        LoopVerdict::Held => (
            true,
            true,
            "Accept joins the two places, and the map moves to fit. Reject stops waiting for others.",
        ),
        LoopVerdict::Rejected | LoopVerdict::Dropped if client_model::is_registered(decision) => {
            (true, false, "Accept joins the two places as they were found, and the map moves to fit.")
        }
        LoopVerdict::Rejected | LoopVerdict::Dropped => {
            (false, false, "The two could not be fitted together. Add them by hand from a better start.")
        }
    }
}

/// How the scans lie, and which is which.
fn overlay(ui: &mut Ui, model: &Model, tokens: &Tokens, pair: LoopPair, out: &mut Vec<ClientCommand>) {
    ui.add_space(2.0);
    widgets::head(ui, tokens, "Both scans");
    let choices = [
        ("As found", ScanOverlay::Registered),
        ("In the graph", ScanOverlay::Graph),
        ("Map only", ScanOverlay::Off),
    ];
    widgets::choice(ui, tokens, &choices, model.loops.overlay(), |overlay| {
        out.push(ClientCommand::SetScanOverlay(overlay))
    });
    if model.loops.overlay() != ScanOverlay::Off {
        legend(ui, model, tokens, pair);
    }
}

/// The colours of the two scans, and how far their points have come.
pub(crate) fn legend(ui: &mut Ui, model: &Model, tokens: &Tokens, pair: LoopPair) {
    ui.horizontal(|ui| {
        for (keyframe, word, colour) in [(pair.from, "older", tokens.older), (pair.to, "newer", tokens.newer)]
        {
            let (dot, _) = ui.allocate_exact_size(egui::vec2(12.0, 20.0), egui::Sense::hover());
            ui.painter().circle_filled(dot.center(), 5.0, colour);
            let text = format!("Keyframe {}, {word}", keyframe.0);
            ui.label(egui::RichText::new(text).size(theme::SMALL).color(tokens.text));
        }
    });
    let states = [model.cloud(pair.from), model.cloud(pair.to)];
    let failed = states.iter().find_map(|state| match state {
        Some(CloudState::Failed(sentence)) => Some(sentence.as_str()),
        _ => None,
    });
    if let Some(sentence) = failed {
        widgets::tinted_box(ui, tokens, tokens.warn, |ui| widgets::sentence(ui, tokens, sentence));
    } else if states.contains(&Some(&CloudState::Loading)) {
        widgets::remark(ui, tokens, "Fetching the scans…");
    }
}

/// Every number, with its unit and with what it means.
fn figures(ui: &mut Ui, tokens: &Tokens, decision: &LoopDecision) {
    widgets::rule(ui, tokens);
    ui.spacing_mut().item_spacing.y = 2.0;
    let (metres, radians) = client_model::correction_of(decision);
    let fitted = client_model::is_registered(decision);
    let or_none = |text: String| if fitted { text } else { "nothing to measure".to_owned() };
    let facts = [
        (
            "Overlap",
            or_none(words::two_shares(decision.overlap)),
            "Share of each scan that lies on the other's surfaces: newer on older, older on newer.",
        ),
        (
            "Surfaces apart",
            or_none(words::accuracy(f64::from(decision.residual))),
            "Root mean square distance of the points from those surfaces.",
        ),
        (
            "Seen through",
            or_none(words::two_shares(decision.free_space_violation)),
            "Share of each scan that the other looked through, which a wall forbids.",
        ),
        (
            "Best rival",
            or_none(words::rival(decision.runner_up_ratio)),
            "How well the best other place fits, as a share of this one.",
        ),
        (
            "Moved from the guess",
            or_none(words::shift(metres, radians)),
            "From where the comparison started to where it ended.",
        ),
        ("Found by", words::source(decision.source), "Why the two were compared."),
    ];
    for (name, value, hint) in facts {
        widgets::fact(ui, tokens, name, &value).on_hover_text(hint);
    }
}
