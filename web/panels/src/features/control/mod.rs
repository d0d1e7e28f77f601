//! The control lease: who controls the robot, taking control and releasing it.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::message::show_message;
use crate::status_line::{StatusDetail, StatusLine};
use crate::theme::{self, Weight};
use crate::{Width, icon, widgets};
use api::Role;
use client_model::ClientCommand;
use egui::Ui;

/// What is said at the top of the scene while somebody asks for control. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct ControlPanel;

impl FeaturePanel for ControlPanel {
    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        if let Some((name, left_s)) = model.asked_for_control() {
            let sentence = texts::asked_for_control(name, left_s);
            show_message(ui, tokens, tokens.warn, icon::USER, &sentence, |ui| {
                if Button::new(texts::KEEP).kind(Kind::Primary).show(ui, tokens).clicked() {
                    cx.commands.push(ClientCommand::RefuseTakeOver);
                }
            });
            // The seconds count down.
            ui.ctx().request_repaint_after_secs(0.25);
        } else if model.asks_for_control() {
            let sentence = texts::asks_for_control(model.control().holder_name());
            show_message(ui, tokens, tokens.accent, icon::USER, &sentence, |_| {});
        }
    }
}

/// Shows the button of the top bar that takes or releases control.
pub(crate) fn show_button(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    if cx.model.has_control() {
        let release = Button::new(texts::RELEASE).text(texts::RELEASE_SHORT).kind(Kind::Quiet);
        let release = release.hint(texts::RELEASE_HINT).enabled(cx.model.is_connected());
        if release.size(0.0, 40.0).show(ui, cx.tokens).clicked() {
            cx.commands.push(ClientCommand::ReleaseControl);
        }
        return;
    }
    let may = cx.model.may(Role::Operator);
    let hint = match cx.model.is_controlled_by_other() {
        _ if !may => texts::NEEDS_OPERATOR,
        true => texts::TAKE_OVER_HINT,
        false => texts::TAKE_HINT,
    };
    let take = Button::new(texts::TAKE).hint(hint).enabled(cx.model.is_connected() && may);
    if take.size(0.0, 40.0).show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::TakeControl);
    }
}

/// Says that another operator controls the robot. On narrow windows the button to take control stands below, as the top bar lacks it.
pub(crate) fn show_controlled_by_other(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let sentence = texts::controlled_by(cx.model.control().holder_name());
    widgets::remark(ui, cx.tokens, &sentence);
    if cx.layout.width != Width::Narrow {
        return;
    }
    let is_enabled = cx.model.is_connected() && cx.model.may(Role::Operator);
    let take = Button::new(texts::TAKE).wide(ui).enabled(is_enabled);
    if take.show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::TakeControl);
    }
}

/// Who controls the robot, for the top bar; `None` where there is no room.
pub(crate) fn status(cx: &PanelContext<'_>, detail: StatusDetail) -> Option<StatusLine> {
    let (model, tokens) = (cx.model, cx.tokens);
    let holder = match model.control().owner() {
        None => texts::NOBODY,
        Some(_) if model.has_control() => texts::YOU,
        Some(_) => model.control().holder_name(),
    };
    let colour = if model.has_control() { tokens.accent } else { tokens.text };
    let line = StatusLine::new(texts::CONTROL, holder);
    let line = match detail {
        StatusDetail::Least => return None,
        StatusDetail::Full => line.text(texts::CONTROL, tokens.dim),
        StatusDetail::Normal | StatusDetail::Short => line.icon(icon::USER, tokens.dim),
    };
    Some(line.part(holder, theme::BODY, Weight::Medium, colour))
}
