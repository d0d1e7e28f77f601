//! Calls of actions, for tasks of missions, and for edges and zones on routes. Where the camera's head does not pan far enough, a goal of the executive turns the body, and the action
//! is called again.

use super::open_call::OpenCall;
use super::platform;
use crate::{Running, texts};
use geometry::{Rotation, Vector3, isometry_from_pose, pose_from_isometry};
use messages::{ActionOutcome, Approach, GoalKind, PoseGoal, StackEffect};
use missions::{ActionResult, LegResult, MissionInput, turn_goal_id};
use site_model::{ActionRequest, PoseTolerance, RouteActionPlace};
use vocab::{ActionCallId, GoalId, Pose, Stamp};

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
        match self.missions.executor.goal().filter(|goal| self.missions.is_of_runner(*goal)) {
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
        self.executive.cancel_goal(at, turn, platform(), &situation, effects);
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
        let is_free = self.can_move_for_missions()
            && self.missions.executor.walk().is_none()
            && self.missions.turn().is_none();
        let frames = self.frames(self.last.as_deref());
        let Some(open) = self.missions.calls.get_mut(&call).filter(|_| is_free && turn_rad.is_finite())
        else {
            return false;
        };
        if open.turns >= config.turns_max {
            return false;
        }
        let turn = turn_goal_id(call, open.turns);
        open.turns += 1;
        open.turn = Some(turn);
        let turn_rad = turn_rad + config.turn_margin_rad.copysign(turn_rad);
        let Some(map_from_goal) = turned(&pose_from_isometry(&frames.map_from_base()), turn_rad) else {
            return false;
        };
        let goal = PoseGoal {
            map_from_goal,
            tolerance: Some(PoseTolerance::default()),
            speed_max_m_s: None,
            approach: Approach::Path,
        };
        let goal = (turn, GoalKind::WalkToPose(goal), platform());
        let situation = self.situation(frames);
        let started = self.executive.start_goal(at, goal, &situation, effects);
        if started.is_err()
            && let Some(open) = self.missions.calls.get_mut(&call)
        {
            open.turn = None;
        }
        started.is_ok()
    }

    /// A goal by which the body turns has ended. Returns whether it is one.
    pub(super) fn end_turn(
        &mut self,
        at: Stamp,
        goal: GoalId,
        result: &LegResult,
        effects: &mut Vec<StackEffect>,
    ) -> bool {
        let mut calls = self.missions.calls.iter_mut();
        let Some((call, open)) = calls.find(|(_, open)| open.turn == Some(goal)) else { return false };
        let call = *call;
        open.turn = None;
        if *result == LegResult::Reached {
            effects.push(open.effect(call));
            return true;
        }
        let reason = match result {
            LegResult::MotionTaken => texts::MOTION_TAKEN_WHILE_TURNING.to_owned(),
            _ => texts::TURN_BLOCKED.to_owned(),
        };
        self.end_call(at, call, ActionResult::Failed(reason), effects);
        true
    }
}

/// A pose that is turned to the left about the vertical, where it is.
fn turned(pose: &Pose, turn_rad: f64) -> Option<Pose> {
    let mut isometry = isometry_from_pose(pose)?;
    isometry.rotation = Rotation::from_axis_angle(&Vector3::z_axis(), turn_rad) * isometry.rotation;
    Some(pose_from_isometry(&isometry))
}
