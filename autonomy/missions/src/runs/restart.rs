//! Recovers runs after a restart of the program.

use super::runner::MissionRunner;
use super::table::{RunTrigger, TaskTrigger};
use site_model::{RunChangeReason, RunId, TaskState};

impl MissionRunner {
    /// Runs wait until the place is known. A task on the way waits again. Of an action that was begun it is not known how it ended, also of one on the way.
    pub(super) fn recover_runs(&mut self) {
        let runs: Vec<RunId> = self.records.runs.keys().copied().collect();
        for run in runs {
            let reason = RunChangeReason::ProgramRestarted;
            self.fire_run_because(run, RunTrigger::ProgramRestarted, reason);
            self.recover_route_actions(run);
            let tasks = self.records.runs.get(&run).map_or(0, |run| run.tasks.len());
            for task in 0..tasks {
                let state = self.records.runs[&run].tasks[task].state;
                if matches!(state, TaskState::Navigating | TaskState::Running) {
                    self.fire_task(run, task, TaskTrigger::OutcomeUnknown, None);
                }
            }
        }
    }
}
