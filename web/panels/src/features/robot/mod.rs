//! The robot's state: motion, map, position, speed and battery.

#[cfg(test)]
mod tests;
mod texts;

use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::{connection, localisation, tabs};
use crate::status_line::{StatusDetail, StatusLine};
use crate::theme::Tokens;
use crate::widgets::{self, fact, fact_with_note};
use crate::{format, icon};
use client_model::{Model, position_sigma_m};
use egui::{Color32, Ui};

/// From which charges the icon and colour of the battery change. Chosen: as on common phones and laptops.
struct BatteryIconConfig {
    /// Charge below which the battery is shown as almost empty, 0 to 1. Chosen: as the charge that is left at the dock at least.
    critical_charge: f32,
    /// Charge below which it is shown as low, 0 to 1. Chosen: a little above the charge below which the robot goes to a dock (0.2), so that people see it before.
    low_charge: f32,
    /// Charge below which its icon is half full, 0 to 1. Chosen as a round number between the half and the full icon.
    medium_charge: f32,
}

const BATTERY_ICON: BatteryIconConfig =
    BatteryIconConfig { critical_charge: 0.1, low_charge: 0.25, medium_charge: 0.6 };

/// The panel. It keeps nothing between frames.
#[derive(Debug, Default)]
pub(crate) struct RobotPanel;

impl FeaturePanel for RobotPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[tabs::ROBOT]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        widgets::head(ui, tokens, texts::HEAD);
        fact(ui, tokens, texts::MOTION, motion_text(model));
        if let api::Motion::Blocked { reason, .. } = model.motion() {
            widgets::tinted_box(ui, tokens, tokens.warn, |ui| widgets::sentence(ui, tokens, reason));
        }
        if let Some(map) = model.localisation().map() {
            let map = model.maps().get(map).map_or(texts::DELETED_MAP, |map| map.name.as_str());
            fact(ui, tokens, texts::MAP, map);
            localisation::show_state(ui, cx);
        }
        show_estimate(ui, cx);
    }
}

/// What the robot does, in a few words.
pub(crate) fn motion_text(model: &Model) -> &'static str {
    texts::motion(model.robot.motion.as_ref().map(|motion| &motion.value))
}

/// Horizontal speed of the robot, m/s; 0 before the first estimate.
pub(crate) fn speed_m_s(model: &Model) -> f64 {
    model.robot.estimate.as_ref().map_or(0.0, |estimate| {
        let velocity = estimate.value.velocity.linear;
        velocity.x.hypot(velocity.y)
    })
}

/// Speed, position, accuracy and distance. Those that change fast carry their age when it is not live.
fn show_estimate(ui: &mut Ui, cx: &PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    let Some(estimate) = &model.robot.estimate else {
        widgets::remark(ui, tokens, texts::NO_ESTIMATE);
        return;
    };
    let age = connection::stale_age_s(model).map(format::age);
    let note = age.as_deref().map(|age| (age, tokens.warn));
    let position = &estimate.value.map_from_base.position;
    fact_with_note(ui, tokens, texts::SPEED, &format::speed(speed_m_s(model)), note);
    fact_with_note(ui, tokens, texts::POSITION, &format::position(position), note);
    fact(ui, tokens, texts::ACCURACY, &format::accuracy(position_sigma_m(&estimate.value)));
    fact(ui, tokens, texts::DISTANCE, &format::distance(estimate.value.distance_m));
}

/// The battery for the top bar.
pub(crate) fn battery_status(cx: &PanelContext<'_>, detail: StatusDetail) -> Option<StatusLine> {
    let battery = cx.model.robot.battery.as_ref()?;
    let tokens = cx.tokens;
    let (icon, colour) = battery_icon(&battery.value, tokens);
    let charge = format::percent(battery.value.charge);
    let time_left = texts::battery_time_left(&battery.value).unwrap_or_default();
    let line = StatusLine::new(texts::BATTERY, &format!("{charge} {time_left}"));
    let shown_time = if detail == StatusDetail::Full { time_left.as_str() } else { "" };
    Some(line.icon(icon, colour).text(&charge, tokens.text).text(shown_time, tokens.dim))
}

fn battery_icon(battery: &api::Battery, tokens: &Tokens) -> (&'static str, Color32) {
    match battery.charge {
        _ if battery.charging => (icon::BATTERY_CHARGING, tokens.good),
        charge if charge < BATTERY_ICON.critical_charge => (icon::BATTERY_WARNING, tokens.bad),
        charge if charge < BATTERY_ICON.low_charge => (icon::BATTERY_LOW, tokens.warn),
        charge if charge < BATTERY_ICON.medium_charge => (icon::BATTERY_MEDIUM, tokens.text),
        _ => (icon::BATTERY_FULL, tokens.text),
    }
}
