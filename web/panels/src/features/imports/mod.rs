//! Imports: making maps of point clouds from other programs.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::theme::{self, Tokens};
use crate::{format, icon, widgets};
use api::{Import, MapSummary};
use client_model::{ClientCommand, Model};
use egui::{Align, Layout, Response, Ui, vec2};

/// The section below the saved maps: a running import, or else the buttons that start one.
pub(crate) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let model = cx.model;
    if let Some(upload) = model.imports.upload() {
        show_running(ui, cx, &texts::sending(&upload.file), upload.share);
    } else if let Import::Running { name, stage, share, .. } = model.imports.import() {
        show_running(ui, cx, &texts::stage(*stage, name), *share);
    } else {
        show_start(ui, cx);
    }
}

fn show_start(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    let enabled = model.is_connected();
    if Button::new(texts::IMPORT).icon(icon::PLUS).enabled(enabled).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::ImportMap { frame: None });
    }
    widgets::remark(ui, tokens, texts::IMPORT_HINT);
    let Some(reference) = reference_map(model) else { return };
    if Button::new(texts::IMPORT_AND_ALIGN).enabled(enabled).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::ImportMap { frame: Some(reference.id) });
    }
    widgets::remark(ui, tokens, &texts::import_and_align_hint(&reference.name));
}

/// The map to which an import would be aligned: the viewed map, or else the map in use.
fn reference_map(model: &Model) -> Option<&MapSummary> {
    let map = model.viewed_map().or(model.localisation().map())?;
    model.maps().list()?.iter().find(|summary| summary.id == map)
}

/// A running import: activity, progress, and a button that cancels it.
fn show_running(ui: &mut Ui, cx: &mut PanelContext<'_>, activity: &str, share: f32) {
    let tokens = cx.tokens;
    let share = share.clamp(0.0, 1.0);
    let percent = format::share(share);
    let response = show_activity(ui, tokens, activity, &percent);
    widgets::status_node(&response, texts::STATE, &texts::progress(activity, &percent));
    widgets::progress_bar(ui, tokens, share);
    let cancel = Button::new(texts::CANCEL).text(texts::CANCEL_SHORT).icon(icon::X);
    if cancel.wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::CancelImport);
    }
}

fn show_activity(ui: &mut Ui, tokens: &Tokens, activity: &str, percent: &str) -> Response {
    let shown = ui.horizontal(|ui| {
        let text = egui::RichText::new(activity).size(theme::BODY).color(tokens.text);
        ui.allocate_ui(vec2(ui.available_width() - 56.0, theme::TOUCH), |ui| {
            ui.add(egui::Label::new(text).truncate());
        });
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| widgets::remark(ui, tokens, percent));
    });
    shown.response
}
