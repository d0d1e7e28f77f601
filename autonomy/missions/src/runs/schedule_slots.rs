//! Schedules and monitors within the runner: due slots become runs, and conditions that hold have their response.

use super::battery::{CHARGE_SIGNAL, RESERVE_SIGNAL, reserve, time_to_dock_p95_s};
use super::interface::MissionNotice;
use super::runner::MissionRunner;
use super::scheduler::DueSlot;
use super::table::RunTrigger;
use crate::ids::{monitor_run_id, slot_run_id};
use site_model::{
    MissionEventKind, MissionId, MonitorId, MonitorResponse, ObjectId, OverlapPolicy, Resumption, RunCause,
    RunChangeReason, RunId, RunState, Schedule, ScheduleId, SkipReason, SlotDecision, Utc,
};

impl MissionRunner {
    pub(super) fn handle_clock(&mut self, utc: Utc, is_synchronised: bool) {
        self.utc = Some(utc);
        self.is_clock_synchronised = is_synchronised;
        if !is_synchronised {
            if self.site.schedules().next().is_some() && !std::mem::replace(&mut self.is_clock_reported, true)
            {
                self.notify(MissionNotice::ClockNotSynchronised);
            }
            return;
        }
        self.is_clock_reported = false;
        for schedule in self.scheduler.read(&self.site) {
            self.notify(MissionNotice::ScheduleUnusable(schedule));
        }
        let schedules: Vec<(ScheduleId, i32)> =
            self.scheduler.schedules().map(|schedule| (schedule.id, schedule.priority)).collect();
        let mut due: Vec<(Utc, i32, DueSlot)> = Vec::new();
        for (id, priority) in schedules {
            self.adopt(id, utc);
            let found = self.scheduler.due(id, utc, &self.records);
            if let Some((first, last, count)) = found.missed {
                let (first, last_due, last) = (first.slot, last.due, last.slot);
                self.emit(MissionEventKind::SlotsMissed { schedule: id, first, last, last_due, count });
                self.scheduler.decided(id, last);
            }
            due.extend(found.slots.into_iter().map(|slot| (slot.due, -priority, slot)));
        }
        due.sort_by_key(|(due, priority, slot)| (*due, *priority, slot.schedule));
        for (_, _, slot) in due {
            self.decide_slot(&slot);
        }
    }

    /// Follows a schedule from now on, if it is new or was changed. Slots that wait, or were not decided on yet, are still those of before.
    fn adopt(&mut self, schedule: ScheduleId, now: Utc) {
        let Some(revision) = self.site.revision(ObjectId::Schedule(schedule)) else { return };
        let adopted = self.records.adopted.get(&schedule).copied();
        if adopted.is_some_and(|(known, _)| known == revision) {
            return;
        }
        let since = match adopted {
            Some((_, since)) if self.scheduler.has_waiting(schedule) => since,
            _ => now,
        };
        self.emit(MissionEventKind::ScheduleAdopted { schedule, revision, since });
        self.scheduler.changed(schedule);
    }

    /// Decides what becomes of a slot. One that may wait for a monitor is not decided yet.
    fn decide_slot(&mut self, slot: &DueSlot) {
        let Some(schedule) = self.scheduler.schedules().find(|other| other.id == slot.schedule).cloned()
        else {
            return;
        };
        let decision = match (slot.skip, self.blocked_by()) {
            (Some(reason), _) => SlotDecision::Skipped(reason),
            (None, Some(_)) if slot.may_wait => return self.scheduler.wait(slot),
            (None, Some(monitor)) => SlotDecision::Skipped(SkipReason::Blocked(monitor)),
            (None, None) => self.start_slot(slot, &schedule),
        };
        self.emit(MissionEventKind::SlotDecided {
            schedule: slot.schedule,
            slot: slot.slot,
            due: slot.due,
            decision,
        });
        self.scheduler.decided(slot.schedule, slot.slot);
    }

    /// Queues the run of a slot, unless another one is in its way.
    fn start_slot(&mut self, slot: &DueSlot, schedule: &Schedule) -> SlotDecision {
        let Some(mission) = self.site.mission(schedule.mission).filter(|mission| !mission.tasks.is_empty())
        else {
            return SlotDecision::Skipped(SkipReason::NoMission);
        };
        let mission = mission.id;
        let queue = self.records.queue();
        let active = self.records.active().or(self.records.suspended()).map(|run| run.id);
        let mut priority = schedule.priority;
        match (schedule.overlap, active.or(queue.first().copied())) {
            (_, None) => {}
            (OverlapPolicy::Skip, Some(other)) => return SlotDecision::Skipped(SkipReason::OtherRun(other)),
            (OverlapPolicy::Queue, _) => {
                if let Some(queued) = self.queued_of(schedule.id, mission) {
                    return SlotDecision::Skipped(SkipReason::AlreadyQueued(queued));
                }
                if queue.len() >= self.config.max_queue {
                    return SlotDecision::Skipped(SkipReason::QueueFull);
                }
            }
            (OverlapPolicy::Replace, _) => {
                // The run of a monitor is more important.
                let is_by_monitor =
                    |run: &RunId| matches!(self.records.runs[run].cause, RunCause::Monitor(_));
                if let Some(other) = active.filter(|other| !is_by_monitor(other)) {
                    self.fire_run(other, RunTrigger::Replaced);
                }
                // Before all that wait.
                let first = queue.iter().filter_map(|run| Some(self.records.runs.get(run)?.priority)).max();
                priority = priority.max(first.map_or(priority, |first| first.saturating_add(1)));
            }
        }
        let run = slot_run_id(schedule.id, slot.slot);
        let cause = RunCause::Schedule { schedule: schedule.id, slot: slot.slot };
        self.emit(MissionEventKind::RunQueued { run, mission, cause, priority });
        SlotDecision::Run(run)
    }

    /// A queued run of this schedule, or of this mission.
    fn queued_of(&self, schedule: ScheduleId, mission: MissionId) -> Option<RunId> {
        let queued = self.records.runs.values().filter(|run| run.state == RunState::Queued);
        let is_same = |run: &&super::records::Run| {
            run.mission == mission
                || matches!(run.cause, RunCause::Schedule { schedule: other, .. } if other == schedule)
        };
        queued.filter(is_same).map(|run| run.id).next()
    }

    pub(super) fn handle_signal(&mut self, name: &str, value: f64) {
        self.monitors.set_signal(name, value, self.at);
        if name != CHARGE_SIGNAL {
            return;
        }
        // The reserve follows from the charge and the route to the nearest dock.
        let Some(from) = self.situation.place.nearest else { return };
        let routes =
            self.route_site.docks().filter_map(|dock| self.graph.routes_to(dock.node)?.route(from).ok());
        let Some(route) = routes.min_by(|a, b| a.cost_s.total_cmp(&b.cost_s)) else { return };
        let times_s: Vec<f64> =
            route.edges.iter().map(|edge| self.graph.cost(*edge).map_or(0.0, |(time_s, _)| time_s)).collect();
        let time_s = time_to_dock_p95_s(&route, &times_s, &self.learned, &self.config.battery);
        let reserve = reserve(value, time_s, &self.config.battery);
        self.monitors.set_signal(RESERVE_SIGNAL, reserve, self.at);
    }

    pub(super) fn check_monitors(&mut self) {
        for (monitor, holds) in self.monitors.update(self.at, &self.records.monitors) {
            self.emit(MissionEventKind::MonitorChanged { monitor, holds });
            if holds {
                self.notify(MissionNotice::MonitorHolds(monitor));
                self.respond(monitor);
            }
        }
    }

    /// What happens when a condition begins to hold. That the robot goes to a dock, and that missions are blocked, is decided as long as it holds.
    fn respond(&mut self, monitor: MonitorId) {
        let Some(response) = self.monitors.get(monitor).map(|monitor| monitor.response) else { return };
        let active = self.records.active().map(|run| (run.id, run.cause.clone()));
        let reason = RunChangeReason::MonitorHolds(monitor);
        match (response, active) {
            (MonitorResponse::Pause, Some((run, _))) => {
                self.fire_run_because(run, RunTrigger::PauseRequested, reason);
            }
            (MonitorResponse::Interrupt { mission, afterwards }, active) => {
                let is_known = |run: &RunId| {
                    self.records.runs.contains_key(run)
                        || self.records.ended.iter().any(|(ended, ..)| ended == run)
                };
                let run =
                    (0..).map(|number| monitor_run_id(monitor, self.at, number)).find(|run| !is_known(run));
                let Some(run) = run else { return };
                let cause = RunCause::Monitor(monitor);
                self.emit(MissionEventKind::RunQueued { run, mission, cause, priority: i32::MAX });
                if let Some((other, _)) = active {
                    match afterwards {
                        Resumption::Resume => {
                            self.fire_run_because(other, RunTrigger::InterruptBegan, reason);
                        }
                        Resumption::Drop => self.fire_run(other, RunTrigger::InterruptDrops),
                    }
                }
            }
            _ => {}
        }
    }
}
