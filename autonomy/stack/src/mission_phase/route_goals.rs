//! Goals on the topological map: the executive has the goal, and the route executor decides its legs. This file carries legs, their ends and the outcome between the
//! two, and tells the mission runner and clients.

use super::conversions::{
    goal_attempt, goal_failure, goal_result, leg_result, reach_failure, route_leg, route_remainder,
    turn_end_of_goal, turn_end_of_leg,
};
use super::platform;
use crate::{Running, notice, publish, texts};
use executive::GoalEvent;
use messages::{
    ExecutiveState, GoalKind, GoalUpdate, LedgerEvent, Principal, Publication, Severity, SiteWrite,
    StackEffect,
};
use missions::{
    DockOffset, GoalRequest, LegResult, LegWalk, MissionInput, RouteEffect, RouteGoalResult, RouteRemaining,
    RouteView,
};
use site_model::{DockId, Object, ObjectId, RouteStatus};
use std::collections::VecDeque;
use std::sync::Arc;
use vocab::{GoalId, LegId, MapId, Stamp};

impl Running {
    /// Somebody asks for a goal on the topological map. A goal that was asked for before has no effect.
    ///
    /// # Errors
    /// Why it cannot begin, with what to do.
    pub(crate) fn start_route(
        &mut self,
        at: Stamp,
        goal: (GoalId, GoalKind, Principal),
        request: GoalRequest,
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), String> {
        if self.executive.knows_goal(goal.0) {
            return Ok(());
        }
        if self.missions.runner.is_none() {
            return Err(texts::NO_SITE.to_owned());
        }
        if !self.is_localised_in_site() {
            return Err(texts::NOT_LOCALISED_IN_SITE.to_owned());
        }
        self.begin_route(at, goal, request, effects)
    }

    /// Begins a goal. The one before it ends by that, and a run that wanted that is paused.
    ///
    /// # Errors
    /// Why the executive refuses it.
    pub(super) fn begin_route(
        &mut self,
        at: Stamp,
        goal: (GoalId, GoalKind, Principal),
        request: GoalRequest,
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), String> {
        let id = goal.0;
        let situation = self.situation(self.frames(self.last.as_deref()));
        self.executive.start_goal(at, goal, &situation, effects)?;
        self.handle_goal_events(at, effects);
        if self.executive.goal() != Some(id) {
            return Err(texts::GOAL_KNOWN.to_owned());
        }
        let route = self.with_view(at, |executor, view| executor.begin(at, id, request, view));
        self.handle_route_effects(at, route, effects);
        Ok(())
    }

    /// Handles what has become of goals and legs. Returns whether anything has.
    pub(crate) fn handle_goal_events(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) -> bool {
        let events = self.executive.take_events();
        let is_changed = !events.is_empty();
        for event in events {
            match event {
                GoalEvent::LegEnded(leg, outcome) => {
                    if !self.end_turn(at, leg, turn_end_of_leg(outcome), effects) {
                        self.end_leg(at, leg, leg_result(outcome), effects);
                    }
                }
                GoalEvent::Ended(update) => self.handle_ended_goal(at, &update, effects),
            }
        }
        is_changed
    }

    fn end_leg(&mut self, at: Stamp, leg: LegId, result: LegResult, effects: &mut Vec<StackEffect>) {
        let route = self.with_view(at, |executor, view| executor.end_leg(at, leg, result, view));
        self.handle_route_effects(at, route, effects);
    }

    /// A goal has ended. If the executor has not ended it itself, its legs end too.
    fn handle_ended_goal(&mut self, at: Stamp, update: &GoalUpdate, effects: &mut Vec<StackEffect>) {
        let GoalUpdate { id, kind, status, .. } = update;
        if self.end_turn(at, LegId(id.0), turn_end_of_goal(status), effects) {
            return;
        }
        if self.missions.executor.goal() == Some(*id)
            && let Some(result) = goal_result(status)
        {
            let dropped = self.missions.executor.cancel(*id);
            self.handle_route_effects(at, dropped, effects);
            self.report_route_end(at, (*id, *kind), result, effects);
        }
    }

    /// The executor has ended its goal.
    fn end_route(
        &mut self,
        at: Stamp,
        goal: GoalId,
        result: RouteGoalResult,
        effects: &mut Vec<StackEffect>,
    ) {
        let outcome = match &result {
            RouteGoalResult::Reached => Ok(()),
            RouteGoalResult::Failed(reason) => Err(goal_failure(reason)),
            // The executive has ended the goal, and the executor follows.
            RouteGoalResult::MotionTaken | RouteGoalResult::Cancelled => return,
        };
        let Some((kind, _)) = self.executive.request().filter(|_| self.executive.goal() == Some(goal)) else {
            return;
        };
        let situation = self.situation(self.frames(self.last.as_deref()));
        self.executive.end_route(at, goal, outcome, &situation, effects);
        self.report_route_end(at, (goal, kind), result, effects);
    }

    /// Tells the runner, which knows its own goals, and people how a goal ended.
    fn report_route_end(
        &mut self,
        at: Stamp,
        (goal, kind): (GoalId, GoalKind),
        result: RouteGoalResult,
        effects: &mut Vec<StackEffect>,
    ) {
        if let GoalKind::GoToDock(dock) = kind {
            self.report_docking(at, dock, &result, effects);
        }
        self.missions.pending.push_back(MissionInput::Goal { goal, result });
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
                RouteEffect::Walk(leg, walk) => route.extend(self.begin_leg(at, leg, &walk, effects)),
                RouteEffect::CancelWalk(leg) => self.executive.end_leg(leg, effects),
                RouteEffect::Tried(attempt) => {
                    if let Some(goal) = self.executive.goal() {
                        self.executive.add_attempt(goal, &goal_attempt(attempt));
                    }
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
                RouteEffect::Traversed(edge, duration) => {
                    self.missions.pending.push_back(MissionInput::Traversed { edge, duration });
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

    /// Begins a leg of the executor's goal. Returns what follows if it cannot begin.
    fn begin_leg(
        &mut self,
        at: Stamp,
        leg: LegId,
        walk: &LegWalk,
        effects: &mut Vec<StackEffect>,
    ) -> Vec<RouteEffect> {
        let Some(goal) = self.missions.executor.goal() else { return Vec::new() };
        let situation = self.situation(self.frames(self.last.as_deref()));
        match self.executive.begin_leg(at, goal, route_leg(leg, walk), &situation, effects) {
            Ok(()) => Vec::new(),
            Err(reason) => {
                let result = LegResult::Failed(reach_failure(reason));
                self.with_view(at, |executor, view| executor.end_leg(at, leg, result, view))
            }
        }
    }

    fn commit_site_write(&mut self, write: SiteWrite, effects: &mut Vec<StackEffect>) {
        let (_, commit) = self.commits.begin_events(vec![LedgerEvent::Site(write)]);
        effects.push(commit);
    }

    /// Tells people why the robot is not in a dock, or that the dock is not where the map has it.
    fn report_docking(
        &self,
        at: Stamp,
        dock: DockId,
        result: &RouteGoalResult,
        effects: &mut Vec<StackEffect>,
    ) {
        let site = &self.missions.site;
        let Some(dock) = site.docks().find(|known| known.id == dock) else { return };
        let text = match result {
            RouteGoalResult::Failed(reason) => {
                Some((Severity::Warning, texts::not_docked(&dock.name, &missions::reach_failure(reason))))
            }
            RouteGoalResult::Reached => {
                let map_from_base = self.missions.map_from_base;
                let offset = map_from_base.and_then(|pose| DockOffset::new(site, dock.id, &pose));
                let offset = offset.filter(|offset| offset.is_elsewhere(&self.missions.config.docks));
                offset.map(|DockOffset { distance_m, turned_rad }| {
                    (Severity::Info, texts::dock_is_elsewhere(&dock.name, distance_m, turned_rad))
                })
            }
            RouteGoalResult::MotionTaken | RouteGoalResult::Cancelled => None,
        };
        effects.extend(text.map(|(severity, text)| notice(at, severity, text)));
    }

    /// Publishes where the robot is on the map and its route, and keeps what is left of the route for the progress of the goal.
    pub(super) fn publish_route(&mut self, at: Stamp, effects: &mut Vec<StackEffect>) {
        if self.missions.runner.is_none() {
            return;
        }
        let (mut route, mut remaining) = (None, RouteRemaining::default());
        if let Some(goal) = self.missions.executor.goal() {
            self.with_view(at, |executor, view| {
                (route, remaining) = (executor.progress(view), executor.remaining(view));
                Vec::new()
            });
            self.executive.set_remainder(goal, route_remainder(remaining));
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
    pub(super) fn is_localised_in_site(&self) -> bool {
        let wanted = self.missions.site.settings().and_then(|settings| settings.map);
        is_map_of_site(self.localisation.localised_map(), wanted)
    }

    /// Whether missions may move the robot: motion is not stopped, nobody drives, and no goal of a person is executed.
    pub(super) fn can_move_for_missions(&self) -> bool {
        match self.executive.state() {
            ExecutiveState::Stopped | ExecutiveState::ManualDriving => false,
            ExecutiveState::Idle => true,
            ExecutiveState::Executing | ExecutiveState::Recovering => {
                self.executive.request().is_some_and(|(_, by)| *by == platform())
            }
        }
    }
}

/// Whether the map in which the robot is localised is that of the site. A site that names none has any.
fn is_map_of_site(localised: Option<MapId>, of_site: Option<MapId>) -> bool {
    localised.is_some() && (of_site.is_none() || localised == of_site)
}

#[cfg(test)]
#[path = "route_goals_tests.rs"]
mod tests;
