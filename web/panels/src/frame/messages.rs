//! Messages at the top of the scene: what every operator must see at once. Each feature adds its own.

use super::texts;
use crate::feature_panel::PanelContext;
use crate::features::FeaturePanels;
use crate::layout::{self, Layout, Width};
use crate::theme;
use egui::{Align2, Context, Order, Rect, pos2};

/// Greatest width of a message, points.
const MAX_WIDTH: f32 = 460.0;

/// Shows the messages of all features, one below the other.
pub(super) fn show(ctx: &Context, panels: &mut FeaturePanels, cx: &mut PanelContext<'_>) {
    let free = free_area(cx.layout, cx.frame.drawer_open);
    let area = layout::area(texts::MESSAGES, Order::Foreground);
    area.pivot(Align2::CENTER_TOP).fixed_pos(free.center_top()).show(ctx, |ui| {
        ui.set_width(MAX_WIDTH.min(free.width()));
        ui.spacing_mut().item_spacing.y = 8.0;
        for panel in panels.iter_mut() {
            panel.show_messages(ui, cx);
        }
    });
}

/// The part of the scene beside the tools and the drawer.
fn free_area(layout: &Layout, drawer_open: bool) -> Rect {
    let tools_width = if layout.width == Width::Narrow { 68.0 } else { 76.0 };
    let is_beside_drawer = layout.width == Width::Medium && drawer_open;
    let right = if is_beside_drawer { layout.card.left() - theme::GAP } else { layout.free.right() };
    Rect::from_min_max(
        pos2(layout.free.left() + tools_width, layout.free.top()),
        pos2(right, layout.free.bottom()),
    )
}
