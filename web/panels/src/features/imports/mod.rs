//! Imports: making maps of point clouds from other programs.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::theme::{self, Tokens, Weight, font};
use crate::{format, icon, widgets};
use api::{Command, Import, MapSummary, StoredUpload};
use client_model::{ClientCommand, Model};
use egui::{Align, Layout, Response, Ui, vec2};

/// The section below the saved maps: a running import, or else the buttons that start one; then files that wait for another attempt. They come last, so that the
/// buttons do not move when a file is refused.
pub(crate) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let model = cx.model;
    if let Some(upload) = model.imports.upload() {
        show_running(ui, cx, &texts::sending(&upload.file), upload.share);
    } else if !show_on_robot(ui, cx) {
        show_start(ui, cx);
    }
    for stored in model.imports.stored() {
        ui.push_id(stored.upload.0, |ui| show_stored(ui, cx, stored));
    }
}

/// The map that the robot makes now. Returns whether it makes any.
pub(crate) fn show_on_robot(ui: &mut Ui, cx: &mut PanelContext<'_>) -> bool {
    let Import::Running { name, stage, share, .. } = cx.model.imports.import() else { return false };
    show_running(ui, cx, &texts::stage(*stage, name), *share);
    true
}

/// A file that waits on the robot's computer: what it is, why no map was made of it, and what can be done.
fn show_stored(ui: &mut Ui, cx: &mut PanelContext<'_>, stored: &StoredUpload) {
    let (model, tokens) = (cx.model, cx.tokens);
    let is_pending = model.is_pending(|command| match command {
        Command::ImportMap { upload, .. } | Command::DeleteUpload(upload) => *upload == stored.upload,
        _ => false,
    });
    // A file that has just come is imported at once.
    if is_pending && stored.problem.is_none() {
        return;
    }
    let colour = if stored.problem.is_some() { tokens.warn } else { tokens.accent };
    let name = texts::stored(stored.name.as_deref());
    let until = stored.kept_until.map(|until| format::date(until, cx.utc_offset_s));
    let details =
        texts::stored_details(&format::bytes(stored.bytes), stored.problem.as_deref(), until.as_deref());
    let response = widgets::tinted_box(ui, tokens, colour, |ui| {
        let title = egui::RichText::new(&name).font(font(theme::BODY, Weight::Medium)).color(tokens.text);
        let response = ui.add(egui::Label::new(title).truncate());
        widgets::remark(ui, tokens, &details);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            let width = ((ui.available_width() - 8.0) / 2.0).floor();
            let is_busy = matches!(model.imports.import(), Import::Running { .. });
            let enabled = model.is_connected() && !is_pending;
            let label = texts::retry(stored.name.as_deref());
            let retry = Button::new(&label).text(texts::RETRY_SHORT).enabled(enabled && !is_busy);
            if retry.size(width, theme::TOUCH).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::RetryImport(stored.upload));
            }
            let label = texts::delete(stored.name.as_deref());
            let delete = Button::new(&label).text(texts::DELETE_SHORT).icon(icon::TRASH).enabled(enabled);
            if delete.size(width, theme::TOUCH).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::DeleteUpload(stored.upload));
            }
        });
        response
    });
    widgets::status_node(&response, &name, &details);
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
