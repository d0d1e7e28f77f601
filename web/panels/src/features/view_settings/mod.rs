//! View settings: the tool column, which says how the scene looks and from where it is viewed.

mod menus;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::theme::Tokens;
use crate::{Layout, PanelState, Width, icon};
use client_model::{CameraMove, ClientCommand, Model, ViewSettings};
use egui::{Align2, Response, Ui};

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct ViewTools {
    /// Below 700 px: whether the tools are unfolded.
    is_open: bool,
    /// Name typed for a bookmark.
    bookmark_name: String,
}

/// The tool column at the left edge.
pub(crate) fn show(
    ctx: &egui::Context,
    model: &Model,
    tokens: &Tokens,
    layout: &Layout,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    let is_narrow = layout.width == Width::Narrow;
    if is_narrow && state.drawer_open {
        return;
    }
    crate::layout::hung_card(ctx, tokens, texts::TOOLS, layout.tools, Align2::LEFT_TOP, |ui| {
        ui.spacing_mut().item_spacing = egui::vec2(4.0, 4.0);
        let tools = &mut state.view_settings;
        if is_narrow {
            let button = Button::icon_only(texts::TOOLS, icon::SLIDERS_HORIZONTAL).on(tools.is_open);
            tools.is_open ^= button.show(ui, tokens).clicked();
        }
        if !is_narrow || tools.is_open {
            let mut edited = model.view_settings().clone();
            show_tools(ui, model, tokens, state, &mut edited, out);
            if edited != *model.view_settings() {
                out.push(ClientCommand::EditView(edited));
            }
        }
        if !is_narrow && tool(ui, tokens, texts::KEYBOARD_SHORTCUTS, icon::KEYBOARD).clicked() {
            state.help_open = !state.help_open;
        }
    });
}

/// The buttons that fit on every window.
fn show_tools(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    state: &mut PanelState,
    edited: &mut ViewSettings,
    out: &mut Vec<ClientCommand>,
) {
    menus::show_colour(ui, tokens, edited);
    menus::show_ceiling(ui, tokens, edited);
    menus::show_point_size(ui, tokens, edited);
    show_switches(ui, model, tokens, edited, out);
    for (name, icon, camera_move) in [
        (texts::TOP_VIEW, icon::SQUARE_HALF, CameraMove::Top),
        (texts::FIT_VIEW, icon::CORNERS_OUT, CameraMove::Fit),
    ] {
        if tool(ui, tokens, name, icon).clicked() {
            out.push(ClientCommand::MoveCamera(camera_move));
        }
    }
    menus::show_bookmarks(ui, tokens, &mut state.view_settings, &mut state.text_inputs, edited, out);
    menus::show_theme(ui, tokens, edited);
}

/// The switches of the pose graph and of following the robot.
fn show_switches(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    edited: &mut ViewSettings,
    out: &mut Vec<ClientCommand>,
) {
    let has_graph = model.has_pose_graph();
    let graph = Button::icon_only(texts::POSE_GRAPH, icon::GRAPH).on(edited.graph && has_graph);
    if graph.enabled(has_graph).show(ui, tokens).clicked() {
        edited.graph = !edited.graph;
    }
    let follow = Button::icon_only(texts::FOLLOW_ROBOT, icon::NAVIGATION_ARROW).on(edited.follow);
    if follow.show(ui, tokens).clicked() {
        edited.follow = !edited.follow;
        if edited.follow {
            out.push(ClientCommand::MoveCamera(CameraMove::Robot));
        }
    }
}

/// A button of the column that is not a switch.
fn tool(ui: &mut Ui, tokens: &Tokens, name: &str, icon: &str) -> Response {
    Button::icon_only(name, icon).kind(Kind::Quiet).show(ui, tokens)
}
