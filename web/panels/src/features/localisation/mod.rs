//! Localisation in a saved map: using and leaving a map, setting the pose, relocalising.

mod texts;

use crate::button::Button;
use crate::theme::Tokens;
use crate::{icon, widgets};
use api::{Command, Localisation, MapSummary, Motion};
use client_model::{ClientCommand, Model};
use egui::Ui;

/// The state of localisation in words.
pub(crate) fn state_text(localisation: &Localisation) -> String {
    texts::state(localisation)
}

/// The section of the map that is viewed.
pub(crate) fn show(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    map: &MapSummary,
    out: &mut Vec<ClientCommand>,
) {
    let is_pending =
        model.is_pending(|command| matches!(command, Command::Localise { .. } | Command::LeaveMap));
    let enabled = model.can_command() && !is_pending;
    if model.localisation().map() == Some(map.id) {
        show_leave(ui, model, tokens, map, enabled, out);
        show_relocalise(ui, model, tokens, enabled, out);
    } else {
        show_use(ui, tokens, map, enabled, out);
    }
    show_set_pose(ui, model, tokens, enabled, out);
}

fn show_leave(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    map: &MapSummary,
    enabled: bool,
    out: &mut Vec<ClientCommand>,
) {
    let name = texts::leave_map(&map.name);
    let button = Button::new(&name).text(texts::LEAVE_SHORT).icon(icon::X).enabled(enabled).wide(ui);
    if button.show(ui, tokens).clicked() {
        out.push(ClientCommand::LeaveMap);
    }
    widgets::remark(ui, tokens, &texts::state(&model.localisation()));
}

fn show_use(ui: &mut Ui, tokens: &Tokens, map: &MapSummary, enabled: bool, out: &mut Vec<ClientCommand>) {
    let name = texts::use_map(&map.name);
    let button = Button::new(&name).text(texts::USE_SHORT).icon(icon::GPS_FIX).enabled(enabled).wide(ui);
    if button.show(ui, tokens).clicked() {
        out.push(ClientCommand::UseMap(map.id));
        out.push(ClientCommand::ViewMap(None));
    }
    widgets::remark(ui, tokens, texts::USE_HINT);
}

/// Starts picking the robot's pose on the map that is viewed, or ends it.
fn show_set_pose(ui: &mut Ui, model: &Model, tokens: &Tokens, enabled: bool, out: &mut Vec<ClientCommand>) {
    let is_picking = model.is_picking_pose();
    let button = Button::new(texts::SET_POSE).icon(icon::NAVIGATION_ARROW).on(is_picking);
    if button.enabled(enabled).wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::PickPose(!is_picking));
    }
}

/// Offers that a robot which cannot relocalise where it stands moves.
fn show_relocalise(ui: &mut Ui, model: &Model, tokens: &Tokens, enabled: bool, out: &mut Vec<ClientCommand>) {
    let is_lost = matches!(model.localisation(), Localisation::Relocalising { .. });
    let is_moving_for_it = matches!(model.motion(), Motion::Looking { .. });
    if !is_lost || is_moving_for_it {
        return;
    }
    let button = Button::new(texts::RELOCALISE).icon(icon::ARROWS_OUT);
    if button.enabled(enabled && !model.is_stopped()).wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::Relocalise);
    }
    widgets::remark(ui, tokens, texts::RELOCALISE_HINT);
}
