//! Zones: areas that the robot keeps out of, slows down in or walks round where it can.

mod change;
mod effect;
mod effect_kind;
mod holds;
#[cfg(test)]
mod tests;
mod texts;

pub(crate) use texts::tag;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::message::show_message;
use crate::name_field::NameField;
use crate::number_field::TypedNumber;
use crate::{corner_fields, icon, screens, widgets};
use change::change;
use client_model::{CameraMove, ClientCommand, GraphTool, Selection, SiteEdit, middle_of};
use effect::EffectFields;
use egui::{Context, Ui};
use holds::HoldsFields;
use site_model::{ObjectId, Site, Zone};
use vocab::Vec3;

/// The tab of zones.
const ZONES: Tab = Tab { screen: screens::SITE, name: texts::TAB, scrolls: true, row_spacing: 8.0 };

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct ZonesPanel {
    name: NameField,
    typed: TypedNumber,
    effect: EffectFields,
    holds: HoldsFields,
    /// Whether the coordinates of the corners are shown.
    are_corners_open: bool,
    /// What was selected in the last frame.
    selection: Option<Selection>,
    /// Whether the list scrolls to the zone that is selected, because it is so since this frame.
    is_scroll_wanted: bool,
}

impl FeaturePanel for ZonesPanel {
    fn update(&mut self, _ctx: &Context, cx: &mut PanelContext<'_>) {
        let selection = cx.model.selection();
        let before = std::mem::replace(&mut self.selection, selection);
        let is_new = before != selection && matches!(selection, Some(Selection::Zone(_)));
        if is_new && cx.screen() == screens::SITE {
            cx.frame.open_tab(ZONES);
            self.is_scroll_wanted = true;
        }
    }

    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        if cx.model.graph_tool() == Some(GraphTool::DrawZone) {
            // Whoever ends it has no danger in mind.
            cx.frame.is_escape_consumed = true;
            show_message(ui, cx.tokens, cx.tokens.accent, icon::CORNERS_OUT, texts::DRAW_HINT, |_| {});
        }
    }

    fn tabs(&self) -> &'static [Tab] {
        &[ZONES]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::HEAD);
        let Some(site) = cx.model.site.site() else { return widgets::remark(ui, tokens, texts::LOADING) };
        show_draw(ui, cx, site);
        let zones = cx.model.site.zones();
        if zones.is_empty() {
            widgets::remark(ui, tokens, texts::EMPTY);
        }
        for zone in zones {
            let is_selected = cx.model.selection() == Some(Selection::Zone(zone.id));
            let name = texts::zone(&zone.name);
            let row = tag(zone);
            let button = Button::new(&name).text(&row).on(is_selected).wide(ui).left();
            let response = button.show(ui, tokens);
            if response.clicked() {
                let selection = (!is_selected).then_some(Selection::Zone(zone.id));
                cx.commands.push(ClientCommand::Select(selection));
            }
            if !is_selected {
                continue;
            }
            // Below a long list nobody would see what was just drawn.
            if std::mem::take(&mut self.is_scroll_wanted) {
                ui.scroll_to_rect(response.rect, Some(egui::Align::TOP));
            }
            widgets::tinted_box(ui, tokens, tokens.accent, |ui| self.show_zone(ui, cx, zone));
        }
    }
}

/// The button that lets the next drag draw a zone, or what is needed before.
fn show_draw(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) {
    let (model, tokens) = (cx.model, cx.tokens);
    if !model.is_site_on_screen() {
        let has_map = site.settings().is_some_and(|settings| settings.map.is_some());
        return widgets::sentence(ui, tokens, if has_map { texts::OTHER_MAP } else { texts::NO_MAP });
    }
    let tool = GraphTool::DrawZone;
    let is_on = model.graph_tool() == Some(tool);
    if Button::new(texts::DRAW).icon(icon::CORNERS_OUT).on(is_on).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::UseGraphTool((!is_on).then_some(tool)));
    }
}

impl ZonesPanel {
    fn show_zone(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, zone: &Zone) {
        let tokens = cx.tokens;
        let object = ObjectId::Zone(zone.id);
        if let Some(name) = self.name.show(ui, cx, &texts::NAME_FIELD, object, &zone.name) {
            change(cx, zone, |zone| zone.name = name);
        }
        self.effect.show(ui, cx, &mut self.typed, zone);
        holds::show_heights(ui, cx, &mut self.typed, zone);
        self.holds.show_times(ui, cx, zone);
        let corners = texts::corners(zone.corners_m.len());
        let open = Button::new(&corners).on(self.are_corners_open).wide(ui);
        self.are_corners_open ^= open.show(ui, tokens).clicked();
        if self.are_corners_open {
            let corners = corner_fields::show(ui, cx, &mut self.typed, object, &zone.corners_m);
            if let Some(corners) = corners {
                change(cx, zone, |zone| zone.corners_m = corners);
            }
        }
        let is_shown = cx.model.is_site_on_screen();
        if Button::new(texts::SHOW).icon(icon::EYE).enabled(is_shown).wide(ui).show(ui, tokens).clicked() {
            let [x, y] = middle_of(&zone.corners_m);
            let z = cx.model.site.base_height_in_m(&zone.corners_m, zone.height_m).unwrap_or(0.0);
            cx.commands.push(ClientCommand::MoveCamera(CameraMove::Point(Vec3::new(x, y, z))));
        }
        let name = texts::delete(&zone.name);
        let delete = Button::new(&name).text(texts::DELETE_SHORT).icon(icon::TRASH).kind(Kind::Danger);
        if delete.wide(ui).show(ui, tokens).clicked() {
            let removed = vec![object];
            cx.commands.push(ClientCommand::EditSite(SiteEdit { put: Vec::new(), removed }));
            cx.commands.push(ClientCommand::Select(None));
        }
    }
}
