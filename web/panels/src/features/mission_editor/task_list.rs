//! The list of tasks: rows that are selected, unfolded and dragged.

use super::dragging::{self, KeyboardDrag, ROW_HEIGHT};
use super::texts;
use crate::feature_panel::PanelContext;
use crate::features::action_form::show_problem;
use crate::features::mission_task::row::{Mark, RowResponse, TaskRow};
use crate::features::mission_task::{self, TaskForm, push_command, show_buttons};
use crate::theme::{self, Tokens};
use crate::{format, layout, widgets};
use client_model::{DraggedTasks, MissionEditorCommand, MissionPlan, StopProblem};
use egui::{Context, CornerRadius, Id, Key, Order, Sense, Ui, vec2};
use site_model::{Site, Task, TaskId};
use std::collections::BTreeSet;

/// What the list keeps between frames.
#[derive(Debug, Default)]
pub(super) struct TaskList {
    form: TaskForm,
    /// A drag by keys.
    keyboard: Option<KeyboardDrag>,
    /// Whether the drag has ended here, and the model does not know it yet.
    is_dropped: bool,
    /// The task from which a range of tasks is selected.
    range_from: Option<TaskId>,
}

impl TaskList {
    /// Whether keys move tasks.
    pub(super) fn is_moved_by_keys(&self) -> bool {
        self.keyboard.is_some()
    }

    /// Reads the keys of a drag. A drag ends when the list is hidden.
    pub(super) fn follow_keys(&mut self, ctx: &Context, cx: &mut PanelContext<'_>, is_shown: bool) {
        if cx.model.missions.drag().is_none() {
            self.is_dropped = false;
            self.keyboard.take_if(|keyboard| keyboard.has_begun);
        } else if self.is_dropped {
            // It ends with this frame's commands.
        } else if !is_shown {
            push_command(cx, MissionEditorCommand::EndDrag);
        } else if let Some(keyboard) = &mut self.keyboard {
            keyboard.has_begun = true;
            self.is_dropped = keyboard.follow_keys(ctx, cx);
        }
    }

    /// Shows the list as it would be if the drag ended now.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, plan: &MissionPlan) {
        let drag = cx.model.missions.drag();
        let new_task = TaskId(cx.model.site.new_id(0));
        let selected = cx.model.missions.selected();
        if selected.len() > 1 {
            show_selected(ui, cx, plan);
        }
        let top = ui.cursor().top();
        let is_dragged = |task: &Task| match drag.map(|drag| &drag.what) {
            Some(DraggedTasks::Listed(tasks)) => tasks.contains(&task.id),
            Some(DraggedTasks::New(_)) => task.id == new_task,
            None => false,
        };
        for (index, task) in plan.mission.tasks.iter().enumerate() {
            let response = show_row(ui, cx, site, plan, task, is_dragged(task));
            self.react(ui, cx, plan, task, index, &response);
            // Rows of one height make the place under the pointer that of the drop.
            let is_unfolded = drag.is_none() && selected.len() == 1 && selected.contains(&task.id);
            if is_unfolded {
                ui.push_id(task.id.0, |ui| self.show_form(ui, cx, site, plan, task));
            }
        }
        if plan.mission.tasks.is_empty() {
            show_empty(ui, cx.tokens, drag.is_some());
        }
        if drag.is_some() && self.keyboard.is_none() && !self.is_dropped {
            self.is_dropped = dragging::follow_pointer(ui, cx, top, new_task);
            show_ghost(ui, cx, site, plan);
        }
    }

    /// A press selects, with Ctrl one more, with Shift all up to it. A drag moves. A key on the handle lets the arrow keys move.
    fn react(
        &mut self,
        ui: &Ui,
        cx: &mut PanelContext<'_>,
        plan: &MissionPlan,
        task: &Task,
        index: usize,
        response: &RowResponse,
    ) {
        let missions = &cx.model.missions;
        if missions.drag().is_some() {
            if self.keyboard.is_some() && response.handle.clicked() {
                self.keyboard = None;
                self.is_dropped = true;
                dragging::drop_tasks(cx);
            }
            return;
        }
        let is_by_pointer = ui.input(|input| input.pointer.any_released() || input.pointer.any_down());
        if response.drag_started() {
            let tasks = dragging::dragged_from(cx, task.id);
            dragging::begin(cx, &plan.mission, tasks);
        } else if response.handle.clicked() && !is_by_pointer {
            self.keyboard = Some(KeyboardDrag { handle: response.handle.id, has_begun: false });
            let tasks = dragging::dragged_from(cx, task.id);
            dragging::begin(cx, &plan.mission, tasks);
        } else if response.body.clicked() {
            let (ctrl, shift) = ui.input(|input| (input.modifiers.command, input.modifiers.shift));
            let from =
                self.range_from.and_then(|from| plan.mission.tasks.iter().position(|it| it.id == from));
            let mut selected = missions.selected().clone();
            match from.filter(|_| shift) {
                Some(from) => {
                    let range = from.min(index)..=from.max(index);
                    selected = plan.mission.tasks[range].iter().map(|task| task.id).collect();
                }
                None if ctrl => {
                    if !selected.remove(&task.id) {
                        selected.insert(task.id);
                    }
                }
                None if selected == BTreeSet::from([task.id]) => selected.clear(),
                None => selected = BTreeSet::from([task.id]),
            }
            if !shift {
                self.range_from = Some(task.id);
            }
            push_command(cx, MissionEditorCommand::Select(selected));
        } else if response.body.has_focus() && ui.input(|input| input.key_pressed(Key::Delete)) {
            let tasks = dragging::dragged_from(cx, task.id);
            let edit = cx.model.site.deleting_tasks(plan.mission.id, &tasks);
            mission_task::push_edit(cx, edit);
        }
    }

    fn show_form(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        site: &Site,
        plan: &MissionPlan,
        task: &Task,
    ) {
        let tokens = cx.tokens;
        let frame =
            egui::Frame::new().fill(tokens.raised).corner_radius(CornerRadius::same(theme::BUTTON_RADIUS));
        frame.inner_margin(10).show(ui, |ui| {
            ui.set_width(ui.available_width());
            let problem = plan.stop_of(task.id).and_then(|(_, stop)| stop.problem.as_ref());
            // What is wrong with a parameter stands below its field.
            let is_of_field = matches!(problem, Some(StopProblem::Parameter(..)));
            if let Some(problem) = problem.filter(|_| !is_of_field) {
                show_problem(ui, tokens, &mission_task::stop_problem(site, problem));
            }
            self.form.show(ui, cx, site, plan.mission.id, task);
        });
    }
}

/// What can be done with several tasks.
fn show_selected(ui: &mut Ui, cx: &mut PanelContext<'_>, plan: &MissionPlan) {
    let selected = cx.model.missions.selected();
    widgets::tinted_box(ui, cx.tokens, cx.tokens.accent, |ui| {
        widgets::sentence(ui, cx.tokens, &texts::selected(selected.len()));
        show_buttons(ui, cx, plan.mission.id, selected);
    });
}

fn show_row(
    ui: &mut Ui,
    cx: &PanelContext<'_>,
    site: &Site,
    plan: &MissionPlan,
    task: &Task,
    is_target: bool,
) -> RowResponse {
    let tokens = cx.tokens;
    let (number, stop) = match plan.stop_of(task.id) {
        Some((number, stop)) => (number, Some(stop)),
        None => (0, None),
    };
    let title = mission_task::title(site, task);
    let action = mission_task::action(site, task);
    let before: Vec<usize> = plan
        .mission
        .order_constraints
        .iter()
        .filter(|[_, second]| *second == task.id)
        .filter_map(|[first, _]| plan.stop_of(*first).map(|(number, _)| number))
        .collect();
    let noted = texts::noted(&action, &before);
    let problem = stop.and_then(|stop| stop.problem.as_ref()).map(|problem| {
        let sentence = mission_task::stop_problem(site, problem);
        match problem {
            StopProblem::Parameter(..) => texts::of_action(&action, &sentence),
            StopProblem::NoPlace | StopProblem::NoDock | StopProblem::NoRoute(..) => sentence,
        }
    });
    let time = stop.filter(|stop| stop.problem.is_none());
    let value = time.map_or_else(String::new, |stop| format::elapsed(stop.walk.time_s + stop.action_s));
    let colour = if problem.is_some() { tokens.bad } else { tokens.accent };
    let is_selected = cx.model.missions.selected().contains(&task.id) && cx.model.missions.drag().is_none();
    let (name, handle_name) = (texts::task(number, &title), texts::move_task(number, &title));
    let row = TaskRow {
        name: &name,
        handle_name: Some(&handle_name),
        mark: Mark::Number(number, colour),
        title: &title,
        note: match &problem {
            Some(problem) => (problem, tokens.bad),
            None => (&noted, tokens.dim),
        },
        value: &value,
        edge: if problem.is_some() || is_selected { colour } else { tokens.line },
        is_selected: Some(is_selected),
        is_target,
    };
    let response = row.show(ui, tokens, Id::unique(("task", task.id.0)), ROW_HEIGHT);
    if let Some(problem) = problem {
        let place =
            egui::Rect::from_min_max(response.body.rect.left_center(), response.body.rect.right_bottom());
        let status = ui.interact(place, Id::unique(("problem", task.id.0)), Sense::hover());
        widgets::status_node(&status, &texts::problem_of(number), &problem);
        status.on_hover_text(&problem);
    }
    response
}

/// The place of the first task.
fn show_empty(ui: &mut Ui, tokens: &Tokens, is_dragging: bool) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 2.0 * ROW_HEIGHT), Sense::hover());
    let inner = rect.shrink(1.0);
    let corners =
        [inner.left_top(), inner.right_top(), inner.right_bottom(), inner.left_bottom(), inner.left_top()];
    let colour = if is_dragging { tokens.accent } else { tokens.line };
    ui.painter().extend(egui::Shape::dashed_line(&corners, egui::Stroke::new(1.5, colour), 6.0, 4.0));
    let text = if is_dragging { texts::DROP_HERE } else { texts::EMPTY };
    let galley = ui.painter().layout(
        text.to_owned(),
        theme::font(theme::SMALL, theme::Weight::Regular),
        tokens.dim,
        rect.width() - 40.0,
    );
    ui.painter().galley(rect.center() - 0.5 * galley.size(), galley, tokens.dim);
}

/// What is dragged, under the pointer, with what it adds.
fn show_ghost(ui: &Ui, cx: &PanelContext<'_>, site: &Site, plan: &MissionPlan) {
    let Some(at) = ui.input(|input| input.pointer.latest_pos()) else { return };
    let Some(drag) = cx.model.missions.drag() else { return };
    let tokens = cx.tokens;
    let (title, note) = match &drag.what {
        DraggedTasks::New(new) => mission_task::entry_texts(site, *new),
        DraggedTasks::Listed(tasks) => {
            let listed: Vec<&Task> =
                plan.mission.tasks.iter().filter(|task| tasks.contains(&task.id)).collect();
            match listed.as_slice() {
                [one] => (mission_task::title(site, one), mission_task::action(site, one)),
                several => (texts::selected(several.len()), String::new()),
            }
        }
    };
    let cost = cx.model.missions.drag_cost().map(|cost| texts::drag_cost(cost.time_s, cost.length_m));
    let width = theme::CARD_WIDTH - 60.0;
    // Below the pointer, so that the place of the drop stays in sight, and within the window.
    let corner = at + vec2(-16.0, 10.0);
    let window = ui.ctx().content_rect().shrink2(vec2(theme::GAP, theme::GAP));
    let corner = corner.clamp(window.min, window.max - vec2(width, ROW_HEIGHT));
    layout::area(texts::DROP_HERE, Order::Tooltip).fixed_pos(corner).interactable(false).show(
        ui.ctx(),
        |ui| {
            let (rect, _) = ui.allocate_exact_size(vec2(width, ROW_HEIGHT), Sense::hover());
            ui.painter()
                .add(theme::drag_shadow(tokens).as_shape(rect, CornerRadius::same(theme::BUTTON_RADIUS)));
            let row = TaskRow {
                name: "",
                handle_name: None,
                mark: Mark::Icon(crate::icon::PLUS),
                title: &title,
                note: (&note, tokens.dim),
                value: cost.as_deref().unwrap_or_default(),
                edge: tokens.accent,
                is_selected: None,
                is_target: true,
            };
            row.paint(ui, tokens, rect, false);
        },
    );
    ui.request_repaint();
}
