//! The joystick on the screen.

use super::{Deflection, speed_limits, texts};
use crate::theme::{self, Tokens};
use crate::{icon, paint};
use client_model::Model;
use egui::{Sense, Stroke, Ui, Vec2, vec2};

/// Radius of the joystick, points.
const RADIUS: f32 = 62.0;
/// Radius of its knob, points.
const KNOB_RADIUS: f32 = 22.0;

/// Parameters of the joystick.
struct JoystickConfig {
    /// Share of the radius around the centre in which a deflection means no motion: hands are not exact. Chosen: an eighth, some pixels.
    dead_zone_share: f32,
}

const CONFIG: JoystickConfig = JoystickConfig { dead_zone_share: 0.12 };

/// Shows the joystick. Returns its deflection while it is held, at most 1, x to the right and y down.
pub(super) fn show(ui: &mut Ui, model: &Model, tokens: &Tokens) -> Option<Vec2> {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(2.0 * RADIUS + 4.0), Sense::drag());
    let is_enabled = speed_limits(model).is_some();
    let is_held = is_enabled && response.is_pointer_button_down_on();
    let centre = rect.center();
    let deflection = response.interact_pointer_pos().filter(|_| is_held).map(|pointer| {
        let offset = (pointer - centre) / RADIUS;
        offset / offset.length().max(1.0)
    });
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(egui::Role::Group);
        node.set_label(texts::JOYSTICK);
        node.set_description(texts::JOYSTICK_HINT);
    });
    paint(ui, tokens, centre, deflection.unwrap_or(Vec2::ZERO), is_enabled);
    deflection
}

fn paint(ui: &Ui, tokens: &Tokens, centre: egui::Pos2, deflection: Vec2, is_enabled: bool) {
    let (rim, knob) =
        if is_enabled { (tokens.dim, tokens.accent_filled) } else { (tokens.line, tokens.line) };
    ui.painter().circle(centre, RADIUS, tokens.raised, Stroke::new(tokens.line_width, rim));
    for (icon, direction) in [
        (icon::CARET_UP, vec2(0.0, -1.0)),
        (icon::CARET_DOWN, vec2(0.0, 1.0)),
        (icon::ARROW_BEND_UP_LEFT, vec2(-1.0, 0.0)),
        (icon::ARROW_BEND_UP_RIGHT, vec2(1.0, 0.0)),
    ] {
        paint::icon_at(ui, centre + direction * (RADIUS - 13.0), icon, theme::ICON, rim);
    }
    let knob_centre = centre + deflection * (RADIUS - KNOB_RADIUS);
    ui.painter().circle_filled(knob_centre, KNOB_RADIUS, knob);
    let icon = if is_enabled { icon::ARROWS_OUT } else { icon::LOCK };
    paint::icon_at(ui, knob_centre, icon, theme::ICON, tokens.on_filled);
}

/// What a position of the knob commands: up walks ahead, sideways turns. Squared, so that small deflections are slow.
pub(super) fn shaped(position: Vec2) -> Deflection {
    let length = position.length();
    if length < CONFIG.dead_zone_share {
        return Deflection::default();
    }
    let strength = ((length - CONFIG.dead_zone_share) / (1.0 - CONFIG.dead_zone_share)).powi(2);
    let scaled = position / length * strength;
    Deflection { ahead: f64::from(-scaled.y), left: 0.0, turn_left: f64::from(-scaled.x) }
}
