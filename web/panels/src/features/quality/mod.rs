//! How good the map being made is: what of the floor it covers, how well it is known, and where to walk next.

#[cfg(test)]
mod tests;

use crate::button::Button;
use crate::theme::{self, Tokens};
use crate::widgets::{self, fact};
use crate::{icon, words};
use api::{SurveyReason, SurveyTarget};
use client_model::{ClientCommand, Model};
use egui::{Align, Layout, Ui, vec2};

/// Places listed: those after them are on the map all the same.
const LISTED: usize = 4;

pub(crate) fn show(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    let quality = model.quality();
    fact(ui, tokens, "Floor covered", &words::area(quality.covered_m2));
    let worst = quality.deviations_m.iter().copied().fold(0.0, f32::max);
    if worst.is_finite() && !quality.deviations_m.is_empty() {
        let response = fact(ui, tokens, "Known to", &words::accuracy(f64::from(worst).max(1e-3)));
        response.on_hover_text("One standard deviation of the keyframe that is known least; the graph's nodes turn amber with it");
    }
    if quality.targets.is_empty() {
        return;
    }
    ui.add_space(4.0);
    widgets::rule(ui, tokens);
    widgets::head(ui, tokens, "Worth a walk");
    let enabled = model.is_connected() && !model.is_controlled_by_other() && !model.is_stopped();
    for (number, place) in quality.targets.iter().take(LISTED).enumerate() {
        row(ui, tokens, (number + 1, place), enabled, out);
    }
    if let Some(more) = quality.targets.len().checked_sub(LISTED).filter(|more| *more > 0) {
        widgets::remark(ui, tokens, &format!("and {more} more, marked on the map"));
    }
}

fn row(
    ui: &mut Ui,
    tokens: &Tokens,
    (number, place): (usize, &SurveyTarget),
    enabled: bool,
    out: &mut Vec<ClientCommand>,
) {
    let why = match place.why {
        SurveyReason::FromAfar(area) => format!("{} seen from afar only", words::area(area)),
        SurveyReason::Uncertain(deviation) => {
            format!("Known to {} only: come back to where you began", words::accuracy(deviation))
        }
    };
    let width = 76.0;
    ui.horizontal(|ui| {
        let text = vec2(ui.available_width() - width - 8.0, theme::TOUCH);
        ui.allocate_ui_with_layout(text, Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_size(text);
            let label = egui::RichText::new(&why).size(theme::BODY).color(tokens.text);
            let response = ui.add(egui::Label::new(label).wrap());
            widgets::status_node(&response, &format!("Place {number} worth a walk"), &why);
        });
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let name = format!("Walk to place {number}");
            let go = Button::new(&name).text("Go").icon(icon::NAVIGATION_ARROW).size(width, theme::TOUCH);
            if go.enabled(enabled).show(ui, tokens).clicked() {
                out.push(ClientCommand::WalkTo(place.at));
            }
        });
    });
}
