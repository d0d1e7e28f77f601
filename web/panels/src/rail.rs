//! The rail: one entry per screen that exists.

use crate::button::{Button, Kind};
use crate::theme::{self, Tokens};
use crate::{Layout, PanelState, Width, icon};
use client_model::{ClientCommand, Model, Screen};

const ENTRIES: [(Screen, &str, &str); 2] =
    [(Screen::Live, "Live", icon::BROADCAST), (Screen::Map, "Map", icon::MAP_TRIFOLD)];

pub(crate) fn show(
    ctx: &egui::Context,
    model: &Model,
    tokens: &Tokens,
    layout: &Layout,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    let narrow = layout.width == Width::Narrow;
    crate::layout::area("Screens", egui::Order::Middle).fixed_pos(layout.rail.min).show(ctx, |ui| {
        theme::card(tokens).inner_margin(4).show(ui, |ui| {
            let inside = layout.rail.size() - egui::Vec2::splat(8.0 + 2.0 * tokens.line_width);
            ui.set_min_size(inside);
            ui.set_max_size(inside);
            let direction = if narrow {
                egui::Layout::left_to_right(egui::Align::Center)
            } else {
                egui::Layout::top_down(egui::Align::Center)
            };
            ui.with_layout(direction, |ui| {
                ui.spacing_mut().item_spacing = egui::vec2(4.0, 4.0);
                let width = if narrow { inside.x / ENTRIES.len() as f32 - 4.0 } else { inside.x };
                for (screen, name, sign) in ENTRIES {
                    entry(ui, model, tokens, (screen, name, sign), width, narrow, state, out);
                }
            });
        });
    });
}

fn entry(
    ui: &mut egui::Ui,
    model: &Model,
    tokens: &Tokens,
    (screen, name, sign): (Screen, &str, &str),
    width: f32,
    narrow: bool,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    let on = model.view.screen() == screen;
    let button = Button::new(name).icon(sign).kind(Kind::Quiet).on(on).stacked();
    if button.size(width, if narrow { 46.0 } else { 56.0 }).show(ui, tokens).clicked() {
        // On a phone a second touch on the same entry puts its sheet away.
        state.drawer_open = !(narrow && on && state.drawer_open);
        out.push(ClientCommand::ShowScreen(screen));
    }
}
