//! Steps of runs: applies the run table.

use super::interface::MissionNotice;
use super::runner::{Activity, MissionRunner, Purpose, RunLeg};
use super::table::{RUN_TABLE, RunAction, RunTrigger, TaskTrigger};
use site_model::{EndPlace, MissionEnd, MissionEventKind, RunChangeReason, RunId, RunState, TaskState};

impl MissionRunner {
    /// Applies a row of the run table; a trigger without one changes nothing.
    pub(super) fn fire_run(&mut self, run: RunId, trigger: RunTrigger) {
        self.fire_run_because(run, trigger, RunChangeReason::Requested);
    }

    pub(super) fn fire_run_because(&mut self, id: RunId, trigger: RunTrigger, reason: RunChangeReason) {
        let Some(run) = self.records.runs.get(&id) else { return };
        let state = run.state;
        let row = RUN_TABLE.iter().position(|row| row.from == state && row.trigger == trigger);
        let Some(number) = row else { return };
        #[cfg(test)]
        self.taken.insert(('r', number));
        let row = &RUN_TABLE[number];
        match row.to {
            None => {
                self.cancel_tasks(id);
                self.end_run(id);
            }
            Some(RunState::Ending) => self.decide_ending(id, row.actions),
            Some(to) if to.is_outcome() => {
                self.emit_end(id, to);
            }
            Some(state) => self.emit(MissionEventKind::RunChanged { run: id, state, reason }),
        }
        for action in row.actions {
            match action {
                RunAction::PauseTask => self.fire_current_task(id, TaskTrigger::RunPaused),
                RunAction::InterruptTask => self.fire_current_task(id, TaskTrigger::RunInterrupted),
                RunAction::StopTask => self.fire_current_task(id, TaskTrigger::RunStops),
                RunAction::FinishTask => self.fire_current_task(id, TaskTrigger::RunFinishes),
                // Part of the decision above.
                RunAction::GoToEnd
                | RunAction::GoToDock
                | RunAction::Stay
                | RunAction::EndCancelled
                | RunAction::EndInterrupted
                | RunAction::CancelTasks => {}
            }
        }
    }

    /// Decides outcome and end of a run. An outcome that was decided before stays; only where the robot goes changes.
    fn decide_ending(&mut self, id: RunId, actions: &[RunAction]) {
        let Some(run) = self.records.runs.get(&id) else { return };
        let mission_end = run.plan.as_ref().map_or(MissionEnd::Stay, |plan| plan.end);
        let decision = actions.iter().find_map(|action| match action {
            RunAction::GoToEnd => Some((run.outcome(), end_place(mission_end))),
            RunAction::GoToDock => Some((run.outcome(), EndPlace::NearestDock)),
            RunAction::Stay => Some((run.outcome(), EndPlace::Here)),
            RunAction::EndCancelled => Some((RunState::Cancelled, EndPlace::Here)),
            RunAction::EndInterrupted => Some((RunState::Interrupted, EndPlace::Here)),
            _ => None,
        });
        let Some((outcome, place)) = decision else { return };
        let outcome = run.ending.map_or(outcome, |(decided, _)| decided);
        self.emit(MissionEventKind::RunEnding { run: id, outcome, place });
        // A leg to where the run would have ended.
        if let Some(Activity::Leg(RunLeg { goal, purpose: Purpose::End(..), .. })) = self.activity {
            self.cancel_goal(goal);
        }
    }

    fn end_run(&mut self, id: RunId) {
        let Some(run) = self.records.runs.get(&id) else { return };
        let outcome = run.ending.map_or(RunState::Cancelled, |(outcome, _)| outcome);
        if let Some(Activity::Leg(RunLeg { goal, purpose: Purpose::End(..), .. })) = self.activity {
            self.cancel_goal(goal);
        }
        self.emit_end(id, outcome);
    }

    /// Records the end of a run, and tells people.
    fn emit_end(&mut self, id: RunId, outcome: RunState) {
        // Where the run ends, nobody waits for what was cancelled.
        self.give_up_route_actions(id);
        // It is not among the records afterwards.
        let ended = self.records.runs.get(&id).map(|run| {
            let succeeded = run.tasks.iter().filter(|task| task.state == TaskState::Succeeded).count();
            MissionNotice::RunEnded { mission: run.mission, outcome, succeeded, tasks: run.tasks.len() }
        });
        self.emit(MissionEventKind::RunEnded { run: id, outcome });
        if let Some(notice) = ended {
            self.notify(notice);
        }
    }
}

fn end_place(end: MissionEnd) -> EndPlace {
    match end {
        MissionEnd::NearestDock => EndPlace::NearestDock,
        MissionEnd::Node(node) => EndPlace::Node(node),
        MissionEnd::Stay => EndPlace::Here,
    }
}
