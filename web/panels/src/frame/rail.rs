//! The rail: one button for each screen.

use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::layout::{self, Width};
use crate::screens::{self, SCREENS, ScreenDescription};
use crate::theme;
use client_model::{ClientCommand, Screen};
use egui::{Align, Context, Direction, Order, Ui, Vec2, vec2};

/// Distance between buttons, points.
const BUTTON_SPACING: f32 = 4.0;

/// Shows the rail; on narrow windows a bar at the bottom.
pub(super) fn show(ctx: &Context, cx: &mut PanelContext<'_>) {
    let (tokens, rect) = (cx.tokens, cx.layout.rail);
    let is_narrow = cx.layout.width == Width::Narrow;
    layout::area(texts::SCREENS, Order::Middle).fixed_pos(rect.min).show(ctx, |ui| {
        theme::card(tokens).inner_margin(4).show(ui, |ui| {
            let inside = rect.size() - Vec2::splat(8.0 + 2.0 * tokens.line_width);
            ui.set_min_size(inside);
            ui.set_max_size(inside);
            let direction = if is_narrow { Direction::LeftToRight } else { Direction::TopDown };
            ui.with_layout(egui::Layout::from_main_dir_and_cross_align(direction, Align::Center), |ui| {
                ui.spacing_mut().item_spacing = Vec2::splat(BUTTON_SPACING);
                let size = if is_narrow {
                    vec2(inside.x / SCREENS.len() as f32 - BUTTON_SPACING, 46.0)
                } else {
                    vec2(inside.x, 56.0)
                };
                for (screen, description) in SCREENS {
                    show_entry(ui, cx, *screen, description, size);
                }
            });
        });
    });
}

fn show_entry(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    screen: Screen,
    description: &ScreenDescription,
    size: Vec2,
) {
    let is_shown = cx.screen() == screen;
    let text = text_of(cx, screen, description);
    let button = Button::new(description.name)
        .text(&text)
        .icon(description.icon)
        .kind(Kind::Quiet)
        .on(is_shown)
        .stacked();
    if button.size(size.x, size.y).show(ui, cx.tokens).clicked() {
        // On a narrow window a second click on the same entry closes its sheet. A drawer would cover half of what a screen shows instead of the scene.
        let is_covering = cx.layout.width == Width::Medium && screens::covers_scene(screen);
        cx.frame.drawer_open = !(is_covering || is_shown && cx.is_covered_by_sheet());
        cx.commands.push(ClientCommand::ShowScreen(screen));
    }
}

/// The name of a screen; that of runs with the number of changes and alerts that nobody has looked at yet.
fn text_of(cx: &PanelContext<'_>, screen: Screen, description: &ScreenDescription) -> String {
    let new = cx.model.site.unseen_findings();
    if screen == screens::RUNS && new > 0 {
        texts::with_count(description.name, new)
    } else {
        description.name.to_owned()
    }
}
