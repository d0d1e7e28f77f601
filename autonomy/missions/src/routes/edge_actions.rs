//! Actions of edges and zones. Those of an edge on entering and on leaving are performed one after the other while the robot stands at the beginning or the end of the edge. Those during
//! begin together when it sets out, and what of them has not ended when the edge is left is cancelled. An edge that is traversed by an action of the robot's own has that as the
//! last one on entering; then the robot walks the rest of the edge.
//!
//! The action of a zone is called when the robot comes into the zone on its way, and the robot walks on. It is not called where a goal begins inside.
//!
//! An action on entering an edge that fails counts as an edge that cannot be walked, because it may be the one that opens a door: the fail policy of the edge follows. Of all
//! others people are told, and the robot goes on.

use super::active_route::{Leg, WalkingCall};
use super::executor::RouteExecutor;
use super::interface::{RouteEffect, RouteView};
use crate::graph::zones_with_actions;
use crate::ids::edge_call_id;
use crate::texts;
use site_model::{
    ActionRequest, EdgeId, EdgeStage, RouteActionPlace, Traversal, ZoneEffect, describe_action,
};
use vocab::{ActionCallId, Span, Stamp};

impl RouteExecutor {
    /// Whether a call is one of the edges of the active goal.
    pub fn is_calling(&self, call: ActionCallId) -> bool {
        let Some(active) = &self.active else { return false };
        self.is_standing_for(call) || active.during.iter().any(|open| open.call == call)
    }

    /// Whether the robot stands at the end of an edge until this call has ended.
    pub fn is_standing_for(&self, call: ActionCallId) -> bool {
        let leg = self.active.as_ref().and_then(|active| active.leg);
        matches!(leg, Some((_, Leg::Act { call: known, .. })) if known == call)
    }

    /// An action of an edge has ended: it was done, or the reason why not, a sentence. Calls that are not active change nothing.
    pub fn end_action(
        &mut self,
        at: Stamp,
        call: ActionCallId,
        result: Result<(), String>,
        view: &RouteView<'_>,
    ) -> Vec<RouteEffect> {
        self.handle_action_end(at, call, result, view);
        std::mem::take(&mut self.effects)
    }

    pub(super) fn handle_action_end(
        &mut self,
        at: Stamp,
        call: ActionCallId,
        result: Result<(), String>,
        view: &RouteView<'_>,
    ) {
        let Some(active) = &mut self.active else { return };
        if let Some(index) = active.during.iter().position(|open| open.call == call) {
            let WalkingCall { action, .. } = active.during.remove(index);
            self.effects.extend(result.err().map(|reason| RouteEffect::ActionFailed(action, reason)));
            return;
        }
        let leg =
            active.leg.take_if(|(_, leg)| matches!(leg, Leg::Act { call: known, .. } if *known == call));
        let Some((_, Leg::Act { edge, stage, index, .. })) = leg else { return };
        match (stage, result) {
            (EdgeStage::Enter, Ok(())) => self.act_on_entering(at, edge, index + 1, view),
            (EdgeStage::Enter, Err(reason)) => {
                let action =
                    request(view, edge, stage, index).map_or_else(String::new, |request| request.action);
                let reason = texts::edge_action_failed(&action, &reason);
                self.handle_blocked_edge(at, edge, Some(&reason), view);
            }
            (EdgeStage::During | EdgeStage::Leave, result) => {
                let action = request(view, edge, stage, index).map(|request| request.action);
                let failed = result.err().zip(action);
                self.effects.extend(failed.map(|(reason, action)| RouteEffect::ActionFailed(action, reason)));
                self.act_on_leaving(at, edge, index + 1, view);
            }
        }
    }

    /// Performs the actions on entering an edge from this one on; then the robot sets out.
    pub(super) fn act_on_entering(&mut self, at: Stamp, edge: EdgeId, index: usize, view: &RouteView<'_>) {
        if self.act(at, edge, EdgeStage::Enter, index, view) {
            return;
        }
        let during = view.site.edge(edge).map(|edge| edge.during.clone()).unwrap_or_default();
        for (index, request) in (0..).zip(during) {
            let place = RouteActionPlace::Edge { edge, stage: EdgeStage::During, index };
            self.call_while_walking(place, request);
        }
        if let Some(active) = &mut self.active {
            active.entered = Some(edge);
        }
        self.walk_edge(at, edge, view);
    }

    /// Performs the actions on leaving an edge from this one on; then the goal goes on.
    pub(super) fn act_on_leaving(&mut self, at: Stamp, edge: EdgeId, index: usize, view: &RouteView<'_>) {
        if !self.act(at, edge, EdgeStage::Leave, index, view) {
            self.next_leg(at, view);
        }
    }

    /// The robot is not on an edge any more: actions during it end.
    pub(super) fn leave_edge(&mut self) {
        let Some(active) = &mut self.active else { return };
        active.entered = None;
        let calls = active.during.extract_if(.., |open| open.is_of_edge);
        self.effects.extend(calls.map(|open| RouteEffect::CancelAction(open.call)));
    }

    /// Follows in which zones with an action the robot is, and calls the actions of those that it has entered on its way.
    pub(super) fn enter_zones(&mut self, view: &RouteView<'_>) {
        let Some(pose) = view.map_from_base else { return };
        let (entered, inside) =
            zones_with_actions(view.newest, view.time_of_day, &self.inside, pose.position);
        self.inside = inside;
        for zone in entered {
            if let ZoneEffect::Action(request) = &zone.effect {
                self.call_while_walking(RouteActionPlace::Zone(zone.id), request.clone());
            }
        }
    }

    /// Calls an action, and the robot walks on. Nothing without a goal.
    fn call_while_walking(&mut self, place: RouteActionPlace, request: ActionRequest) {
        let Some(call) = self.next_call() else { return };
        if let Some(active) = &mut self.active {
            let is_of_edge = matches!(place, RouteActionPlace::Edge { .. });
            active.during.push(WalkingCall { call, action: request.action.clone(), is_of_edge });
        }
        self.effects.push(RouteEffect::CallAction(call, place, request));
    }

    /// Calls an action of an edge. Returns whether there is one.
    fn act(&mut self, at: Stamp, edge: EdgeId, stage: EdgeStage, index: usize, view: &RouteView<'_>) -> bool {
        let Some(request) = request(view, edge, stage, index) else { return false };
        let Some(call) = self.next_call() else { return false };
        let until = at + self.time_limit(&request);
        self.stand(at, Leg::Act { edge, stage, index, call, until });
        let index = u32::try_from(index).unwrap_or(u32::MAX);
        let place = RouteActionPlace::Edge { edge, stage, index };
        self.effects.push(RouteEffect::CallAction(call, place, request));
        true
    }

    fn next_call(&mut self) -> Option<ActionCallId> {
        let active = self.active.as_mut()?;
        active.calls += 1;
        Some(edge_call_id(active.goal, active.calls))
    }

    fn time_limit(&self, request: &ActionRequest) -> Span {
        let expected = describe_action(&request.action).map_or(self.config.expected_action_time, |action| {
            Span::from_secs_f64(action.expected_time_s(&request.parameters))
        });
        self.config.action_time.limit(expected)
    }
}

/// An action of an edge; none: there are no more at that end of it.
fn request(view: &RouteView<'_>, edge: EdgeId, stage: EdgeStage, index: usize) -> Option<ActionRequest> {
    let edge = view.site.edge(edge)?;
    match (stage, &edge.traversal) {
        (EdgeStage::Enter, Traversal::Action { name, parameters }) if index == edge.on_enter.len() => {
            Some(ActionRequest { action: name.clone(), parameters: parameters.clone() })
        }
        (EdgeStage::Enter, _) => edge.on_enter.get(index).cloned(),
        (EdgeStage::During, _) => edge.during.get(index).cloned(),
        (EdgeStage::Leave, _) => edge.on_leave.get(index).cloned(),
    }
}
