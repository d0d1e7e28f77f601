//! Driving: the stick, the keys, walking to a point, and what the robot does with it.

use crate::button::{Button, Kind};
use crate::features::goals;
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets;
use crate::{Layout, PanelState, Width, icon, words};
use api::Motion;
use client_model::{ClientCommand, Model, TeleoperationConfig};
use egui::{Align2, Key, Sense, Stroke, Ui, Vec2, vec2};
use vocab::{Twist, Vec3};

/// Walking sideways is slower than walking ahead.
const SIDEWAYS_FACTOR: f64 = 0.5;
/// With Shift: for narrow places.
const SLOW_FACTOR: f64 = 0.4;
const STICK_RADIUS: f32 = 62.0;
/// Share of the stick's travel round its middle that means nothing: hands are not exact.
const STICK_DEAD: f32 = 0.12;

/// Keys that stop and keys that undo. Nothing while text is being typed.
pub(crate) fn shortcuts(ctx: &egui::Context, model: &Model, out: &mut Vec<ClientCommand>) {
    if ctx.egui_wants_keyboard_input() {
        return;
    }
    let nothing_focused = ctx.memory(|memory| memory.focused().is_none());
    let (stop, undo, redo) = ctx.input(|input| {
        let stop = input.key_pressed(Key::Escape) || (nothing_focused && input.key_pressed(Key::Space));
        let z = input.modifiers.command && input.key_pressed(Key::Z);
        (stop, z && !input.modifiers.shift, z && input.modifiers.shift)
    });
    // Escape stops whatever else it does: nobody shall have to think first.
    if ctx.input(|input| input.key_pressed(Key::Escape)) {
        if model.is_picking_pose() {
            out.push(ClientCommand::PickPose(false));
        } else if model.loop_pick().is_some() {
            out.push(ClientCommand::PickLoopKeyframes(false));
        } else if model.selection().is_some() {
            out.push(ClientCommand::Select(None));
        }
    }
    for (pressed, command) in
        [(stop, ClientCommand::StopMotion), (undo, ClientCommand::Undo), (redo, ClientCommand::Redo)]
    {
        if pressed {
            out.push(command);
        }
    }
}

/// What keys and stick together want of the robot in this frame; says so when they begin, go on and end.
pub(crate) fn steer(ctx: &egui::Context, model: &Model, state: &PanelState, out: &mut Vec<ClientCommand>) {
    let allowed = !model.is_controlled_by_other() && !model.is_stopped() && model.viewed_map().is_none();
    let typing = ctx.egui_wants_keyboard_input();
    let keyed = if typing { None } else { ctx.input(keyed_twist) };
    let wanted = keyed.or(state.stick.map(stick_twist)).filter(|_| allowed);
    if wanted.is_some() || model.driven_velocity().is_some() {
        out.push(ClientCommand::SetVelocity(wanted));
    }
}

/// Velocity of the keys held down; `None` when there are none, or the window is not looked at.
fn keyed_twist(input: &egui::InputState) -> Option<Twist> {
    if !input.focused || input.modifiers.command || input.modifiers.alt {
        return None;
    }
    let held = |keys: &[Key]| f64::from(u8::from(keys.iter().any(|key| input.key_down(*key))));
    let ahead = held(&[Key::W, Key::ArrowUp]) - held(&[Key::S, Key::ArrowDown]);
    let left = held(&[Key::A]) - held(&[Key::D]);
    let turn = held(&[Key::Q, Key::ArrowLeft]) - held(&[Key::E, Key::ArrowRight]);
    if (ahead, left, turn) == (0.0, 0.0, 0.0) {
        return None;
    }
    let pace = if input.modifiers.shift { SLOW_FACTOR } else { 1.0 };
    Some(twist(pace * ahead, pace * left, pace * turn))
}

/// Velocity from shares of the greatest: ahead, to the left, turning left.
fn twist(ahead: f64, left: f64, turn: f64) -> Twist {
    let limits = TeleoperationConfig::default();
    Twist {
        linear: Vec3::new(ahead * limits.speed_max_mps, left * limits.speed_max_mps * SIDEWAYS_FACTOR, 0.0),
        angular: Vec3::new(0.0, 0.0, turn * limits.turn_max_radps),
    }
}

pub(crate) fn show(
    ctx: &egui::Context,
    model: &Model,
    tokens: &Tokens,
    layout: &Layout,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    let covered = layout.width == Width::Narrow && state.drawer_open;
    if covered || model.viewed_map().is_some() {
        state.stick = None;
        return;
    }
    crate::layout::hung_card(ctx, tokens, "Drive", layout.drive, Align2::LEFT_BOTTOM, |ui| {
        ui.horizontal(|ui| {
            stick(ui, model, tokens, state);
            ui.vertical(|ui| {
                ui.set_width(172.0);
                side(ui, model, tokens, layout, out);
            });
        });
    });
}

fn stick(ui: &mut Ui, model: &Model, tokens: &Tokens, state: &mut PanelState) {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(2.0 * STICK_RADIUS + 4.0), Sense::drag());
    let enabled = !model.is_controlled_by_other() && !model.is_stopped();
    let middle = rect.center();
    state.stick = response
        .interact_pointer_pos()
        .filter(|_| enabled && response.is_pointer_button_down_on())
        .map(|at| (at - middle) / STICK_RADIUS)
        .map(|at| at / at.length().max(1.0));
    ui.ctx().accesskit_node_builder(response.id, |node| {
        node.set_role(egui::Role::Group);
        node.set_label("Drive stick");
        node.set_description(
            "Drag: up walks ahead, sideways turns. The keys W, A, S, D, Q and E do the same.",
        );
    });
    let painter = ui.painter();
    let (rim, knob) = if enabled { (tokens.dim, tokens.accent_filled) } else { (tokens.line, tokens.line) };
    painter.circle(middle, STICK_RADIUS, tokens.raised, Stroke::new(tokens.line_width, rim));
    for (sign, at) in [
        (icon::CARET_UP, vec2(0.0, -1.0)),
        (icon::CARET_DOWN, vec2(0.0, 1.0)),
        (icon::ARROW_BEND_UP_LEFT, vec2(-1.0, 0.0)),
        (icon::ARROW_BEND_UP_RIGHT, vec2(1.0, 0.0)),
    ] {
        let at = middle + at * (STICK_RADIUS - 13.0);
        widgets::icon_at(ui, at, sign, theme::ICON, rim);
    }
    let at = middle + state.stick.unwrap_or(Vec2::ZERO) * (STICK_RADIUS - 22.0);
    painter.circle_filled(at, 22.0, knob);
    let sign = if enabled { icon::ARROWS_OUT } else { icon::LOCK };
    widgets::icon_at(ui, at, sign, theme::ICON, tokens.on_filled);
}

/// Up walks ahead, sideways turns; squared, so that small movements are fine ones.
fn stick_twist(at: Vec2) -> Twist {
    let length = at.length();
    if length < STICK_DEAD {
        return Twist::default();
    }
    let strength = ((length - STICK_DEAD) / (1.0 - STICK_DEAD)).powi(2);
    let at = at / length * strength;
    twist(f64::from(-at.y), 0.0, f64::from(-at.x))
}

fn side(ui: &mut Ui, model: &Model, tokens: &Tokens, layout: &Layout, out: &mut Vec<ClientCommand>) {
    let motion = goals::heading(model);
    let speed = model.robot.estimate.as_ref().map_or(0.0, |estimate| {
        let v = estimate.value.velocity.linear;
        v.x.hypot(v.y)
    });
    ui.label(egui::RichText::new(motion).font(font(theme::HEAD, Weight::SemiBold)).color(tokens.text));
    let detail = match model.motion() {
        Motion::Walking { remaining, .. } => {
            format!("{speed:.1} m/s · {} to go", words::distance(*remaining))
        }
        _ => format!("{speed:.1} m/s"),
    };
    widgets::remark(ui, tokens, &detail);
    if model.is_controlled_by_other() {
        widgets::remark(ui, tokens, &format!("{} controls the robot.", model.control().holder_name()));
        if layout.width == Width::Narrow
            && Button::new("Take control").wide(ui).enabled(model.is_connected()).show(ui, tokens).clicked()
        {
            out.push(ClientCommand::TakeControl);
        }
        return;
    }
    if matches!(model.motion(), Motion::Walking { .. } | Motion::Waiting { .. } | Motion::Looking { .. }) {
        if Button::new("Cancel walk").icon(icon::X).wide(ui).show(ui, tokens).clicked() {
            out.extend(model.goals.active().map(|goal| ClientCommand::CancelGoal(goal.id)));
        }
        return;
    }
    let walk =
        Button::new("Walk to a point").icon(icon::MAP_PIN).on(model.is_picking_goal()).kind(Kind::Plain);
    let enabled = !model.is_stopped() && model.is_connected();
    if walk.enabled(enabled).wide(ui).show(ui, tokens).clicked() {
        out.push(ClientCommand::PickGoal(!model.is_picking_goal()));
    }
}
