//! The list of keyboard shortcuts and gestures. The key `?` opens and closes it.

use super::texts;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::layout;
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets::{self, fact};
use egui::{Align2, Context, Order, Ui};

/// Greatest width of the list, points.
const MAX_WIDTH: f32 = 360.0;

/// Shows the list while it is open.
pub(super) fn show(ctx: &Context, cx: &mut PanelContext<'_>) {
    if !cx.frame.help_open {
        return;
    }
    // Not a modal window: the stop button must stay within reach.
    let window = ctx.content_rect();
    let area = layout::area(texts::HELP_HEAD, Order::Foreground)
        .pivot(Align2::CENTER_CENTER)
        .fixed_pos(window.center());
    let shown = area.show(ctx, |ui| {
        theme::card(cx.tokens).inner_margin(20).show(ui, |ui| show_list(ui, cx.tokens, window.width())).inner
    });
    if shown.inner {
        cx.frame.help_open = false;
    }
}

/// Shows the list. Returns whether it was closed.
fn show_list(ui: &mut Ui, tokens: &Tokens, window_width: f32) -> bool {
    ui.set_width(MAX_WIDTH.min(window_width - 72.0));
    let head = egui::RichText::new(texts::HELP_HEAD).font(font(theme::LARGE, Weight::SemiBold));
    ui.label(head.color(tokens.text));
    ui.add_space(4.0);
    for (action, keys) in texts::SHORTCUTS {
        fact(ui, tokens, action, keys);
    }
    widgets::remark(ui, tokens, texts::HELP_REMARK);
    Button::new(texts::CLOSE).wide(ui).show(ui, tokens).clicked()
}
