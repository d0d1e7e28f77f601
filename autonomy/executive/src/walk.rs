//! Walking to a point in the map.
//!
//! The path is kept in the odometry frame, which does not jump. When a loop closure moves the map, obstacles stay, the goal moves, and the path
//! is planned again.

use crate::{Behaviour, BehaviourContext, BehaviourOutcome, Frames};
use geometry::{Isometry, Vector3};
use messages::{GoalAttempt, GoalFailure, GoalProgress, SpeedLimits, WaitReason};
use navigation::{ElevationMap, PathFollower, PathFollowerConfig, PlanError, PlannerConfig, Velocity, plan};
use std::task::Poll;
use vocab::{Span, Stamp, Twist, Vec3};

/// Parameters of [`WalkBehaviour`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WalkConfig {
    /// The path is planned again after this time, because the elevation map has been seen better. Chosen: at walking speed a metre, and a search takes up to 50 ms. Less
    /// costs computing time, more lets the robot follow an old path for longer.
    pub replan_period: Span,
    /// The path is planned again when a loop closure has moved its goal by this in the odometry frame, metres. Chosen: a third of the distance at which the robot has
    /// arrived, 0.15 m.
    pub replan_goal_shift_m: f64,
    /// The walk fails when its path stays blocked for this time. Chosen: people who pass have gone by then, and traces of them are cleared in 5.5 s.
    pub blocked_timeout: Span,
    /// A robot that has moved less than this within `blocked_timeout` is held by what stands beside its path, metres: the walk fails. Below the slowest walk. Chosen: a
    /// cell of the elevation map.
    pub held_distance_m: f64,
    /// A robot that has moved less than this distance for this time waits for a free path, as people are told. Half a turn in place takes 3.5 s. Chosen: half a second
    /// longer, so that a turn is not reported.
    pub held_report_time: Span,
    /// Parameters of path planning.
    pub planner: PlannerConfig,
    /// Parameters of path following.
    pub follower: PathFollowerConfig,
}

impl WalkConfig {
    /// For a robot with these speed limits.
    pub fn new(limits: &SpeedLimits) -> Self {
        Self {
            replan_period: Span::from_millis(1_000),
            replan_goal_shift_m: 0.05,
            blocked_timeout: Span::from_millis(8_000),
            held_distance_m: 0.1,
            held_report_time: Span::from_millis(4_000),
            planner: PlannerConfig::default(),
            follower: PathFollowerConfig::new(limits.forward_m_s, limits.turn_rad_s),
        }
    }
}

/// A walk to a point in the map.
#[derive(Debug)]
pub struct WalkBehaviour {
    config: WalkConfig,
    /// The goal, map frame.
    goal: Vector3,
    /// Position of the goal in the odometry frame when the path was planned.
    planned_to: Vector3,
    /// Follower of the path, odometry frame.
    follower: PathFollower,
    planned_at: Stamp,
    plans: u32,
    /// Start of the present blockage; `None` if there is a path.
    blocked_since: Option<Stamp>,
    /// Time that the robot waited in front of blocked paths that became free again.
    waited: Span,
    /// When and where the robot last moved, odometry frame.
    moved: (Stamp, Vector3),
    /// Whether it has not moved for a while although there is a path.
    is_held: bool,
    /// Whether the robot stands because it does not see the ground.
    is_blind: bool,
}

impl WalkBehaviour {
    /// A walk to `goal`, map frame, metres.
    ///
    /// # Errors
    /// When there is no path.
    pub fn begin(
        config: WalkConfig,
        at: Stamp,
        elevation_map: &ElevationMap,
        frames: &Frames,
        goal: Vector3,
    ) -> Result<Self, PlanError> {
        let planned_to = frames.to_odom(&goal);
        let path =
            plan(&config.planner, elevation_map, &frames.odom_from_base.translation.vector, &planned_to)?;
        Ok(Self::on(config, at, goal, planned_to, path, None))
    }

    /// Like [`Self::begin`], for a walk that is resumed: if there is no path now, it waits for one.
    pub fn resume(
        config: WalkConfig,
        at: Stamp,
        elevation_map: &ElevationMap,
        frames: &Frames,
        goal: Vector3,
    ) -> Self {
        Self::begin(config, at, elevation_map, frames, goal).unwrap_or_else(|_| {
            let here = vec![frames.odom_from_base.translation.vector];
            Self::on(config, at, goal, frames.to_odom(&goal), here, Some(at))
        })
    }

    fn on(
        config: WalkConfig,
        at: Stamp,
        goal: Vector3,
        planned_to: Vector3,
        path: Vec<Vector3>,
        blocked_since: Option<Stamp>,
    ) -> Self {
        Self {
            config,
            goal,
            planned_to,
            follower: PathFollower::new(config.follower, path),
            planned_at: at,
            plans: 1,
            blocked_since,
            waited: Span::ZERO,
            moved: (at, Vector3::repeat(f64::INFINITY)),
            is_held: false,
            is_blind: false,
        }
    }

    /// Since when there has been no path; none if there is one.
    pub(crate) fn blocked_since(&self) -> Option<Stamp> {
        self.blocked_since
    }

    /// Plans to the goal's present position in the odometry frame.
    fn replan(&mut self, at: Stamp, elevation_map: &ElevationMap, odom_from_base: &Isometry, goal: Vector3) {
        (self.planned_at, self.planned_to) = (at, goal);
        self.plans += 1;
        match plan(&self.config.planner, elevation_map, &odom_from_base.translation.vector, &goal) {
            Ok(path) => {
                self.follower = PathFollower::new(self.config.follower, path);
                if let Some(since) = self.blocked_since.take() {
                    self.waited = self.waited + (at - since);
                }
            }
            Err(_) => self.blocked_since = self.blocked_since.or(Some(at)),
        }
    }
}

impl Behaviour for WalkBehaviour {
    fn update(&mut self, context: &mut BehaviourContext<'_>) -> Poll<BehaviourOutcome> {
        let at = context.at;
        self.is_blind = !context.sees_ground;
        if self.is_blind {
            // Time without sight does not count as time in front of a blocked path.
            self.blocked_since = self.blocked_since.map(|_| at);
            self.moved.0 = at;
            return Poll::Pending;
        }
        let goal = context.frames.to_odom(&self.goal);
        let is_moved = (goal - self.planned_to).norm() > self.config.replan_goal_shift_m;
        if at - self.planned_at > self.config.replan_period || is_moved {
            self.replan(at, context.elevation_map, &context.frames.odom_from_base, goal);
        }
        if let Some(since) = self.blocked_since {
            // The wait gives people time to leave the path.
            if at - since > self.config.blocked_timeout {
                self.waited = self.waited + (at - since);
                return Poll::Ready(Err(GoalFailure::PathBlocked));
            }
            self.moved.0 = at;
            return Poll::Pending;
        }
        let here = context.frames.odom_from_base.translation.vector;
        if (here - self.moved.1).xy().norm() > self.config.held_distance_m {
            self.moved = (at, here);
        }
        let stood = at - self.moved.0;
        self.is_held = stood > self.config.held_report_time;
        if stood > self.config.blocked_timeout {
            self.waited = self.waited + stood;
            return Poll::Ready(Err(GoalFailure::PathBlocked));
        }
        match self.follower.velocity(&context.frames.odom_from_base, context.guard) {
            Some(velocity) => {
                context.velocity = twist(velocity);
                Poll::Pending
            }
            None => Poll::Ready(Ok(())),
        }
    }

    fn progress(&self, odom_from_base: &Isometry) -> GoalProgress {
        let waits_for = match self.is_blind {
            true => Some(WaitReason::Sight),
            false if self.is_held || self.blocked_since.is_some() => Some(WaitReason::FreePath),
            false => None,
        };
        // Rounded to 0.1 m, so that progress is not published 20 times a second.
        let remaining_m = (self.follower.remaining(odom_from_base) * 10.0).round() / 10.0;
        GoalProgress { remaining_m: Some(remaining_m), waits_for }
    }

    fn path(&self) -> &[Vector3] {
        self.follower.path()
    }

    fn attempts(&self) -> Vec<GoalAttempt> {
        let mut attempts = vec![GoalAttempt::PlannedPaths(self.plans)];
        if self.waited > Span::ZERO {
            attempts.push(GoalAttempt::WaitedForPath(self.waited));
        }
        attempts
    }
}

/// Converts the path follower's velocity to a twist.
pub(crate) fn twist(velocity: Velocity) -> Twist {
    Twist { linear: Vec3::new(velocity.forward, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, velocity.turn) }
}
