//! Notices: what happened and what comes next.

#[cfg(test)]
mod tests;

use crate::button::{Button, Kind};
use crate::sensors::{severity_colour, severity_icon};
use crate::theme::Tokens;
use crate::widgets;
use crate::{icon, words};
use client_model::{ClientCommand, Model, ShownNotice};
use egui::Ui;

pub(crate) fn show(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    for note in model.notices().visible() {
        ui.push_id(note.id, |ui| entry(ui, model, tokens, note, out));
    }
}

fn entry(ui: &mut Ui, model: &Model, tokens: &Tokens, note: &ShownNotice, out: &mut Vec<ClientCommand>) {
    let colour = severity_colour(note.severity, tokens);
    let response = widgets::tinted_box(ui, tokens, colour, |ui| {
        ui.horizontal(|ui| {
            ui.label(egui::RichText::new(severity_icon(note.severity)).size(20.0).color(colour));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let dismiss = Button::icon_only("Dismiss", icon::X).kind(Kind::Quiet);
                if dismiss.show(ui, tokens).clicked() {
                    out.push(ClientCommand::DismissNotice(note.id));
                }
                ui.with_layout(egui::Layout::top_down(egui::Align::Min), |ui| text(ui, model, tokens, note))
                    .inner
            })
            .inner
        })
        .inner
    });
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(egui::Role::Alert);
        node.set_value(note.text.clone());
    });
}

/// The sentence, and under it how often and how long ago it was said.
fn text(ui: &mut Ui, model: &Model, tokens: &Tokens, note: &ShownNotice) -> egui::Response {
    ui.spacing_mut().item_spacing.y = 2.0;
    let response = ui.add(egui::Label::new(egui::RichText::new(&note.text).color(tokens.text)).wrap());
    let age = model.now().since(note.since);
    let times = (note.times > 1).then(|| format!("{} times", note.times));
    let old = (age > 10.0).then(|| words::age(age));
    let remarks: Vec<String> = times.into_iter().chain(old).collect();
    if !remarks.is_empty() {
        widgets::remark(ui, tokens, &remarks.join(" · "));
    }
    response
}
