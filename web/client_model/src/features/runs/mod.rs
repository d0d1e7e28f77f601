//! Runs of missions: those under way and in the queue, how far they are, those that ended, and what the operator asks of them.

mod estimate;

pub use estimate::{RunEstimate, estimate_run};

use super::Feature;
use crate::ClientCommand;
use crate::shared::{Change, Context};
use api::Command;
use site_model::{
    LocalDateTime, MissionCommandKind, MissionStatus, RouteStatus, RunCause, RunId, RunState, RunStatus,
    ScheduleId, StartMode,
};
use std::collections::BTreeMap;

/// Ended runs that are kept with their tasks at most.
const MAX_KEPT: usize = 64;

/// Runs as the robot last reported them.
#[derive(Clone, Debug, Default)]
pub struct Runs {
    status: Option<MissionStatus>,
    route: RouteStatus,
    /// The last report of each run that this client has seen, also of those that ended since.
    seen: BTreeMap<RunId, RunStatus>,
    /// What became of slots of schedules, as far as this client has seen it.
    slots: BTreeMap<(ScheduleId, LocalDateTime), RunState>,
}

/// A run that has ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PastRun<'a> {
    /// The run.
    pub run: RunId,
    /// Its mission.
    pub mission: site_model::MissionId,
    /// Its outcome.
    pub outcome: RunState,
    /// Its last report, if this client has seen one.
    pub report: Option<&'a RunStatus>,
}

impl Runs {
    /// State of all missions; `None` before the robot has reported it.
    pub fn status(&self) -> Option<&MissionStatus> {
        self.status.as_ref()
    }

    /// The run under way, or else the one that waits to go on.
    pub fn current(&self) -> Option<&RunStatus> {
        self.status.as_ref()?.runs.iter().find(|run| run.state != RunState::Queued)
    }

    /// Runs that wait for their turn.
    pub fn queue(&self) -> impl Iterator<Item = &RunStatus> {
        let runs = self.status.iter().flat_map(|status| &status.runs);
        runs.filter(|run| run.state == RunState::Queued)
    }

    /// Where the robot is on the topological map, and its route.
    pub fn route(&self) -> &RouteStatus {
        &self.route
    }

    /// Runs that ended lately, the newest first.
    pub fn past(&self) -> impl Iterator<Item = PastRun<'_>> {
        let ended = self.status.iter().flat_map(|status| status.ended.iter().rev());
        ended.map(|ended| PastRun {
            run: ended.run,
            mission: ended.mission,
            outcome: ended.outcome,
            report: self.seen.get(&ended.run),
        })
    }

    /// What became of a slot of a schedule: the state of its run. `None` if this client has not seen it.
    pub fn slot(&self, schedule: ScheduleId, slot: LocalDateTime) -> Option<RunState> {
        self.slots.get(&(schedule, slot)).copied()
    }

    fn on_status(&mut self, status: &MissionStatus) {
        for run in &status.runs {
            self.seen.insert(run.run, run.clone());
            self.note_slot(run.run, run.state);
        }
        for ended in &status.ended {
            self.note_slot(ended.run, ended.outcome);
        }
        let is_listed = |run: &RunId| {
            status.runs.iter().any(|it| it.run == *run) || status.ended.iter().any(|it| it.run == *run)
        };
        if self.seen.len() > MAX_KEPT {
            self.seen.retain(|run, _| is_listed(run));
        }
        self.status = Some(status.clone());
    }

    fn note_slot(&mut self, run: RunId, state: RunState) {
        if let Some(RunCause::Schedule { schedule, slot }) = self.seen.get(&run).map(|run| run.cause) {
            self.slots.insert((schedule, slot), state);
        }
    }
}

impl Feature for Runs {
    fn on_event(&mut self, event: &api::Event, _cx: &mut Context<'_>) {
        match event {
            api::Event::Missions(status) => self.on_status(status),
            api::Event::Route(route) => self.route = route.clone(),
            _ => {}
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::StartMission { mission, is_queued } => {
                let mode = if *is_queued { StartMode::Queue } else { StartMode::Now };
                let run = cx.shared.ids.run();
                cx.send(Command::Mission(MissionCommandKind::Start { run, mission: *mission, mode }));
            }
            ClientCommand::Run(kind) => cx.send(Command::Mission(*kind)),
            _ => {}
        }
    }

    fn on_change(&mut self, change: &Change, _cx: &mut Context<'_>) {
        // The snapshot that follows has the present state. A robot without missions sends none.
        if *change == Change::Connected {
            self.status = None;
            self.route = RouteStatus::default();
        }
    }
}

#[cfg(test)]
mod tests;
