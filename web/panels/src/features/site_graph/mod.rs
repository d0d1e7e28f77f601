//! The topological map: adding and joining nodes, what is selected of it, and its problems.

mod closures;
mod docks;
mod edge;
mod edge_actions;
mod edge_policy;
mod edge_routing;
mod facts;
mod generation;
mod group;
mod influence;
mod moment;
mod node;
#[cfg(test)]
mod tests;
mod texts;

pub(crate) use closures::show_all as show_closures;
pub(crate) use facts::name_of;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::message::show_message;
use crate::widgets::{self, fact};
use crate::{icon, screens};
use client_model::{ClientCommand, GraphTool, Selection};
use edge::EdgeSection;
use egui::{Key, Ui};
use facts::missing_name;
use generation::GenerationSection;
use group::GroupSection;
use node::NodeSection;
use site_model::{ObjectId, ProblemSeverity, Site, SiteProblem, ValidationConfig};
use vocab::MapId;

/// The tab of the topological map.
const GRAPH: Tab = Tab { screen: screens::SITE, name: texts::TAB, scrolls: true, row_spacing: 8.0 };
/// How many problems are listed.
#[derive(Clone, Copy, Debug)]
struct ProblemListConfig {
    /// Largest number of problems that are listed at once. Chosen: the whole list is laid out in each frame, and people mend one after the other.
    max_problems: usize,
}

const LISTS: ProblemListConfig = ProblemListConfig { max_problems: 30 };

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct SiteGraphPanel {
    node: NodeSection,
    edge: EdgeSection,
    group: GroupSection,
    /// Problems of the site, with the revision that they were found in.
    problems: Option<(u64, Vec<SiteProblem>)>,
    generation: GenerationSection,
}

impl FeaturePanel for SiteGraphPanel {
    fn update(&mut self, ctx: &egui::Context, cx: &mut PanelContext<'_>) {
        // A tool works on its screen only, so that no click elsewhere edits anything.
        if cx.model.graph_tool().is_some() && cx.screen() != screens::SITE {
            cx.commands.push(ClientCommand::UseGraphTool(None));
        }
        // Elsewhere nothing says that other floors are hidden.
        if cx.model.site.shown_floor().is_some() && cx.screen() != screens::SITE {
            cx.commands.push(ClientCommand::ShowFloor(None));
        }
        if crate::is_editing_graph(cx.model) && !ctx.egui_wants_keyboard_input() {
            follow_keys(ctx, cx);
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
        if let Some(obstruction) = &cx.frame.scene_drag.obstruction {
            let sentence = texts::obstructed(obstruction);
            return show_message(ui, cx.tokens, cx.tokens.bad, icon::WARNING_OCTAGON, &sentence, |_| {});
        }
        let hint = match cx.model.graph_tool() {
            Some(GraphTool::AddNodes) => texts::ADD_HINT,
            Some(GraphTool::Connect) => texts::CONNECT_HINT,
            Some(GraphTool::SelectSeveral) => texts::SELECT_HINT,
            // Their hints are those of inspection points and zones.
            Some(GraphTool::AddInspectionPoints | GraphTool::PickTarget | GraphTool::DrawZone) | None => {
                return;
            }
        };
        // Whoever ends a tool has no danger in mind.
        cx.frame.is_escape_consumed = true;
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
        let selected = cx.model.selected_nodes();
        match cx.model.selection() {
            Some(Selection::Node(node)) => {
                if let Some(node) = site.node(node) {
                    self.node.show(ui, cx, site, node);
                }
            }
            Some(Selection::Edge(edge)) => {
                if let Some(edge) = site.edge(edge) {
                    self.edge.show(ui, cx, site, edge);
                }
            }
            None if selected.is_empty() => docks::show_list(ui, cx, site),
            None if selected.len() > 1 => self.group.show(ui, cx, site, &selected),
            _ => {}
        }
        closures::show_all(ui, cx, site);
        self.show_problems(ui, cx, site);
    }
}

/// Delete deletes what is selected, and Ctrl A selects all nodes that are shown.
fn follow_keys(ctx: &egui::Context, cx: &mut PanelContext<'_>) {
    let (delete, all) = ctx.input(|input| {
        let delete = input.key_pressed(Key::Delete) || input.key_pressed(Key::Backspace);
        (delete, input.modifiers.command && input.key_pressed(Key::A))
    });
    let site = &cx.model.site;
    if all {
        let nodes = site.shown_nodes().map(|node| node.id).collect();
        cx.commands.push(ClientCommand::SelectNodes(nodes));
    }
    if delete && let Some(edit) = site.removing_selected(cx.model.selection(), &cx.model.selected_nodes()) {
        cx.commands.push(ClientCommand::EditSite(edit));
        cx.commands.push(ClientCommand::Select(None));
    }
}

/// The choice of the floor that is shown, where there are several.
fn show_floors(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let floors = cx.model.site.floors();
    if floors.len() < 2 {
        return;
    }
    let shown = cx.model.site.shown_floor();
    let names: Vec<(String, Option<i32>)> = std::iter::once((texts::ALL_FLOORS.to_owned(), None))
        .chain(floors.into_iter().map(|floor| (texts::floor(floor), Some(floor))))
        .collect();
    let choices: Vec<(&str, Option<i32>)> =
        names.iter().map(|(name, floor)| (name.as_str(), *floor)).collect();
    for choices in choices.chunks(3) {
        widgets::choice(ui, cx.tokens, choices, shown, |floor| {
            cx.commands.push(ClientCommand::ShowFloor(floor))
        });
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
        (texts::SELECT_SEVERAL, icon::CORNERS_OUT, GraphTool::SelectSeveral),
    ];
    ui.horizontal(|ui| {
        let gap = 6.0;
        ui.spacing_mut().item_spacing.x = gap;
        let width = ((ui.available_width() + gap) / tools.len() as f32 - gap).floor();
        for (name, sign, tool) in tools {
            let is_on = model.graph_tool() == Some(tool);
            let has_nodes = tool == GraphTool::AddNodes || site.nodes().count() > 1;
            let button = Button::new(name).icon(sign).on(is_on).enabled(has_nodes).stacked();
            if button.size(width, 60.0).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::UseGraphTool((!is_on).then_some(tool)));
            }
        }
    });
    if site.nodes().next().is_none() {
        widgets::remark(ui, tokens, texts::EMPTY);
    }
    show_floors(ui, cx);
    Some(on_screen)
}

impl SiteGraphPanel {
    /// The problems of the graph; a click selects the object. They are looked for once for each change of the site.
    fn show_problems(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site) {
        let revision = cx.model.site.revision();
        if self.problems.as_ref().is_none_or(|(of, _)| *of != revision) {
            self.problems = Some((revision, site.problems(&ValidationConfig::default())));
        }
        let Some((_, problems)) = &self.problems else { return };
        let of_graph: Vec<(&SiteProblem, Selection)> =
            problems.iter().filter_map(|problem| Some((problem, selection_of(problem.object)?))).collect();
        if of_graph.is_empty() {
            return;
        }
        let tokens = cx.tokens;
        widgets::rule(ui, tokens);
        widgets::section_head(ui, tokens, texts::PROBLEMS_HEAD);
        for (problem, selection) in of_graph.into_iter().take(LISTS.max_problems) {
            let sentence = texts::problem(problem, &object_name(site, selection));
            let sign = if problem.kind.severity() == ProblemSeverity::Error {
                icon::X_CIRCLE
            } else {
                icon::WARNING
            };
            if Button::new(&sentence).icon(sign).kind(Kind::Quiet).wide(ui).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::Select(Some(selection)));
            }
        }
    }
}

/// What the scene selects for an object; `None` for what it does not show.
fn selection_of(object: ObjectId) -> Option<Selection> {
    match object {
        ObjectId::Node(node) => Some(Selection::Node(node)),
        ObjectId::Edge(edge) => Some(Selection::Edge(edge)),
        ObjectId::InspectionPoint(point) => Some(Selection::InspectionPoint(point)),
        ObjectId::Zone(zone) => Some(Selection::Zone(zone)),
        _ => None,
    }
}

fn object_name(site: &Site, selection: Selection) -> String {
    match selection {
        Selection::Node(node) => missing_name(name_of(site, node)).to_owned(),
        Selection::Edge(edge) => site
            .edge(edge)
            .map_or_else(String::new, |edge| texts::ends(name_of(site, edge.from), name_of(site, edge.to))),
        Selection::InspectionPoint(point) => {
            site.inspection_point(point).map_or_else(String::new, |point| point.name.clone())
        }
        Selection::Zone(zone) => {
            site.zones().find(|it| it.id == zone).map_or_else(String::new, |zone| zone.name.clone())
        }
        _ => String::new(),
    }
}
