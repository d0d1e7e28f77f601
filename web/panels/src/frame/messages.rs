//! Messages at the top of the scene: what every operator must see at once. Each feature adds its own.

use super::texts;
use crate::feature_panel::PanelContext;
use crate::features::FeaturePanels;
use crate::layout;
use egui::{Align2, Context, Order};

/// Greatest width of a message, points.
const MAX_WIDTH: f32 = 460.0;

/// Shows the messages of all features, one below the other.
pub(super) fn show(ctx: &Context, panels: &mut FeaturePanels, cx: &mut PanelContext<'_>) {
    let free = cx.layout.free_beside(cx.frame.drawer_open, cx.frame.is_left_card_shown);
    let area = layout::area(texts::MESSAGES, Order::Foreground);
    area.pivot(Align2::CENTER_TOP).fixed_pos(free.center_top()).show(ctx, |ui| {
        ui.set_width(MAX_WIDTH.min(free.width()));
        ui.spacing_mut().item_spacing.y = 8.0;
        for panel in panels.iter_mut() {
            panel.show_messages(ui, cx);
        }
    });
}
