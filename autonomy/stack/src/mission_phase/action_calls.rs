//! Calls of actions, for tasks of missions, and for edges and zones on routes. Where the camera's head does not pan far enough, the executive turns the body, and the
//! action is called again. For an edge the turn is a leg of the goal that is under way, and for a task a goal that clients do not see.

use super::open_call::{OpenCall, TurnEnd, turn_goal};
use super::platform;
use crate::{Running, texts};
use executive::RouteLeg;
use geometry::pose_from_isometry;
use messages::{ActionOutcome, Approach, GoalKind, PoseGoal, StackEffect};
use missions::{ActionResult, MissionInput, turn_leg_id, turned};
use site_model::{ActionRequest, PoseTolerance, RouteActionPlace};
use vocab::{ActionCallId, LegId, Stamp};

impl Running {
    pub(super) fn call_action(
        &mut self,
        call: ActionCallId,
        request: ActionRequest,
        effects: &mut Vec<StackEffect>,
    ) {
        // Maps and lists of plain values are always written.
        let parameters = serde_json::to_string(&request.parameters).unwrap_or_default();
        let open = OpenCall::new(request.action, parameters);
        effects.push(open.effect(call));
        self.missions.calls.insert(call, open);
    }

    /// Calls an action of an edge or a zone. On the way of a run it is recorded first, and the runner decides.
    pub(super) fn call_route_action(
        &mut self,
        call: ActionCallId,
        place: RouteActionPlace,
        request: ActionRequest,
        effects: &mut Vec<StackEffect>,
    ) {
        let is_of_runner = self.executive.request().is_some_and(|(_, by)| *by == platform());
        match self.missions.executor.goal().filter(|_| is_of_runner) {
            Some(goal) => {
                let wanted = MissionInput::RouteActionWanted { goal, call, place, request };
                self.missions.pending.push_back(wanted);
            }
            None => self.call_action(call, request, effects),
        }
    }

    /// Cancels a call of an action of an edge or a zone.
    pub(super) fn cancel_route_action(
        &mut self,
        at: Stamp,
        call: ActionCallId,
        effects: &mut Vec<StackEffect>,
    ) {
        if self.missions.calls.contains_key(&call) {
            self.cancel_action(at, call, effects);
        } else {
            // It waits until it is durable, or for the runner.
            self.missions.pending.push_back(MissionInput::RouteActionCancelled(call));
        }
    }

    /// Cancels a call. Its end follows.
    pub(super) fn cancel_action(&mut self, at: Stamp, call: ActionCallId, effects: &mut Vec<StackEffect>) {
        let Some(turn) = self.missions.calls.get(&call).and_then(|open| open.turn) else {
            return effects.push(StackEffect::CancelAction(call));
        };
        self.missions.calls.remove(&call);
        let situation = self.situation(self.frames(self.last.as_deref()));
        // It is one of the two.
        self.executive.end_leg(turn, effects);
        self.executive.cancel_goal(at, turn_goal(turn), platform(), &situation, effects);
        let (result, runner) = (ActionResult::Cancelled, self.missions.runner.as_ref());
        self.missions.pending.push_back(match runner.is_some_and(|runner| runner.is_route_action(call)) {
            true => MissionInput::RouteActionEnded { call, result },
            false => MissionInput::Action { call, result },
        });
    }

    /// A call has ended, or needs another heading of the body.
    pub(super) fn action_done(
        &mut self,
        at: Stamp,
        call: ActionCallId,
        outcome: ActionOutcome,
        effects: &mut Vec<StackEffect>,
    ) {
        let result = match outcome {
            ActionOutcome::Succeeded { result } => ActionResult::Succeeded(Some(result)),
            ActionOutcome::Failed { reason } => ActionResult::Failed(reason),
            ActionOutcome::Cancelled => ActionResult::Cancelled,
            ActionOutcome::NeedsTurn { turn_rad } => {
                if self.begin_turn(at, call, turn_rad, effects) {
                    return;
                }
                ActionResult::Failed(texts::body_not_turned(turn_rad))
            }
        };
        self.end_call(at, call, result, effects);
    }

    /// Gives the end of a call to whoever has made it.
    fn end_call(
        &mut self,
        at: Stamp,
        call: ActionCallId,
        result: ActionResult,
        effects: &mut Vec<StackEffect>,
    ) {
        self.missions.calls.remove(&call);
        if self.missions.runner.as_ref().is_some_and(|runner| runner.is_route_action(call)) {
            let result = result.clone();
            self.missions.pending.push_back(MissionInput::RouteActionEnded { call, result });
        }
        if self.missions.executor.is_calling(call) {
            let result = match result {
                ActionResult::Succeeded(_) => Ok(()),
                ActionResult::Failed(reason) => Err(reason),
                ActionResult::Cancelled => Err(texts::ACTION_CANCELLED.to_owned()),
                ActionResult::Unavailable => Err(texts::ACTION_UNAVAILABLE.to_owned()),
            };
            let route = self.with_view(at, |executor, view| executor.end_action(at, call, result, view));
            self.handle_route_effects(at, route, effects);
        } else {
            self.update_missions(at, MissionInput::Action { call, result }, effects);
        }
    }

    /// Turns the body for a call, where it stands. Returns false if it cannot turn now, or has turned as often as it may.
    fn begin_turn(
        &mut self,
        at: Stamp,
        call: ActionCallId,
        turn_rad: f64,
        effects: &mut Vec<StackEffect>,
    ) -> bool {
        let config = self.missions.config;
        let running = self.executive.goal();
        // The goal on whose way the robot stands for the call.
        let goal = running.filter(|_| self.missions.executor.is_standing_for(call));
        let is_free = goal.is_some() || (running.is_none() && self.can_move_for_missions());
        let frames = self.frames(self.last.as_deref());
        let Some(open) = self.missions.calls.get_mut(&call).filter(|_| is_free && turn_rad.is_finite())
        else {
            return false;
        };
        if open.turns >= config.max_turns {
            return false;
        }
        let turn = turn_leg_id(call, open.turns);
        open.turns += 1;
        open.turn = Some(turn);
        let turn_rad = turn_rad + config.turn_margin_rad.copysign(turn_rad);
        let map_from_goal = turned(&pose_from_isometry(&frames.map_from_base()), turn_rad);
        let pose = PoseGoal {
            map_from_goal,
            tolerance: Some(PoseTolerance::default()),
            max_speed_m_s: None,
            approach: Approach::Path,
        };
        let situation = self.situation(frames);
        let has_begun = match goal {
            Some(goal) => {
                let leg = RouteLeg { id: turn, pose, dock: None };
                self.executive.begin_leg(at, goal, leg, &situation, effects).is_ok()
            }
            None => {
                let goal = (turn_goal(turn), GoalKind::WalkToPose(pose), platform());
                self.executive.start_hidden_goal(at, goal, &situation, effects).is_ok()
            }
        };
        if !has_begun && let Some(open) = self.missions.calls.get_mut(&call) {
            open.turn = None;
        }
        has_begun
    }

    /// A turn of the body has ended. Returns whether it is one.
    pub(super) fn end_turn(
        &mut self,
        at: Stamp,
        turn: LegId,
        end: TurnEnd,
        effects: &mut Vec<StackEffect>,
    ) -> bool {
        let mut calls = self.missions.calls.iter_mut();
        let Some((call, open)) = calls.find(|(_, open)| open.turn == Some(turn)) else { return false };
        let call = *call;
        open.turn = None;
        let reason = match end {
            TurnEnd::Turned => {
                effects.push(open.effect(call));
                return true;
            }
            TurnEnd::MotionTaken => texts::MOTION_TAKEN_WHILE_TURNING.to_owned(),
            TurnEnd::Blocked => texts::TURN_BLOCKED.to_owned(),
        };
        self.end_call(at, call, ActionResult::Failed(reason), effects);
        true
    }
}

#[cfg(test)]
#[path = "action_calls_tests.rs"]
mod tests;
