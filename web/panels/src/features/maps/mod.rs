//! Saved maps: their list, viewing one, and what can be done with the one that is viewed.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::Button;
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::map_management::{self, Rename};
use crate::features::{alignment, imports, localisation, tabs};
use crate::theme::{self, Tokens, Weight, font};
use crate::{format, icon, widgets};
use api::{Command, DamagedMap, MapSummary, Mapping};
use client_model::ClientCommand;
use egui::{Align, CornerRadius, Layout, Response, Ui, vec2};

/// Width of the button that views a map, points.
const BUTTON_WIDTH: f32 = 84.0;

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct MapsPanel {
    /// The map that is being renamed.
    rename: Option<Rename>,
}

impl FeaturePanel for MapsPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[tabs::SESSION]
    }

    fn cancel(&mut self, _cx: &mut PanelContext<'_>) -> bool {
        self.rename.take().is_some()
    }

    /// Shown unless an alignment takes its place.
    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        if cx.model.alignment().is_none() {
            ui.add_space(4.0);
            widgets::rule(ui, cx.tokens);
            show_list(ui, cx, &mut self.rename);
        }
    }
}

/// The list, and importing a map.
fn show_list(ui: &mut Ui, cx: &mut PanelContext<'_>, rename: &mut Option<Rename>) {
    let tokens = cx.tokens;
    widgets::head(ui, tokens, texts::HEAD);
    match cx.model.maps().list() {
        None => widgets::remark(ui, tokens, texts::LOADING),
        Some([]) => widgets::remark(ui, tokens, texts::NONE),
        Some(maps) => {
            for map in maps {
                ui.push_id(map.id.0, |ui| show_entry(ui, cx, map, rename));
            }
        }
    }
    for map in cx.model.maps().damaged() {
        show_damaged(ui, cx, map);
    }
    imports::show(ui, cx);
}

/// A map that cannot be read: which, what is wrong, and what to do.
fn show_damaged(ui: &mut Ui, cx: &mut PanelContext<'_>, map: &DamagedMap) {
    let tokens = cx.tokens;
    let response = widgets::tinted_box(ui, tokens, tokens.bad, |ui| {
        let name = egui::RichText::new(texts::damaged(map)).font(font(theme::BODY, Weight::Medium));
        let response = ui.add(egui::Label::new(name.color(tokens.text)).wrap());
        widgets::remark(ui, tokens, &map.problem);
        widgets::remark(ui, tokens, &map.remedy);
        map_management::show_delete_damaged(ui, cx, map);
        response
    });
    widgets::status_node(&response, &texts::damaged(map), &texts::damaged_value(map));
}

fn show_entry(ui: &mut Ui, cx: &mut PanelContext<'_>, map: &MapSummary, rename: &mut Option<Rename>) {
    let (model, tokens) = (cx.model, cx.tokens);
    let is_viewed = model.viewed_map() == Some(map.id);
    let fill = if is_viewed { tokens.selected() } else { tokens.raised };
    let frame = egui::Frame::new().fill(fill).corner_radius(CornerRadius::same(theme::BUTTON_RADIUS));
    let is_renamed = rename.as_ref().is_some_and(|rename| rename.is_of(map.id));
    let shown = frame.inner_margin(12).show(ui, |ui| {
        if is_renamed {
            ui.set_width(ui.available_width());
            return map_management::show_rename(ui, cx, rename);
        }
        ui.horizontal(|ui| {
            show_summary(ui, tokens, cx.utc_offset_s, map);
            let toggled = show_view_button(ui, tokens, map, is_viewed).clicked();
            if toggled {
                cx.commands.push(ClientCommand::ViewMap((!is_viewed).then_some(map.id)));
            }
        });
    });
    if is_viewed && !is_renamed {
        map_management::show_actions(ui, cx, map, rename);
    }
    if is_viewed && *model.mapping() == Mapping::Idle {
        localisation::show(ui, cx, map);
        show_extend(ui, cx, map);
        alignment::show_offer(ui, cx, map.id);
    }
    let value = texts::entry_value(map, cx.utc_offset_s);
    widgets::status_node(&shown.response, &texts::entry(&map.name), &value);
}

/// Name, date and size of a map.
fn show_summary(ui: &mut Ui, tokens: &Tokens, utc_offset_s: i64, map: &MapSummary) {
    let size = vec2(ui.available_width() - BUTTON_WIDTH - 8.0, 40.0);
    ui.allocate_ui(size, |ui| {
        ui.vertical(|ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            let name = egui::RichText::new(&map.name).font(font(theme::BODY, Weight::Medium));
            ui.add(egui::Label::new(name.color(tokens.text)).truncate());
            widgets::remark(ui, tokens, &format::date(map.created, utc_offset_s));
            widgets::remark(ui, tokens, &texts::size(map));
        });
    });
}

fn show_view_button(ui: &mut Ui, tokens: &Tokens, map: &MapSummary, is_viewed: bool) -> Response {
    let (name, short, sign) = if is_viewed {
        (texts::close(&map.name), texts::CLOSE_SHORT, icon::X)
    } else {
        (texts::view(&map.name), texts::VIEW_SHORT, icon::EYE)
    };
    let shown = ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        Button::new(&name).text(short).icon(sign).size(BUTTON_WIDTH, theme::TOUCH).show(ui, tokens)
    });
    shown.inner
}

/// Goes on mapping in the map that is viewed.
fn show_extend(ui: &mut Ui, cx: &mut PanelContext<'_>, map: &MapSummary) {
    let (model, tokens) = (cx.model, cx.tokens);
    let is_pending = model.is_pending(|command| matches!(command, Command::ExtendMap { .. }));
    let name = texts::extend(&map.name);
    let button = Button::new(&name).text(texts::EXTEND_SHORT).icon(icon::PLUS);
    if button.enabled(model.can_command() && !is_pending).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::ExtendMap(map.id));
    }
    widgets::remark(ui, tokens, texts::EXTEND_HINT);
}
