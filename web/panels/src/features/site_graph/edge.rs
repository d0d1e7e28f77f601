//! The edge that is selected: how it may be used. What is changed holds for both directions of a pair.

use super::closures;
use super::edge_actions::EdgeActions;
use super::edge_policy;
use super::edge_routing::{self, GroupField};
use super::facts::{both_directions, length_m, name_of};
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::features::action_form::TypedParameters;
use crate::number_field::{NumberField, TypedNumber};
use crate::select::select;
use crate::widgets::{self, fact};
use crate::{format, icon};
use api::OfferedAction;
use client_model::{ClientCommand, Selection, SiteEdit};
use egui::{Id, Ui};
use site_model::{
    ActionRequest, Edge, EdgeId, ObjectId, Parameters, Site, Traversal, ValidationConfig, describe_action,
};
use std::sync::Arc;

/// What the section keeps between frames.
#[derive(Debug, Default)]
pub(super) struct EdgeSection {
    typed: TypedNumber,
    actions: EdgeActions,
    group: GroupField,
    /// Parameters of the action by which it is traversed.
    traversal: TypedParameters,
}

impl EdgeSection {
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, edge: &Edge) {
        let (model, tokens) = (cx.model, cx.tokens);
        widgets::section_head(ui, tokens, texts::EDGE_HEAD);
        let ends = texts::ends(name_of(site, edge.from), name_of(site, edge.to));
        fact(ui, tokens, &ends, &format::distance(length_m(site, edge)));
        closures::show_of_edge(ui, cx, site, edge);
        let both: Vec<EdgeId> = both_directions(site, edge).map(|edge| edge.id).collect();
        if Button::new(texts::ENABLED).on(edge.is_enabled).wide(ui).show(ui, tokens).clicked() {
            change(cx, site, edge, |it| it.is_enabled = !edge.is_enabled);
        }
        let is_pair = both.len() > 1;
        if Button::new(texts::BOTH_DIRECTIONS).on(is_pair).wide(ui).show(ui, tokens).clicked() {
            let edit = if is_pair {
                let back = both.iter().filter(|id| **id != edge.id).map(|id| ObjectId::Edge(*id));
                SiteEdit { put: Vec::new(), removed: back.collect() }
            } else {
                model.site.connecting(edge.from, edge.to)
            };
            cx.commands.push(ClientCommand::EditSite(edit));
        }
        self.show_properties(ui, cx, site, edge);
        if let Some(cost) = edge_routing::show_cost(ui, cx, &mut self.typed, edge) {
            change(cx, site, edge, |it| it.cost = cost);
        }
        if let Some(group) = self.group.show(ui, cx, edge) {
            change(cx, site, edge, |it| it.mutex_group.clone_from(&group));
        }
        if let Some((moment, list)) = self.actions.show(ui, cx, edge) {
            change(cx, site, edge, |it| moment.put(it, list.clone()));
        }
        if let Some(steps) = edge_policy::show(ui, cx, &mut self.typed, edge) {
            change(cx, site, edge, |it| it.fail_policy.clone_from(&steps));
        }
        widgets::section_head(ui, tokens, texts::SHAPE_HEAD);
        let split = Button::new(texts::SPLIT).icon(icon::PLUS).wide(ui);
        if split.show(ui, tokens).clicked()
            && let Some(map) = model.saved_map_on_screen()
            && let Some((node, edit)) = model.site.splitting_edge(edge.id, map)
        {
            cx.commands.push(ClientCommand::EditSite(edit));
            cx.commands.push(ClientCommand::Select(Some(Selection::Node(node))));
        }
        let delete = Button::new(texts::DELETE_EDGE).text(texts::DELETE_SHORT).icon(icon::TRASH);
        if delete.kind(Kind::Danger).wide(ui).show(ui, tokens).clicked() {
            let removed = both.into_iter().map(ObjectId::Edge).collect();
            cx.commands.push(ClientCommand::EditSite(SiteEdit { put: Vec::new(), removed }));
            cx.commands.push(ClientCommand::Select(None));
        }
    }

    /// How it is walked: traversal, heading, speed, corridor.
    fn show_properties(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, edge: &Edge) {
        let tokens = cx.tokens;
        self.show_traversal(ui, cx, site, edge);
        widgets::choice(ui, tokens, &texts::DIRECTIONS, edge.direction, |direction| {
            change(cx, site, edge, |it| it.direction = direction);
        });
        let object = ObjectId::Edge(edge.id);
        let max_m_s = ValidationConfig::default().max_speed_m_s;
        let speed = NumberField {
            name: texts::SPEED,
            object,
            value: edge.max_speed_m_s,
            hint: texts::SPEED_OF_ROBOT,
            step: 0.1,
            decimals: 2,
            range: [0.1, max_m_s],
        };
        if let Some(value) = speed.show(ui, cx, &mut self.typed) {
            change(cx, site, edge, |it| it.max_speed_m_s = value);
        }
        for (name, is_left) in [(texts::ROOM_LEFT, true), (texts::ROOM_RIGHT, false)] {
            let value = Some(if is_left { edge.corridor.left_m } else { edge.corridor.right_m });
            let room =
                NumberField { name, object, value, hint: "", step: 0.1, decimals: 2, range: [0.0, 10.0] };
            if let Some(value) = room.show(ui, cx, &mut self.typed).flatten() {
                change(cx, site, edge, |it| {
                    // The left of one direction is the right of the other.
                    let is_there = (it.id == edge.id) == is_left;
                    *if is_there { &mut it.corridor.left_m } else { &mut it.corridor.right_m } = value;
                });
            }
        }
    }
}

impl EdgeSection {
    /// By which gait it is traversed, or by which action of the robot.
    fn show_traversal(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, edge: &Edge) {
        let forms = Arc::clone(cx.model.site.action_forms());
        // Those of the platform are done along an edge and do not traverse it.
        let of_robot = forms.offered().iter().filter(|action| describe_action(&action.name).is_none());
        let actions: Vec<&OfferedAction> = of_robot.collect();
        let names = texts::TRAVERSALS.iter().map(|(name, _)| (*name).to_owned());
        let choices: Vec<String> = names.chain(actions.iter().map(|action| action.title.clone())).collect();
        let offered = |name: &str| actions.iter().find(|action| action.name == name);
        let shown = match &edge.traversal {
            Traversal::Action { name, .. } => offered(name).map_or(name.as_str(), |action| &action.title),
            traversal => texts::traversal(traversal),
        };
        if let Some(index) = select(ui, cx.tokens, texts::TRAVERSAL, texts::TRAVERSAL, shown, &choices) {
            let of_action = |action: &&OfferedAction| Traversal::Action {
                name: action.name.clone(),
                parameters: Parameters::new(),
            };
            let chosen = texts::TRAVERSALS.get(index).map(|(_, traversal)| traversal.clone());
            let action = index.checked_sub(texts::TRAVERSALS.len()).and_then(|index| actions.get(index));
            if let Some(traversal) = chosen.or_else(|| action.map(of_action)) {
                change(cx, site, edge, |it| it.traversal = traversal.clone());
            }
        } else if let Traversal::Action { name, parameters } = &edge.traversal {
            let owner = Id::unique(("traversal", edge.id.0));
            self.traversal.keep_only(owner);
            if offered(name).is_none() {
                widgets::remark(ui, cx.tokens, texts::NOT_OFFERED);
            }
            let request = ActionRequest { action: name.clone(), parameters: parameters.clone() };
            if let Some(parameters) = self.traversal.show(ui, cx, owner, &request, false) {
                let traversal = Traversal::Action { name: name.clone(), parameters };
                change(cx, site, edge, |it| it.traversal = traversal.clone());
            }
        }
    }
}

/// Changes an edge and the one that leads back, if there is one, in one step.
fn change(cx: &mut PanelContext<'_>, site: &Site, edge: &Edge, change: impl Fn(&mut Edge)) {
    let edits = both_directions(site, edge).flat_map(|it| cx.model.site.changing_edge(it.id, &change).put);
    let edit = SiteEdit { put: edits.collect(), removed: Vec::new() };
    cx.commands.push(ClientCommand::EditSite(edit));
}
