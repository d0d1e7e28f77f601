//! The top bar: robot, position, battery, link and control; *Stop motion* at the far right, always.

use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::features::{connection, control, driving, localisation, platform, robot};
use crate::layout::{self, Width};
use crate::theme::{self, Weight};
use crate::{icon, widgets};
use egui::{Align, Context, Order, Ui, Vec2, vec2};

/// Shows the bar.
pub(super) fn show(ctx: &Context, cx: &mut PanelContext<'_>) {
    let (tokens, rect) = (cx.tokens, cx.layout.top);
    let frame = theme::card(tokens).inner_margin(egui::Margin { left: 14, right: 4, top: 1, bottom: 1 });
    layout::area(texts::TOP_BAR, Order::Foreground).fixed_pos(rect.min).show(ctx, |ui| {
        frame.show(ui, |ui| {
            let inside = rect.size() - vec2(18.0, 2.0) - Vec2::splat(2.0 * tokens.line_width);
            ui.set_min_size(inside);
            ui.set_max_size(inside);
            ui.spacing_mut().item_spacing.x = if cx.layout.width == Width::Wide { 18.0 } else { 10.0 };
            ui.with_layout(egui::Layout::right_to_left(Align::Center), |ui| {
                let spacing = std::mem::replace(&mut ui.spacing_mut().item_spacing.x, 8.0);
                show_buttons(ui, cx);
                ui.spacing_mut().item_spacing.x = spacing;
                ui.with_layout(egui::Layout::left_to_right(Align::Center), |ui| {
                    let room = ui.max_rect();
                    ui.shrink_clip_rect(room);
                    show_statuses(ui, cx);
                });
            });
        });
    });
}

/// From right to left.
fn show_buttons(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    driving::show_stop_button(ui, cx);
    show_drawer_button(ui, cx);
    driving::show_allow_button(ui, cx);
    if cx.layout.width != Width::Narrow {
        control::show_button(ui, cx);
    }
}

/// Opens and closes the side card where it is a drawer. On a narrow window the bar at the bottom opens it.
fn show_drawer_button(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let is_open = cx.frame.drawer_open;
    let is_offered = match cx.layout.width {
        Width::Wide => false,
        Width::Medium => true,
        Width::Narrow => is_open,
    };
    if !is_offered {
        return;
    }
    let (name, icon) =
        if is_open { (texts::CLOSE_PANEL, icon::X) } else { (texts::OPEN_PANEL, icon::SIDEBAR_SIMPLE) };
    let button = Button::icon_only(name, icon).kind(Kind::Quiet).size(40.0, 40.0);
    if button.show(ui, cx.tokens).clicked() {
        cx.frame.drawer_open = !is_open;
    }
}

/// From left to right.
fn show_statuses(ui: &mut Ui, cx: &PanelContext<'_>) {
    let is_narrow = cx.layout.width == Width::Narrow;
    if cx.layout.width == Width::Wide {
        let name = (texts::PRODUCT_NAME, theme::HEAD, Weight::SemiBold, cx.tokens.text);
        widgets::status_line(ui, texts::PRODUCT, texts::PRODUCT_NAME, &[name]);
    }
    if !is_narrow {
        platform::show_robot_status(ui, cx);
    }
    localisation::show_status(ui, cx);
    robot::show_battery_status(ui, cx);
    connection::show_status(ui, cx);
    if !is_narrow {
        control::show_status(ui, cx);
    }
}
