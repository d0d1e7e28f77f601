//! The mission that the operator edits: which one is open, what is selected and dragged in it, and what it takes to run it. The missions themselves are objects of
//! the site.

mod command;
mod drag;
mod edits;
mod order_edits;
mod plan;

pub use command::MissionEditorCommand;
pub use drag::{DraggedTasks, NewTask, TaskDrag, move_tasks};
pub use edits::users_of_mission;
pub use order_edits::constraints_against_list;
pub use plan::{
    EndProblem, MissionPlan, OrderGain, PlanStart, PlannedEnd, PlannedStop, StopProblem, put_in_order,
    request_of,
};
pub(crate) use plan::{MissionPlanConfig, PlanConditions, PlanOrder, plan as plan_mission};

use super::Feature;
use super::site::{ActionForms, SiteEdit, SiteFeature};
use crate::ClientCommand;
use crate::shared::Context;
use missions::RouteCost;
use site_model::{MissionId, NodeId, Object, Site, TaskId};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The mission editor.
#[derive(Clone, Debug, Default)]
pub struct MissionEditor {
    config: MissionPlanConfig,
    open: Option<MissionId>,
    selected: BTreeSet<TaskId>,
    drag: Option<TaskDrag>,
    /// The plan before the drag.
    before_drag: Option<Box<MissionPlan>>,
    is_order_proposed: bool,
    plan: Option<MissionPlan>,
    /// What the plan was made from.
    planned: Option<PlanInput>,
}

/// All that a plan depends on.
#[derive(Clone, Debug, PartialEq)]
struct PlanInput {
    mission: MissionId,
    site_revision: u64,
    drag: Option<TaskDrag>,
    order: PlanOrder,
    start: Option<(PlanStart, NodeId)>,
    /// Number of the interval in which blocks of edges were looked at.
    interval: Option<i64>,
    forms: Arc<ActionForms>,
}

impl MissionEditor {
    /// The mission that is edited; `None` while the list of missions is shown.
    pub fn open(&self) -> Option<MissionId> {
        self.open
    }

    /// The tasks that are selected in it.
    pub fn selected(&self) -> &BTreeSet<TaskId> {
        &self.selected
    }

    /// The drag that has not ended.
    pub fn drag(&self) -> Option<&TaskDrag> {
        self.drag.as_ref()
    }

    /// What the drag adds where it is, in time and length; `None` while nothing is dragged.
    pub fn drag_cost(&self) -> Option<RouteCost> {
        let (before, now) = (self.before_drag.as_ref()?.cost(), self.plan.as_ref()?.cost());
        self.drag.as_ref()?.index?;
        Some(RouteCost { time_s: now.time_s - before.time_s, length_m: now.length_m - before.length_m })
    }

    /// What the shortest order would gain; while tasks are dragged, what it would have gained before.
    pub fn gain(&self) -> Option<&OrderGain> {
        let before = self.drag.as_ref().and(self.before_drag.as_deref());
        before.or(self.plan.as_ref())?.gain.as_ref()
    }

    /// Whether the shortest order is shown before it is chosen.
    pub fn is_order_proposed(&self) -> bool {
        self.is_order_proposed
    }

    /// The mission as it is shown, with its route; `None` while none is open.
    pub fn plan(&self) -> Option<&MissionPlan> {
        self.plan.as_ref()
    }

    /// The edit with which the drag ends where it is. Nothing outside the list, or if the order stays.
    pub fn dropping(&self, site: &SiteFeature) -> SiteEdit {
        let mut edit = SiteEdit::default();
        let new_id = site.new_id(0);
        if let (Some(site), Some(open), Some(drag)) = (site.site(), self.open, &self.drag)
            && let Some(mission) = site.mission(open)
        {
            let changed = drag::with_drag(mission, drag, new_id, site);
            if changed != *mission {
                edit.put.push(Object::Mission(changed));
            }
        }
        edit
    }

    /// The edit with which the proposed order becomes that of the list. Nothing if none is proposed.
    pub fn accepting_order(&self, site: &SiteFeature) -> SiteEdit {
        let proposed =
            self.plan.as_ref().filter(|_| self.is_order_proposed).and_then(|plan| plan.gain.as_ref());
        match (self.open, proposed) {
            (Some(open), Some(gain)) => {
                site.changing_mission(open, |mission| put_in_order(mission, &gain.order))
            }
            _ => SiteEdit::default(),
        }
    }

    /// The edit that puts a new task behind the selected ones, else at the end of the list.
    pub fn adding(&self, new: NewTask, site: &SiteFeature) -> (Option<TaskId>, SiteEdit) {
        let id = site.new_id(0);
        let mut is_made = false;
        let Some((site_now, open)) = site.site().zip(self.open) else { return (None, SiteEdit::default()) };
        let edit = site.changing_mission(open, |mission| {
            let last = mission.tasks.iter().rposition(|task| self.selected.contains(&task.id));
            let index = last.map_or(mission.tasks.len(), |last| last + 1);
            if let Some(task) = new.make(id, site_now, mission, index) {
                mission.tasks.insert(index, task);
                is_made = true;
            }
        });
        (is_made.then_some(TaskId(id)), edit)
    }

    /// The edit that moves the selected tasks by one place, to the end of the list or to its beginning.
    pub fn moving_selected(&self, towards_end: bool, site: &SiteFeature) -> SiteEdit {
        let Some(open) = self.open else { return SiteEdit::default() };
        site.changing_mission(open, |mission| {
            let Some(first) = mission.tasks.iter().position(|task| self.selected.contains(&task.id)) else {
                return;
            };
            let index = if towards_end { first + 1 } else { first.saturating_sub(1) };
            move_tasks(mission, &self.selected, index);
        })
    }

    /// Follows the site, and makes the plan anew if anything that it depends on has changed.
    pub(crate) fn update(&mut self, site_feature: &SiteFeature, conditions: &PlanConditions<'_>) {
        let conditions = &PlanConditions { forms: Some(site_feature.action_forms()), ..*conditions };
        let site = site_feature.site();
        self.forget_missing(site);
        let (Some(site), Some(open)) = (site, self.open) else {
            (self.plan, self.planned) = (None, None);
            return;
        };
        let Some(mission) = site.mission(open) else { return };
        let order = match (&self.drag, self.is_order_proposed) {
            (Some(_), _) => PlanOrder::Dragged,
            (None, true) => PlanOrder::Proposed,
            (None, false) => PlanOrder::Own,
        };
        let has_blocks = site.edge_blocks().next().is_some();
        let interval = conditions.now.filter(|_| has_blocks);
        let input = PlanInput {
            mission: open,
            site_revision: site_feature.revision(),
            drag: self.drag.clone(),
            order,
            start: plan::start_of(site, mission, conditions),
            interval: interval.map(|now| (now.secs_f64() / self.config.blocks_interval_s) as i64),
            forms: Arc::clone(site_feature.action_forms()),
        };
        if self.planned.as_ref() == Some(&input) {
            return;
        }
        let shown = match &self.drag {
            Some(drag) => drag::with_drag(mission, drag, site_feature.new_id(0), site),
            None => mission.clone(),
        };
        self.plan = Some(plan::plan(site, shown, order, conditions, &self.config));
        self.planned = Some(input);
    }

    /// Opens a mission or the list, with nothing selected.
    fn reset(&mut self, open: Option<MissionId>) {
        *self = Self { open, ..Self::default() };
    }

    /// Forgets what the site no longer has.
    fn forget_missing(&mut self, site: Option<&Site>) {
        let mission = self.open.and_then(|open| site?.mission(open));
        let Some(mission) = mission else {
            self.reset(None);
            return;
        };
        let is_there = |id: &TaskId| mission.tasks.iter().any(|task| task.id == *id);
        self.selected.retain(is_there);
        let is_draggable = |drag: &TaskDrag| match &drag.what {
            DraggedTasks::Listed(tasks) => tasks.iter().all(is_there),
            DraggedTasks::New(_) => true,
        };
        self.drag = self.drag.take().filter(is_draggable);
    }
}

impl Feature for MissionEditor {
    fn on_command(&mut self, command: &ClientCommand, _cx: &mut Context<'_>) {
        let ClientCommand::MissionEditor(command) = command else { return };
        match command {
            MissionEditorCommand::Open(mission) => self.reset(*mission),
            MissionEditorCommand::Select(tasks) => self.selected.clone_from(tasks),
            MissionEditorCommand::Drag(drag) => {
                self.is_order_proposed = false;
                if self.drag.is_none() {
                    self.before_drag = self.plan.clone().map(Box::new);
                }
                self.drag = Some(drag.clone());
            }
            MissionEditorCommand::EndDrag => self.drag = None,
            MissionEditorCommand::ProposeOrder(is_proposed) => {
                self.is_order_proposed = *is_proposed && self.drag.is_none();
            }
        }
    }
}

#[cfg(test)]
mod tests;
