//! What holds for the whole mission: the order of its tasks, and where the robot goes afterwards.

use super::texts;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::features::action_form::show_problem;
use crate::features::mission_task::{self, push_edit};
use crate::select::select;
use crate::theme;
use crate::widgets;
use client_model::{MissionPlan, PlanStart};
use egui::Ui;
use site_model::{Mission, MissionEnd, NodeId, Site, TaskOrder};

/// Shows both.
pub(super) fn show(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    site: &Site,
    mission: &Mission,
    plan: &MissionPlan,
) {
    if mission.tasks.is_empty() && plan.mission.tasks.is_empty() {
        return;
    }
    show_end_text(ui, cx, site, plan);
    let mut changed = mission.clone();
    show_order(ui, cx, &mut changed, plan);
    show_end(ui, cx, site, &mut changed);
    push_edit(cx, cx.model.site.changing_mission(mission.id, |mission| *mission = changed));
}

fn show_order(ui: &mut Ui, cx: &mut PanelContext<'_>, mission: &mut Mission, plan: &MissionPlan) {
    let tokens = cx.tokens;
    widgets::section_head(ui, tokens, texts::ORDER_HEAD);
    let is_shortest = mission.order != TaskOrder::AsListed;
    let before = mission.order;
    widgets::choice(
        ui,
        tokens,
        &[(texts::AS_LISTED, false), (texts::SHORTEST, true)],
        is_shortest,
        |shortest| {
            mission.order = match (shortest, before) {
                (false, _) => TaskOrder::AsListed,
                (true, TaskOrder::AsListed) => TaskOrder::Shortest { keep_first: false, keep_last: false },
                (true, kept) => kept,
            };
        },
    );
    let TaskOrder::Shortest { keep_first, keep_last } = before else { return };
    widgets::remark(ui, tokens, texts::SHORTEST_HINT);
    if let Some(gain) = &plan.gain {
        widgets::remark(ui, tokens, &texts::always_gains(gain.saved.time_s));
    }
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        let width = ((ui.available_width() - 6.0) / 2.0).floor();
        for (name, is_on, toggled) in [
            (texts::KEEP_FIRST, keep_first, TaskOrder::Shortest { keep_first: !keep_first, keep_last }),
            (texts::KEEP_LAST, keep_last, TaskOrder::Shortest { keep_first, keep_last: !keep_last }),
        ] {
            let button = Button::new(name).on(is_on).slim().size(width, theme::TOUCH);
            if button.show(ui, tokens).clicked() {
                mission.order = toggled;
            }
        }
    });
}

fn show_end(ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, mission: &mut Mission) {
    let tokens = cx.tokens;
    widgets::section_head(ui, tokens, texts::END_HEAD);
    let nodes = mission_task::nodes(site);
    let node = match mission.end {
        MissionEnd::Node(node) => Some(node),
        MissionEnd::NearestDock | MissionEnd::Stay => None,
    };
    let mut choices = texts::ENDS.to_vec();
    if let Some(first) = node.or_else(|| nodes.first().map(|node| node.id)) {
        choices.push((texts::NODE_CHOICE, MissionEnd::Node(first)));
    }
    widgets::choice(ui, tokens, &choices, mission.end, |end| mission.end = end);
    let Some(node) = node else { return };
    let options: Vec<String> = nodes.iter().map(|node| node.name.clone()).collect();
    if let Some(index) = select(ui, tokens, texts::END_NODE, texts::END_NODE, name_of(site, node), &options) {
        mission.end = MissionEnd::Node(nodes[index].id);
    }
}

/// The route after the last task, with its time or why there is none.
fn show_end_text(ui: &mut Ui, cx: &PanelContext<'_>, site: &Site, plan: &MissionPlan) {
    let text = match plan.end.route.last() {
        Some(node) => {
            let dock = site.docks().find(|dock| dock.node == *node).map(|dock| dock.name.as_str());
            let place = dock.unwrap_or_else(|| name_of(site, *node));
            format!("{} · {}", texts::back_to(place), texts::time(plan.end.walk.time_s))
        }
        None => texts::STAYS.to_owned(),
    };
    match &plan.end.problem {
        None => widgets::remark(ui, cx.tokens, &text),
        Some(problem) => {
            show_problem(ui, cx.tokens, &mission_task::end_problem(site, problem));
        }
    }
}

/// Where the route begins.
pub(super) fn start_text(site: &Site, plan: &MissionPlan) -> String {
    match plan.start {
        None if plan.mission.tasks.is_empty() => texts::EMPTY.to_owned(),
        None => texts::NO_START.to_owned(),
        Some((PlanStart::Dock(id), _)) => {
            let dock = site.docks().find(|dock| dock.id == id);
            texts::from_dock(dock.map_or("", |dock| dock.name.as_str()))
        }
        Some((PlanStart::Robot, node)) => texts::from_robot(name_of(site, node)),
        Some((PlanStart::FirstTask, node)) => texts::from_task(name_of(site, node)),
    }
}

fn name_of(site: &Site, node: NodeId) -> &str {
    site.node(node).map_or("?", |node| node.name.as_str())
}
