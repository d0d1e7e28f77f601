//! Connects the mission runner with the rest of the stack: what happens becomes its input, and what it wants becomes goals, commits, calls of actions, answers and
//! notices. Goals on the topological map are in `route_goals.rs`.

use super::conversions::{goal_kind, map_zone, severity};
use super::ledger_events::{ResultPose, write};
use super::status::mission_status;
use super::{action_info, platform};
use crate::{Running, notice, publish, texts};
use executive::Frames;
use geometry::pose_from_isometry;
use messages::{Command, Input, Publication, Severity, StackEffect};
use missions::{CHARGE_SIGNAL, MissionEffect, MissionInput, MissionSituation};
use site_model::{MissionCommand, MissionCommandKind, Utc};
use std::sync::Arc;
use vocab::{Covariance6, Pose, Stamp};

impl Running {
    /// An input that concerns missions only: the calendar time, actions, the site. Others change nothing.
    pub(crate) fn mission_input(&mut self, at: Stamp, input: Input, effects: &mut Vec<StackEffect>) {
        let input = match input {
            Input::WallClock { utc_ns, synchronised } => {
                MissionInput::Clock { utc: Utc(utc_ns), is_synchronised: synchronised }
            }
            Input::ActionDone { call, outcome } => return self.action_done(at, call, outcome, effects),
            Input::ActionsRegistered(actions) if self.missions.runner.is_none() => {
                self.missions.actions = action_info(actions);
                return;
            }
            Input::ActionsRegistered(actions) => MissionInput::Actions(action_info(actions)),
            Input::MissionsRestored(events) => {
                self.missions.restored = events;
                return;
            }
            Input::Site(snapshot) => MissionInput::Site(self.missions.set_site(*snapshot)),
            Input::SiteEdited(edit) => match self.missions.apply_edit(&edit) {
                Some(site) => MissionInput::Site(site),
                None => return,
            },
            _ => return,
        };
        self.update_missions(at, input, effects);
    }

    /// A command of missions. It is answered once what it leads to is durable.
    ///
    /// # Errors
    /// Before the site is known.
    pub(crate) fn mission_command(
        &mut self,
        at: Stamp,
        command: &Command,
        kind: MissionCommandKind,
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), String> {
        if self.missions.runner.is_none() {
            return Err(texts::NO_SITE.to_owned());
        }
        self.missions.waiting.push((), command.id, command.by.client);
        let command = MissionCommand { id: command.id, account: command.by.account.clone(), kind };
        self.update_missions(at, MissionInput::Command(command), effects);
        Ok(())
    }

    /// The charge of the battery and whether it grows.
    pub(crate) fn mission_battery(
        &mut self,
        at: Stamp,
        battery: messages::BatteryState,
        effects: &mut Vec<StackEffect>,
    ) {
        self.missions.battery = Some(battery);
        let value = f64::from(battery.charge);
        self.update_missions(at, MissionInput::Signal { name: CHARGE_SIGNAL.to_owned(), value }, effects);
    }

    /// Commits of the stack up to this number are durable.
    pub(crate) fn missions_committed(&mut self, at: Stamp, seq: u64, effects: &mut Vec<StackEffect>) {
        let count = self.missions.commits.partition_point(|(stack, _)| *stack <= seq);
        let durable = self.missions.commits.drain(..count).next_back();
        if let Some((_, number)) = durable {
            self.update_missions(at, MissionInput::Committed(number), effects);
        }
    }

    /// Looks where the robot is on the graph, and lets time pass. To be called with every tick.
    pub(crate) fn tick_missions(&mut self, at: Stamp, frames: &Frames, effects: &mut Vec<StackEffect>) {
        let period = self.missions.config.place_period;
        if self.missions.runner.is_none() || self.missions.looked_at.is_some_and(|last| at - last < period) {
            return;
        }
        let is_localised = self.is_localised_in_site();
        let map_from_base = is_localised.then(|| pose_from_isometry(&frames.map_from_base()));
        self.look_at_place(at, map_from_base, effects);
    }

    /// What follows from the pose in the map of the site, or from not knowing it.
    pub(super) fn look_at_place(
        &mut self,
        at: Stamp,
        map_from_base: Option<Pose>,
        effects: &mut Vec<StackEffect>,
    ) {
        self.missions.looked_at = Some(at);
        self.missions.map_from_base = map_from_base;
        let is_localised = map_from_base.is_some();
        let Some(runner) = &mut self.missions.runner else { return };
        // Zones are areas of the map of the site.
        let zones = runner.active_zones().filter(|_| is_localised).filter_map(map_zone);
        self.executive.set_zones(zones.collect());
        let graph = runner.route_graph(at).clone();
        let site = Arc::clone(runner.route_site());
        if let Some(pose) = &self.missions.map_from_base {
            self.missions.localiser.update(&site, &graph, pose);
        }
        let situation = MissionSituation {
            place: self.missions.localiser.place(),
            is_localised,
            can_move: self.can_move_for_missions(),
            docked: self.missions.docked(),
        };
        if situation != self.missions.situation {
            self.missions.situation = situation;
            self.update_missions(at, MissionInput::Situation(situation), effects);
        }
        self.update_missions(at, MissionInput::Tick, effects);
        self.report_waiting_run(at, is_localised, effects);
        if !self.executive.is_recovering() {
            // A route waits while the robot searches for its pose.
            let route = self.with_view(at, |executor, view| executor.tick(at, view));
            self.handle_route_effects(at, route, effects);
        }
        self.publish_route(at, effects);
    }

    /// Tells people once for each run that it waits because the robot is not localised.
    fn report_waiting_run(&mut self, at: Stamp, is_localised: bool, effects: &mut Vec<StackEffect>) {
        let waiting = if is_localised { None } else { self.missions.waiting_run() };
        if waiting.is_some() && waiting != self.missions.reported_waiting_run {
            effects.push(notice(at, Severity::Warning, texts::RUN_WAITS_FOR_PLACE.to_owned()));
        }
        self.missions.reported_waiting_run = waiting.or(self.missions.reported_waiting_run);
    }

    /// Handles what has become of goals and legs in this step, and what follows from it.
    pub(crate) fn settle_missions(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        while self.handle_goal_events(at, effects) || !self.missions.pending.is_empty() {
            self.drain_missions(at, effects);
        }
        if std::mem::take(&mut self.missions.is_changed)
            && let Some(runner) = &self.missions.runner
        {
            let status = mission_status(runner);
            if self.missions.published.as_deref() != Some(&status) {
                let status = Arc::new(status);
                self.missions.published = Some(Arc::clone(&status));
                publish(effects, Publication::Missions(status));
            }
        }
    }

    pub(super) fn update_missions(&mut self, at: Stamp, input: MissionInput, effects: &mut Vec<StackEffect>) {
        self.missions.pending.push_back(input);
        self.drain_missions(at, effects);
    }

    /// Gives the runner its inputs, one after the other: the effects of one are handled before the next, so that commits are in the order of their numbers.
    fn drain_missions(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        while let Some(input) = self.missions.pending.pop_front() {
            let Some(runner) = &mut self.missions.runner else { continue };
            self.missions.is_changed |= !matches!(input, MissionInput::Tick | MissionInput::Situation(_));
            let wanted = runner.update(at, input);
            self.missions.is_changed |= !wanted.is_empty();
            for effect in wanted {
                self.handle_mission_effect(at, effect, effects);
            }
        }
    }

    pub(super) fn handle_mission_effect(
        &mut self,
        at: Stamp,
        effect: MissionEffect,
        effects: &mut Vec<StackEffect>,
    ) {
        match effect {
            MissionEffect::Commit { number, events } => {
                let result_pose = ResultPose {
                    map_from_base: self.missions.map_from_base,
                    covariance: self
                        .localisation
                        .covariance()
                        .map(|matrix| Covariance6(crate::rows(&matrix))),
                    is_localised: self.missions.situation.is_localised,
                };
                let (written, site) = (&mut self.missions.written, &self.missions.site);
                let rows = events.iter().flat_map(|event| write(event, written, site, &result_pose));
                let (seq, commit) = self.commits.begin_events(rows.collect());
                self.missions.commits.push_back((seq, number));
                effects.push(commit);
            }
            MissionEffect::RequestGoal { goal, request } => {
                let has_begun = self.can_move_for_missions()
                    && self.begin_route(at, (goal, goal_kind(request), platform()), request, effects).is_ok();
                if !has_begun {
                    let result = missions::RouteGoalResult::MotionTaken;
                    self.missions.pending.push_back(MissionInput::Goal { goal, result });
                }
            }
            MissionEffect::CancelGoal(goal) => {
                let situation = self.situation(self.frames(self.last.as_deref()));
                self.executive.cancel_goal(at, goal, platform(), &situation, effects);
                self.handle_goal_events(at, effects);
            }
            MissionEffect::CallAction { call, request, .. }
            | MissionEffect::CallRouteAction { call, request } => self.call_action(call, request, effects),
            MissionEffect::RefuseRouteAction { call, reason } => {
                let route =
                    self.with_view(at, |executor, view| executor.end_action(at, call, Err(reason), view));
                self.handle_route_effects(at, route, effects);
            }
            MissionEffect::CancelAction(call) => self.cancel_action(at, call, effects),
            MissionEffect::Answer { command, refused } => {
                if let Some(client) = self.missions.waiting.take(command) {
                    self.answer(command, client, refused, effects);
                }
            }
            MissionEffect::Notice(mission_notice) => {
                effects.push(notice(
                    at,
                    severity(mission_notice),
                    missions::notice(mission_notice, &self.missions.site),
                ));
            }
        }
    }
}

#[cfg(test)]
#[path = "wiring_tests.rs"]
mod tests;
