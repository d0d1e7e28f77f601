//! Making the topological map from the saved map on the screen: the button, its progress and its result.

use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::{icon, widgets};
use api::{Command, TopomapGeneration, TopomapStage, TopomapSummary};
use client_model::{CameraMove, ClientCommand};
use egui::Ui;
use site_model::Site;
use vocab::{MapId, Vec3};

/// What the section keeps between frames.
#[derive(Debug, Default)]
pub(super) struct GenerationSection {
    /// Whether the operator is asked whether the topological map shall be replaced.
    is_asking: bool,
}

impl GenerationSection {
    /// Lets the operator answer no. Returns whether there was a question.
    pub(super) fn cancel(&mut self) -> bool {
        std::mem::take(&mut self.is_asking)
    }

    /// Shows the section for a saved map.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, map: MapId) {
        let (model, tokens) = (cx.model, cx.tokens);
        let generation = model.site.topomap_generation();
        if let TopomapGeneration::Running { stage, .. } = generation {
            self.is_asking = false;
            return show_progress(ui, cx, *stage);
        }
        let is_asked_for = model.is_pending(|command| matches!(command, Command::GenerateTopomap { .. }));
        let nodes = site.nodes().count();
        if self.is_asking {
            // Escape means no.
            cx.frame.is_escape_consumed = true;
            widgets::tinted_box(ui, tokens, tokens.warn, |ui| {
                widgets::sentence(ui, tokens, &texts::replaces(nodes, site.edges().count()));
                ui.horizontal(|ui| {
                    if Button::new(texts::REPLACE).kind(Kind::Danger).show(ui, tokens).clicked() {
                        self.is_asking = false;
                        generate(cx, map);
                    }
                    if Button::new(texts::KEEP).show(ui, tokens).clicked() {
                        self.is_asking = false;
                    }
                });
            });
        } else {
            // Where there are no nodes, it is what to do first.
            let kind = if nodes == 0 { Kind::Primary } else { Kind::Plain };
            let button = Button::new(texts::GENERATE)
                .icon(icon::GRAPH)
                .kind(kind)
                .enabled(!is_asked_for && !model.site.is_draft());
            if button.wide(ui).show(ui, tokens).clicked() {
                self.is_asking = nodes > 0;
                if nodes == 0 {
                    generate(cx, map);
                }
            }
        }
        match generation {
            TopomapGeneration::Done { summary, .. } => show_result(ui, cx, summary),
            TopomapGeneration::Failed { reason, .. } => {
                widgets::tinted_box(ui, tokens, tokens.bad, |ui| {
                    status(ui, cx, texts::RESULT, reason);
                    dismiss_button(ui, cx);
                });
            }
            TopomapGeneration::None | TopomapGeneration::Running { .. } => {}
        }
    }
}

/// Makes it, and shows the map in which it will appear.
fn generate(cx: &mut PanelContext<'_>, map: MapId) {
    cx.commands.push(ClientCommand::GenerateTopomap(map));
    if cx.model.viewed_map().is_none() && !cx.model.has_pose_in_map() {
        cx.commands.push(ClientCommand::ViewMap(Some(map)));
    }
}

fn show_progress(ui: &mut Ui, cx: &mut PanelContext<'_>, stage: TopomapStage) {
    let (text, share) = match stage {
        TopomapStage::Reading => (texts::READING, 0.1),
        TopomapStage::Generating => (texts::GENERATING, 0.5),
        TopomapStage::Storing => (texts::STORING, 0.9),
    };
    widgets::tinted_box(ui, cx.tokens, cx.tokens.accent, |ui| {
        status(ui, cx, texts::PROGRESS, text);
        widgets::progress_bar(ui, cx.tokens, share);
    });
}

fn show_result(ui: &mut Ui, cx: &mut PanelContext<'_>, summary: &TopomapSummary) {
    let tokens = cx.tokens;
    let has_problems = summary.pieces > 1 || !summary.blocked.is_empty();
    let colour = if has_problems { tokens.warn } else { tokens.good };
    widgets::tinted_box(ui, tokens, colour, |ui| {
        status(ui, cx, texts::RESULT, &texts::made(summary));
        if summary.pieces > 1 {
            widgets::sentence(ui, tokens, &texts::pieces(summary.pieces));
        }
        if summary.kept_nodes > 0 {
            widgets::sentence(ui, tokens, &texts::kept(summary.kept_nodes));
        }
        if !summary.blocked.is_empty() {
            widgets::sentence(ui, tokens, texts::BLOCKED);
            for (number, [from, to]) in (1..).zip(&summary.blocked) {
                let name = texts::blocked_segment(number, distance_m(from, to));
                if Button::new(&name).icon(icon::EYE).kind(Kind::Quiet).wide(ui).show(ui, tokens).clicked() {
                    cx.commands.push(ClientCommand::MoveCamera(CameraMove::Point(middle(from, to))));
                }
            }
        }
        dismiss_button(ui, cx);
    });
}

/// A sentence that is a status in the accessible tree.
fn status(ui: &mut Ui, cx: &PanelContext<'_>, name: &str, sentence: &str) {
    let text = egui::RichText::new(sentence).size(crate::theme::BODY).color(cx.tokens.text);
    let response = ui.add(egui::Label::new(text).wrap());
    widgets::status_node(&response, name, sentence);
}

fn dismiss_button(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let button = Button::new(texts::DISMISS_RESULT).text(texts::DISMISS_SHORT).kind(Kind::Quiet);
    if button.show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::DismissTopomapResult);
    }
}

fn distance_m(a: &Vec3, b: &Vec3) -> f64 {
    (a.x - b.x).hypot(a.y - b.y).hypot(a.z - b.z)
}

fn middle(a: &Vec3, b: &Vec3) -> Vec3 {
    Vec3::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y), 0.5 * (a.z + b.z))
}
