//! What is selected in the scene: Escape deselects it.

#[cfg(test)]
mod tests;

use crate::feature_panel::{FeaturePanel, PanelContext};
use client_model::ClientCommand;

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct SelectionPanel;

impl FeaturePanel for SelectionPanel {
    fn cancel(&mut self, cx: &mut PanelContext<'_>) -> bool {
        let is_selected = cx.model.selection().is_some() || cx.model.selected_nodes().len() > 1;
        if is_selected {
            cx.commands.push(ClientCommand::Select(None));
        }
        is_selected
    }
}
