//! Quality of the map under construction: the floor it covers, its accuracy, and where to survey next.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::theme::{self, Tokens};
use crate::widgets::{self, fact};
use crate::{format, icon};
use api::SurveyTarget;
use client_model::ClientCommand;
use egui::{Align, Layout, Ui, vec2};

/// How many survey targets are listed.
#[derive(Clone, Copy, Debug)]
struct TargetListConfig {
    /// Survey targets in the list. The others are marked on the map only. Chosen: they fit without scrolling.
    max_targets: usize,
}

const LISTS: TargetListConfig = TargetListConfig { max_targets: 4 };
/// Width of the button that sends the robot to a target, points.
const BUTTON_WIDTH: f32 = 76.0;

/// What the map covers and how accurate it is. The rows are always there, so that nothing below them moves.
pub(crate) fn show_figures(ui: &mut Ui, cx: &PanelContext<'_>) {
    let tokens = cx.tokens;
    let quality = cx.model.quality();
    fact(ui, tokens, texts::FLOOR_COVERED, &format::area(quality.covered_m2));
    let worst_sigma_m = quality.deviations_m.iter().copied().fold(0.0, f32::max);
    let is_known = worst_sigma_m.is_finite() && !quality.deviations_m.is_empty();
    let value = if is_known {
        format::accuracy(f64::from(worst_sigma_m).max(format::MIN_SHOWN_DEVIATION_M))
    } else {
        texts::NOT_YET_KNOWN.to_owned()
    };
    fact(ui, tokens, texts::ACCURACY, &value).on_hover_text(texts::ACCURACY_HINT);
}

/// Where to survey next, if there is such a place.
pub(crate) fn show_targets(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    let targets: &[SurveyTarget] = &model.quality().targets;
    if targets.is_empty() {
        return;
    }
    ui.add_space(4.0);
    widgets::rule(ui, tokens);
    widgets::head(ui, tokens, texts::SURVEY_TARGETS);
    let can_walk = model.can_command() && !model.is_stopped();
    for (number, target) in (1..).zip(targets.iter().take(LISTS.max_targets)) {
        if show_target(ui, tokens, number, target, can_walk) {
            cx.commands.push(ClientCommand::WalkTo(target.at));
        }
    }
    if let Some(more) = targets.len().checked_sub(LISTS.max_targets).filter(|more| *more > 0) {
        widgets::remark(ui, tokens, &texts::more_targets(more));
    }
}

/// A row of the list. Returns whether the robot shall walk there.
fn show_target(ui: &mut Ui, tokens: &Tokens, number: usize, target: &SurveyTarget, can_walk: bool) -> bool {
    let reason = texts::reason(target.why);
    let row = ui.horizontal(|ui| {
        let size = vec2(ui.available_width() - BUTTON_WIDTH - 8.0, theme::TOUCH);
        ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_size(size);
            let text = egui::RichText::new(&reason).size(theme::BODY).color(tokens.text);
            let response = ui.add(egui::Label::new(text).wrap());
            widgets::status_node(&response, &texts::survey_target(number), &reason);
        });
        let go = ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let name = texts::walk_to(number);
            let button = Button::new(&name).text(texts::GO).icon(icon::NAVIGATION_ARROW);
            button.size(BUTTON_WIDTH, theme::TOUCH).enabled(can_walk).show(ui, tokens).clicked()
        });
        go.inner
    });
    row.inner
}
