//! The menus of the tool column. Each is a button and what it unfolds to its right.

use super::{ViewTools, texts, tool};
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::theme::{self, Tokens, Weight, font};
use crate::{TextInput, icon, widgets};
use client_model::{Bookmark, CameraMove, ClientCommand, ColourBy, Theme, ViewSettings};
use egui::{Popup, PopupCloseBehavior, RectAlign, Response, Ui};
use std::ops::RangeInclusive;

/// Distance from a button to its menu, points: to the edge of the tools' card, and the usual gap between cards.
const MENU_GAP: f32 = 9.0 + theme::GAP;
/// Width of a menu, points.
const MENU_WIDTH: f32 = 228.0;
/// Ceilings that can be chosen, metres above the ground at the robot.
const CEILING_M: RangeInclusive<f32> = 0.5..=12.0;
/// Sizes of points that can be chosen, as multiples of their spacing.
const POINT_SIZE: RangeInclusive<f32> = 0.25..=3.0;

/// A menu to the right of its button.
fn menu(button: &Response, name: &str, content: impl FnOnce(&mut Ui)) {
    Popup::from_toggle_button_response(button)
        .align(RectAlign::RIGHT_START)
        .gap(MENU_GAP)
        .accessible_name(name)
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
        .show(|ui| {
            ui.set_width(MENU_WIDTH);
            content(ui);
        });
}

/// What gives the points their colour.
pub(super) fn show_colour(ui: &mut Ui, tokens: &Tokens, edited: &mut ViewSettings) {
    let button = tool(ui, tokens, texts::COLOUR, icon::PALETTE);
    menu(&button, texts::COLOUR_MENU, |ui| {
        widgets::head(ui, tokens, texts::COLOUR_HEAD);
        for colour in ColourBy::ALL {
            let name = texts::colour_by(colour);
            let choice = Button::new(&name).text(texts::colour_by_short(colour)).on(edited.colour == colour);
            if choice.wide(ui).show(ui, tokens).clicked() {
                edited.colour = colour;
            }
        }
    });
}

/// Whether the ceiling is cut off, and at which height.
pub(super) fn show_ceiling(ui: &mut Ui, tokens: &Tokens, edited: &mut ViewSettings) {
    let button = Button::icon_only(texts::CEILING, icon::CARET_DOUBLE_DOWN).on(edited.cut_ceiling);
    menu(&button.show(ui, tokens), texts::CEILING_MENU, |ui| {
        widgets::head(ui, tokens, texts::CUT_CEILING);
        widgets::remark(ui, tokens, texts::CUT_CEILING_HINT);
        let switch = Button::new(texts::CUT_CEILING).text(texts::switch(edited.cut_ceiling));
        if switch.on(edited.cut_ceiling).wide(ui).show(ui, tokens).clicked() {
            edited.cut_ceiling = !edited.cut_ceiling;
        }
        let height = texts::ceiling_height(edited.ceiling_m);
        if slider(ui, tokens, texts::CEILING_HEIGHT, &height, &mut edited.ceiling_m, CEILING_M) {
            edited.cut_ceiling = true;
        }
    });
}

/// How large the points are drawn.
pub(super) fn show_point_size(ui: &mut Ui, tokens: &Tokens, edited: &mut ViewSettings) {
    let button = tool(ui, tokens, texts::POINT_SIZE, icon::DOTS_NINE);
    menu(&button, texts::POINT_SIZE_MENU, |ui| {
        widgets::head(ui, tokens, texts::POINT_SIZE);
        widgets::remark(ui, tokens, texts::POINT_SIZE_HINT);
        let size = texts::point_size(edited.point_size);
        slider(ui, tokens, texts::POINT_SIZE_SLIDER, &size, &mut edited.point_size, POINT_SIZE);
    });
}

/// A slider as wide as there is room, with its value beside it. Returns whether it moved.
fn slider(
    ui: &mut Ui,
    tokens: &Tokens,
    name: &str,
    shown: &str,
    value: &mut f32,
    range: RangeInclusive<f32>,
) -> bool {
    let row = ui.horizontal(|ui| {
        ui.spacing_mut().slider_width = ui.available_width() - 64.0;
        ui.spacing_mut().interact_size.y = theme::TOUCH;
        let response = ui.add(egui::Slider::new(value, range).show_value(false));
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
        ui.label(egui::RichText::new(shown).font(font(theme::BODY, Weight::Medium)).color(tokens.text));
        response.changed()
    });
    row.inner
}

/// Views that the operator saved, and saving the present one.
pub(super) fn show_bookmarks(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    tools: &mut ViewTools,
    edited: &mut ViewSettings,
) {
    let tokens = cx.tokens;
    let button = tool(ui, tokens, texts::BOOKMARKS, icon::BOOKMARK_SIMPLE);
    menu(&button, texts::BOOKMARKS_MENU, |ui| {
        widgets::head(ui, tokens, texts::BOOKMARKS);
        edited.bookmarks.retain(|bookmark| !show_bookmark(ui, cx, bookmark));
        let default_name = texts::default_bookmark_name(edited.bookmarks.len() + 1);
        let input = TextInput::new(texts::BOOKMARK_NAME, texts::BOOKMARK_NAME).hint(&default_name);
        input.show(ui, tokens, cx.text_inputs, &mut tools.bookmark_name);
        if Button::new(texts::ADD_BOOKMARK).icon(icon::PLUS).wide(ui).show(ui, tokens).clicked() {
            let typed = std::mem::take(&mut tools.bookmark_name);
            let name = if typed.trim().is_empty() { default_name } else { typed.trim().to_owned() };
            cx.commands.push(ClientCommand::MoveCamera(CameraMove::SaveBookmark(name)));
        }
    });
}

/// A row of the list. Returns whether the bookmark shall be removed.
fn show_bookmark(ui: &mut Ui, cx: &mut PanelContext<'_>, bookmark: &Bookmark) -> bool {
    let tokens = cx.tokens;
    let row = |ui: &mut Ui| {
        let width = ui.available_width() - theme::TOUCH - 8.0;
        let name = texts::go_to_bookmark(&bookmark.name);
        let go = Button::new(&name).text(&bookmark.name).size(width, theme::TOUCH);
        if go.show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::MoveCamera(CameraMove::Bookmark(bookmark.clone())));
        }
        let name = texts::remove_bookmark(&bookmark.name);
        Button::icon_only(&name, icon::TRASH).kind(Kind::Quiet).show(ui, tokens).clicked()
    };
    ui.push_id(&bookmark.name, |ui| ui.horizontal(row).inner).inner
}

/// The theme of the whole client.
pub(super) fn show_theme(ui: &mut Ui, tokens: &Tokens, edited: &mut ViewSettings) {
    let button = tool(ui, tokens, texts::THEME, theme_icon(edited.theme));
    menu(&button, texts::THEME_MENU, |ui| {
        widgets::head(ui, tokens, texts::THEME);
        for theme in Theme::ALL {
            let name = texts::theme(theme);
            let choice = Button::new(&name).text(texts::theme_short(theme)).icon(theme_icon(theme));
            if choice.on(edited.theme == theme).wide(ui).show(ui, tokens).clicked() {
                edited.theme = theme;
            }
        }
    });
}

fn theme_icon(theme: Theme) -> &'static str {
    match theme {
        Theme::Dark => icon::MOON,
        Theme::Light => icon::CIRCLE_HALF,
        Theme::Sunlight => icon::SUN,
    }
}
