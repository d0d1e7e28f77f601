//! Driving by hand: the joystick, the keys, the stop button, and what the robot does meanwhile.

mod joystick;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::features::{control, goals, robot};
use crate::theme::{self, Weight, font};
use crate::{Width, icon, layout, widgets};
use api::{Motion, SpeedLimits};
use client_model::{ClientCommand, Model};
use egui::{Align2, Context, InputState, Key, Ui, Vec2};
use vocab::{Twist, Vec3};

/// Parameters of driving with keys.
struct KeyDrivingConfig {
    /// Share of the full speed while Shift is held, for narrow passages. Chosen: two fifths, 0.5 m/s of the default robot's 1.2 m/s.
    slow_speed_share: f64,
}

const CONFIG: KeyDrivingConfig = KeyDrivingConfig { slow_speed_share: 0.4 };

/// Width of the texts and buttons beside the joystick, points.
const SIDE_WIDTH: f32 = 172.0;

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct DrivingPanel {
    /// Deflection of the joystick while it is held, -1 to 1 in both axes, x to the right and y down.
    deflection: Option<Vec2>,
}

impl FeaturePanel for DrivingPanel {
    fn update(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        if !ctx.egui_wants_keyboard_input()
            && is_stop_pressed(ctx, cx.frame.is_escape_consumed || cx.frame.scene_drag.is_active)
        {
            cx.commands.push(ClientCommand::StopMotion);
        }
    }

    fn show_card(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        let is_covered = cx.is_covered_by_sheet() || cx.is_scene_covered() || cx.frame.is_left_card_shown;
        if is_covered || cx.model.viewed_map().is_some() {
            self.deflection = None;
        } else {
            let position = cx.layout.drive;
            layout::hung_card(ctx, cx.tokens, texts::CARD, position, Align2::LEFT_BOTTOM, |ui| {
                ui.horizontal(|ui| {
                    self.deflection = joystick::show(ui, cx.model, cx.tokens);
                    ui.vertical(|ui| {
                        ui.set_width(SIDE_WIDTH);
                        show_state(ui, cx);
                    });
                });
            });
        }
        self.emit_velocity(ctx, cx);
    }
}

impl DrivingPanel {
    /// Emits the velocity that keys or joystick command: when they begin, while they go on, and `None` when they end. Keys come before the
    /// joystick.
    fn emit_velocity(&self, ctx: &Context, cx: &mut PanelContext<'_>) {
        let model = cx.model;
        let limits = speed_limits(model).filter(|_| model.viewed_map().is_none() && !cx.is_scene_covered());
        let commanded = limits.and_then(|limits| {
            // While tasks are dragged, the arrow keys move them; over pictures, they go on to the next.
            let are_keys_consumed =
                ctx.egui_wants_keyboard_input() || model.missions.drag().is_some() || cx.frame.is_covered;
            let from_keys = if are_keys_consumed { None } else { ctx.input(deflection_of_keys) };
            let from_joystick = || self.deflection.map(joystick::shaped);
            from_keys.or_else(from_joystick).map(|deflection| deflection.velocity(&limits))
        });
        if commanded.is_some() || model.driven_velocity().is_some() {
            cx.commands.push(ClientCommand::SetVelocity(commanded));
        }
    }
}

/// Escape stops whatever else it does, except where it keeps a name, ends a drag or closes a question: whoever does that has no danger in mind. Space stops unless
/// it presses the focused button.
fn is_stop_pressed(ctx: &Context, is_escape_consumed: bool) -> bool {
    let is_nothing_focused = ctx.memory(|memory| memory.focused().is_none());
    ctx.input(|input| {
        (!is_escape_consumed && input.key_pressed(Key::Escape))
            || (is_nothing_focused && input.key_pressed(Key::Space))
    })
}

/// The limits within which this client may drive the robot now; `None` while it may not, or the robot has not told its limits yet.
fn speed_limits(model: &Model) -> Option<SpeedLimits> {
    let is_allowed = !model.is_controlled_by_other() && !model.is_stopped();
    model.platform.manual_limits().filter(|_| is_allowed)
}

/// What keys or joystick command, as shares of the greatest speeds, -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Deflection {
    ahead: f64,
    left: f64,
    turn_left: f64,
}

impl Deflection {
    fn velocity(self, limits: &SpeedLimits) -> Twist {
        let linear = Vec3::new(self.ahead * limits.forward_m_s, self.left * limits.sideways_m_s, 0.0);
        Twist { linear, angular: Vec3::new(0.0, 0.0, self.turn_left * limits.turn_rad_s) }
    }
}

/// Deflection of the keys held down; `None` if there are none or the window lacks the focus.
fn deflection_of_keys(input: &InputState) -> Option<Deflection> {
    if !input.focused || input.modifiers.command || input.modifiers.alt {
        return None;
    }
    let held = |keys: &[Key]| f64::from(u8::from(keys.iter().any(|key| input.key_down(*key))));
    let ahead = held(&[Key::W, Key::ArrowUp]) - held(&[Key::S, Key::ArrowDown]);
    let left = held(&[Key::A]) - held(&[Key::D]);
    let turn_left = held(&[Key::Q, Key::ArrowLeft]) - held(&[Key::E, Key::ArrowRight]);
    if (ahead, left, turn_left) == (0.0, 0.0, 0.0) {
        return None;
    }
    let pace = if input.modifiers.shift { CONFIG.slow_speed_share } else { 1.0 };
    Some(Deflection { ahead: pace * ahead, left: pace * left, turn_left: pace * turn_left })
}

/// What the robot does, and the buttons of its goals.
fn show_state(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    let heading = egui::RichText::new(goals::heading(model)).font(font(theme::HEAD, Weight::SemiBold));
    ui.label(heading.color(tokens.text));
    let remaining_m = match model.motion() {
        Motion::Walking { remaining_m, .. } => Some(*remaining_m),
        _ => None,
    };
    widgets::remark(ui, tokens, &texts::speed_and_distance(robot::speed_m_s(model), remaining_m));
    if model.is_controlled_by_other() {
        control::show_controlled_by_other(ui, cx);
    } else {
        if model.is_connected() && model.platform.manual_limits().is_none() {
            widgets::remark(ui, tokens, texts::LIMITS_UNKNOWN);
        }
        goals::show_walk_button(ui, cx);
    }
}

/// Shows the stop button of the top bar.
pub(crate) fn show_stop_button(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let is_narrow = cx.layout.width == Width::Narrow;
    let stop = Button::new(texts::STOP).icon(icon::STOP).kind(Kind::Stop).hint(texts::STOP_HINT);
    let (stop, width) = if is_narrow { (stop.text(texts::STOP_SHORT), 92.0) } else { (stop, 136.0) };
    if stop.size(width, 40.0).show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::StopMotion);
    }
}

/// Shows the button of the top bar that allows motion, while motion is stopped.
pub(crate) fn show_allow_button(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    if !cx.model.is_stopped() {
        return;
    }
    let allow = Button::new(texts::ALLOW).kind(Kind::Primary).enabled(!cx.model.is_controlled_by_other());
    let is_narrow = cx.layout.width == Width::Narrow;
    let allow = if is_narrow { allow.text(texts::ALLOW_SHORT) } else { allow };
    if allow.size(0.0, 40.0).show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::AllowMotion);
    }
}
