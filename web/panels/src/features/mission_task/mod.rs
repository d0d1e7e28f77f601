//! A task of a mission: what it is called, its icon, what is wrong with it, and its form. The list of tasks and the palette use these.

pub(crate) mod order;
mod policy;
pub(crate) mod row;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::features::action_form::{self, TypedParameters};
use crate::select::select;
use crate::theme::Tokens;
use crate::{icon, widgets};
use client_model::{
    ClientCommand, EndProblem, MissionEditorCommand, NewTask, SiteEdit, StopProblem, request_of,
};
use egui::{Id, Ui};
use site_model::{
    ActionRequest, DockAction, InspectionPoint, Mission, MissionId, Node, Object, Parameters, Site, Task,
    TaskId, TaskPlace, actions_at_places,
};
use std::collections::BTreeSet;

/// What the form keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct TaskForm {
    typed: TypedParameters,
}

/// The inspection points of a site, by name.
pub(crate) fn inspection_points(site: &Site) -> Vec<&InspectionPoint> {
    let point = |versioned: &'_ site_model::Versioned| match &versioned.object {
        Object::InspectionPoint(point) => Some(point.id),
        _ => None,
    };
    let mut points: Vec<_> =
        site.objects().filter_map(point).filter_map(|id| site.inspection_point(id)).collect();
    points.sort_by(|a, b| in_order(&a.name, &b.name));
    points
}

/// The nodes of a site, by name.
pub(crate) fn nodes(site: &Site) -> Vec<&Node> {
    let mut nodes: Vec<_> = site.nodes().collect();
    nodes.sort_by(|a, b| in_order(&a.name, &b.name));
    nodes
}

/// The missions of a site, by name.
pub(crate) fn missions_by_name(site: &Site) -> Vec<&Mission> {
    let mut missions: Vec<_> = site.missions().collect();
    missions.sort_by(|a, b| in_order(&a.name, &b.name));
    missions
}

/// The order of names: `N2` comes before `N10`.
fn in_order(a: &str, b: &str) -> std::cmp::Ordering {
    let key = |name: &str| {
        let letters = name.trim_end_matches(|c: char| c.is_ascii_digit());
        (letters.to_lowercase(), name[letters.len()..].parse::<u64>().unwrap_or(0))
    };
    key(a).cmp(&key(b)).then_with(|| a.cmp(b))
}

/// What a task is called: its inspection point or node.
pub(crate) fn title(site: &Site, task: &Task) -> String {
    match &task.place {
        TaskPlace::InspectionPoint(point) => site
            .inspection_point(*point)
            .map_or_else(|| texts::MISSING_POINT.to_owned(), |point| point.name.clone()),
        TaskPlace::Node { node, .. } => {
            site.node(*node).map_or_else(|| texts::MISSING_NODE.to_owned(), |node| node.name.clone())
        }
        TaskPlace::ByAction { request } => dock_title(site, request),
    }
}

/// A task with its number in the list: `2 Pump`.
pub(crate) fn numbered_title(site: &Site, mission: &Mission, task: TaskId) -> String {
    match mission.tasks.iter().enumerate().find(|(_, listed)| listed.id == task) {
        Some((index, listed)) => format!("{} {}", index + 1, title(site, listed)),
        None => texts::MISSING_TASK.to_owned(),
    }
}

/// Where a task docks or undocks.
fn dock_title(site: &Site, request: &ActionRequest) -> String {
    match DockAction::of(request) {
        Some(DockAction::Dock { dock: Some(dock), .. }) => {
            let known = site.docks().find(|known| known.id == dock);
            known.map_or_else(|| action_form::DELETED_DOCK.to_owned(), |dock| dock.name.clone())
        }
        Some(DockAction::Dock { dock: None, .. }) => action_form::NEAREST_DOCK.to_owned(),
        Some(DockAction::Undock) | None => texts::PRESENT_DOCK.to_owned(),
    }
}

/// What is done in a task.
pub(crate) fn action(site: &Site, task: &Task) -> String {
    request_of(site, task)
        .map_or_else(|| texts::VISIT.to_owned(), |request| action_form::action_title(&request.action))
}

/// What an entry of the palette is called, and what would be done.
pub(crate) fn entry_texts(site: &Site, new: NewTask) -> (String, String) {
    match new {
        NewTask::InspectionPoint(id) => {
            let point = site.inspection_point(id);
            let name = point.map_or_else(|| texts::MISSING_POINT.to_owned(), |point| point.name.clone());
            (name, point.map_or_else(String::new, |point| action_form::action_title(&point.request.action)))
        }
        NewTask::Node(node) => (
            site.node(node).map_or_else(|| texts::MISSING_NODE.to_owned(), |node| node.name.clone()),
            texts::VISIT.to_owned(),
        ),
        NewTask::Action(name) => (action_form::action_title(name), String::new()),
    }
}

/// The icon of an action; of a visit, if there is none.
pub(crate) fn icon_of(action: Option<&str>) -> &'static str {
    match action {
        None => icon::MAP_PIN,
        Some("photo") => icon::CAMERA,
        Some("thermal_photo") => icon::THERMOMETER_HOT,
        Some("point_cloud") => icon::CUBE,
        Some("temperature_humidity") => icon::DROP_HALF,
        Some("gamma_spectrum") => icon::RADIOACTIVE,
        Some("wait") => icon::HOURGLASS_MEDIUM,
        Some("message") => icon::CHAT_TEXT,
        Some("dock") => icon::BATTERY_CHARGING,
        Some("undock") => icon::PLUGS,
        Some(_) => icon::PLAY,
    }
}

/// Why a task cannot be done: a sentence.
pub(crate) fn stop_problem(site: &Site, problem: &StopProblem) -> String {
    texts::stop_problem(site, problem)
}

/// Why a mission cannot end where it should: a sentence.
pub(crate) fn end_problem(site: &Site, problem: &EndProblem) -> String {
    texts::end_problem(site, problem)
}

impl TaskForm {
    /// Shows the form of a task: place, action, parameters, policies, and what else can be done with it.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        site: &Site,
        mission: MissionId,
        task: &Task,
    ) {
        let owner = Id::unique(("task", task.id.0));
        self.typed.keep_only(owner);
        let tokens = cx.tokens;
        ui.spacing_mut().item_spacing.y = 6.0;
        let mut changed = task.clone();
        show_place(ui, tokens, site, &mut changed);
        match &task.place {
            TaskPlace::InspectionPoint(_) => widgets::remark(ui, tokens, texts::ACTION_OF_POINT),
            TaskPlace::ByAction { request } => {
                if let Some(parameters) = self.typed.show(ui, cx, owner, request, false) {
                    changed.place =
                        TaskPlace::ByAction { request: ActionRequest { parameters, ..request.clone() } };
                }
            }
            TaskPlace::Node { node, request } => {
                if let Some(request) = show_action(ui, tokens, request.as_ref()) {
                    changed.place = TaskPlace::Node { node: *node, request };
                } else if let Some(request) = request {
                    if let Some(parameters) = self.typed.show(ui, cx, owner, request, false) {
                        let request = Some(ActionRequest { parameters, ..request.clone() });
                        changed.place = TaskPlace::Node { node: *node, request };
                    } else if cx.model.site.action_forms().fields(&request.action).is_empty() {
                        widgets::remark(ui, tokens, texts::UNKNOWN_ACTION);
                    }
                }
            }
        }
        ui.add_space(4.0);
        if let Some(policy) = policy::show(ui, tokens, texts::UNREACHABLE_HEAD, task.on_unreachable) {
            changed.on_unreachable = policy;
        }
        if request_of(site, task).is_some()
            && let Some(policy) = policy::show(ui, tokens, texts::FAILURE_HEAD, task.on_action_failure)
        {
            changed.on_action_failure = policy;
        }
        if changed != *task {
            let edit = cx.model.site.changing_task(mission, task.id, |task| *task = changed);
            cx.commands.push(ClientCommand::EditSite(edit));
        }
        if let Some(of_site) = site.mission(mission) {
            order::show(ui, cx, site, of_site, task);
        }
        ui.add_space(4.0);
        show_buttons(ui, cx, mission, &BTreeSet::from([task.id]));
    }
}

/// Moving, duplicating and deleting tasks.
pub(crate) fn show_buttons(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    mission: MissionId,
    tasks: &BTreeSet<TaskId>,
) {
    let (model, tokens) = (cx.model, cx.tokens);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        for (name, sign, towards_end) in
            [(texts::MOVE_UP, icon::CARET_UP, false), (texts::MOVE_DOWN, icon::CARET_DOWN, true)]
        {
            if Button::icon_only(name, sign).show(ui, tokens).clicked() {
                push_edit(cx, model.missions.moving_selected(towards_end, &model.site));
            }
        }
        if Button::icon_only(texts::DUPLICATE, icon::COPY).show(ui, tokens).clicked() {
            let (copies, edit) = model.site.duplicating_tasks(mission, tasks);
            push_edit(cx, edit);
            cx.commands.push(ClientCommand::MissionEditor(MissionEditorCommand::Select(copies)));
        }
        if Button::icon_only(texts::DELETE, icon::TRASH).kind(Kind::Danger).show(ui, tokens).clicked() {
            push_edit(cx, model.site.deleting_tasks(mission, tasks));
        }
    });
}

/// Emits a command of the mission editor.
pub(crate) fn push_command(cx: &mut PanelContext<'_>, command: MissionEditorCommand) {
    cx.commands.push(ClientCommand::MissionEditor(command));
}

/// Emits an edit, unless it changes nothing.
pub(crate) fn push_edit(cx: &mut PanelContext<'_>, edit: SiteEdit) {
    if edit != SiteEdit::default() {
        cx.commands.push(ClientCommand::EditSite(edit));
    }
}

/// Where the task is: an inspection point or a node.
fn show_place(ui: &mut Ui, tokens: &Tokens, site: &Site, task: &mut Task) {
    let (points, nodes) = (inspection_points(site), nodes(site));
    let names = points.iter().map(|point| texts::point_option(&point.name));
    let options: Vec<String> = names.chain(nodes.iter().map(|node| texts::node_option(&node.name))).collect();
    let name = title(site, task);
    let shown = match &task.place {
        TaskPlace::InspectionPoint(_) => texts::point_option(&name),
        TaskPlace::Node { .. } => texts::node_option(&name),
        // The action says where it is.
        TaskPlace::ByAction { .. } => return,
    };
    let Some(index) = select(ui, tokens, texts::PLACE, texts::PLACE, &shown, &options) else { return };
    task.place = match points.get(index) {
        Some(point) => TaskPlace::InspectionPoint(point.id),
        None => {
            let request = match &task.place {
                TaskPlace::Node { request, .. } => request.clone(),
                TaskPlace::InspectionPoint(_) | TaskPlace::ByAction { .. } => request_of(site, task).cloned(),
            };
            TaskPlace::Node { node: nodes[index - points.len()].id, request }
        }
    };
}

/// What is done at a node. Returns another request once it is chosen.
fn show_action(
    ui: &mut Ui,
    tokens: &Tokens,
    request: Option<&ActionRequest>,
) -> Option<Option<ActionRequest>> {
    let titles = actions_at_places().iter().map(|action| action.title.to_owned());
    let options: Vec<String> = std::iter::once(texts::NO_ACTION.to_owned()).chain(titles).collect();
    let shown = request
        .map_or_else(|| texts::NO_ACTION.to_owned(), |request| action_form::action_title(&request.action));
    let index = select(ui, tokens, texts::ACTION, texts::ACTION, &shown, &options)?;
    let action = index.checked_sub(1).map(|index| actions_at_places()[index].name);
    let is_same = request.map(|request| request.action.as_str()) == action;
    let new = action.map(|action| ActionRequest { action: action.to_owned(), parameters: Parameters::new() });
    (!is_same).then_some(new)
}
