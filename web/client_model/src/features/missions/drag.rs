//! Tasks that are dragged within the list of a mission or into it.

use site_model::{
    ActionRequest, DockAction, InspectionPointId, Mission, NodeId, Parameters, Site, Task, TaskId, TaskPlace,
};
use std::collections::BTreeSet;
use uuid::Uuid;

/// A drag that has not ended.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskDrag {
    /// What is dragged.
    pub what: DraggedTasks,
    /// Where it would be dropped: the number of tasks before it, of those that are not dragged. `None`: outside the list, where nothing changes.
    pub index: Option<usize>,
}

/// What is dragged.
#[derive(Clone, Debug, PartialEq)]
pub enum DraggedTasks {
    /// Tasks of the mission.
    Listed(BTreeSet<TaskId>),
    /// An entry of the palette.
    New(NewTask),
}

/// An entry of the palette, of which a task can be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NewTask {
    /// The action of an inspection point.
    InspectionPoint(InspectionPointId),
    /// A visit of a node.
    Node(NodeId),
    /// An action of this name, at the place of the task before it, or where it moves the robot.
    Action(&'static str),
}

impl NewTask {
    /// The task of this id, at a position of the list. `None` for an action at a place if the site has no node at all.
    pub fn make(self, id: Uuid, site: &Site, mission: &Mission, index: usize) -> Option<Task> {
        let place = match self {
            Self::InspectionPoint(point) => TaskPlace::InspectionPoint(point),
            Self::Node(node) => TaskPlace::Node { node, request: None },
            Self::Action(name) => {
                let request = ActionRequest { action: name.to_owned(), parameters: Parameters::new() };
                match DockAction::of(&request) {
                    Some(_) => TaskPlace::ByAction { request },
                    None => {
                        let node = place_of_action(site, mission, index)?;
                        TaskPlace::Node { node, request: Some(request) }
                    }
                }
            }
        };
        let (on_unreachable, on_action_failure) = Default::default();
        Some(Task { id: TaskId(id), place, on_unreachable, on_action_failure })
    }
}

/// Where an action without a place of its own is done: at the task before it, else the one after it, else a dock, else any node.
fn place_of_action(site: &Site, mission: &Mission, index: usize) -> Option<NodeId> {
    let (before, after) = mission.tasks.split_at(index.min(mission.tasks.len()));
    let mut neighbours = before.iter().rev().chain(after);
    let of_neighbour = neighbours.find_map(|task| missions::node_of(site, task));
    let of_dock = || site.docks().map(|dock| dock.node).find(|node| site.node(*node).is_some());
    of_neighbour.or_else(of_dock).or_else(|| site.nodes().next().map(|node| node.id))
}

/// The mission after the drag has ended here. `new_id` is the id of a task that is made.
pub(super) fn with_drag(mission: &Mission, drag: &TaskDrag, new_id: Uuid, site: &Site) -> Mission {
    let mut changed = mission.clone();
    let Some(index) = drag.index else { return changed };
    match &drag.what {
        DraggedTasks::Listed(tasks) => move_tasks(&mut changed, tasks, index),
        DraggedTasks::New(new) => {
            let index = index.min(changed.tasks.len());
            if let Some(task) = new.make(new_id, site, mission, index) {
                changed.tasks.insert(index, task);
            }
        }
    }
    changed
}

/// Moves tasks together, in their order, behind this number of others.
pub fn move_tasks(mission: &mut Mission, tasks: &BTreeSet<TaskId>, index: usize) {
    let (moved, mut others): (Vec<Task>, Vec<Task>) =
        std::mem::take(&mut mission.tasks).into_iter().partition(|task| tasks.contains(&task.id));
    let index = index.min(others.len());
    others.splice(index..index, moved);
    mission.tasks = others;
}
