//! Dragging tasks: with the pointer over the list, which scrolls at its edges, or by keys.

use crate::feature_panel::PanelContext;
use crate::features::mission_task::{push_command, push_edit};
use client_model::{DraggedTasks, MissionEditorCommand, TaskDrag};
use egui::{Context, Id, Key, Rect, Ui, Vec2};
use site_model::{Mission, TaskId};
use std::collections::BTreeSet;

/// Height of a row, points.
pub(super) const ROW_HEIGHT: f32 = 52.0;
/// Distance between rows, points.
pub(super) const GAP: f32 = 6.0;
/// Distance from row to row, points.
const PITCH: f32 = ROW_HEIGHT + GAP;

/// Parameters of dragging tasks.
struct TaskDragConfig {
    /// Distance from the edge of the list within which a drag scrolls it, points. Chosen: the size of a button for fingers.
    scroll_edge_pt: f32,
    /// Greatest speed of that scrolling, points per second. Chosen: 12 rows a second.
    max_scroll_pt_s: f32,
    /// Distance beside the list within which tasks are still dropped into it, points. Chosen: hands are not exact.
    drop_distance_pt: f32,
}

const CONFIG: TaskDragConfig =
    TaskDragConfig { scroll_edge_pt: 44.0, max_scroll_pt_s: 700.0, drop_distance_pt: 28.0 };

/// A drag by keys.
#[derive(Debug)]
pub(super) struct KeyboardDrag {
    /// The handle that has the focus meanwhile.
    pub(super) handle: Id,
    /// Whether the model has it.
    pub(super) has_begun: bool,
}

impl KeyboardDrag {
    /// The arrow keys move the tasks by one place. Another focus drops them. Returns whether the drag has ended.
    pub(super) fn follow_keys(&self, ctx: &Context, cx: &mut PanelContext<'_>) -> bool {
        let Some(drag) = cx.model.missions.drag().cloned() else { return true };
        if ctx.memory(|memory| memory.focused()) != Some(self.handle) {
            drop_tasks(cx);
            return true;
        }
        // While the handle has the focus, the frame leaves Escape to it.
        if ctx.input(|input| input.key_pressed(Key::Escape)) {
            push_command(cx, MissionEditorCommand::EndDrag);
            return true;
        }
        let filter =
            egui::EventFilter { vertical_arrows: true, escape: true, ..egui::EventFilter::default() };
        ctx.memory_mut(|memory| memory.set_focus_lock_filter(self.handle, filter));
        let (up, down) =
            ctx.input(|input| (input.key_pressed(Key::ArrowUp), input.key_pressed(Key::ArrowDown)));
        let others = cx.model.missions.plan().map_or(0, |plan| others(&plan.mission, &drag.what));
        let before = drag.index.unwrap_or(0);
        let index = match (up, down) {
            (true, false) => before.saturating_sub(1),
            (false, true) => (before + 1).min(others),
            _ => before,
        };
        if drag.index != Some(index) {
            push_command(cx, MissionEditorCommand::Drag(TaskDrag { index: Some(index), ..drag }));
        }
        false
    }
}

/// The tasks that a drag from one of them moves: all that are selected, if it is one of these.
pub(super) fn dragged_from(cx: &PanelContext<'_>, task: TaskId) -> BTreeSet<TaskId> {
    let selected = cx.model.missions.selected();
    if selected.contains(&task) { selected.clone() } else { BTreeSet::from([task]) }
}

/// Begins to drag tasks from where the first of them is.
pub(super) fn begin(cx: &mut PanelContext<'_>, mission: &Mission, tasks: BTreeSet<TaskId>) {
    let first = mission.tasks.iter().position(|task| tasks.contains(&task.id));
    push_command(
        cx,
        MissionEditorCommand::Drag(TaskDrag { what: DraggedTasks::Listed(tasks), index: first }),
    );
}

/// Ends the drag where it is: one edit, unless nothing is changed.
pub(super) fn drop_tasks(cx: &mut PanelContext<'_>) {
    let model = cx.model;
    let edit = model.missions.dropping(&model.site);
    // Whoever drops a new task wants to say more about it.
    let is_new =
        matches!(model.missions.drag(), Some(TaskDrag { what: DraggedTasks::New(_), index: Some(_) }));
    let new = is_new.then(|| TaskId(model.site.new_id(0)));
    push_edit(cx, edit);
    push_command(cx, MissionEditorCommand::EndDrag);
    if let Some(new) = new {
        push_command(cx, MissionEditorCommand::Select(BTreeSet::from([new])));
    }
}

/// Number of tasks of a shown mission that are not dragged.
fn others(mission: &Mission, what: &DraggedTasks) -> usize {
    match what {
        DraggedTasks::Listed(tasks) => mission.tasks.iter().filter(|task| !tasks.contains(&task.id)).count(),
        DraggedTasks::New(_) => mission.tasks.len(),
    }
}

/// The pointer drags over the list, whose first row is at `top`, or drops what it has dragged. The list scrolls near its edges. Returns whether the drag has ended.
pub(super) fn follow_pointer(ui: &Ui, cx: &mut PanelContext<'_>, top: f32, new_task: TaskId) -> bool {
    let Some(drag) = cx.model.missions.drag().cloned() else { return true };
    let Some(plan) = cx.model.missions.plan() else { return true };
    let (pointer, is_down) = ui.input(|input| (input.pointer.latest_pos(), input.pointer.any_down()));
    let list = ui.clip_rect();
    let shown = others(&plan.mission, &drag.what);
    let is_counted = matches!(drag.what, DraggedTasks::New(_))
        && plan.mission.tasks.iter().any(|task| task.id == new_task);
    let others = shown - usize::from(is_counted);
    let index = pointer.map(|at| {
        let is_over = list.expand(CONFIG.drop_distance_pt).contains(at);
        let row = ((at.y - top) / PITCH).floor().max(0.0) as usize;
        is_over.then(|| row.min(others))
    });
    match index {
        Some(index) if index != drag.index => {
            push_command(cx, MissionEditorCommand::Drag(TaskDrag { index, ..drag }));
            ui.request_repaint();
        }
        _ if !is_down => {
            drop_tasks(cx);
            return true;
        }
        _ => {}
    }
    if let Some(at) = pointer.filter(|_| is_down) {
        scroll_at_edge(ui, list, at);
    }
    false
}

fn scroll_at_edge(ui: &Ui, list: Rect, at: egui::Pos2) {
    if !list.expand(CONFIG.drop_distance_pt).contains(at) {
        return;
    }
    let into = |distance: f32| ((CONFIG.scroll_edge_pt - distance) / CONFIG.scroll_edge_pt).clamp(0.0, 1.0);
    let speed = into(at.y - list.top()) - into(list.bottom() - at.y);
    if speed != 0.0 {
        let seconds = ui.input(|input| input.stable_dt).min(0.1);
        ui.scroll_with_delta_animation(
            Vec2::new(0.0, speed * CONFIG.max_scroll_pt_s * seconds),
            egui::style::ScrollAnimation::none(),
        );
        ui.request_repaint();
    }
}
