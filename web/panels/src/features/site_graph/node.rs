//! The node that is selected: its name, kind, place, edges, and what needs it.

use super::facts::{both_directions, length_m, missing_name, name_of, needed_by};
use super::{docks, influence, texts};
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::features::goals::show_send_button;
use crate::heading::{heading_deg, orientation_of};
use crate::icon;
use crate::name_field::NameField;
use crate::number_field::{NumberField, TypedNumber};
use crate::property_fields::PropertyFields;
use crate::tag_field::TagField;
use crate::widgets;
use client_model::{ClientCommand, Selection, SiteEdit};
use egui::Ui;
use site_model::{Edge, Node, ObjectId, PoseTolerance, Site, ValidationConfig};
use std::collections::BTreeSet;

/// Coordinates that people may enter, metres.
pub(super) const RANGE_M: [f64; 2] = [-100_000.0, 100_000.0];

/// Tolerances of a node that people may enter.
struct ToleranceLimitsConfig {
    /// Greatest distance, metres. Chosen: an open place to pass by.
    max_m: f64,
}

const TOLERANCES: ToleranceLimitsConfig = ToleranceLimitsConfig { max_m: 5.0 };

/// What the section keeps between frames.
#[derive(Debug, Default)]
pub(super) struct NodeSection {
    name: NameField,
    tags: TagField,
    properties: PropertyFields,
    dock_name: NameField,
    typed: TypedNumber,
}

impl NodeSection {
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, node: &Node) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::NODE_HEAD);
        if let Some(name) = self.name.show(ui, cx, &texts::NAME_FIELD, ObjectId::Node(node.id), &node.name) {
            change(cx, node, |node| node.name = name);
        }
        if let Some(tags) = self.tags.show(ui, cx, ObjectId::Node(node.id), &node.tags) {
            change(cx, node, |node| node.tags = tags);
        }
        let object = ObjectId::Node(node.id);
        if let Some(properties) = self.properties.show(ui, cx, object, &node.properties) {
            change(cx, node, |node| node.properties = properties);
        }
        for kinds in texts::KINDS.chunks(2) {
            widgets::choice(ui, tokens, kinds, node.kind, |kind| change(cx, node, |node| node.kind = kind));
        }
        docks::show_of_node(ui, cx, &mut self.dock_name, site, node);
        show_send_button(ui, cx, site, node.id);
        self.show_place(ui, cx, node);
        self.show_tolerance(ui, cx, node);
        if let Some(corners) = influence::show(ui, cx, &mut self.typed, node) {
            change(cx, node, |node| node.influence_area_m = corners);
        }
        widgets::section_head(ui, tokens, texts::WAYS_HEAD);
        // Of a pair of edges the one that leads away stands for both.
        let leads_here_only = |edge: &Edge| edge.to == node.id && both_directions(site, edge).count() == 1;
        for edge in site.edges().filter(|edge| edge.from == node.id || leads_here_only(edge)) {
            let [from, to] = [name_of(site, edge.from), name_of(site, edge.to)];
            let row = texts::edge_row(from, to, length_m(site, edge));
            let name = texts::edge(from, to);
            if Button::new(&name).text(&row).kind(Kind::Quiet).wide(ui).left().show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::Select(Some(Selection::Edge(edge.id))));
            }
        }
        needed_by(ui, tokens, site, &BTreeSet::from([node.id]));
        let name = texts::delete_node(missing_name(&node.name));
        let delete = Button::new(&name).text(texts::DELETE_SHORT).icon(icon::TRASH).kind(Kind::Danger);
        if delete.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::EditSite(cx.model.site.removing_nodes(&[node.id].into())));
            cx.commands.push(ClientCommand::Select(None));
        }
    }

    /// Fields for position, heading and floor, by which keys and fingers move and turn the node as drags do.
    fn show_place(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, node: &Node) {
        let object = ObjectId::Node(node.id);
        let mut field = |ui: &mut Ui, cx: &mut PanelContext<'_>, name, value, step, decimals, range| {
            let field = NumberField { name, object, value: Some(value), hint: "", step, decimals, range };
            field.show(ui, cx, &mut self.typed).flatten()
        };
        let position = node.map_from_node.position;
        for (index, name) in texts::COORDINATES.into_iter().enumerate() {
            let present = [position.x, position.y, position.z][index];
            if let Some(value) = field(ui, cx, name, present, 0.1, 2, RANGE_M) {
                let mut to = position;
                *[&mut to.x, &mut to.y, &mut to.z][index] = value;
                cx.commands.push(ClientCommand::EditSite(cx.model.site.moving_node(node.id, to)));
            }
        }
        let heading = heading_deg(&node.map_from_node.orientation);
        if let Some(value) = field(ui, cx, texts::HEADING, heading, 15.0, 0, [-360.0, 360.0]) {
            change(cx, node, |node| node.map_from_node.orientation = orientation_of(value.to_radians()));
        }
        if let Some(floor) = field(ui, cx, texts::FLOOR, f64::from(node.floor), 1.0, 0, texts::FLOORS) {
            change(cx, node, |node| node.floor = floor as i32);
        }
    }
}

impl NodeSection {
    /// Fields for how near the robot has to come.
    fn show_tolerance(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, node: &Node) {
        widgets::section_head(ui, cx.tokens, texts::TOLERANCE_HEAD);
        let limits = ValidationConfig::default();
        let lengths_m = [limits.min_tolerance_m, TOLERANCES.max_m];
        let min_deg = (2.0 * limits.min_tolerance_rad.to_degrees()).ceil() / 2.0;
        let PoseTolerance { along_m, across_m, yaw_rad } = node.tolerance;
        let fields = [
            (along_m, 0.05, 2, lengths_m),
            (across_m, 0.05, 2, lengths_m),
            (yaw_rad.to_degrees(), 1.0, 1, [min_deg, 180.0]),
        ];
        for (index, (value, step, decimals, range)) in fields.into_iter().enumerate() {
            let (name, object) = (texts::TOLERANCES[index], ObjectId::Node(node.id));
            let field = NumberField { name, object, value: Some(value), hint: "", step, decimals, range };
            if let Some(value) = field.show(ui, cx, &mut self.typed).flatten() {
                change(cx, node, |node| match index {
                    0 => node.tolerance.along_m = value,
                    1 => node.tolerance.across_m = value,
                    _ => node.tolerance.yaw_rad = value.to_radians(),
                });
            }
        }
        widgets::remark(ui, cx.tokens, texts::TOLERANCE_REMARK);
    }
}

fn change(cx: &mut PanelContext<'_>, node: &Node, change: impl FnOnce(&mut Node)) {
    let edit: SiteEdit = cx.model.site.changing_node(node.id, change);
    cx.commands.push(ClientCommand::EditSite(edit));
}
