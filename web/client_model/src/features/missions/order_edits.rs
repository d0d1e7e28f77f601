//! Order constraints of a mission as operators make them: each change is a step of undo.

use super::plan::put_in_order;
use crate::features::site::{SiteEdit, SiteFeature};
use site_model::{Mission, MissionId, TaskId};
use std::collections::BTreeSet;

impl SiteFeature {
    /// A mission in which `first` is done before `second`. Nothing if that is so already, or both are one task.
    pub fn constraining_order(&self, mission: MissionId, first: TaskId, second: TaskId) -> SiteEdit {
        self.changing_mission(mission, |mission| {
            if first != second && !mission.order_constraints.contains(&[first, second]) {
                mission.order_constraints.push([first, second]);
            }
        })
    }

    /// A mission without an order constraint.
    pub fn freeing_order(&self, mission: MissionId, constraint: [TaskId; 2]) -> SiteEdit {
        self.changing_mission(mission, |mission| mission.order_constraints.retain(|it| *it != constraint))
    }

    /// A mission whose list meets its order constraints. Tasks keep their order where the constraints permit it. Nothing if no order meets all.
    pub fn listing_in_constrained_order(&self, mission: MissionId) -> SiteEdit {
        self.changing_mission(mission, |mission| {
            if let Some(order) = constrained_order(mission) {
                put_in_order(mission, &order);
            }
        })
    }
}

/// The order constraints that the list of a mission does not meet.
pub fn constraints_against_list(mission: &Mission) -> Vec<[TaskId; 2]> {
    let place = |task: &TaskId| mission.tasks.iter().position(|it| it.id == *task);
    let is_against = |[first, second]: &&[TaskId; 2]| match (place(first), place(second)) {
        (Some(first), Some(second)) => first >= second,
        _ => false,
    };
    mission.order_constraints.iter().filter(is_against).copied().collect()
}

/// The order next to that of the list that meets all constraints; none if there is no such order. Each place gets the first task of the list that waits for none of those after it.
fn constrained_order(mission: &Mission) -> Option<Vec<TaskId>> {
    let mut left: Vec<TaskId> = mission.tasks.iter().map(|task| task.id).collect();
    let mut order = Vec::new();
    while !left.is_empty() {
        let waiting: BTreeSet<TaskId> = mission
            .order_constraints
            .iter()
            .filter(|[first, _]| left.contains(first))
            .map(|[_, second]| *second)
            .collect();
        let free = left.iter().position(|task| !waiting.contains(task))?;
        order.push(left.remove(free));
    }
    Some(order)
}
