//! How long a run still takes.

use crate::features::missions::{MissionPlanConfig, PlanConditions, PlanOrder, plan_mission};
use site_model::{RouteStatus, RunStatus, Site, TaskId, TaskState};
use std::collections::BTreeMap;
use vocab::Stamp;

/// What a run is expected to take.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunEstimate {
    /// Time for each task, with the route to it, seconds.
    pub tasks_s: BTreeMap<TaskId, f64>,
    /// Time of the action of each task, seconds.
    pub actions_s: BTreeMap<TaskId, f64>,
    /// The route after the last task, seconds.
    pub end_s: f64,
}

impl RunEstimate {
    /// Time until the run ends, seconds, by what its tasks have reached and the route that is followed.
    pub fn remaining_s(&self, run: &RunStatus, route: &RouteStatus) -> f64 {
        let of = |times: &BTreeMap<TaskId, f64>, task| times.get(&task).copied().unwrap_or(0.0);
        let left = |task: &site_model::TaskStatus| match task.state {
            TaskState::Waiting | TaskState::Paused | TaskState::Retriable => of(&self.tasks_s, task.task),
            TaskState::Navigating => match &route.route {
                Some(route) => route.remaining_s + of(&self.actions_s, task.task),
                None => of(&self.tasks_s, task.task),
            },
            TaskState::Running => of(&self.actions_s, task.task),
            TaskState::Succeeded | TaskState::Failed | TaskState::Skipped | TaskState::Cancelled => 0.0,
        };
        run.tasks.iter().map(left).sum::<f64>() + self.end_s
    }
}

/// Plans the mission of a run as it is in the site now. None if the site lacks it. `now`: time on the robot's clock, by which blocks of edges end; none: every block counts.
pub fn estimate_run(site: &Site, run: &RunStatus, now: Option<Stamp>) -> Option<RunEstimate> {
    let mission = site.mission(run.mission)?.clone();
    let plan = plan_mission(
        site,
        mission,
        PlanOrder::Dragged,
        &PlanConditions { now, ..PlanConditions::default() },
        &MissionPlanConfig::default(),
    );
    let mut estimate = RunEstimate { end_s: plan.end.walk.time_s, ..RunEstimate::default() };
    for stop in &plan.stops {
        estimate.tasks_s.insert(stop.task, stop.walk.time_s + stop.action_s);
        estimate.actions_s.insert(stop.task, stop.action_s);
    }
    Some(estimate)
}
