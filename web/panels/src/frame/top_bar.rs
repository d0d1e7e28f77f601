//! The top bar: robot, position, battery, link, control and the next run; *Stop motion* at the far right, always.

use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::features::{account, connection, control, driving, localisation, platform, robot, schedule};
use crate::icon;
use crate::layout::{self, Width};
use crate::status_line::{StatusDetail, StatusLine};
use crate::theme::{self, Weight};
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
            ui.with_layout(egui::Layout::right_to_left(Align::Center), |ui| {
                ui.spacing_mut().item_spacing.x = 8.0;
                show_buttons(ui, cx);
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

/// From left to right, in as much detail as there is room for. Where even the least is too wide, the last ones are cut.
fn show_statuses(ui: &mut Ui, cx: &PanelContext<'_>) {
    let room = ui.available_width();
    for detail in StatusDetail::ALL {
        let statuses = statuses(cx, detail);
        let gaps = statuses.len().saturating_sub(1) as f32 * detail.spacing();
        let width = statuses.iter().map(|status| status.width(ui)).sum::<f32>() + gaps;
        if width <= room || detail == StatusDetail::Least {
            ui.spacing_mut().item_spacing.x = detail.spacing();
            for status in &statuses {
                status.show(ui);
            }
            return;
        }
    }
}

fn statuses(cx: &PanelContext<'_>, detail: StatusDetail) -> Vec<StatusLine> {
    let product = (detail == StatusDetail::Full).then(|| {
        let line = StatusLine::new(texts::PRODUCT, texts::PRODUCT_NAME);
        line.part(texts::PRODUCT_NAME, theme::HEAD, Weight::SemiBold, cx.tokens.text)
    });
    [
        product,
        account::demo_status(cx, detail),
        platform::robot_status(cx, detail),
        Some(localisation::status(cx, detail)),
        robot::battery_status(cx, detail),
        Some(connection::status(cx, detail)),
        control::status(cx, detail),
        schedule::next_run_status(cx, detail),
    ]
    .into_iter()
    .flatten()
    .collect()
}
