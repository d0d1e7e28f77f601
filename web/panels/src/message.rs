//! One message at the top of the scene.

use crate::theme::{self, Tokens, Weight, font};
use crate::widgets;
use egui::{Align, Color32, Ui};

/// Accessible name of a message. Its value is the sentence.
const MESSAGE: &str = "Message";

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
        ui.horizontal(|ui| {
            ui.set_min_height(theme::TOUCH);
            ui.label(egui::RichText::new(icon).size(20.0).color(colour));
            ui.with_layout(egui::Layout::right_to_left(Align::Center), |ui| {
                action(ui);
                ui.with_layout(egui::Layout::left_to_right(Align::Center), |ui| {
                    let text_font = font(theme::BODY, Weight::Medium);
                    let text = egui::RichText::new(sentence).font(text_font).color(tokens.text);
                    let response = ui.add(egui::Label::new(text).wrap());
                    widgets::status_node(&response, MESSAGE, sentence);
                });
            });
        });
    });
}
