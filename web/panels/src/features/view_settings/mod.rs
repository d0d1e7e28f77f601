//! View settings: the tool column, which says how the scene looks and from where it is viewed.

mod menus;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::theme::Tokens;
use crate::{Width, icon, layout};
use client_model::{CameraMove, ClientCommand, ViewSettings};
use egui::{Align2, Context, Response, Ui};

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct ViewTools {
    /// Below 700 px: whether the tools are unfolded.
    is_open: bool,
    /// Name typed for a bookmark.
    bookmark_name: String,
}

impl FeaturePanel for ViewTools {
    /// The tool column at the left edge.
    fn show_card(&mut self, ctx: &Context, cx: &mut PanelContext<'_>) {
        if cx.is_covered_by_sheet() || cx.is_scene_covered() {
            return;
        }
        let (tokens, position) = (cx.tokens, cx.layout.tools);
        let is_narrow = cx.layout.width == Width::Narrow;
        layout::hung_card(ctx, tokens, texts::TOOLS, position, Align2::LEFT_TOP, |ui| {
            ui.spacing_mut().item_spacing = egui::vec2(4.0, 4.0);
            if is_narrow {
                let button = Button::icon_only(texts::TOOLS, icon::SLIDERS_HORIZONTAL).on(self.is_open);
                self.is_open ^= button.show(ui, tokens).clicked();
            }
            if !is_narrow || self.is_open {
                let mut edited = cx.model.view_settings().clone();
                self.show_tools(ui, &mut edited, cx);
                if edited != *cx.model.view_settings() {
                    cx.commands.push(ClientCommand::EditView(edited));
                }
            }
            if !is_narrow && tool(ui, tokens, texts::KEYBOARD_SHORTCUTS, icon::KEYBOARD).clicked() {
                cx.frame.help_open = !cx.frame.help_open;
            }
        });
    }
}

impl ViewTools {
    /// The buttons that fit on every window.
    fn show_tools(&mut self, ui: &mut Ui, edited: &mut ViewSettings, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        menus::show_colour(ui, tokens, edited);
        menus::show_ceiling(ui, tokens, edited);
        menus::show_point_size(ui, tokens, edited);
        show_switches(ui, cx, edited);
        for (name, icon, camera_move) in [
            (texts::TOP_VIEW, icon::SQUARE_HALF, CameraMove::Top),
            (texts::FIT_VIEW, icon::CORNERS_OUT, CameraMove::Fit),
        ] {
            if tool(ui, tokens, name, icon).clicked() {
                cx.commands.push(ClientCommand::MoveCamera(camera_move));
            }
        }
        menus::show_bookmarks(ui, cx, self, edited);
        menus::show_theme(ui, tokens, edited);
    }
}

/// The switches of the pose graph and of following the robot.
fn show_switches(ui: &mut Ui, cx: &mut PanelContext<'_>, edited: &mut ViewSettings) {
    let tokens = cx.tokens;
    let has_graph = cx.model.has_pose_graph() && !crate::is_graph_covered(cx.model);
    let graph = Button::icon_only(texts::POSE_GRAPH, icon::GRAPH).on(edited.graph && has_graph);
    if graph.enabled(has_graph).show(ui, tokens).clicked() {
        edited.graph = !edited.graph;
    }
    let follow = Button::icon_only(texts::FOLLOW_ROBOT, icon::NAVIGATION_ARROW).on(edited.follow);
    if follow.show(ui, tokens).clicked() {
        edited.follow = !edited.follow;
        if edited.follow {
            cx.commands.push(ClientCommand::MoveCamera(CameraMove::Robot));
        }
    }
}

/// A button of the column that is not a switch.
fn tool(ui: &mut Ui, tokens: &Tokens, name: &str, icon: &str) -> Response {
    Button::icon_only(name, icon).kind(Kind::Quiet).show(ui, tokens)
}
