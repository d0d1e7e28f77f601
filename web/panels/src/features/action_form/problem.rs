//! How it is shown that something is wrong with a task.

use crate::icon;
use crate::theme::{self, Tokens};
use egui::Ui;

/// A sentence that says what is wrong.
pub(crate) fn show_problem(ui: &mut Ui, tokens: &Tokens, sentence: &str) {
    let text =
        egui::RichText::new(format!("{}  {sentence}", icon::WARNING)).size(theme::SMALL).color(tokens.bad);
    let response = ui.add(egui::Label::new(text).wrap());
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_value(sentence));
}
