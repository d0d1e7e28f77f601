//! Goals of the robot: what it is to reach, its progress, and the outcome of each.

use super::Feature;
use crate::features::selection::PointerMode;
use crate::shared::Context;
use crate::{Aged, ClientCommand, ClientTime};
use api::{CancelCause, ExecutiveStatus, Goal, GoalKind, GoalStatus};
use std::collections::{BTreeMap, BTreeSet};
use vocab::GoalId;

/// Goals and the executive as the robot last reported them.
#[derive(Clone, Debug, Default)]
pub struct Goals {
    executive: Option<Aged<ExecutiveStatus>>,
    /// Newest first.
    goals: Vec<Goal>,
    /// When each outcome came that this client waited for.
    outcomes: BTreeMap<GoalId, ClientTime>,
    /// Longest distance to go that was reported for each goal, metres.
    longest_m: BTreeMap<GoalId, f64>,
    dismissed: BTreeSet<GoalId>,
    /// Whether goals have been reported since the page was opened.
    reported: bool,
}

/// The outcome of a goal, to be shown until it is dismissed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoalOutcome<'a> {
    /// The goal. Its status is an outcome.
    pub goal: &'a Goal,
    /// When the outcome came.
    pub ended: ClientTime,
}

impl Goals {
    /// State of the executive; `None` before the robot reported it.
    pub fn executive(&self) -> Option<&ExecutiveStatus> {
        self.executive.as_ref().map(|executive| &executive.value)
    }

    /// The goal that is executed or waits.
    pub fn active(&self) -> Option<&Goal> {
        self.goals.iter().find(|goal| !goal.status.is_outcome())
    }

    /// Share of the path that is behind the robot, 0 to 1; `None` while no path is known.
    pub fn progress(&self, goal: &Goal) -> Option<f32> {
        let GoalStatus::Running(progress) = &goal.status else { return None };
        let longest_m = *self.longest_m.get(&goal.id)?;
        let share = if longest_m > 0.0 { 1.0 - progress.remaining_m? / longest_m } else { 1.0 };
        Some(share.clamp(0.0, 1.0) as f32)
    }

    /// The newest outcome that was not dismissed. A goal that was replaced by another one has none to show.
    pub fn outcome(&self) -> Option<GoalOutcome<'_>> {
        self.goals.iter().find_map(|goal| {
            let ended = *self.outcomes.get(&goal.id)?;
            let replaced =
                matches!(goal.status, GoalStatus::Cancelled { cause: CancelCause::Replaced(_), .. });
            (!replaced && !self.dismissed.contains(&goal.id)).then_some(GoalOutcome { goal, ended })
        })
    }

    fn update(&mut self, goals: &[Goal], now: ClientTime) {
        for goal in goals {
            // The first report repeats outcomes from before the page was opened.
            if goal.status.is_outcome() && self.reported {
                let known = self.goals.iter().any(|it| it.id == goal.id && it.status.is_outcome());
                if !known {
                    self.outcomes.insert(goal.id, now);
                }
            }
            if let GoalStatus::Running(progress) = &goal.status
                && let Some(remaining_m) = progress.remaining_m
            {
                let longest_m = self.longest_m.entry(goal.id).or_insert(remaining_m);
                *longest_m = longest_m.max(remaining_m);
            }
        }
        self.reported = true;
        self.goals = goals.to_vec();
        let listed = |id: &GoalId| goals.iter().any(|goal| goal.id == *id);
        self.outcomes.retain(|id, _| listed(id));
        self.longest_m.retain(|id, _| listed(id));
        self.dismissed.retain(listed);
    }
}

fn start(kind: GoalKind, cx: &mut Context<'_>) {
    let goal = cx.shared.ids.goal();
    cx.send_in_control(api::Command::StartGoal { goal, kind });
}

impl Feature for Goals {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        match event {
            api::Event::Executive(executive) => {
                self.executive = Some(Aged { value: *executive, arrived: cx.now() });
            }
            api::Event::Goals(goals) => self.update(goals, cx.now()),
            _ => {}
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::WalkTo(point) => {
                cx.shared.selected.leave(PointerMode::PickGoal);
                start(GoalKind::WalkTo(*point), cx);
            }
            ClientCommand::GoToNode(node) => start(GoalKind::GoToNode(*node), cx),
            ClientCommand::GoToDock(dock) => start(GoalKind::GoToDock(*dock), cx),
            ClientCommand::LeaveDock => start(GoalKind::Undock, cx),
            ClientCommand::Relocalise => start(GoalKind::Relocalise, cx),
            ClientCommand::CancelGoal(goal) => cx.send_in_control(api::Command::CancelGoal(*goal)),
            ClientCommand::DismissGoal(goal) => {
                self.dismissed.insert(*goal);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
