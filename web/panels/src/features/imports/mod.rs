//! Making maps of other people's point clouds.

#[cfg(test)]
mod tests;

use crate::button::Button;
use crate::theme::{self, Tokens};
use crate::{icon, widgets, words};
use api::{Import, MapSummary};
use client_model::{ClientCommand, Model};
use egui::{CornerRadius, Sense, Ui, vec2};

/// Height of a bar, points.
const BAR: f32 = 6.0;

pub(crate) fn show(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    if let Some(upload) = model.imports.upload() {
        let doing = format!("Sending {}", upload.file);
        under_way(ui, tokens, &doing, upload.share, out);
    } else if let Import::Running { name, stage, share, .. } = model.imports.import() {
        under_way(ui, tokens, &format!("{} {name}", words::import_stage(*stage)), *share, out);
    } else {
        let button = Button::new("Import a map").icon(icon::PLUS).enabled(model.is_connected()).wide(ui);
        if button.show(ui, tokens).clicked() {
            out.push(ClientCommand::ImportMap { frame: None });
        }
        widgets::remark(ui, tokens, "Of a survey or another program's: PCD, PLY, LAS, LAZ, E57 or PTX.");
        if let Some(map) = of_the_site(model) {
            let button = Button::new("Import and align").enabled(model.is_connected()).wide(ui);
            if button.show(ui, tokens).clicked() {
                out.push(ClientCommand::ImportMap { frame: Some(map.id) });
            }
            let what =
                format!("Of the same site as {}: laid into its frame, where both look alike.", map.name);
            widgets::remark(ui, tokens, &what);
        }
    }
}

/// The saved map that is looked at, or else the one in use.
fn of_the_site(model: &Model) -> Option<&MapSummary> {
    let map = model.viewed_map().or(model.localisation().map())?;
    model.maps().list()?.iter().find(|one| one.id == map)
}

/// A name, a bar, and a way out.
fn under_way(ui: &mut Ui, tokens: &Tokens, doing: &str, share: f32, out: &mut Vec<ClientCommand>) {
    let share = share.clamp(0.0, 1.0);
    let percent = words::share(share);
    let response = ui
        .horizontal(|ui| {
            let text = egui::RichText::new(doing).size(theme::BODY).color(tokens.text);
            ui.allocate_ui(vec2(ui.available_width() - 56.0, theme::TOUCH), |ui| {
                ui.add(egui::Label::new(text).truncate());
            });
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                widgets::remark(ui, tokens, &percent);
            });
        })
        .response;
    widgets::status_node(&response, "Import", &format!("{doing}, {percent}"));
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), BAR), Sense::hover());
    let round = CornerRadius::same(3);
    ui.painter().rect_filled(rect, round, tokens.line);
    let mut done = rect;
    done.set_width(rect.width() * share);
    ui.painter().rect_filled(done, round, tokens.accent);
    if Button::new("Cancel import").text("Cancel").icon(icon::X).wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::CancelImport);
    }
}
