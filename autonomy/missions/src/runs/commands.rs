//! Commands of people and programs.

use super::interface::MissionEffect;
use super::records::Run;
use super::runner::MissionRunner;
use super::table::{RUN_TABLE, RunTrigger, TASK_TABLE, TaskTrigger};
use crate::texts;
use site_model::{
    MissionCommand, MissionCommandKind, MissionEventKind, MissionId, RunCause, RunId, RunState, StartMode,
    TaskId,
};

impl MissionRunner {
    pub(super) fn handle_command(&mut self, command: &MissionCommand) {
        if self.records.knows(command.id) {
            // It was executed: the same answer again.
            return self.act(MissionEffect::Answer { command: command.id, refused: None });
        }
        self.command = Some(command.id);
        let refused = self.execute(command).err().map(str::to_owned);
        self.act(MissionEffect::Answer { command: command.id, refused });
    }

    fn execute(&mut self, command: &MissionCommand) -> Result<(), &'static str> {
        match command.kind {
            MissionCommandKind::Start { run, mission, mode } => {
                self.check_start(run, mission, mode)?;
                let cause = RunCause::of_command(command);
                // Before all that wait: nothing is under way, so it begins at once.
                let priority = if mode == StartMode::Now { i32::MAX } else { 0 };
                self.emit(MissionEventKind::RunQueued { run, mission, cause, priority });
                Ok(())
            }
            MissionCommandKind::Pause(run) => self.command_run(run, RunTrigger::PauseRequested),
            MissionCommandKind::Resume(run) => {
                if !self.situation.can_move {
                    return Err(texts::RESUME_WHEN_FREE);
                }
                self.command_run(run, RunTrigger::ResumeRequested)
            }
            MissionCommandKind::Cancel(run) => self.command_run(run, RunTrigger::CancelRequested),
            MissionCommandKind::Abort(run) => self.command_run(run, RunTrigger::AbortRequested),
            MissionCommandKind::SkipTask(run, task) => {
                self.command_task(run, task, TaskTrigger::SkipRequested)
            }
            MissionCommandKind::RedoTask(run, task) => {
                self.command_task(run, task, TaskTrigger::RedoRequested)
            }
            MissionCommandKind::Answer(run, task, answer) => {
                let (record, index) = self.find_task(run, task)?;
                if record.question != Some(index) {
                    return Err(texts::NO_QUESTION);
                }
                self.answer_question(run, index, answer, false);
                Ok(())
            }
        }
    }

    fn check_start(&self, run: RunId, mission: MissionId, mode: StartMode) -> Result<(), &'static str> {
        let has_ended = self.records.ended.iter().any(|(ended, ..)| *ended == run);
        if has_ended || self.records.runs.contains_key(&run) {
            return Err(texts::RUN_EXISTS);
        }
        let tasks = &self.site.mission(mission).ok_or(texts::MISSION_UNKNOWN)?.tasks;
        if tasks.is_empty() {
            return Err(texts::MISSION_EMPTY);
        }
        match mode {
            StartMode::Now if !self.situation.can_move => Err(texts::CANNOT_MOVE),
            StartMode::Now if self.blocked_by().is_some() => Err(texts::BLOCKED),
            StartMode::Now if self.records.active().is_some() || self.records.suspended().is_some() => {
                Err(texts::OTHER_RUN)
            }
            StartMode::Now => Ok(()),
            StartMode::Queue => self.check_queue(mission),
        }
    }

    /// Whether a run of this mission can wait.
    pub(super) fn check_queue(&self, mission: MissionId) -> Result<(), &'static str> {
        let queued = self.records.runs.values().filter(|run| run.state == RunState::Queued);
        let (count, is_queued) =
            queued.fold((0, false), |(count, found), run| (count + 1, found || run.mission == mission));
        match (count >= self.config.max_queue, is_queued) {
            (_, true) => Err(texts::ALREADY_QUEUED),
            (true, _) => Err(texts::QUEUE_FULL),
            _ => Ok(()),
        }
    }

    fn command_run(&mut self, run: RunId, trigger: RunTrigger) -> Result<(), &'static str> {
        let state = self.records.runs.get(&run).ok_or(texts::RUN_UNKNOWN)?.state;
        if !RUN_TABLE.iter().any(|row| row.from == state && row.trigger == trigger) {
            return Err(texts::NOT_POSSIBLE_NOW);
        }
        self.fire_run(run, trigger);
        Ok(())
    }

    fn command_task(&mut self, run: RunId, task: TaskId, trigger: TaskTrigger) -> Result<(), &'static str> {
        let (record, index) = self.find_task(run, task)?;
        let state = record.tasks[index].state;
        let is_possible = record.state != RunState::Ending
            && TASK_TABLE.iter().any(|row| row.from == state && row.trigger == trigger);
        if !is_possible {
            return Err(texts::NOT_POSSIBLE_NOW);
        }
        self.fire_task(run, index, trigger, None);
        Ok(())
    }

    fn find_task(&self, run: RunId, task: TaskId) -> Result<(&Run, usize), &'static str> {
        let run = self.records.runs.get(&run).ok_or(texts::RUN_UNKNOWN)?;
        Ok((run, run.index_of(task).ok_or(texts::TASK_UNKNOWN)?))
    }
}
