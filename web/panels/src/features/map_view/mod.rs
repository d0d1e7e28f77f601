//! Viewing a saved map: a message that says which one, how much of it is loaded, and leads back.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::Button;
use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::icon;
use crate::map_name::map_name;
use crate::message::show_message;
use client_model::{ClientCommand, Loading};
use egui::Ui;

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct MapViewPanel;

impl FeaturePanel for MapViewPanel {
    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let Some((map, view)) = cx.model.saved_map() else { return };
        let tokens = cx.tokens;
        let name = map_name(cx.model, map);
        let (colour, text) = match &view.loading {
            Loading::Waiting => (tokens.accent, texts::opening(name)),
            Loading::Failed(sentence) => (tokens.bad, sentence.clone()),
            Loading::Done if view.tiles.loading() > 0 => {
                let (loaded, all) = (view.tiles.ready_points(), view.tiles.points());
                (tokens.accent, texts::loading(name, loaded, all))
            }
            Loading::Done => (tokens.accent, texts::loaded(name, view.tiles.points())),
        };
        show_message(ui, tokens, colour, icon::MAP_TRIFOLD, &text, |ui| {
            if Button::new(texts::BACK).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::ViewMap(None));
            }
        });
    }
}
