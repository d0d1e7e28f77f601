//! Notices: what happened and what the operator can do about it.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::features::sensors::{severity_colour, severity_icon};
use crate::theme::{self, Weight, font};
use crate::{format, icon, widgets};
use client_model::{ClientCommand, ShownNotice};
use egui::text::{LayoutJob, TextFormat};
use egui::{Align, Layout, Response, Ui};

/// Parameters of the list of notices.
struct NoticeListConfig {
    /// Age from which a notice shows its age, seconds. Chosen: a newer one has just come, as everybody sees.
    min_shown_age_s: f64,
}

const CONFIG: NoticeListConfig = NoticeListConfig { min_shown_age_s: 10.0 };

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct NoticesPanel;

impl FeaturePanel for NoticesPanel {
    /// All notices that are visible, one below the other.
    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        for notice in cx.model.notices().visible() {
            ui.push_id(notice.id, |ui| show_notice(ui, cx, notice));
        }
    }
}

fn show_notice(ui: &mut Ui, cx: &mut PanelContext<'_>, notice: &ShownNotice) {
    let tokens = cx.tokens;
    let colour = severity_colour(notice.severity, tokens);
    let response = widgets::tinted_box(ui, tokens, colour, |ui| {
        let row = ui.horizontal(|ui| {
            ui.label(egui::RichText::new(severity_icon(notice.severity)).size(20.0).color(colour));
            let right = ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let dismiss = Button::icon_only(texts::DISMISS, icon::X).kind(Kind::Quiet);
                if dismiss.show(ui, tokens).clicked() {
                    cx.commands.push(ClientCommand::DismissNotice(notice.id));
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| show_text(ui, cx, notice)).inner
            });
            right.inner
        });
        row.inner
    });
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(egui::Role::Alert);
        node.set_value(notice.text.clone());
    });
}

/// The sentence, and below it how often it was raised and how old it is. Returns the response of the sentence.
fn show_text(ui: &mut Ui, cx: &PanelContext<'_>, notice: &ShownNotice) -> Response {
    let tokens = cx.tokens;
    let age_s = cx.model.now().since(notice.since);
    let repetitions = (notice.times > 1).then(|| texts::repetitions(notice.times));
    let age = (age_s > CONFIG.min_shown_age_s).then(|| format::age(age_s));
    let remarks: Vec<String> = repetitions.into_iter().chain(age).collect();
    // One label, because the row centres one thing.
    let mut job = LayoutJob::default();
    job.append(&notice.text, 0.0, TextFormat::simple(font(theme::BODY, Weight::Regular), tokens.text));
    if !remarks.is_empty() {
        let small = TextFormat::simple(font(theme::SMALL, Weight::Regular), tokens.dim);
        job.append(&format!("\n{}", remarks.join(" · ")), 0.0, small);
    }
    ui.add(egui::Label::new(job).wrap())
}
