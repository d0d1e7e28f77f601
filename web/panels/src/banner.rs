//! What everybody must see at once, at the top of the scene: the link, which map this is, notices.

use crate::button::Button;
use crate::features::{alignment, loops, notices};
use crate::layout::area;
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets;
use crate::{Layout, Width, icon, words};
use client_model::{ClientCommand, Loading, Model, SocketState};
use egui::{Align2, Order, Ui};

const WIDTH: f32 = 460.0;

pub(crate) fn show(
    ctx: &egui::Context,
    model: &Model,
    tokens: &Tokens,
    layout: &Layout,
    drawer_open: bool,
    out: &mut Vec<ClientCommand>,
) {
    let left =
        if layout.width == Width::Narrow { layout.free.left() + 68.0 } else { layout.free.left() + 76.0 };
    let beside_drawer = layout.width == Width::Medium && drawer_open;
    let right = if beside_drawer { layout.card.left() - theme::GAP } else { layout.free.right() };
    let free = egui::Rect::from_min_max(
        egui::pos2(left, layout.free.top()),
        egui::pos2(right, layout.free.bottom()),
    );
    let width = WIDTH.min(free.width());
    area("Messages", Order::Foreground).pivot(Align2::CENTER_TOP).fixed_pos(free.center_top()).show(
        ctx,
        |ui| {
            ui.set_width(width);
            ui.spacing_mut().item_spacing.y = 8.0;
            link(ui, model, tokens, out);
            saved_map(ui, model, tokens, out);
            walk_hint(ui, model, tokens);
            place_hint(ui, model, tokens, out);
            loop_hint(ui, model, tokens, out);
            align_hint(ui, model, tokens, out);
            notices::show(ui, model, tokens, out);
        },
    );
}

fn link(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    let lost = model.connection().lost_since().map(|since| model.now().since(since));
    match (model.connection().state(), lost) {
        (SocketState::Connected { .. }, _) => {}
        (SocketState::Refused { reason }, _) => line(ui, tokens, tokens.bad, icon::X_CIRCLE, reason, |_| {}),
        (SocketState::Connecting { .. }, None) => {
            line(ui, tokens, tokens.accent, icon::PLUGS, "Connecting to the robot…", |_| {});
        }
        (SocketState::Connecting { .. }, Some(lost)) => {
            let text = format!("Link lost {} ago. Trying again now…", words::duration(lost));
            line(ui, tokens, tokens.bad, icon::WIFI_SLASH, &text, |_| {});
        }
        (SocketState::Lost { retry_at, .. }, lost) => {
            let wait = retry_at.since(model.now()).ceil();
            let text = format!(
                "Link lost {} ago. Next try in {wait:.0} s.",
                words::duration(lost.unwrap_or_default())
            );
            line(ui, tokens, tokens.bad, icon::WIFI_SLASH, &text, |ui| {
                if Button::new("Reconnect now").show(ui, tokens).clicked() {
                    out.push(ClientCommand::Reconnect);
                }
            });
        }
    }
}

fn saved_map(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    let Some((id, view)) = model.saved_map() else { return };
    let name = model
        .maps()
        .list()
        .into_iter()
        .flatten()
        .find(|map| map.id == id)
        .map_or("a saved map", |map| map.name.as_str());
    let (colour, text) = match &view.loading {
        Loading::Waiting => (tokens.accent, format!("Opening {name}…")),
        Loading::Failed(sentence) => (tokens.bad, sentence.clone()),
        Loading::Done => {
            let (here, all) = (view.tiles.ready_points(), view.tiles.points());
            let points = if view.tiles.loading() > 0 {
                format!("{} of {} points", words::points(here), words::points(all))
            } else {
                format!("{} points", words::points(all))
            };
            (tokens.accent, format!("{name} · {points}"))
        }
    };
    line(ui, tokens, colour, icon::MAP_TRIFOLD, &text, |ui| {
        if Button::new("Back to live").show(ui, tokens).clicked() {
            out.push(ClientCommand::ViewMap(None));
        }
    });
}

fn walk_hint(ui: &mut Ui, model: &Model, tokens: &Tokens) {
    if model.is_picking_goal() {
        line(ui, tokens, tokens.accent, icon::MAP_PIN, "Click the floor where the robot shall walk.", |_| {});
    }
}

fn place_hint(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    if model.is_picking_pose() {
        let text = "Press the floor where the robot stands and drag in the direction it faces.";
        line(ui, tokens, tokens.accent, icon::NAVIGATION_ARROW, text, |ui| {
            if Button::new("Cancel").show(ui, tokens).clicked() {
                out.push(ClientCommand::PickPose(false));
            }
        });
    }
}

fn align_hint(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    if let Some(align) = model.alignment().filter(|align| align.reference.is_some() && align.job.is_none()) {
        line(ui, tokens, tokens.accent, icon::ARROWS_DOWN_UP, &alignment::next_step(model, align), |ui| {
            if Button::new("Cancel").show(ui, tokens).clicked() {
                out.push(ClientCommand::CancelAlignment);
            }
        });
    }
}

fn loop_hint(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    if let Some(pick) = model.loop_pick() {
        line(ui, tokens, tokens.accent, icon::GRAPH, &loops::next_step(pick), |ui| {
            if Button::new("Cancel").show(ui, tokens).clicked() {
                out.push(ClientCommand::PickLoopKeyframes(false));
            }
        });
    }
}

/// One line on a card of its own: sign, sentence, and what can be done.
fn line(
    ui: &mut Ui,
    tokens: &Tokens,
    colour: egui::Color32,
    sign: &str,
    text: &str,
    action: impl FnOnce(&mut Ui),
) {
    theme::card(tokens).inner_margin(egui::Margin::symmetric(14, 6)).show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.horizontal(|ui| {
            ui.set_min_height(theme::TOUCH);
            ui.label(egui::RichText::new(sign).size(20.0).color(colour));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                action(ui);
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    let text_font = font(theme::BODY, Weight::Medium);
                    let shown = egui::RichText::new(text).font(text_font).color(tokens.text);
                    let response = ui.add(egui::Label::new(shown).wrap());
                    widgets::status_node(&response, "Message", text);
                });
            });
        });
    });
}
