//! Keyboard shortcuts, on `?`.

use crate::PanelState;
use crate::button::Button;
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets::{self, fact};

const SHORTCUTS: [(&str, &str); 11] = [
    ("Stop motion", "Esc or Space"),
    ("Walk ahead, back", "W, S or ↑, ↓"),
    ("Step left, right", "A, D"),
    ("Turn left, right", "Q, E or ←, →"),
    ("Slowly", "Shift with any of these"),
    ("Orbit", "drag, or one finger"),
    ("Pan", "right drag, or two fingers"),
    ("Zoom", "wheel, or pinch"),
    ("Undo a change of the view", "Ctrl Z"),
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
    let modal =
        egui::Modal::new(egui::Id::unique("Keyboard shortcuts")).frame(theme::card(tokens).inner_margin(20));
    let shown = modal.show(ctx, |ui| {
        ui.set_width(360.0_f32.min(ui.ctx().content_rect().width() - 72.0));
        let title = egui::RichText::new("Keyboard and pointer").font(font(theme::LARGE, Weight::SemiBold));
        ui.label(title.color(tokens.text));
        ui.add_space(4.0);
        for (what, keys) in SHORTCUTS {
            fact(ui, tokens, what, keys);
        }
        widgets::remark(ui, tokens, "The robot stops by itself half a second after the last order to move.");
        Button::new("Close").wide(ui).show(ui, tokens).clicked()
    });
    if shown.inner || shown.should_close() {
        state.help_open = false;
    }
}
