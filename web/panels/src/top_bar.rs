//! The top bar: site, localisation, battery, link, control; *Stop motion* at the far right, always.

use crate::button::{Button, Kind};
use crate::theme::{self, Tokens, Weight};
use crate::widgets::status_line;
use crate::{Layout, PanelState, Width, icon, words};
use api::Localisation;
use client_model::{ClientCommand, Model, SocketState};
use egui::{Color32, Ui};

pub(crate) fn show(
    ctx: &egui::Context,
    model: &Model,
    tokens: &Tokens,
    layout: &Layout,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    let frame = theme::card(tokens).inner_margin(egui::Margin { left: 14, right: 4, top: 1, bottom: 1 });
    crate::layout::area("Top bar", egui::Order::Foreground).fixed_pos(layout.top.min).show(ctx, |ui| {
        frame.show(ui, |ui| {
            let inside =
                layout.top.size() - egui::vec2(18.0, 2.0) - egui::Vec2::splat(2.0 * tokens.line_width);
            ui.set_min_size(inside);
            ui.set_max_size(inside);
            ui.spacing_mut().item_spacing.x = if layout.width == Width::Wide { 18.0 } else { 10.0 };
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let gap = std::mem::replace(&mut ui.spacing_mut().item_spacing.x, 8.0);
                buttons(ui, model, tokens, layout, state, out);
                ui.spacing_mut().item_spacing.x = gap;
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    let room = ui.max_rect();
                    ui.shrink_clip_rect(room);
                    statuses(ui, model, tokens, layout);
                });
            });
        });
    });
}

fn buttons(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    layout: &Layout,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    let narrow = layout.width == Width::Narrow;
    let stop = Button::new("Stop motion")
        .icon(icon::STOP)
        .kind(Kind::Stop)
        .hint("Stops the robot now. Esc or Space");
    let stop = if narrow { stop.text("Stop") } else { stop };
    if stop.size(if narrow { 92.0 } else { 136.0 }, 40.0).show(ui, tokens).clicked() {
        out.push(ClientCommand::StopMotion);
    }
    // On a phone the bar at the bottom opens the sheets.
    if layout.width == Width::Medium || (narrow && state.drawer_open) {
        let (name, sign) =
            if state.drawer_open { ("Close panel", icon::X) } else { ("Open panel", icon::SIDEBAR_SIMPLE) };
        if Button::icon_only(name, sign).kind(Kind::Quiet).size(40.0, 40.0).show(ui, tokens).clicked() {
            state.drawer_open = !state.drawer_open;
        }
    }
    if model.is_stopped() {
        let allow = Button::new("Allow motion").kind(Kind::Primary).enabled(!model.is_controlled_by_other());
        let allow = if narrow { allow.text("Allow") } else { allow };
        if allow.size(0.0, 40.0).show(ui, tokens).clicked() {
            out.push(ClientCommand::AllowMotion);
        }
    }
    if !narrow {
        control_button(ui, model, tokens, out);
    }
}

fn control_button(ui: &mut Ui, model: &Model, tokens: &Tokens, out: &mut Vec<ClientCommand>) {
    let connected = model.is_connected();
    if model.has_control() {
        let release = Button::new("Release control").text("Release").kind(Kind::Quiet).enabled(connected);
        if release.hint("Let somebody else control the robot").size(0.0, 40.0).show(ui, tokens).clicked() {
            out.push(ClientCommand::ReleaseControl);
        }
    } else {
        let hint = if model.is_controlled_by_other() {
            "Takes control from the person who has it"
        } else {
            "Only one person moves the robot at a time"
        };
        let take = Button::new("Take control").hint(hint).enabled(connected);
        if take.size(0.0, 40.0).show(ui, tokens).clicked() {
            out.push(ClientCommand::TakeControl);
        }
    }
}

fn statuses(ui: &mut Ui, model: &Model, tokens: &Tokens, layout: &Layout) {
    let wide = layout.width == Width::Wide;
    if wide {
        status_line(
            ui,
            "Product",
            "AutoInspect",
            &[("AutoInspect", theme::HEAD, Weight::SemiBold, tokens.text)],
        );
    }
    if layout.width != Width::Narrow {
        robot(ui, model, tokens);
    }
    position(ui, model, tokens, layout);
    battery(ui, model, tokens, layout);
    link(ui, model, tokens, layout);
    if layout.width != Width::Narrow {
        control(ui, model, tokens, wide);
    }
}

fn robot(ui: &mut Ui, model: &Model, tokens: &Tokens) {
    let Some(platform) = model.platform.report() else { return };
    let name = match &platform.site {
        Some(site) => format!("{} · {}", platform.robot, site),
        None => platform.robot.clone(),
    };
    status_line(ui, "Robot", &name, &[(&name, theme::BODY, Weight::Regular, tokens.text)]);
}

/// Above this standard deviation a person should not trust the position.
const UNSURE_M: f64 = 0.5;

fn position(ui: &mut Ui, model: &Model, tokens: &Tokens, layout: &Layout) {
    let (sign, colour, word, figure) = match &model.robot.estimate {
        None => (icon::GPS_SLASH, tokens.dim, "No position yet", String::new()),
        Some(estimate) => {
            let sigma = words::position_sigma_m(&estimate.value);
            let figure = words::accuracy(sigma);
            if !model.is_connected() {
                (icon::GPS_SLASH, tokens.bad, "Last position", words::age(estimate.age(model.now())))
            } else if matches!(
                model.localisation(),
                Localisation::Loading { .. } | Localisation::Relocalising { .. }
            ) {
                (icon::GPS_SLASH, tokens.warn, "Relocalising", String::new())
            } else if sigma > UNSURE_M
                || matches!(model.localisation(), Localisation::Localised { degradation: Some(_), .. })
            {
                (icon::WARNING, tokens.warn, "Position uncertain", figure)
            } else if estimate.value.degenerate > 0 {
                (icon::WARNING, tokens.warn, "Few landmarks", figure)
            } else {
                (icon::GPS_FIX, tokens.good, "Localised", figure)
            }
        }
    };
    let shown_figure = if layout.width == Width::Narrow { "" } else { &figure };
    let value = format!("{word} {figure}");
    let word = if layout.width == Width::Narrow && word == "Position uncertain" { "Uncertain" } else { word };
    let parts = [
        (sign, theme::ICON, Weight::Regular, colour),
        (word, theme::BODY, Weight::Regular, tokens.text),
        (shown_figure, theme::BODY, Weight::Regular, tokens.dim),
    ];
    status_line(ui, "Position", value.trim(), &parts)
        .on_hover_text("Accuracy is one standard deviation of the horizontal position");
}

fn battery(ui: &mut Ui, model: &Model, tokens: &Tokens, layout: &Layout) {
    let Some(battery) = &model.robot.battery else { return };
    let charge = battery.value.charge;
    let (sign, colour) = match charge {
        _ if battery.value.charging => (icon::BATTERY_CHARGING, tokens.good),
        c if c < 0.1 => (icon::BATTERY_WARNING, tokens.bad),
        c if c < 0.25 => (icon::BATTERY_LOW, tokens.warn),
        c if c < 0.6 => (icon::BATTERY_MEDIUM, tokens.text),
        _ => (icon::BATTERY_FULL, tokens.text),
    };
    let percent = format!("{:.0} %", charge * 100.0);
    let mut left = words::battery_left(&battery.value).unwrap_or_default();
    let value = format!("{percent} {left}");
    if layout.width != Width::Wide {
        left.clear();
    }
    let parts = [
        (sign, theme::ICON, Weight::Regular, colour),
        (percent.as_str(), theme::BODY, Weight::Regular, tokens.text),
        (left.as_str(), theme::BODY, Weight::Regular, tokens.dim),
    ];
    status_line(ui, "Battery", value.trim(), &parts);
}

/// Below this age data counts as live and the age is not worth a word.
pub(crate) const FRESH_S: f64 = 1.0;

fn link(ui: &mut Ui, model: &Model, tokens: &Tokens, layout: &Layout) {
    let age = model.data_age_s();
    let (sign, colour, word): (&str, Color32, String) = match model.connection().state() {
        SocketState::Connected { .. } => match age {
            Some(age) if age > FRESH_S => (icon::CLOCK_COUNTDOWN, tokens.warn, words::age(age)),
            _ => (
                icon::ARROWS_DOWN_UP,
                tokens.good,
                words::bit_rate(model.connection().throughput().bits_per_s()),
            ),
        },
        SocketState::Connecting { .. } if model.connection().lost_since().is_none() => {
            (icon::PLUGS, tokens.warn, "Connecting".to_owned())
        }
        SocketState::Connecting { .. } | SocketState::Lost { .. } => {
            (icon::WIFI_SLASH, tokens.bad, "Link lost".to_owned())
        }
        SocketState::Refused { .. } => (icon::X_CIRCLE, tokens.bad, "Refused".to_owned()),
    };
    let fresh = match (model.is_connected(), age) {
        (true, Some(age)) if age <= FRESH_S && layout.width == Width::Wide => words::age(age),
        _ => String::new(),
    };
    let value = format!("{word} {fresh}");
    // On a phone the message under the bar says it in words.
    let shown = if layout.width == Width::Narrow { "" } else { word.as_str() };
    let parts = [
        (sign, theme::ICON, Weight::Regular, colour),
        (shown, theme::BODY, Weight::Regular, tokens.text),
        (fresh.as_str(), theme::BODY, Weight::Regular, tokens.dim),
    ];
    let response = status_line(ui, "Link", value.trim(), &parts);
    let delay = model
        .connection()
        .clock()
        .round_trip_s()
        .map_or_else(String::new, |s| format!(" Answer after {:.0} ms.", s * 1000.0));
    response.on_hover_text(format!("Data coming in, and how old the robot's position is.{delay}"));
}

fn control(ui: &mut Ui, model: &Model, tokens: &Tokens, wide: bool) {
    let holder = match model.control().owner() {
        None => "nobody",
        Some(_) if model.has_control() => "You",
        Some(_) => model.control().holder_name(),
    };
    let colour = if model.has_control() { tokens.accent } else { tokens.text };
    let label = if wide { "Control" } else { "" };
    let sign = if wide { "" } else { icon::USER };
    let parts = [
        (sign, theme::ICON, Weight::Regular, tokens.dim),
        (label, theme::BODY, Weight::Regular, tokens.dim),
        (holder, theme::BODY, Weight::Medium, colour),
    ];
    status_line(ui, "Control", holder, &parts);
}
