//! The goal that the executive executes or keeps while its pose is searched for, and what has become of goals and their legs.

use crate::{BehaviourOutcome, DockGoal, Frames};
use geometry::vec_from_plain;
use messages::{
    GoalAttempt, GoalKind, GoalProgress, GoalStatus, GoalUpdate, PoseGoal, Principal, Publication,
    StackEffect, WaitReason,
};
use vocab::{GoalId, LegId, Span, Stamp, Vec3};

/// A part of the route to a goal on the topological map, which the robot walks in one go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteLeg {
    /// Its id, which no other leg has.
    pub id: LegId,
    /// Where it ends.
    pub pose: PoseGoal,
    /// The dock that it leads into, by what the scans show of it; none: it leads into the pose.
    pub dock: Option<DockGoal>,
}

/// What is left of a route besides the leg that is walked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RouteRemainder {
    /// Distance from the end of the leg to the goal, metres; without a leg, from the robot. None while no route is known.
    pub beyond_leg_m: Option<f64>,
    /// Why the robot stands between two legs, if it waits for one of these reasons.
    pub waits_for: Option<WaitReason>,
}

/// What has become of a goal or of a leg. Taken with [`crate::Executive::take_events`].
#[derive(Clone, Debug, PartialEq)]
pub enum GoalEvent {
    /// A leg has ended by itself. The goal goes on, and the robot stands until the next leg begins or the goal ends.
    LegEnded(LegId, BehaviourOutcome),
    /// A goal has ended, with this outcome.
    Ended(GoalUpdate),
}

/// A goal that has been accepted and has no outcome yet.
#[derive(Debug)]
pub(crate) struct RunningGoal {
    pub id: GoalId,
    pub kind: GoalKind,
    /// The leg that is walked, of a goal on the topological map.
    pub leg: Option<RouteLeg>,
    /// What is left besides it.
    pub remainder: RouteRemainder,
    pub by: Principal,
    pub accepted: Stamp,
    pub status: GoalStatus,
    /// Attempts of behaviours that have ended, and of those who decide the legs. One of each kind.
    pub tried: Vec<GoalAttempt>,
    /// Whether clients see it.
    pub is_published: bool,
}

impl RunningGoal {
    /// The point to which the robot walks for it, map frame; none if it does not walk to a point.
    pub(crate) fn point(&self) -> Option<Vec3> {
        match self.kind {
            GoalKind::WalkTo(point) => Some(point),
            GoalKind::WalkToPose(pose) => Some(pose.map_from_goal.position),
            GoalKind::Relocalise => None,
            GoalKind::GoToNode(_) | GoalKind::GoToDock(_) | GoalKind::Undock => {
                self.leg.map(|leg| leg.pose.map_from_goal.position)
            }
        }
    }

    pub(crate) fn publish(&self, effects: &mut Vec<StackEffect>) {
        if self.is_published {
            effects.push(StackEffect::Publish(Publication::Goal(self.update())));
        }
    }

    pub(crate) fn update(&self) -> GoalUpdate {
        GoalUpdate {
            id: self.id,
            kind: self.kind,
            by: self.by.clone(),
            accepted: self.accepted,
            status: self.status.clone(),
        }
    }

    /// Whether the goal is on the topological map.
    pub(crate) fn is_route(&self) -> bool {
        matches!(self.kind, GoalKind::GoToNode(_) | GoalKind::GoToDock(_) | GoalKind::Undock)
    }

    /// Whether the robot has to know its pose in the map for what it does now. A robot that stands between two legs need not.
    pub(crate) fn needs_pose(&self) -> bool {
        matches!(self.kind, GoalKind::WalkTo(_) | GoalKind::WalkToPose(_)) || self.leg.is_some()
    }

    /// Progress of the goal, of which the behaviour knows the present leg.
    pub(crate) fn progress(&self, behaviour: GoalProgress, frames: &Frames) -> GoalProgress {
        if !self.is_route() {
            return behaviour;
        }
        let RouteRemainder { beyond_leg_m, waits_for } = self.remainder;
        let place = frames.map_from_base().translation.vector;
        let to_leg_end_m =
            |leg: RouteLeg| (vec_from_plain(leg.pose.map_from_goal.position) - place).xy().norm();
        // Before a blocked path the behaviour knows none. No path is shorter than the straight line.
        let leg_m = self.leg.map_or(0.0, to_leg_end_m).max(behaviour.remaining_m.unwrap_or_default());
        let remaining_m = beyond_leg_m.map(|beyond_m| beyond_m + leg_m);
        GoalProgress {
            // Rounded to 0.1 m, as every progress.
            remaining_m: remaining_m.map(|remaining_m| (10.0 * remaining_m).round() / 10.0),
            waits_for: behaviour.waits_for.or(waits_for),
        }
    }

    /// Adds an attempt to those of its kind.
    pub(crate) fn add_attempt(&mut self, attempt: &GoalAttempt) {
        if !self.tried.iter_mut().any(|total| add(total, attempt)) {
            self.tried.push(*attempt);
        }
    }
}

/// Adds an attempt to `total` if both are of the same kind. Returns whether they are.
fn add(total: &mut GoalAttempt, attempt: &GoalAttempt) -> bool {
    let sum = |a: &mut Span, b: &Span| *a = *a + *b;
    match (total, attempt) {
        (GoalAttempt::PlannedPaths(a), GoalAttempt::PlannedPaths(b))
        | (GoalAttempt::ExploredPaths(a), GoalAttempt::ExploredPaths(b))
        | (GoalAttempt::DockingAttempts(a), GoalAttempt::DockingAttempts(b)) => *a = a.saturating_add(*b),
        (GoalAttempt::WaitedForPath(a), GoalAttempt::WaitedForPath(b))
        | (GoalAttempt::SearchedForPose(a), GoalAttempt::SearchedForPose(b)) => sum(a, b),
        _ => return false,
    }
    true
}
