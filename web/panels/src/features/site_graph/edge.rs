//! The edge that is selected: how it may be used. What is changed holds for both directions of a pair.

use super::edge_actions::EdgeActions;
use super::edge_policy;
use super::facts::{both_directions, length_m, name_of};
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::number_field::{NumberField, TypedNumber};
use crate::select::select;
use crate::widgets::{self, fact};
use crate::{format, icon};
use client_model::{ClientCommand, Selection, SiteEdit};
use egui::Ui;
use site_model::{Edge, EdgeId, ObjectId, Site, Traversal, ValidationConfig};

/// What the section keeps between frames.
#[derive(Debug, Default)]
pub(super) struct EdgeSection {
    typed: TypedNumber,
    actions: EdgeActions,
}

impl EdgeSection {
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, edge: &Edge) {
        let (model, tokens) = (cx.model, cx.tokens);
        widgets::section_head(ui, tokens, texts::EDGE_HEAD);
        let ends = texts::ends(name_of(site, edge.from), name_of(site, edge.to));
        fact(ui, tokens, &ends, &format::distance(length_m(site, edge)));
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
        let choices: Vec<String> = texts::TRAVERSALS.iter().map(|(name, _)| (*name).to_owned()).collect();
        let shown = texts::traversal(&edge.traversal);
        if let Some(index) = select(ui, tokens, texts::TRAVERSAL, texts::TRAVERSAL, shown, &choices) {
            let traversal: &Traversal = &texts::TRAVERSALS[index].1;
            change(cx, site, edge, |it| it.traversal = traversal.clone());
        }
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

/// Changes an edge and the one that leads back, if there is one, in one step.
fn change(cx: &mut PanelContext<'_>, site: &Site, edge: &Edge, change: impl Fn(&mut Edge)) {
    let edits = both_directions(site, edge).flat_map(|it| cx.model.site.changing_edge(it.id, &change).put);
    let edit = SiteEdit { put: edits.collect(), removed: Vec::new() };
    cx.commands.push(ClientCommand::EditSite(edit));
}
