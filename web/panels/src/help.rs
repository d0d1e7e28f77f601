//! Keyboard shortcuts, on `?`.

use crate::PanelState;
use crate::button::Button;
use crate::layout::area;
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets::{self, fact};
use egui::{Align2, Order, Ui};

const SHORTCUTS: [(&str, &str); 12] = [
    ("Stop motion", "Esc or Space"),
    ("Put away what is selected", "Esc"),
    ("Walk ahead, back", "W, S or ↑, ↓"),
    ("Step left, right", "A, D"),
    ("Turn left, right", "Q, E or ←, →"),
    ("Slowly", "Shift with any of these"),
    ("Orbit", "drag, or one finger"),
    ("Pan", "right drag, or two fingers"),
    ("Zoom", "wheel, or pinch"),
    ("Undo: the view, loops", "Ctrl Z"),
    ("Do it again", "Ctrl Shift Z"),
    ("These shortcuts", "?"),
];

pub(crate) fn show(ctx: &egui::Context, tokens: &Tokens, state: &mut PanelState) {
    let asked =
        !ctx.egui_wants_keyboard_input() && ctx.input(|input| input.key_pressed(egui::Key::Questionmark));
    if asked {
        state.help_open = !state.help_open;
    }
    if !state.help_open {
        return;
    }
    // No modal window: the stop button must stay within reach.
    let window = ctx.content_rect();
    let area = area("Keyboard and pointer", Order::Foreground)
        .pivot(Align2::CENTER_CENTER)
        .fixed_pos(window.center());
    let closed = area
        .show(ctx, |ui| {
            theme::card(tokens).inner_margin(20).show(ui, |ui| content(ui, tokens, window.width())).inner
        })
        .inner;
    if closed {
        state.help_open = false;
    }
}

/// The list; returns whether it was closed.
fn content(ui: &mut Ui, tokens: &Tokens, window_width: f32) -> bool {
    ui.set_width(360.0_f32.min(window_width - 72.0));
    let title = egui::RichText::new("Keyboard and pointer").font(font(theme::LARGE, Weight::SemiBold));
    ui.label(title.color(tokens.text));
    ui.add_space(4.0);
    for (what, keys) in SHORTCUTS {
        fact(ui, tokens, what, keys);
    }
    widgets::remark(ui, tokens, "The robot stops by itself half a second after the last order to move.");
    Button::new("Close").wide(ui).show(ui, tokens).clicked()
}
