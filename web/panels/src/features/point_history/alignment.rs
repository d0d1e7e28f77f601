//! How the two photos that are compared are aligned: said in words, switched on and off, and applied to what is drawn.

use super::strip::ask;
use super::texts;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::features::runs::{ChangeFrames, Pane};
use crate::{icon, theme, widgets};
use client_model::{PairAlignment, PointHistoryCommand};
use egui::{Key, Ui};
use site_model::{AlignedPictures, PictureComparisonOutcome};

/// The switches, which stay as they are while results are looked through.
#[derive(Debug)]
pub(super) struct AlignedView {
    /// Whether the earlier photo is drawn as the later one sees it.
    is_aligned: bool,
    /// Whether frames are drawn round changes.
    are_changes_shown: bool,
}

impl Default for AlignedView {
    fn default() -> Self {
        Self { is_aligned: true, are_changes_shown: true }
    }
}

impl AlignedView {
    /// What is known of the alignment, with the switches. Asks the robot if nothing is.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        let alignment = model.point_history.alignment();
        if alignment == PairAlignment::NotAsked {
            ask(cx, PointHistoryCommand::Align);
        }
        if let PairAlignment::Known(PictureComparisonOutcome::Aligned(aligned)) = alignment {
            ui.input(|input| {
                self.is_aligned ^= input.key_pressed(Key::L);
                self.are_changes_shown ^= input.key_pressed(Key::C);
            });
            let align = Button::new(texts::ALIGN).on(self.is_aligned).hint(texts::ALIGN_HINT).slim();
            if align.show(ui, tokens).clicked() {
                self.is_aligned = !self.is_aligned;
            }
            if !aligned.changes.is_empty() {
                let changes = Button::new(texts::SHOW_CHANGES).on(self.are_changes_shown);
                if changes.hint(texts::CHANGES_HINT).slim().show(ui, tokens).clicked() {
                    self.are_changes_shown = !self.are_changes_shown;
                }
            }
        }
        let Some(sentence) = texts::alignment(alignment) else { return };
        let colour = match alignment {
            PairAlignment::Failed(_) | PairAlignment::Known(PictureComparisonOutcome::NotAligned(_)) => {
                tokens.warn
            }
            _ => tokens.dim,
        };
        let label = egui::RichText::new(&sentence).size(theme::BODY).color(colour);
        widgets::status_node(&ui.add(egui::Label::new(label).wrap()), texts::ALIGNMENT, &sentence);
        if matches!(alignment, PairAlignment::Failed(_)) {
            let again = Button::new(texts::ALIGN_AGAIN).icon(icon::ARROW_COUNTER_CLOCKWISE).slim();
            if again.show(ui, tokens).clicked() {
                ask(cx, PointHistoryCommand::Align);
            }
        }
    }

    /// Draws the earlier photo as the later one sees it, and frames round changes, as the switches say.
    pub(super) fn apply(&self, cx: &PanelContext<'_>, [before, after]: &mut [Option<Pane>; 2]) {
        let Some(aligned) = aligned(cx) else { return };
        let (Some(before), Some(after)) = (before, after) else { return };
        if self.are_changes_shown {
            after.changes = Some(ChangeFrames::after(aligned));
            before.changes = after.changes.clone().filter(|_| self.is_aligned);
            if !self.is_aligned {
                before.changes = Some(ChangeFrames::before(aligned));
            }
        }
        if self.is_aligned {
            before.aligned = Some(aligned.clone());
        }
    }
}

fn aligned<'a>(cx: &PanelContext<'a>) -> Option<&'a AlignedPictures> {
    match cx.model.point_history.alignment() {
        PairAlignment::Known(PictureComparisonOutcome::Aligned(aligned)) => Some(aligned),
        _ => None,
    }
}
