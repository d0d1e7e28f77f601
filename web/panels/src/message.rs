//! One message at the top of the scene.

use crate::theme::{self, Tokens, Weight, font};
use crate::{texts, widgets};
use egui::{Align, Color32, Ui};

/// Width from which the button is beside the sentence and not below it, points.
const MIN_ROW_WIDTH: f32 = 320.0;

/// Shows one message on a card of its own: icon, sentence, and the button that `action` shows.
pub(crate) fn show_message(
    ui: &mut Ui,
    tokens: &Tokens,
    colour: Color32,
    icon: &str,
    sentence: &str,
    action: impl FnOnce(&mut Ui),
) {
    theme::card(tokens).inner_margin(egui::Margin::symmetric(14, 6)).show(ui, |ui| {
        ui.set_width(ui.available_width());
        let sign = egui::RichText::new(icon).size(20.0).color(colour);
        if ui.available_width() < MIN_ROW_WIDTH {
            ui.horizontal(|ui| {
                ui.label(sign);
                show_sentence(ui, tokens, sentence);
            });
            action(ui);
            return;
        }
        ui.horizontal(|ui| {
            ui.set_min_height(theme::TOUCH);
            ui.label(sign);
            ui.with_layout(egui::Layout::right_to_left(Align::Center), |ui| {
                action(ui);
                ui.with_layout(egui::Layout::left_to_right(Align::Center), |ui| {
                    show_sentence(ui, tokens, sentence);
                });
            });
        });
    });
}

fn show_sentence(ui: &mut Ui, tokens: &Tokens, sentence: &str) {
    let text = egui::RichText::new(sentence).font(font(theme::BODY, Weight::Medium)).color(tokens.text);
    let response = ui.add(egui::Label::new(text).wrap());
    widgets::status_node(&response, texts::MESSAGE, sentence);
}
