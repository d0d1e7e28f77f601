//! Inspection points: what is looked at, from which node, and with which action.

mod limits;
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
use crate::select::select;
use crate::widgets::{self, fact};
use crate::{format, icon, screens};
use client_model::{CameraMove, ClientCommand, GraphTool, PointHistoryCommand, Selection, SiteEdit};
use egui::{Context, Ui};
use request::RequestFields;
use site_model::{InspectionPoint, NodeId, ObjectId, Site};
use vocab::Vec3;

/// The tab of inspection points.
const INSPECTION: Tab = Tab { screen: screens::SITE, name: texts::TAB, scrolls: true, row_spacing: 8.0 };

/// Distances from a target that people may enter, m.
const STAND_OFF_RANGE_M: [f64; 2] = [0.3, 30.0];

/// Parameters of the form.
struct PointFormConfig {
    /// Nodes that are offered to look from: the best ones. Chosen: a list that fits without scrolling.
    max_nodes: usize,
}

const CONFIG: PointFormConfig = PointFormConfig { max_nodes: 12 };

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct InspectionPointsPanel {
    name: NameField,
    request: RequestFields,
    typed: TypedNumber,
    /// What was selected in the last frame.
    selection: Option<Selection>,
    /// Whether the list scrolls to the point that is selected, because it is so since this frame.
    is_scroll_wanted: bool,
}

impl FeaturePanel for InspectionPointsPanel {
    fn update(&mut self, _ctx: &Context, cx: &mut PanelContext<'_>) {
        let selection = cx.model.selection();
        let before = std::mem::replace(&mut self.selection, selection);
        let is_new = before != selection && matches!(selection, Some(Selection::InspectionPoint(_)));
        if is_new && cx.screen() == screens::SITE {
            cx.frame.open_tab(INSPECTION);
            self.is_scroll_wanted = true;
        }
    }

    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let hint = match cx.model.graph_tool() {
            Some(GraphTool::AddInspectionPoints) => texts::ADD_HINT,
            Some(GraphTool::PickTarget) => texts::PICK_HINT,
            _ => return,
        };
        // Whoever ends it has no danger in mind.
        cx.frame.is_escape_consumed = true;
        show_message(ui, cx.tokens, cx.tokens.accent, icon::CAMERA, hint, |_| {});
    }

    fn tabs(&self) -> &'static [Tab] {
        &[INSPECTION]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::HEAD);
        let Some(site) = cx.model.site.site() else { return widgets::remark(ui, tokens, texts::LOADING) };
        show_add(ui, cx, site);
        let points = cx.model.site.inspection_points();
        if points.is_empty() {
            widgets::remark(ui, tokens, texts::EMPTY);
        }
        for point in points {
            let is_selected = cx.model.selection() == Some(Selection::InspectionPoint(point.id));
            let name = texts::point(&point.name);
            let row = texts::row(&point.name, name_of(site, point.node));
            let button = Button::new(&name).text(&row).on(is_selected).wide(ui).left();
            let response = button.show(ui, tokens);
            if response.clicked() {
                let selection = (!is_selected).then_some(Selection::InspectionPoint(point.id));
                cx.commands.push(ClientCommand::Select(selection));
            }
            if !is_selected {
                continue;
            }
            // Below a long list nobody would see what was just made.
            if std::mem::take(&mut self.is_scroll_wanted) {
                ui.scroll_to_rect(response.rect, Some(egui::Align::TOP));
            }
            widgets::tinted_box(ui, tokens, tokens.accent, |ui| self.show_point(ui, cx, site, point));
        }
    }
}

/// The button that lets clicks make inspection points, or what is needed before.
fn show_add(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) {
    let (model, tokens) = (cx.model, cx.tokens);
    if site.nodes().next().is_none() {
        return widgets::sentence(ui, tokens, texts::NO_NODES);
    }
    if !model.is_site_on_screen() {
        return widgets::sentence(ui, tokens, texts::OTHER_MAP);
    }
    let tool = GraphTool::AddInspectionPoints;
    let is_on = model.graph_tool() == Some(tool);
    if Button::new(texts::ADD).icon(icon::CAMERA).on(is_on).wide(ui).show(ui, tokens).clicked() {
        cx.commands.push(ClientCommand::UseGraphTool((!is_on).then_some(tool)));
    }
    widgets::remark(ui, tokens, texts::ADD_REMARK);
}

impl InspectionPointsPanel {
    fn show_point(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, point: &InspectionPoint) {
        let (model, tokens) = (cx.model, cx.tokens);
        let object = ObjectId::InspectionPoint(point.id);
        if let Some(name) = self.name.show(ui, cx, &texts::NAME_FIELD, object, &point.name) {
            change(cx, point, |point| point.name = name);
        }
        if let Some(request) = self.request.show(ui, cx, point) {
            change(cx, point, |point| point.request = request);
        }
        if let Some(asset) = limits::show_asset(ui, cx, point) {
            change(cx, point, |point| point.asset = asset);
        }
        if let Some(limits) = limits::show(ui, cx, &mut self.typed, point) {
            change(cx, point, |point| point.limits = limits);
        }
        let is_editable = model.is_site_on_screen();
        widgets::section_head(ui, tokens, texts::VIEW_HEAD);
        if is_editable {
            sight::show(ui, cx, point);
        }
        show_node(ui, cx, site, point);
        self.show_stand_off(ui, cx, site, point);
        if let Some(stand_off_m) = stand_off_m(site, point) {
            fact(ui, tokens, texts::STAND_OFF, &format::distance(stand_off_m));
        }
        fact(ui, tokens, texts::TARGET, &format::position(&point.target_m));
        let is_on = model.graph_tool() == Some(GraphTool::PickTarget);
        let pick = Button::new(texts::MOVE_TARGET).icon(icon::MAP_PIN).on(is_on).enabled(is_editable);
        if pick.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::UseGraphTool((!is_on).then_some(GraphTool::PickTarget)));
        }
        if Button::new(texts::SHOW).icon(icon::EYE).enabled(is_editable).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::MoveCamera(CameraMove::Point(point.target_m)));
        }
        if Button::new(texts::HISTORY).icon(icon::CLOCK).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::PointHistory(PointHistoryCommand::Open(point.id)));
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

/// From which node it is looked at: the present one and those from which it can be seen best.
fn show_node(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, point: &InspectionPoint) {
    let mut nodes = cx.model.site.viewpoints(point.target_m);
    nodes.truncate(CONFIG.max_nodes);
    if !nodes.contains(&point.node) {
        nodes.insert(0, point.node);
    }
    let option = |node: &NodeId| {
        let distance_m = distance_m(site, *node, &point.target_m).unwrap_or(0.0);
        texts::node_option(name_of(site, *node), distance_m)
    };
    let options: Vec<String> = nodes.iter().map(option).collect();
    let index = select(ui, cx.tokens, texts::NODE, texts::NODE, &option(&point.node), &options);
    if let Some(node) = index.map(|index| nodes[index]).filter(|node| *node != point.node) {
        change(cx, point, |point| point.node = node);
    }
}

fn change(cx: &mut PanelContext<'_>, point: &InspectionPoint, change: impl FnOnce(&mut InspectionPoint)) {
    let edit = cx.model.site.changing_inspection_point(point.id, change);
    cx.commands.push(ClientCommand::EditSite(edit));
}

/// Distance from the base at the node to the target, metres.
fn stand_off_m(site: &Site, point: &InspectionPoint) -> Option<f64> {
    distance_m(site, point.node, &point.target_m)
}

fn distance_m(site: &Site, node: NodeId, to: &Vec3) -> Option<f64> {
    let from = site.node(node)?.map_from_node.position;
    Some((from.x - to.x).hypot(from.y - to.y).hypot(from.z - to.z))
}
