//! The right card of Map: making a map, and the maps that were made.

#[cfg(test)]
mod tests;

use crate::TextInput;
use crate::button::{Button, Kind};
use crate::features::{alignment, maps, quality};
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets::{self, fact};
use crate::{PanelState, icon, sensors, words};
use api::{Command, Mapping};
use client_model::{ClientCommand, Model};
use egui::{Ui, vec2};
use vocab::{MapId, Stamp};

/// Metres through known ground after which the robot has mostly found itself.
const FIND_M: f64 = 15.0;

pub(crate) fn show(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    if !matches!(*model.mapping(), Mapping::Running { .. }) {
        state.confirm_discard = false;
    }
    egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 8.0;
        if let (Mapping::Idle, Some(align)) = (model.mapping(), model.alignment()) {
            return alignment::show(ui, model, tokens, align, out);
        }
        match model.mapping() {
            Mapping::Idle => idle(ui, model, tokens, out),
            Mapping::Starting { .. } => starting(ui, tokens, out),
            Mapping::Loading { map, .. } => loading(ui, model, tokens, *map, out),
            Mapping::Finding { map, distance, ambiguous, .. } => {
                finding(ui, model, tokens, (*map, *distance, *ambiguous), out);
            }
            Mapping::Running { extends, since, distance, keyframes, on_known_ground, .. } => {
                let ground = if *on_known_ground { "Known: nothing to add" } else { "New" };
                running(ui, model, tokens, (*since, *distance, *keyframes, ground));
                if let Some(map) = extends {
                    fact(ui, tokens, "Extends", words::map_name(model, *map));
                }
                quality::show(ui, model, tokens, out);
                finish(ui, model, tokens, state, out);
            }
            Mapping::Saving { .. } => saving(ui, tokens),
        }
        if let (Some(health), false) = (&model.robot.health, matches!(*model.mapping(), Mapping::Idle)) {
            sensors::findings(ui, &health.value, tokens);
            ui.add_space(4.0);
            widgets::rule(ui, tokens);
            widgets::head(ui, tokens, "Sensors");
            sensors::list(ui, model, tokens);
        }
        ui.add_space(4.0);
        widgets::rule(ui, tokens);
        maps::show(ui, model, tokens, state, out);
    });
}

fn idle(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    widgets::head(ui, tokens, "Make a map");
    let first = model.maps().list().is_some_and(<[_]>::is_empty);
    let sentence = if first {
        "No map yet. Put the robot where it can stand still for a moment, start mapping, then drive it through every \
         room. Finish where you began: that makes the map most exact."
    } else {
        "Let the robot stand still, start mapping, drive it through every room, and finish where you began."
    };
    widgets::remark(ui, tokens, sentence);
    let waiting = model.is_pending(|order| matches!(order, Command::StartMapping(_)));
    let name = if waiting { "Starting…" } else { "Start mapping" };
    let enabled = model.is_connected() && !waiting && !model.is_controlled_by_other();
    let start = Button::new(name).icon(icon::PLAY).kind(Kind::Primary).enabled(enabled).wide(ui);
    if start.show(ui, tokens).clicked() {
        out.push(ClientCommand::StartMapping);
    }
    if model.is_controlled_by_other() {
        widgets::remark(
            ui,
            tokens,
            &format!("{} controls the robot. Take control to map.", model.control().holder_name()),
        );
    }
}

fn starting(ui: &mut Ui, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    status_head(ui, tokens, "Finding gravity");
    widgets::tinted_box(ui, tokens, tokens.accent, |ui| {
        widgets::sentence(
            ui,
            tokens,
            "Keep the robot still for a few seconds. Mapping then begins by itself.",
        );
    });
    if Button::new("Cancel mapping").wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::DiscardMapping);
    }
}

fn loading(ui: &mut Ui, model: &Model, tokens: &Tokens, map: MapId, out: &mut Vec<ClientCommand>) {
    status_head(ui, tokens, "Reading the map");
    ui.add(egui::ProgressBar::new(1.0).animate(true).desired_height(6.0).corner_radius(3));
    widgets::remark(ui, tokens, &format!("{} is being read.", words::map_name(model, map)));
    if Button::new("Cancel mapping").wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::DiscardMapping);
    }
}

/// The robot looks for its place in a saved map.
fn finding(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    (map, distance, ambiguous): (MapId, f64, bool),
    out: &mut Vec<ClientCommand>,
) {
    status_head(ui, tokens, "Localising in the map");
    let name = words::map_name(model, map);
    let sentence = if ambiguous {
        format!("The scans so far fit {name} in two places. Drive to a part that exists only once.")
    } else {
        format!(
            "Drive the robot some {FIND_M:.0} m through a part that {name} shows. It is then localised by itself."
        )
    };
    widgets::tinted_box(ui, tokens, tokens.accent, |ui| widgets::sentence(ui, tokens, &sentence));
    let share = (distance / FIND_M).min(1.0) as f32;
    ui.add(egui::ProgressBar::new(share).desired_height(6.0).corner_radius(3));
    fact(ui, tokens, "Driven so far", &words::distance(distance));
    if Button::new("Cancel mapping").wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::DiscardMapping);
    }
}

fn saving(ui: &mut Ui, tokens: &Tokens) {
    status_head(ui, tokens, "Saving the map");
    ui.add(egui::ProgressBar::new(1.0).animate(true).desired_height(6.0).corner_radius(3));
    widgets::remark(
        ui,
        tokens,
        "The map is shown as soon as it is written. You may go on driving meanwhile.",
    );
}

fn status_head(ui: &mut Ui, tokens: &Tokens, text: &str) {
    let response =
        ui.label(egui::RichText::new(text).font(font(theme::HEAD, Weight::SemiBold)).color(tokens.text));
    widgets::status_node(&response, "Mapping", text);
}

fn running(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    (since, distance, keyframes, ground): (Stamp, f64, u32, &str),
) {
    let elapsed = model.connection().clock().age_of(since, model.now()).unwrap_or(0.0);
    ui.horizontal(|ui| {
        let (dot, _) = ui.allocate_exact_size(vec2(10.0, 20.0), egui::Sense::hover());
        ui.painter().circle_filled(dot.center(), 5.0, tokens.good);
        status_head(ui, tokens, "Mapping");
    });
    ui.spacing_mut().item_spacing.y = 4.0;
    fact(ui, tokens, "Elapsed", &words::elapsed(elapsed));
    fact(ui, tokens, "Distance", &words::distance(distance));
    fact(ui, tokens, "Keyframes", &words::count(u64::from(keyframes)));
    fact(ui, tokens, "Ground", ground);
    fact(ui, tokens, "Points in map", &words::points(model.live_map().tiles.points()));
}

fn finish(ui: &mut Ui, model: &Model, tokens: &Tokens, state: &mut PanelState, out: &mut Vec<ClientCommand>) {
    ui.spacing_mut().item_spacing.y = 8.0;
    ui.add_space(4.0);
    let enabled = model.is_connected() && !model.is_controlled_by_other();
    if state.confirm_discard {
        confirm_discard(ui, tokens, enabled, state, out);
        return;
    }
    let hint = match model.mapping() {
        Mapping::Running { extends: Some(map), .. } => words::map_name(model, *map).to_owned(),
        _ => format!("Map {}", model.maps().len() + 1),
    };
    let name = "Map name";
    ui.label(egui::RichText::new(name).size(theme::SMALL).color(tokens.dim));
    TextInput::new(name, name).hint(&hint).show(ui, tokens, &mut state.text_inputs, &mut state.map_name);
    let waiting = model.is_pending(|order| matches!(order, Command::FinishMapping { .. }));
    let save = Button::new("Finish and save").icon(icon::FLOPPY_DISK).kind(Kind::Primary);
    if save.enabled(enabled && !waiting).wide(ui).show(ui, tokens).clicked() {
        let typed = std::mem::take(&mut state.map_name);
        let name = if typed.trim().is_empty() { hint } else { typed.trim().to_owned() };
        out.push(ClientCommand::FinishMapping { name });
    }
    let discard = Button::new("Discard").text("Discard…").icon(icon::TRASH).wide(ui);
    if discard.enabled(enabled).show(ui, tokens).clicked() {
        state.confirm_discard = true;
    }
    if model.is_controlled_by_other() {
        let sentence =
            format!("{} controls the robot. Take control to finish.", model.control().holder_name());
        widgets::remark(ui, tokens, &sentence);
    }
}

fn confirm_discard(
    ui: &mut Ui,
    tokens: &Tokens,
    enabled: bool,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    widgets::tinted_box(ui, tokens, tokens.bad, |ui| {
        widgets::sentence(ui, tokens, "Throw this map away? It cannot be brought back.");
    });
    if Button::new("Discard map")
        .icon(icon::TRASH)
        .kind(Kind::Danger)
        .enabled(enabled)
        .wide(ui)
        .show(ui, tokens)
        .clicked()
    {
        state.confirm_discard = false;
        out.push(ClientCommand::DiscardMapping);
    }
    if Button::new("Keep mapping").wide(ui).show(ui, tokens).clicked() {
        state.confirm_discard = false;
    }
}
