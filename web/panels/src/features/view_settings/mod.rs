//! The tool column: how the scene looks.

use crate::TextInput;
use crate::button::{Button, Kind};
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets;
use crate::{Layout, PanelState, Width, icon, words};
use client_model::{CameraMove, ClientCommand, ColourBy, Model, Theme, ViewSettings};
use egui::{Align2, Popup, PopupCloseBehavior, RectAlign, Response, Ui};

/// From a button to its menu: out of the tools' card, and the usual gap.
const MENU_GAP: f32 = 9.0 + theme::GAP;
/// Ceilings that can be chosen, metres above the ground at the robot.
const CEILING_M: std::ops::RangeInclusive<f32> = 0.5..=12.0;
/// Sizes of points relative to their spacing.
const POINT_SIZE: std::ops::RangeInclusive<f32> = 0.25..=3.0;

pub(crate) fn show(
    ctx: &egui::Context,
    model: &Model,
    tokens: &Tokens,
    layout: &Layout,
    state: &mut PanelState,
    out: &mut Vec<ClientCommand>,
) {
    if layout.width == Width::Narrow && state.drawer_open {
        return;
    }
    crate::layout::hung_card(ctx, tokens, "View tools", layout.tools, Align2::LEFT_TOP, |ui| {
        ui.spacing_mut().item_spacing = egui::vec2(4.0, 4.0);
        if layout.width == Width::Narrow {
            let button = Button::icon_only("View tools", icon::SLIDERS_HORIZONTAL).on(state.tools_open);
            if button.show(ui, tokens).clicked() {
                state.tools_open = !state.tools_open;
            }
            if !state.tools_open {
                return;
            }
        }
        buttons(ui, model, tokens, layout, state, out);
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
    let view = model.view_settings();
    let mut edited = view.clone();
    let button = Button::icon_only("Colour", icon::PALETTE).kind(Kind::Quiet).show(ui, tokens);
    menu(&button, "Colour of points", |ui| colours(ui, tokens, &mut edited));
    let button = Button::icon_only("Ceiling", icon::CARET_DOUBLE_DOWN).on(view.cut_ceiling).show(ui, tokens);
    menu(&button, "Ceiling menu", |ui| ceiling(ui, tokens, &mut edited));
    let button = Button::icon_only("Point size", icon::DOTS_NINE).kind(Kind::Quiet).show(ui, tokens);
    menu(&button, "Point size menu", |ui| point_size(ui, tokens, &mut edited));
    if Button::icon_only("Pose graph", icon::GRAPH)
        .on(view.graph && model.has_pose_graph())
        .enabled(model.has_pose_graph())
        .show(ui, tokens)
        .clicked()
    {
        edited.graph = !view.graph;
    }
    if Button::icon_only("Follow robot", icon::NAVIGATION_ARROW).on(view.follow).show(ui, tokens).clicked() {
        edited.follow = !view.follow;
        if edited.follow {
            out.push(ClientCommand::MoveCamera(CameraMove::Robot));
        }
    }
    for (name, sign, to) in
        [("Top view", icon::SQUARE_HALF, CameraMove::Top), ("Fit view", icon::CORNERS_OUT, CameraMove::Fit)]
    {
        if Button::icon_only(name, sign).kind(Kind::Quiet).show(ui, tokens).clicked() {
            out.push(ClientCommand::MoveCamera(to));
        }
    }
    let button =
        Button::icon_only("Remembered views", icon::BOOKMARK_SIMPLE).kind(Kind::Quiet).show(ui, tokens);
    menu(&button, "Remembered views menu", |ui| bookmarks(ui, tokens, state, &mut edited, out));
    let button = Button::icon_only("Theme", theme_icon(view.theme)).kind(Kind::Quiet).show(ui, tokens);
    menu(&button, "Theme menu", |ui| themes(ui, tokens, &mut edited));
    if layout.width != Width::Narrow
        && Button::icon_only("Keyboard shortcuts", icon::KEYBOARD)
            .kind(Kind::Quiet)
            .show(ui, tokens)
            .clicked()
    {
        state.help_open = !state.help_open;
    }
    if edited != *view {
        out.push(ClientCommand::EditView(edited));
    }
}

/// A menu to the right of its button.
fn menu(button: &Response, name: &str, content: impl FnOnce(&mut Ui)) {
    Popup::from_toggle_button_response(button)
        .align(RectAlign::RIGHT_START)
        .gap(MENU_GAP)
        .accessible_name(name)
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
        .show(|ui| {
            ui.set_width(228.0);
            content(ui);
        });
}

fn colours(ui: &mut Ui, tokens: &Tokens, edited: &mut ViewSettings) {
    widgets::head(ui, tokens, "Colour by");
    for colour in ColourBy::ALL {
        let name = format!("Colour by {}", words::colour_by(colour).to_lowercase());
        let button = Button::new(&name).text(words::colour_by(colour)).on(edited.colour == colour).wide(ui);
        if button.show(ui, tokens).clicked() {
            edited.colour = colour;
        }
    }
}

fn ceiling(ui: &mut Ui, tokens: &Tokens, edited: &mut ViewSettings) {
    widgets::head(ui, tokens, "Cut off the ceiling");
    widgets::remark(ui, tokens, "Nothing is drawn above this height over the floor at the robot.");
    if Button::new("Cut off the ceiling")
        .text(if edited.cut_ceiling { "On" } else { "Off" })
        .on(edited.cut_ceiling)
        .wide(ui)
        .show(ui, tokens)
        .clicked()
    {
        edited.cut_ceiling = !edited.cut_ceiling;
    }
    let height = format!("{:.1} m", edited.ceiling_m);
    if slider(ui, tokens, "Ceiling height", &height, &mut edited.ceiling_m, CEILING_M) {
        edited.cut_ceiling = true;
    }
}

fn point_size(ui: &mut Ui, tokens: &Tokens, edited: &mut ViewSettings) {
    widgets::head(ui, tokens, "Point size");
    widgets::remark(ui, tokens, "At 1.0 × points just close the surfaces they lie on.");
    let size = format!("{:.1} ×", edited.point_size);
    slider(ui, tokens, "Size of points", &size, &mut edited.point_size, POINT_SIZE);
}

/// A slider as wide as there is room, with its value beside it. Returns whether it moved.
fn slider(
    ui: &mut Ui,
    tokens: &Tokens,
    name: &str,
    shown: &str,
    value: &mut f32,
    range: std::ops::RangeInclusive<f32>,
) -> bool {
    ui.horizontal(|ui| {
        ui.spacing_mut().slider_width = ui.available_width() - 64.0;
        ui.spacing_mut().interact_size.y = theme::TOUCH;
        let response = ui.add(egui::Slider::new(value, range).show_value(false));
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
        ui.label(egui::RichText::new(shown).font(font(theme::BODY, Weight::Medium)).color(tokens.text));
        response.changed()
    })
    .inner
}

fn bookmarks(
    ui: &mut Ui,
    tokens: &Tokens,
    state: &mut PanelState,
    edited: &mut ViewSettings,
    out: &mut Vec<ClientCommand>,
) {
    widgets::head(ui, tokens, "Remembered views");
    let mut forget = None;
    for (at, bookmark) in edited.bookmarks.iter().enumerate() {
        ui.push_id(&bookmark.name, |ui| {
            ui.horizontal(|ui| {
                let width = ui.available_width() - theme::TOUCH - 8.0;
                let name = format!("Go to {}", bookmark.name);
                if Button::new(&name)
                    .text(&bookmark.name)
                    .size(width, theme::TOUCH)
                    .show(ui, tokens)
                    .clicked()
                {
                    out.push(ClientCommand::MoveCamera(CameraMove::Bookmark(bookmark.clone())));
                }
                let name = format!("Forget {}", bookmark.name);
                if Button::icon_only(&name, icon::TRASH).kind(Kind::Quiet).show(ui, tokens).clicked() {
                    forget = Some(at);
                }
            });
        });
    }
    if let Some(at) = forget {
        edited.bookmarks.remove(at);
    }
    let next = format!("View {}", edited.bookmarks.len() + 1);
    let name = "Name of the view";
    TextInput::new(name, name).hint(&next).show(ui, tokens, &mut state.text_inputs, &mut state.bookmark_name);
    let button = Button::new("Remember this view").icon(icon::PLUS).wide(ui);
    if button.show(ui, tokens).clicked() {
        let typed = std::mem::take(&mut state.bookmark_name);
        let name = if typed.trim().is_empty() { next } else { typed.trim().to_owned() };
        out.push(ClientCommand::MoveCamera(CameraMove::SaveBookmark(name)));
    }
}

fn themes(ui: &mut Ui, tokens: &Tokens, edited: &mut ViewSettings) {
    widgets::head(ui, tokens, "Theme");
    for theme in Theme::ALL {
        let name = format!("{} theme", words::theme(theme));
        let button =
            Button::new(&name).text(words::theme(theme)).icon(theme_icon(theme)).on(edited.theme == theme);
        if button.wide(ui).show(ui, tokens).clicked() {
            edited.theme = theme;
        }
    }
}

fn theme_icon(theme: Theme) -> &'static str {
    match theme {
        Theme::Dark => icon::MOON,
        Theme::Light => icon::CIRCLE_HALF,
        Theme::Sunlight => icon::SUN,
    }
}
