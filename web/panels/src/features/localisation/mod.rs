//! Localisation: how far the position can be trusted; using and leaving a saved map, setting the pose, relocalising.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::Button;
use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::message::show_message;
use crate::status_line::{StatusDetail, StatusLine};
use crate::theme;
use crate::{format, icon, widgets};
use api::{Command, Localisation, MapSummary, Motion};
use client_model::{ClientCommand, Model, position_sigma_m};
use egui::Ui;

/// Greatest number of characters of a state that fits beside its name.
const MAX_LINE_CHARS: usize = 24;

/// Parameters of the panel.
struct LocalisationPanelConfig {
    /// Standard deviation of the position above which it is shown as uncertain, metres. Chosen: between the monitor's limits of an uncertain and of a lost pose (0.15 and
    /// 0.8 m), because its own status is shown too.
    uncertain_sigma_m: f64,
}

const CONFIG: LocalisationPanelConfig = LocalisationPanelConfig { uncertain_sigma_m: 0.5 };

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct LocalisationPanel;

impl FeaturePanel for LocalisationPanel {
    fn cancel(&mut self, cx: &mut PanelContext<'_>) -> bool {
        let is_picking = cx.model.is_picking_pose();
        if is_picking {
            cx.commands.push(ClientCommand::PickPose(false));
        }
        is_picking
    }

    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        if !cx.model.is_picking_pose() {
            return;
        }
        let tokens = cx.tokens;
        show_message(ui, tokens, tokens.accent, icon::NAVIGATION_ARROW, texts::SET_POSE_HINT, |ui| {
            if Button::new(texts::CANCEL).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::PickPose(false));
            }
        });
    }
}

/// The state of localisation: on the line of its name if it is short, else a sentence below.
pub(crate) fn show_state(ui: &mut Ui, cx: &PanelContext<'_>) {
    let tokens = cx.tokens;
    let state = texts::state(&cx.model.localisation());
    if state.chars().count() <= MAX_LINE_CHARS {
        widgets::fact(ui, tokens, texts::LOCALISATION, &state);
        return;
    }
    widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
        let text = egui::RichText::new(&state).size(theme::BODY).color(tokens.text);
        let response = ui.add(egui::Label::new(text).wrap());
        widgets::status_node(&response, texts::LOCALISATION, &state);
    });
}

/// How far the position in the top bar can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PositionQuality {
    None,
    Outdated,
    Relocalising,
    Uncertain,
    Degenerate,
    Good,
}

fn position_quality(model: &Model) -> PositionQuality {
    let Some(estimate) = &model.robot.estimate else { return PositionQuality::None };
    let localisation = model.localisation();
    if !model.is_connected() {
        PositionQuality::Outdated
    } else if matches!(localisation, Localisation::Loading { .. } | Localisation::Relocalising { .. }) {
        PositionQuality::Relocalising
    } else if position_sigma_m(&estimate.value) > CONFIG.uncertain_sigma_m
        || matches!(localisation, Localisation::Localised { degradation: Some(_), .. })
    {
        PositionQuality::Uncertain
    } else if estimate.value.degenerate > 0 {
        PositionQuality::Degenerate
    } else {
        PositionQuality::Good
    }
}

/// How far the position can be trusted, with its accuracy, for the top bar.
pub(crate) fn status(cx: &PanelContext<'_>, detail: StatusDetail) -> StatusLine {
    let (model, tokens) = (cx.model, cx.tokens);
    let quality = position_quality(model);
    let (icon, colour, text) = match quality {
        PositionQuality::None => (icon::GPS_SLASH, tokens.dim, texts::NO_POSITION),
        PositionQuality::Outdated => (icon::GPS_SLASH, tokens.bad, texts::LAST_POSITION),
        PositionQuality::Relocalising => (icon::GPS_SLASH, tokens.warn, texts::RELOCALISING),
        PositionQuality::Uncertain => (icon::WARNING, tokens.warn, texts::POSITION_UNCERTAIN),
        PositionQuality::Degenerate => (icon::WARNING, tokens.warn, texts::FEW_LANDMARKS),
        PositionQuality::Good => (icon::GPS_FIX, tokens.good, texts::LOCALISED),
    };
    let figure = position_figure(model, quality);
    let line = StatusLine::new(texts::POSITION, &format!("{text} {figure}"));
    let (shown_text, shown_figure) = match (detail, quality) {
        (StatusDetail::Least, PositionQuality::Uncertain) => (texts::POSITION_UNCERTAIN_SHORT, ""),
        (StatusDetail::Least | StatusDetail::Short, _) => (text, ""),
        _ => (text, figure.as_str()),
    };
    let line = line.icon(icon, colour).text(shown_text, tokens.text).text(shown_figure, tokens.dim);
    line.hint(texts::POSITION_HINT.to_owned())
}

/// The age of an outdated position, the accuracy of one that is known; else nothing.
fn position_figure(model: &Model, quality: PositionQuality) -> String {
    match (&model.robot.estimate, quality) {
        (None, _) | (_, PositionQuality::None | PositionQuality::Relocalising) => String::new(),
        (Some(estimate), PositionQuality::Outdated) => format::age(estimate.age(model.now())),
        (Some(estimate), _) => format::accuracy(position_sigma_m(&estimate.value)),
    }
}

/// The section of the map that is viewed.
pub(crate) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, map: &MapSummary) {
    let model = cx.model;
    let is_pending =
        model.is_pending(|command| matches!(command, Command::Localise { .. } | Command::LeaveMap));
    let enabled = model.can_command() && !is_pending;
    if model.localisation().map() == Some(map.id) {
        show_leave(ui, cx, map, enabled);
        show_relocalise(ui, cx, enabled);
    } else {
        show_use(ui, cx, map, enabled);
    }
    show_set_pose(ui, cx, enabled);
}

fn show_leave(ui: &mut Ui, cx: &mut PanelContext<'_>, map: &MapSummary, enabled: bool) {
    let tokens = cx.tokens;
    let name = texts::leave_map(&map.name);
    let button = Button::new(&name).text(texts::LEAVE_SHORT).icon(icon::X).enabled(enabled).wide(ui);
    if button.show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::LeaveMap);
    }
    widgets::remark(ui, tokens, &texts::state(&cx.model.localisation()));
}

fn show_use(ui: &mut Ui, cx: &mut PanelContext<'_>, map: &MapSummary, enabled: bool) {
    let tokens = cx.tokens;
    let name = texts::use_map(&map.name);
    let button = Button::new(&name).text(texts::USE_SHORT).icon(icon::GPS_FIX).enabled(enabled).wide(ui);
    if button.show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::UseMap(map.id));
        cx.commands.push(ClientCommand::ViewMap(None));
    }
    widgets::remark(ui, tokens, texts::USE_HINT);
}

/// Starts picking the robot's pose on the map that is viewed, or ends it.
fn show_set_pose(ui: &mut Ui, cx: &mut PanelContext<'_>, enabled: bool) {
    let is_picking = cx.model.is_picking_pose();
    let button = Button::new(texts::SET_POSE).icon(icon::NAVIGATION_ARROW).on(is_picking);
    if button.enabled(enabled).wide(ui).show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::PickPose(!is_picking));
    }
}

/// Offers that a robot which cannot relocalise where it stands moves.
fn show_relocalise(ui: &mut Ui, cx: &mut PanelContext<'_>, enabled: bool) {
    let (model, tokens) = (cx.model, cx.tokens);
    let is_lost = matches!(model.localisation(), Localisation::Relocalising { .. });
    let is_moving_for_it = matches!(model.motion(), Motion::Relocalising { .. });
    if !is_lost || is_moving_for_it {
        return;
    }
    let button = Button::new(texts::RELOCALISE).icon(icon::ARROWS_OUT);
    if button.enabled(enabled && !model.is_stopped()).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::Relocalise);
    }
    widgets::remark(ui, tokens, texts::RELOCALISE_HINT);
}
