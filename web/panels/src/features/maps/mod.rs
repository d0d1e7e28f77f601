//! The list of saved maps.

#[cfg(test)]
mod tests;

use crate::button::Button;
use crate::features::{alignment, imports};
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets;
use crate::{PanelState, icon, words};
use api::{Command, Localisation, MapSummary, Mapping, Motion};
use client_model::{ClientCommand, Model};
use egui::{CornerRadius, Ui};

pub(crate) fn show(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    state: &PanelState,
    out: &mut Vec<ClientCommand>,
) {
    if let Some(align) = model.alignment() {
        return alignment::show(ui, model, tokens, align, out);
    }
    widgets::head(ui, tokens, "Saved maps");
    match model.maps().list() {
        None => widgets::remark(ui, tokens, "Waiting for the robot to list them."),
        Some([]) => widgets::remark(ui, tokens, "None yet."),
        Some(maps) => {
            for map in maps {
                ui.push_id(map.id.0, |ui| entry(ui, model, tokens, state, map, out));
            }
        }
    }
    imports::show(ui, model, tokens, out);
}

fn entry(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    state: &PanelState,
    map: &MapSummary,
    out: &mut Vec<ClientCommand>,
) {
    let viewed = model.viewed_map() == Some(map.id);
    let fill = if viewed { tokens.selected() } else { tokens.raised };
    let frame = egui::Frame::new()
        .fill(fill)
        .corner_radius(CornerRadius::same(theme::BUTTON_RADIUS))
        .inner_margin(12);
    let shown = frame.show(ui, |ui| {
        ui.horizontal(|ui| {
            let button_width = 84.0;
            ui.allocate_ui(egui::vec2(ui.available_width() - button_width - 8.0, 40.0), |ui| {
                ui.vertical(|ui| {
                    ui.spacing_mut().item_spacing.y = 2.0;
                    let name = egui::RichText::new(&map.name)
                        .font(font(theme::BODY, Weight::Medium))
                        .color(tokens.text);
                    ui.add(egui::Label::new(name).truncate());
                    widgets::remark(ui, tokens, &words::date(map.created, state.utc_offset_s));
                    // Nobody has walked what was imported.
                    let walked =
                        (map.distance > 0.0).then(|| format!("{} · ", words::distance(map.distance)));
                    let size = format!(
                        "{}{} points · {}",
                        walked.unwrap_or_default(),
                        words::points(map.points),
                        words::bytes(map.bytes)
                    );
                    widgets::remark(ui, tokens, &size);
                });
            });
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let (name, text) = if viewed {
                    (format!("Close {}", map.name), "Close")
                } else {
                    (format!("View {}", map.name), "View")
                };
                let sign = if viewed { icon::X } else { icon::EYE };
                let button = Button::new(&name).text(text).icon(sign).size(button_width, theme::TOUCH);
                if button.show(ui, tokens).clicked() {
                    out.push(ClientCommand::ViewMap((!viewed).then_some(map.id)));
                }
            });
        });
    });
    if viewed && *model.mapping() == Mapping::Idle {
        use_or_leave(ui, model, tokens, map, out);
        extend(ui, model, tokens, map, out);
        alignment::offer(ui, model, tokens, map.id, out);
    }
    let name = format!("Saved map {}", map.name);
    let value =
        format!("{}, {}", words::date(map.created, state.utc_offset_s), words::distance(map.distance));
    widgets::status_node(&shown.response, &name, &value);
}

/// The robot walks by the map that is looked at, or no longer.
fn use_or_leave(ui: &mut Ui, model: &Model, tokens: &Tokens, map: &MapSummary, out: &mut Vec<ClientCommand>) {
    let waiting = model.is_pending(|order| matches!(order, Command::Localise { .. } | Command::LeaveMap));
    let enabled = model.is_connected() && !waiting && !model.is_controlled_by_other();
    if model.localisation().map() == Some(map.id) {
        let name = format!("Leave {}", map.name);
        let button = Button::new(&name).text("Leave this map").icon(icon::X).enabled(enabled).wide(ui);
        if button.show(ui, tokens).clicked() {
            out.push(ClientCommand::LeaveMap);
        }
        widgets::remark(ui, tokens, &words::localisation(&model.localisation()));
        look_about(ui, model, tokens, enabled, out);
        place(ui, model, tokens, enabled, out);
        return;
    }
    let name = format!("Use {}", map.name);
    let button = Button::new(&name).text("Use this map").icon(icon::GPS_FIX).enabled(enabled).wide(ui);
    if button.show(ui, tokens).clicked() {
        out.push(ClientCommand::UseMap(map.id));
        out.push(ClientCommand::ViewMap(None));
    }
    widgets::remark(ui, tokens, "The robot localises itself in it and walks by it.");
    place(ui, model, tokens, enabled, out);
}

/// A person who knows where the robot stands shows it on the map that is looked at.
fn place(ui: &mut Ui, model: &Model, tokens: &Tokens, enabled: bool, out: &mut Vec<ClientCommand>) {
    let button = Button::new("Set the pose").icon(icon::NAVIGATION_ARROW).on(model.is_picking_pose());
    if button.enabled(enabled).wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::PickPose(!model.is_picking_pose()));
    }
}

/// A robot that does not find itself where it stands has to move.
fn look_about(ui: &mut Ui, model: &Model, tokens: &Tokens, enabled: bool, out: &mut Vec<ClientCommand>) {
    let lost = matches!(model.localisation(), Localisation::Relocalising { .. });
    if !lost || matches!(model.motion(), Motion::Looking { .. }) {
        return;
    }
    let enabled = enabled && !model.is_stopped();
    let button = Button::new("Relocalise").icon(icon::ARROWS_OUT).enabled(enabled).wide(ui);
    if button.show(ui, tokens).clicked() {
        out.push(ClientCommand::Relocalise);
    }
    widgets::remark(
        ui,
        tokens,
        "Walks a few metres at a time, over free floor, until the robot is localised.",
    );
}

/// The map that is looked at grows.
fn extend(ui: &mut Ui, model: &Model, tokens: &Tokens, map: &MapSummary, out: &mut Vec<ClientCommand>) {
    let waiting = model.is_pending(|order| matches!(order, Command::ExtendMap { .. }));
    let enabled = model.is_connected() && !waiting && !model.is_controlled_by_other();
    let name = format!("Extend {}", map.name);
    let button = Button::new(&name).text("Extend this map").icon(icon::PLUS).enabled(enabled).wide(ui);
    if button.show(ui, tokens).clicked() {
        out.push(ClientCommand::ExtendMap(map.id));
    }
    widgets::remark(
        ui,
        tokens,
        "Goes on mapping where this map ends. It is kept; the larger one is saved beside it.",
    );
}
