//! Notices: what happened and what comes next.

use crate::button::{Button, Kind};
use crate::sensors::{severity_colour, severity_icon};
use crate::theme::Tokens;
use crate::widgets;
use crate::{icon, words};
use client_model::{Command, Model, Note};
use egui::Ui;

pub(crate) fn show(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<Command>) {
    for note in model.notes.shown() {
        ui.push_id(note.id, |ui| entry(ui, model, tokens, note, out));
    }
}

fn entry(ui: &mut Ui, model: &Model, tokens: &Tokens, note: &Note, out: &mut Vec<Command>) {
    let colour = severity_colour(note.severity, tokens);
    let response = widgets::tinted_box(ui, tokens, colour, |ui| {
        ui.horizontal(|ui| {
            ui.label(egui::RichText::new(severity_icon(note.severity)).size(20.0).color(colour));
            let room = egui::vec2(ui.available_width() - 52.0, 0.0);
            let response = ui
                .allocate_ui(room, |ui| {
                    ui.vertical(|ui| {
                        ui.spacing_mut().item_spacing.y = 2.0;
                        let text = egui::RichText::new(&note.text).color(tokens.text);
                        let response = ui.add(egui::Label::new(text).wrap());
                        let age = model.now.since(note.since);
                        let mut remarks = Vec::new();
                        if note.times > 1 {
                            remarks.push(format!("{} times", note.times));
                        }
                        if age > 10.0 {
                            remarks.push(words::age(age));
                        }
                        if !remarks.is_empty() {
                            widgets::remark(ui, tokens, &remarks.join(" · "));
                        }
                        response
                    })
                    .inner
                })
                .inner;
            if Button::icon_only("Dismiss", icon::X).kind(Kind::Quiet).show(ui, tokens).clicked() {
                out.push(Command::Dismiss(note.id));
            }
            response
        })
        .inner
    });
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(egui::Role::Alert);
        node.set_value(note.text.clone());
    });
}
