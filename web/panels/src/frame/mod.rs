//! The frame of the page: top bar, rail, side card, messages, keyboard shortcuts and help. It shows what the panels of features offer.

mod help;
mod messages;
mod rail;
mod shortcuts;
mod side_card;
#[cfg(test)]
mod tests;
mod texts;
mod top_bar;

use crate::feature_panel::PanelContext;
use crate::features::FeaturePanels;
use crate::layout::Width;
use egui::Context;

/// Shows the frame with the panels of all features.
pub(crate) fn show(ctx: &Context, panels: &mut FeaturePanels, cx: &mut PanelContext<'_>) {
    shortcuts::handle(ctx, panels, cx);
    cx.frame.is_covered = false;
    for panel in panels.iter_mut() {
        panel.update(ctx, cx);
    }
    // Set again by whoever shows one.
    cx.frame.is_escape_consumed = false;
    top_bar::show(ctx, cx);
    rail::show(ctx, cx);
    for panel in panels.iter_mut() {
        panel.show_card(ctx, cx);
    }
    // A drawer would lie over a card that covers the page.
    if cx.layout.width == Width::Wide || (cx.frame.drawer_open && !cx.frame.is_covered) {
        side_card::show(ctx, panels, cx);
    }
    messages::show(ctx, panels, cx);
    help::show(ctx, cx);
    // Escape closes an open list, and does nothing else.
    cx.frame.is_escape_consumed |= egui::Popup::is_any_open(ctx);
}
