//! Keyboard shortcuts of the whole page: cancel, undo and redo, help. None of them works while text is typed.

use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::features::FeaturePanels;
use client_model::ClientCommand;
use egui::{Context, Key, Popup};

/// Reads the keys of this frame.
pub(super) fn handle(ctx: &Context, panels: &mut FeaturePanels, cx: &mut PanelContext<'_>) {
    if ctx.egui_wants_keyboard_input() {
        return;
    }
    // While something is dragged in the scene, Escape puts it back and does nothing else.
    let is_scene_dragged = cx.frame.scene_drag.is_active;
    if !is_scene_dragged && ctx.input(|input| input.key_pressed(Key::Escape)) && !Popup::is_any_open(ctx) {
        cancel(panels, cx);
    }
    if cx.frame.is_covered {
        return;
    }
    let (undo, redo) = ctx.input(|input| {
        let z = input.modifiers.command && input.key_pressed(Key::Z);
        (z && !input.modifiers.shift, z && input.modifiers.shift)
    });
    if undo {
        cx.commands.push(ClientCommand::Undo);
    }
    if redo {
        cx.commands.push(ClientCommand::Redo);
    }
    if ctx.input(|input| input.key_pressed(Key::Questionmark)) {
        cx.frame.help_open = !cx.frame.help_open;
    }
}

/// Lets the first panel that has something unfinished cancel it.
fn cancel(panels: &mut FeaturePanels, cx: &mut PanelContext<'_>) {
    // Pictures over all cards are of one of these.
    if cx.frame.is_covered {
        if !panels.point_history.cancel(cx) {
            panels.runs.cancel(cx);
        }
        return;
    }
    for panel in panels.iter_mut() {
        if panel.cancel(cx) {
            return;
        }
    }
}
