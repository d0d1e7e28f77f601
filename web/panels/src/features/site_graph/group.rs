//! Several nodes that are selected together: what is done with all of them is one step of undo.

use super::facts::needed_by;
use super::node::RANGE_M;
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::icon;
use crate::number_field::{NumberField, TypedNumber};
use crate::widgets::{self, fact};
use client_model::ClientCommand;
use egui::Ui;
use site_model::{Node, NodeId, NodeKind, ObjectId, Site};
use std::collections::{BTreeMap, BTreeSet};
use vocab::Vec3;

/// What the section keeps between frames.
#[derive(Debug, Default)]
pub(super) struct GroupSection {
    typed: TypedNumber,
}

impl GroupSection {
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        site: &Site,
        nodes: &BTreeSet<NodeId>,
    ) {
        let (model, tokens) = (cx.model, cx.tokens);
        let of_group: Vec<&Node> = nodes.iter().filter_map(|node| site.node(*node)).collect();
        let Some(first) = of_group.first() else { return };
        widgets::section_head(ui, tokens, texts::GROUP_HEAD);
        fact(ui, tokens, texts::SELECTED, &of_group.len().to_string());
        let common = of_group.iter().all(|node| node.kind == first.kind).then_some(first.kind);
        let kinds: Vec<(&str, Option<NodeKind>)> =
            texts::KINDS.iter().map(|(name, kind)| (*name, Some(*kind))).collect();
        for kinds in kinds.chunks(2) {
            widgets::choice(ui, tokens, kinds, common, |kind| {
                let edit = model.site.changing_nodes(nodes, |node| node.kind = kind.unwrap_or_default());
                cx.commands.push(ClientCommand::EditSite(edit));
            });
        }
        self.show_place(ui, cx, &of_group);
        let join = model.site.joining_nodes(nodes);
        let button = Button::new(texts::JOIN).icon(icon::GRAPH).enabled(!join.put.is_empty());
        if button.hint(texts::JOIN_HINT).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::EditSite(join));
        }
        if model.site.edges_between(nodes).next().is_some() {
            let is_open = model.site.edges_between(nodes).all(|edge| edge.is_enabled);
            if Button::new(texts::EDGES_ENABLED).on(is_open).wide(ui).show(ui, tokens).clicked() {
                let edit = model.site.changing_edges_between(nodes, |edge| edge.is_enabled = !is_open);
                cx.commands.push(ClientCommand::EditSite(edit));
            }
        }
        needed_by(ui, tokens, site, nodes);
        let name = texts::delete_nodes(of_group.len());
        let delete = Button::new(&name).icon(icon::TRASH).kind(Kind::Danger);
        if delete.wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::EditSite(model.site.removing_nodes(nodes)));
            cx.commands.push(ClientCommand::Select(None));
        }
    }

    /// Fields for the middle of all nodes, which move them together, and for their floor.
    fn show_place(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, nodes: &[&Node]) {
        // The fields belong to no object; no other fields of this panel are shown meanwhile.
        let object = ObjectId::Settings;
        let mean = |of: fn(&Vec3) -> f64| {
            nodes.iter().map(|node| of(&node.map_from_node.position)).sum::<f64>() / nodes.len() as f64
        };
        let middle = [mean(|at| at.x), mean(|at| at.y)];
        for (axis, name) in texts::MIDDLE.into_iter().enumerate() {
            let value = Some((middle[axis] * 1e3).round() / 1e3);
            let field = NumberField { name, object, value, hint: "", step: 0.1, decimals: 2, range: RANGE_M };
            if let Some(to) = field.show(ui, cx, &mut self.typed).flatten() {
                let by = to - middle[axis];
                let moved = |node: &&Node| {
                    let at = node.map_from_node.position;
                    let at =
                        if axis == 0 { Vec3 { x: at.x + by, ..at } } else { Vec3 { y: at.y + by, ..at } };
                    (node.id, at)
                };
                let positions: BTreeMap<NodeId, Vec3> = nodes.iter().map(moved).collect();
                cx.commands.push(ClientCommand::EditSite(cx.model.site.moving_nodes(&positions)));
            }
        }
        let first = nodes[0].floor;
        let value = nodes.iter().all(|node| node.floor == first).then_some(f64::from(first));
        let (name, hint, range) = (texts::FLOOR, texts::SEVERAL, texts::FLOORS);
        let field = NumberField { name, object, value, hint, step: 1.0, decimals: 0, range };
        if let Some(floor) = field.show(ui, cx, &mut self.typed).flatten() {
            let ids = nodes.iter().map(|node| node.id).collect();
            let edit = cx.model.site.changing_nodes(&ids, |node| node.floor = floor as i32);
            cx.commands.push(ClientCommand::EditSite(edit));
        }
    }
}
