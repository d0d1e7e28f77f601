//! Connects missions with the rest of the stack: what happens becomes an input of the runner or the executor, and what they want becomes goals of the executive,
//! commits, calls of actions, answers and notices.

use super::conversions::{goal_failure, goal_kind, is_walk, leg_result, map_zone, pose_goal, severity};
use super::ledger_events::{Whereabouts, write};
use super::status::mission_status;
use super::{MissionConfig, action_info, platform};
use crate::{Running, notice, publish, texts};
use executive::{DockGoal, Frames};
use geometry::{Vector3, isometry_from_pose, pose_from_isometry};
use messages::{
    CancelCause, Command, ExecutiveState, GoalKind, GoalResult, GoalStatus, GoalUpdate, Input, LedgerEvent,
    Principal, Publication, Severity, SiteWrite, StackEffect,
};
use missions::{
    CHARGE_SIGNAL, GoalRequest, LegResult, LegWay, MissionEffect, MissionInput, RouteEffect, RouteView,
    Situation,
};
use site_model::{
    DockId, MissionCommand, MissionCommandKind, Object, ObjectId, ReachFailure, RouteStatus, Utc,
};
use std::collections::VecDeque;
use std::sync::Arc;
use vocab::{Covariance6, GoalId, Stamp};

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
            Input::Site(snapshot) => MissionInput::Site(self.missions.take_site(*snapshot)),
            Input::SiteEdited(edit) => match self.missions.take_edit(&edit) {
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
        if self.missions.waiting.len() >= self.missions.config.waiting_max {
            self.missions.waiting.pop_first();
        }
        self.missions.waiting.insert(command.id, command.by.client);
        let command = MissionCommand { id: command.id, kind };
        self.update_missions(at, MissionInput::Command(command), effects);
        Ok(())
    }

    /// Somebody asks for a goal on the topological map.
    ///
    /// # Errors
    /// Why it cannot begin, with what to do.
    pub(crate) fn start_route(
        &mut self,
        at: Stamp,
        (id, kind, by): (GoalId, GoalKind, Principal),
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), String> {
        if self.missions.goal.as_ref().is_some_and(|goal| goal.id == id) {
            return Ok(());
        }
        let request = match kind {
            GoalKind::GoToNode(node) => GoalRequest::Route(node),
            GoalKind::GoToDock(dock) => GoalRequest::Dock(dock),
            _ => GoalRequest::Undock,
        };
        if self.missions.runner.is_none() {
            return Err(texts::NO_SITE.to_owned());
        }
        if self.executive.state() == ExecutiveState::Stopped {
            return Err(texts::MOTION_IS_STOPPED.to_owned());
        }
        if !self.is_localised_in_site() {
            return Err(texts::NOT_LOCALISED_IN_SITE.to_owned());
        }
        // A run that uses the robot is paused by this, as by any other goal of a person.
        self.missions.cancelled = Some((by.clone(), CancelCause::Replaced(id)));
        self.end_route_as_taken(at, effects);
        self.begin_route(at, id, request, kind, by, effects);
        Ok(())
    }

    /// Somebody cancels a goal. Whether it was one on the topological map.
    pub(crate) fn cancel_route(
        &mut self,
        at: Stamp,
        goal: GoalId,
        by: &Principal,
        effects: &mut Vec<StackEffect>,
    ) -> bool {
        if self.missions.executor.goal() != Some(goal) {
            return false;
        }
        self.missions.cancelled = Some((by.clone(), CancelCause::Requested));
        let ended = self.missions.executor.cancel(goal);
        // A person has ended what a run wanted: it is paused.
        let is_of_runner = self.missions.is_of_runner(goal);
        let ended = ended.into_iter().map(|effect| match effect {
            RouteEffect::Ended(goal, missions::GoalResult::Cancelled) if is_of_runner => {
                RouteEffect::Ended(goal, missions::GoalResult::MotionTaken)
            }
            effect => effect,
        });
        let ended = ended.collect();
        self.handle_route_effects(at, ended, effects);
        true
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
        self.missions.looked_at = Some(at);
        let is_localised = self.is_localised_in_site();
        self.missions.map_from_base = is_localised.then(|| pose_from_isometry(&frames.map_from_base()));
        let Some(runner) = &mut self.missions.runner else { return };
        // Zones are areas of the map of the site.
        let zones = runner.active_zones().filter(|_| is_localised).filter_map(map_zone);
        self.executive.set_zones(zones.collect());
        let graph = runner.route_graph(at).clone();
        let site = Arc::clone(runner.route_site());
        if let Some(pose) = &self.missions.map_from_base {
            self.missions.localiser.update(&site, &graph, pose);
        }
        let situation = Situation {
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
        self.tell_waiting(at, is_localised, effects);
        let route = self.with_view(at, |executor, view| executor.tick(at, view));
        self.handle_route_effects(at, route, effects);
        self.publish_route(at, effects);
    }

    /// Tells people once for each run that it waits because the robot is not localised.
    fn tell_waiting(&mut self, at: Stamp, is_localised: bool, effects: &mut Vec<StackEffect>) {
        let waiting = if is_localised { None } else { self.missions.waiting_run() };
        if waiting.is_some() && waiting != self.missions.told_waiting {
            effects.push(notice(at, Severity::Warning, texts::RUN_WAITS_FOR_PLACE.to_owned()));
        }
        self.missions.told_waiting = waiting.or(self.missions.told_waiting);
    }

    /// Handles what goals of the executive have come to since `from`, the number of effects before this step. Walks of routes are not published one by one: the
    /// goal that they belong to is.
    pub(crate) fn settle_missions(&mut self, at: Stamp, from: usize, effects: &mut Vec<StackEffect>) {
        loop {
            let ended = self.take_walk_updates(from, effects);
            if ended.is_empty() && self.missions.pending.is_empty() {
                break;
            }
            for (walk, result) in ended {
                if self.end_turn(at, walk, &result, effects) {
                    continue;
                }
                let route = self.with_view(at, |executor, view| executor.end_leg(at, walk, result, view));
                self.handle_route_effects(at, route, effects);
            }
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

    /// Takes the updates of walks out of the effects. Returns those that have ended.
    fn take_walk_updates(&mut self, from: usize, effects: &mut Vec<StackEffect>) -> Vec<(GoalId, LegResult)> {
        let (walk, goal) = (self.missions.executor.walk(), self.missions.executor.goal());
        let turn = self.missions.turn();
        let mut ended = Vec::new();
        let mut index = from;
        while let Some(effect) = effects.get_mut(index) {
            match effect {
                StackEffect::Publish(Publication::Executive(status)) if status.goal == walk => {
                    status.goal = goal;
                }
                // A turn of the body belongs to an action, and to no goal that clients know.
                StackEffect::Publish(Publication::Executive(status)) if status.goal == turn => {
                    status.goal = None;
                }
                StackEffect::Publish(Publication::Goal(update)) if is_walk(update) => {
                    if let GoalStatus::Cancelled { by, cause } = &update.status {
                        self.missions.cancelled = Some((by.clone(), *cause));
                    }
                    ended.extend(leg_result(&update.status).map(|result| (update.id, result)));
                    match (&update.status, &mut self.missions.goal) {
                        (GoalStatus::Running(progress), Some(goal)) if walk == Some(update.id) => {
                            goal.status = GoalStatus::Running(*progress);
                            *effect = StackEffect::Publish(Publication::Goal(goal.clone()));
                        }
                        _ => {
                            effects.remove(index);
                            continue;
                        }
                    }
                }
                _ => {}
            }
            index += 1;
        }
        ended
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

    fn handle_mission_effect(&mut self, at: Stamp, effect: MissionEffect, effects: &mut Vec<StackEffect>) {
        match effect {
            MissionEffect::Commit { number, events } => {
                let whereabouts = Whereabouts {
                    map_from_base: self.missions.map_from_base,
                    covariance: self
                        .localisation
                        .covariance()
                        .map(|matrix| Covariance6(crate::rows(&matrix))),
                    is_localised: self.missions.situation.is_localised,
                };
                let (written, site) = (&mut self.missions.written, &self.missions.site);
                let rows = events.iter().flat_map(|event| write(event, written, site, &whereabouts));
                let (seq, commit) = self.commits.begin_events(rows.collect());
                self.missions.commits.push_back((seq, number));
                effects.push(commit);
            }
            MissionEffect::RequestGoal { goal, request } => {
                if self.can_move_for_missions() {
                    let kind = goal_kind(request);
                    self.begin_route(at, goal, request, kind, platform(), effects);
                } else {
                    let result = missions::GoalResult::MotionTaken;
                    self.missions.pending.push_back(MissionInput::Goal { goal, result });
                }
            }
            MissionEffect::CancelGoal(goal) => {
                self.missions.cancelled = Some((platform(), CancelCause::Requested));
                let ended = self.missions.executor.cancel(goal);
                self.handle_route_effects(at, ended, effects);
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
                if let Some(client) = self.missions.waiting.remove(&command) {
                    self.answer(command, client, refused, effects);
                }
            }
            MissionEffect::Notice(told) => {
                effects.push(notice(at, severity(told), missions::notice(told, &self.missions.site)));
            }
        }
    }

    fn begin_route(
        &mut self,
        at: Stamp,
        goal: GoalId,
        request: GoalRequest,
        kind: GoalKind,
        by: Principal,
        effects: &mut Vec<StackEffect>,
    ) {
        let status = GoalStatus::Accepted;
        let update = GoalUpdate { id: goal, kind, by, accepted: at, status };
        publish(effects, Publication::Goal(update.clone()));
        self.missions.goal = Some(update);
        let route = self.with_view(at, |executor, view| executor.begin(at, goal, request, view));
        self.handle_route_effects(at, route, effects);
        self.publish_route(at, effects);
    }

    /// Ends the goal that is under way, because somebody else wants the robot.
    fn end_route_as_taken(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        let Some(goal) = self.missions.executor.goal() else { return };
        let ended = self.missions.executor.cancel(goal).into_iter().map(|effect| match effect {
            RouteEffect::Ended(goal, _) => RouteEffect::Ended(goal, missions::GoalResult::MotionTaken),
            effect => effect,
        });
        let ended = ended.collect();
        self.handle_route_effects(at, ended, effects);
    }

    pub(super) fn handle_route_effects(
        &mut self,
        at: Stamp,
        route: Vec<RouteEffect>,
        effects: &mut Vec<StackEffect>,
    ) {
        let mut route = VecDeque::from(route);
        while let Some(effect) = route.pop_front() {
            match effect {
                RouteEffect::Walk(walk, leg) => {
                    let situation = self.situation(self.frames(self.last.as_deref()));
                    let (pose, by) = (pose_goal(&leg), platform());
                    let started = match leg.way {
                        LegWay::OntoDock { is_facing } => {
                            let (map_from_docked, speed_max_m_s) = (leg.map_from_goal, leg.speed_max_m_s);
                            let dock = DockGoal { map_from_docked, is_facing, speed_max_m_s };
                            self.executive.start_docking(at, (walk, pose, by), dock, &situation, effects)
                        }
                        LegWay::Path | LegWay::Straight => {
                            let goal = (walk, GoalKind::WalkToPose(pose), by);
                            self.executive.start_goal(at, goal, &situation, effects)
                        }
                    };
                    if started.is_err() {
                        let result = match self.executive.state() {
                            ExecutiveState::Stopped | ExecutiveState::ManualDriving => LegResult::MotionTaken,
                            _ => LegResult::Failed(ReachFailure::PoseNotFound),
                        };
                        let more =
                            self.with_view(at, |executor, view| executor.end_leg(at, walk, result, view));
                        route.extend(more);
                    }
                }
                RouteEffect::CancelWalk(walk) => {
                    let situation = self.situation(self.frames(self.last.as_deref()));
                    self.executive.cancel_goal(at, walk, platform(), &situation, effects);
                }
                RouteEffect::Ended(goal, result) => self.end_route(at, goal, result, effects),
                RouteEffect::Block(block) => {
                    let write = SiteWrite { put: vec![Object::EdgeBlock(block)], removed: Vec::new() };
                    self.commit_site_write(write, effects);
                }
                RouteEffect::Unblock(edge) => {
                    let write = SiteWrite { put: Vec::new(), removed: vec![ObjectId::EdgeBlock(edge)] };
                    self.commit_site_write(write, effects);
                }
                RouteEffect::Traversed(edge, took) => {
                    self.missions.pending.push_back(MissionInput::Traversed { edge, took });
                }
                RouteEffect::CallAction(call, place, request) => {
                    self.call_route_action(call, place, request, effects);
                }
                RouteEffect::CancelAction(call) => self.cancel_route_action(at, call, effects),
                RouteEffect::ActionFailed(action, reason) => {
                    let text = texts::edge_action_failed(&action, &reason);
                    effects.push(notice(at, Severity::Warning, text));
                }
            }
        }
        self.publish_route(at, effects);
    }

    fn commit_site_write(&mut self, write: SiteWrite, effects: &mut Vec<StackEffect>) {
        let (_, commit) = self.commits.begin_events(vec![LedgerEvent::Site(write)]);
        effects.push(commit);
    }

    /// Publishes the outcome of a goal, and tells the runner if it is its own.
    fn end_route(
        &mut self,
        at: Stamp,
        goal: GoalId,
        result: missions::GoalResult,
        effects: &mut Vec<StackEffect>,
    ) {
        let is_of_runner = self.missions.is_of_runner(goal);
        if let Some(mut update) = self.missions.goal.take_if(|known| known.id == goal) {
            let (by, cause) =
                self.missions.cancelled.take().unwrap_or((update.by.clone(), CancelCause::Requested));
            let frames = self.frames(self.last.as_deref());
            update.status = match &result {
                missions::GoalResult::Reached => GoalStatus::Succeeded(GoalResult {
                    map_from_base: pose_from_isometry(&frames.map_from_base()),
                    took: at - update.accepted,
                }),
                missions::GoalResult::Failed(reason) => {
                    GoalStatus::Failed { reason: goal_failure(reason), tried: Vec::new() }
                }
                missions::GoalResult::MotionTaken | missions::GoalResult::Cancelled => {
                    GoalStatus::Cancelled { by, cause }
                }
            };
            if let GoalKind::GoToDock(dock) = update.kind {
                self.tell_docking(at, dock, &result, effects);
            }
            publish(effects, Publication::Goal(update));
        }
        if is_of_runner {
            self.missions.pending.push_back(MissionInput::Goal { goal, result });
        }
    }

    /// Tells people why the robot is not in a dock, or that the dock is not where the map has it.
    fn tell_docking(
        &self,
        at: Stamp,
        dock: DockId,
        result: &missions::GoalResult,
        effects: &mut Vec<StackEffect>,
    ) {
        let site = &self.missions.site;
        let Some(dock) = site.docks().find(|known| known.id == dock) else { return };
        let text = match result {
            missions::GoalResult::Failed(reason) => {
                Some((Severity::Warning, texts::not_docked(&dock.name, &missions::reach_failure(reason))))
            }
            missions::GoalResult::Reached => {
                let node = site.node(dock.node).and_then(|node| isometry_from_pose(&node.map_from_node));
                let node_from_base = node
                    .zip(self.missions.map_from_base)
                    .and_then(|(node, base)| Some(node.inverse() * isometry_from_pose(&base)?));
                node_from_base.and_then(|offset| {
                    let ahead = offset.rotation * Vector3::x();
                    let (moved_m, turned_rad) =
                        (offset.translation.vector.xy().norm(), ahead.y.atan2(ahead.x).abs());
                    let MissionConfig { dock_moved_m, dock_turned_rad, .. } = self.missions.config;
                    let is_elsewhere = moved_m > dock_moved_m || turned_rad > dock_turned_rad;
                    let text = || texts::dock_is_elsewhere(&dock.name, moved_m, turned_rad);
                    is_elsewhere.then(|| (Severity::Info, text()))
                })
            }
            missions::GoalResult::MotionTaken | missions::GoalResult::Cancelled => None,
        };
        effects.extend(text.map(|(severity, text)| notice(at, severity, text)));
    }

    fn publish_route(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        if self.missions.runner.is_none() {
            return;
        }
        let mut route = None;
        if self.missions.executor.goal().is_some() {
            self.with_view(at, |executor, view| {
                route = executor.progress(view);
                Vec::new()
            });
        }
        let place = self.missions.place();
        let docked = self.missions.situation.docked;
        let status = RouteStatus { at: place.at, nearest: place.nearest, on: place.on, docked, route };
        if self.missions.published_route.as_deref() != Some(&status) {
            let status = Arc::new(status);
            self.missions.published_route = Some(Arc::clone(&status));
            publish(effects, Publication::Route(status));
        }
    }

    /// Calls the executor with what it sees. Without a site it has nothing to do.
    pub(super) fn with_view(
        &mut self,
        at: Stamp,
        call: impl FnOnce(&mut missions::RouteExecutor, &RouteView<'_>) -> Vec<RouteEffect>,
    ) -> Vec<RouteEffect> {
        let missions = &mut self.missions;
        let Some(runner) = &mut missions.runner else { return Vec::new() };
        let (site, newest) = (Arc::clone(runner.route_site()), Arc::clone(runner.newest_site()));
        let view = RouteView {
            site: &site,
            newest: &newest,
            time_of_day: runner.time_of_day(),
            graph: runner.route_graph(at),
            map_from_base: missions.map_from_base,
            place: missions.situation.place,
            docked: missions.situation.docked,
        };
        call(&mut missions.executor, &view)
    }

    /// Whether the robot is localised in the map of the site, or in any if the site names none.
    fn is_localised_in_site(&self) -> bool {
        let wanted = self.missions.site.settings().and_then(|settings| settings.map);
        let map = self.localisation.localised_map();
        map.is_some() && (wanted.is_none() || map == wanted)
    }

    /// Whether missions may move the robot: motion is not stopped, nobody drives, and no goal of a person is executed.
    pub(super) fn can_move_for_missions(&self) -> bool {
        match self.executive.state() {
            ExecutiveState::Stopped | ExecutiveState::ManualDriving => false,
            ExecutiveState::Idle => {
                self.missions.executor.goal().is_none_or(|goal| self.missions.is_of_runner(goal))
            }
            ExecutiveState::Executing | ExecutiveState::Recovering => {
                let goal = self.executive.goal();
                if goal.is_some() && goal == self.missions.turn() {
                    return true;
                }
                let is_own = goal.is_some() && goal == self.missions.executor.walk();
                is_own && self.missions.executor.goal().is_some_and(|goal| self.missions.is_of_runner(goal))
            }
        }
    }
}
