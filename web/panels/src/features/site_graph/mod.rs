//! The topological map: adding and joining nodes, what is selected of it, and its problems.

mod generation;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::message::show_message;
use crate::name_field::NameField;
use crate::widgets::{self, fact};
use crate::{format, icon, screens};
use client_model::{ClientCommand, GraphTool, Selection};
use egui::Ui;
use generation::GenerationSection;
use site_model::{Edge, EdgeId, Node, NodeId, ObjectId, Problem, Severity, Site, ValidationConfig};
use std::collections::BTreeSet;
use vocab::MapId;

/// The tab of the topological map.
const GRAPH: Tab = Tab { screen: screens::SITE, name: texts::TAB, scrolls: true, row_spacing: 8.0 };
/// Largest number of problems that are listed at once.
const MAX_PROBLEMS: usize = 30;

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct SiteGraphPanel {
    name: NameField,
    /// Problems of the site, with the revision that they were found in.
    problems: Option<(u64, Vec<Problem>)>,
    generation: GenerationSection,
}

impl FeaturePanel for SiteGraphPanel {
    fn update(&mut self, _ctx: &egui::Context, cx: &mut PanelContext<'_>) {
        // A tool works on its screen only, so that no click elsewhere edits anything.
        if cx.model.graph_tool().is_some() && cx.screen() != screens::SITE {
            cx.commands.push(ClientCommand::UseGraphTool(None));
        }
    }

    fn cancel(&mut self, cx: &mut PanelContext<'_>) -> bool {
        let is_on = cx.model.graph_tool().is_some();
        if is_on {
            cx.commands.push(ClientCommand::UseGraphTool(None));
        }
        is_on || self.generation.cancel()
    }

    fn show_messages(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let hint = match cx.model.graph_tool() {
            Some(GraphTool::AddNodes) => texts::ADD_HINT,
            Some(GraphTool::Connect) => texts::CONNECT_HINT,
            // Its hint is that of the inspection points.
            Some(GraphTool::PickTarget) | None => return,
        };
        show_message(ui, cx.tokens, cx.tokens.accent, icon::GRAPH, hint, |_| {});
    }

    fn tabs(&self) -> &'static [Tab] {
        &[GRAPH]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::HEAD);
        let Some(site) = cx.model.site.site() else { return widgets::remark(ui, tokens, texts::LOADING) };
        fact(ui, tokens, texts::NODES, &site.nodes().count().to_string());
        fact(ui, tokens, texts::EDGES, &site.edges().count().to_string());
        let unconfirmed = cx.model.site.unconfirmed();
        if unconfirmed > 0 {
            fact(ui, tokens, texts::UNCONFIRMED, &unconfirmed.to_string());
        }
        if let Some(map) = show_tools(ui, cx, site) {
            self.generation.show(ui, cx, site, map);
        }
        match cx.model.selection() {
            Some(Selection::Node(node)) => {
                if let Some(node) = site.node(node) {
                    self.show_node(ui, cx, site, node);
                }
            }
            Some(Selection::Edge(edge)) => {
                if let Some(edge) = site.edge(edge) {
                    show_edge(ui, cx, site, edge);
                }
            }
            _ => {}
        }
        self.show_problems(ui, cx, site);
    }
}

/// The buttons that say what a click does, or what is needed before. Returns the saved map that can be edited.
fn show_tools(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) -> Option<MapId> {
    let (model, tokens) = (cx.model, cx.tokens);
    let on_screen = model.saved_map_on_screen();
    let site_map = site.settings().and_then(|settings| settings.map);
    if let Some(map) = site_map
        && on_screen != Some(map)
    {
        widgets::sentence(ui, tokens, texts::OTHER_MAP);
        if Button::new(texts::VIEW_ITS_MAP).icon(icon::EYE).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::ViewMap(Some(map)));
        }
        return None;
    }
    if on_screen.is_none() {
        widgets::sentence(ui, tokens, texts::NO_MAP);
    }
    let on_screen = on_screen?;
    let tools = [
        (texts::ADD_NODES, icon::PLUS, GraphTool::AddNodes),
        (texts::CONNECT, icon::GRAPH, GraphTool::Connect),
    ];
    for (name, sign, tool) in tools {
        let is_on = model.graph_tool() == Some(tool);
        let has_ends = tool == GraphTool::AddNodes || site.nodes().count() > 1;
        if Button::new(name).icon(sign).on(is_on).enabled(has_ends).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::UseGraphTool((!is_on).then_some(tool)));
        }
    }
    if site.nodes().next().is_none() {
        widgets::remark(ui, tokens, texts::EMPTY);
    }
    Some(on_screen)
}

impl SiteGraphPanel {
    fn show_node(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, node: &Node) {
        let tokens = cx.tokens;
        widgets::rule(ui, tokens);
        widgets::section_head(ui, tokens, texts::NODE_HEAD);
        if let Some(name) = self.name.show(ui, cx, &texts::NAME_FIELD, ObjectId::Node(node.id), &node.name) {
            let edit = cx.model.site.changing_node(node.id, |node| node.name = name);
            cx.commands.push(ClientCommand::EditSite(edit));
        }
        fact(ui, tokens, texts::POSITION, &texts::position(node));
        for kinds in texts::KINDS.chunks(2) {
            widgets::choice(ui, tokens, kinds, node.kind, |kind| {
                let edit = cx.model.site.changing_node(node.id, |node| node.kind = kind);
                cx.commands.push(ClientCommand::EditSite(edit));
            });
        }
        // Of a pair of edges the one that leads away stands for both.
        let leads_here_only = |edge: &Edge| edge.to == node.id && both_ways(site, edge).count() == 1;
        for edge in site.edges().filter(|edge| edge.from == node.id || leads_here_only(edge)) {
            let [from, to] = [name_of(site, edge.from), name_of(site, edge.to)];
            let row = texts::edge_row(from, to, length_m(site, edge));
            let name = texts::edge(from, to);
            if Button::new(&name).text(&row).kind(Kind::Quiet).wide(ui).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::Select(Some(Selection::Edge(edge.id))));
            }
        }
        let needed = site.missions_that_need(ObjectId::Node(node.id));
        let names: Vec<&str> =
            needed.iter().filter_map(|id| Some(site.mission(*id)?.name.as_str())).collect();
        if !names.is_empty() {
            widgets::remark(ui, tokens, &texts::needed_by(&names));
        }
        let name = texts::delete_node(&node.name);
        let delete = Button::new(&name).text(texts::DELETE_SHORT).icon(icon::TRASH).kind(Kind::Danger);
        if delete.wide(ui).show(ui, tokens).clicked() {
            remove(cx, ObjectId::Node(node.id));
        }
    }

    /// The problems of the graph; a click selects the object. They are looked for once for each change of the site.
    fn show_problems(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) {
        let revision = cx.model.site.revision();
        if self.problems.as_ref().is_none_or(|(of, _)| *of != revision) {
            self.problems = Some((revision, site.problems(&ValidationConfig::default())));
        }
        let Some((_, problems)) = &self.problems else { return };
        let of_graph: Vec<(&Problem, Selection)> =
            problems.iter().filter_map(|problem| Some((problem, selection_of(problem.object)?))).collect();
        if of_graph.is_empty() {
            return;
        }
        let tokens = cx.tokens;
        widgets::rule(ui, tokens);
        widgets::section_head(ui, tokens, texts::PROBLEMS_HEAD);
        for (problem, selection) in of_graph.into_iter().take(MAX_PROBLEMS) {
            let sentence = texts::problem(problem, &object_name(site, selection));
            let sign =
                if problem.kind.severity() == Severity::Error { icon::X_CIRCLE } else { icon::WARNING };
            if Button::new(&sentence).icon(sign).kind(Kind::Quiet).wide(ui).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::Select(Some(selection)));
            }
        }
    }
}

fn show_edge(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, edge: &Edge) {
    let (model, tokens) = (cx.model, cx.tokens);
    widgets::rule(ui, tokens);
    widgets::section_head(ui, tokens, texts::EDGE_HEAD);
    let ends = texts::ends(name_of(site, edge.from), name_of(site, edge.to));
    fact(ui, tokens, &ends, &format::distance(length_m(site, edge)));
    let both: BTreeSet<EdgeId> = both_ways(site, edge).map(|edge| edge.id).collect();
    if Button::new(texts::ENABLED).on(edge.is_enabled).wide(ui).show(ui, tokens).clicked() {
        let mut edit = client_model::SiteEdit::default();
        for id in &both {
            edit.put.extend(model.site.changing_edge(*id, |it| it.is_enabled = !edge.is_enabled).put);
        }
        cx.commands.push(ClientCommand::EditSite(edit));
    }
    let is_pair = both.len() > 1;
    if Button::new(texts::BOTH_WAYS).on(is_pair).wide(ui).show(ui, tokens).clicked() {
        let edit = if is_pair {
            let back = both.iter().filter(|id| **id != edge.id).map(|id| ObjectId::Edge(*id));
            client_model::SiteEdit { put: Vec::new(), removed: back.collect() }
        } else {
            model.site.connecting(edge.from, edge.to)
        };
        cx.commands.push(ClientCommand::EditSite(edit));
    }
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
        cx.commands.push(ClientCommand::EditSite(client_model::SiteEdit { put: Vec::new(), removed }));
        cx.commands.push(ClientCommand::Select(None));
    }
}

/// An edge, and the one that leads back if there is one.
fn both_ways<'a>(site: &'a Site, edge: &'a Edge) -> impl Iterator<Item = &'a Edge> {
    site.edges().filter(|it| it.id == edge.id || (it.from == edge.to && it.to == edge.from))
}

fn remove(cx: &mut PanelContext<'_>, object: ObjectId) {
    let edit = client_model::SiteEdit { put: Vec::new(), removed: vec![object] };
    cx.commands.push(ClientCommand::EditSite(edit));
    cx.commands.push(ClientCommand::Select(None));
}

/// What the scene selects for an object; `None` for what it does not show.
fn selection_of(object: ObjectId) -> Option<Selection> {
    match object {
        ObjectId::Node(node) => Some(Selection::Node(node)),
        ObjectId::Edge(edge) => Some(Selection::Edge(edge)),
        ObjectId::InspectionPoint(point) => Some(Selection::InspectionPoint(point)),
        _ => None,
    }
}

fn object_name(site: &Site, selection: Selection) -> String {
    match selection {
        Selection::Node(node) if name_of(site, node).trim().is_empty() => texts::UNNAMED.to_owned(),
        Selection::Node(node) => name_of(site, node).to_owned(),
        Selection::Edge(edge) => site
            .edge(edge)
            .map_or_else(String::new, |edge| texts::ends(name_of(site, edge.from), name_of(site, edge.to))),
        Selection::InspectionPoint(point) => {
            site.inspection_point(point).map_or_else(String::new, |point| point.name.clone())
        }
        _ => String::new(),
    }
}

/// Name of a node; a question mark where there is none of this id.
pub(crate) fn name_of(site: &Site, node: NodeId) -> &str {
    site.node(node).map_or("?", |node| node.name.as_str())
}

/// Straight length of an edge, metres; 0 without its nodes.
fn length_m(site: &Site, edge: &Edge) -> f64 {
    let position = |node| site.node(node).map(|node| node.map_from_node.position);
    let (Some(a), Some(b)) = (position(edge.from), position(edge.to)) else { return 0.0 };
    (a.x - b.x).hypot(a.y - b.y).hypot(a.z - b.z)
}
