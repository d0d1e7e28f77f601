//! Inspection points: what is looked at, from which node, and with which action.

mod request;
mod sight;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::site_graph::name_of;
use crate::message::show_message;
use crate::name_field::NameField;
use crate::number_field::{NumberField, TypedNumber};
use crate::widgets::{self, fact};
use crate::{format, icon, screens};
use client_model::{CameraMove, ClientCommand, GraphTool, Selection, SiteEdit};
use egui::{Context, Ui};
use request::RequestFields;
use site_model::{InspectionPoint, ObjectId, Site};

/// The tab of inspection points.
const INSPECTION: Tab = Tab { screen: screens::SITE, name: texts::TAB, scrolls: true, row_spacing: 8.0 };

/// Distances from a target that people may enter, m.
const STAND_OFF_RANGE_M: [f64; 2] = [0.3, 30.0];

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct InspectionPointsPanel {
    name: NameField,
    request: RequestFields,
    typed: TypedNumber,
    /// What was selected in the last frame.
    selection: Option<Selection>,
}

impl FeaturePanel for InspectionPointsPanel {
    fn update(&mut self, _ctx: &Context, cx: &mut PanelContext<'_>) {
        let selection = cx.model.selection();
        let before = std::mem::replace(&mut self.selection, selection);
        let is_new = before != selection && matches!(selection, Some(Selection::InspectionPoint(_)));
        if is_new && cx.screen() == screens::SITE {
            cx.frame.open_tab(INSPECTION);
        }
    }

    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        if cx.model.graph_tool() == Some(GraphTool::PickTarget) {
            // Whoever ends it has no danger in mind.
            cx.frame.is_escape_taken = true;
            show_message(ui, cx.tokens, cx.tokens.accent, icon::CAMERA, texts::PICK_HINT, |_| {});
        }
    }

    fn tabs(&self) -> &'static [Tab] {
        &[INSPECTION]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::HEAD);
        let Some(site) = cx.model.site.site() else { return widgets::remark(ui, tokens, texts::LOADING) };
        show_add(ui, cx);
        let points = cx.model.site.inspection_points();
        if points.is_empty() {
            widgets::remark(ui, tokens, texts::EMPTY);
        }
        let mut selected = None;
        for point in points {
            let is_selected = cx.model.selection() == Some(Selection::InspectionPoint(point.id));
            let name = texts::point(&point.name);
            let row = texts::row(&point.name, name_of(site, point.node));
            let button = Button::new(&name).text(&row).kind(Kind::Quiet).on(is_selected).wide(ui);
            if button.show(ui, tokens).clicked() {
                let selection = (!is_selected).then_some(Selection::InspectionPoint(point.id));
                cx.commands.push(ClientCommand::Select(selection));
            }
            selected = selected.or(is_selected.then_some(point));
        }
        if let Some(point) = selected {
            self.show_point(ui, cx, site, point);
        }
    }
}

/// The button that lets the next click pick the target of a new inspection point, or what is needed before.
fn show_add(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (model, tokens) = (cx.model, cx.tokens);
    if !model.is_site_on_screen() {
        return widgets::sentence(ui, tokens, texts::OTHER_MAP);
    }
    let has_node = matches!(model.selection(), Some(Selection::Node(_)));
    let is_on = has_node && model.graph_tool() == Some(GraphTool::PickTarget);
    let button = Button::new(texts::ADD).icon(icon::CAMERA).on(is_on).enabled(has_node).wide(ui);
    if button.show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::UseGraphTool((!is_on).then_some(GraphTool::PickTarget)));
    }
    if !has_node {
        widgets::remark(ui, tokens, texts::SELECT_NODE);
    }
}

impl InspectionPointsPanel {
    fn show_point(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, point: &InspectionPoint) {
        let (model, tokens) = (cx.model, cx.tokens);
        widgets::rule(ui, tokens);
        widgets::section_head(ui, tokens, texts::POINT_HEAD);
        let object = ObjectId::InspectionPoint(point.id);
        if let Some(name) = self.name.show(ui, cx, &texts::NAME_FIELD, object, &point.name) {
            change(cx, point, |point| point.name = name);
        }
        let is_editable = model.is_site_on_screen();
        fact(ui, tokens, texts::NODE, name_of(site, point.node));
        if let Some(stand_off_m) = stand_off_m(site, point) {
            fact(ui, tokens, texts::STAND_OFF, &format::distance(stand_off_m));
        }
        fact(ui, tokens, texts::TARGET, &format::position(&point.target_m));
        if is_editable {
            sight::show(ui, cx, point);
        }
        self.show_stand_off(ui, cx, site, point);
        let is_on = model.graph_tool() == Some(GraphTool::PickTarget);
        let pick = Button::new(texts::MOVE_TARGET).icon(icon::MAP_PIN).on(is_on).enabled(is_editable);
        if pick.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::UseGraphTool((!is_on).then_some(GraphTool::PickTarget)));
        }
        if Button::new(texts::SHOW).icon(icon::EYE).enabled(is_editable).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::MoveCamera(CameraMove::Point(point.target_m)));
        }
        if let Some(request) = self.request.show(ui, cx, point) {
            change(cx, point, |point| point.request = request);
        }
        let needed = site.missions_that_need(object);
        let names: Vec<&str> =
            needed.iter().filter_map(|id| Some(site.mission(*id)?.name.as_str())).collect();
        if !names.is_empty() {
            widgets::remark(ui, tokens, &texts::needed_by(&names));
        }
        let name = texts::delete(&point.name);
        let delete = Button::new(&name).text(texts::DELETE_SHORT).icon(icon::TRASH).kind(Kind::Danger);
        if delete.wide(ui).show(ui, tokens).clicked() {
            let removed = vec![object];
            cx.commands.push(ClientCommand::EditSite(SiteEdit { put: Vec::new(), removed }));
            cx.commands.push(ClientCommand::Select(None));
        }
    }
}

impl InspectionPointsPanel {
    /// Places the node at a distance from the target, or turns it towards the target.
    fn show_stand_off(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        site: &Site,
        point: &InspectionPoint,
    ) {
        let tokens = cx.tokens;
        let field = NumberField {
            name: texts::STAND_OFF_FIELD,
            object: ObjectId::InspectionPoint(point.id),
            value: stand_off_m(site, point).map(|distance_m| (distance_m * 1e3).round() / 1e3),
            hint: "",
            step: 0.1,
            decimals: 2,
            range: STAND_OFF_RANGE_M,
        };
        if let Some(distance_m) = field.show(ui, cx, &mut self.typed).flatten() {
            let edit = cx.model.site.standing_off(point, distance_m);
            cx.commands.push(ClientCommand::EditSite(edit));
        }
        let face = cx.model.site.facing_target(point);
        let button = Button::new(texts::FACE).icon(icon::NAVIGATION_ARROW).enabled(!face.put.is_empty());
        if button.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::EditSite(face));
        }
        let sharing = cx.model.site.inspection_points().into_iter();
        let sharing: Vec<&str> = sharing
            .filter(|other| other.node == point.node && other.id != point.id)
            .map(|other| other.name.as_str())
            .collect();
        if !sharing.is_empty() {
            widgets::remark(ui, tokens, &texts::shared_node(name_of(site, point.node), &sharing));
        }
    }
}

fn change(cx: &mut PanelContext<'_>, point: &InspectionPoint, change: impl FnOnce(&mut InspectionPoint)) {
    let edit = cx.model.site.changing_inspection_point(point.id, change);
    cx.commands.push(ClientCommand::EditSite(edit));
}

/// Distance from the base at the node to the target, metres.
fn stand_off_m(site: &Site, point: &InspectionPoint) -> Option<f64> {
    let (from, to) = (site.node(point.node)?.map_from_node.position, point.target_m);
    Some((from.x - to.x).hypot(from.y - to.y).hypot(from.z - to.z))
}
