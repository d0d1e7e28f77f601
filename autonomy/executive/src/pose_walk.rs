//! Walking into a pose: along a path to its point, then with small steps in any direction until position and heading are right. If something keeps the robot from its
//! last steps, or only things that it does not see close its path, it steps back once and looks whether they still stand there.

use crate::back_up::{BackUpConfig, back_up_point};
use crate::{
    Behaviour, BehaviourContext, BehaviourOutcome, Frames, PoseControlConfig, WalkBehaviour, WalkConfig,
};
use geometry::{Isometry, Vector3, isometry_from_pose};
use messages::{Approach, GoalAttempt, GoalFailure, GoalProgress, PoseGoal, SpeedLimits, WaitReason};
use navigation::{ElevationMap, plan};
use site_model::PoseTolerance;
use std::task::Poll;
use vocab::{Span, Stamp, Twist, Vec3};

/// Parameters of [`PoseWalkBehaviour`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseWalkConfig {
    /// Distance at which a pose that is only passed by counts as reached, metres. Less than the width of a doorway, so that the robot does not cut corners of walls.
    /// Chosen: about the radius of the footprint.
    pub passing_distance_m: f64,
    /// Share of the tolerance within which the last steps end. The rest is for the error of localisation. Chosen: two fifths; less takes longer, more leaves less for the
    /// error.
    pub tolerance_share: f64,
    /// Gains of the last steps, and when the robot has come to rest.
    pub control: PoseControlConfig,
    /// Greatest speed of the last steps, m/s. Chosen: about a quarter of the walking speed, so that the robot stops within some centimetres.
    pub max_step_speed_m_s: f64,
    /// Greatest turning speed of the last steps, rad/s. Chosen: half a turn takes 4 s.
    pub max_step_turn_rad_s: f64,
    /// Beyond this distance the robot walks on a path again, metres. It may have been pushed. Chosen: more than the end of a path is from the pose, so that the robot
    /// does not change between both.
    pub walk_again_m: f64,
    /// Time for the last steps, and in straight approaches for each metre. Chosen: the steps take 4 s for each metre at [`Self::max_step_speed_m_s`]; what takes five
    /// times as long does not succeed.
    pub step_time_limit: Span,
    /// Stepping back from what keeps the robot from its path or its last steps.
    pub back_up: BackUpConfig,
}

impl Default for PoseWalkConfig {
    fn default() -> Self {
        Self {
            passing_distance_m: 0.35,
            tolerance_share: 0.4,
            control: PoseControlConfig::default(),
            max_step_speed_m_s: 0.25,
            max_step_turn_rad_s: 0.8,
            walk_again_m: 0.6,
            step_time_limit: Span::from_millis(20_000),
            back_up: BackUpConfig::default(),
        }
    }
}

/// A walk into a pose of the map.
#[derive(Debug)]
pub struct PoseWalkBehaviour {
    config: PoseWalkConfig,
    walk_config: WalkConfig,
    limits: SpeedLimits,
    map_from_goal: Isometry,
    /// None: the pose is passed by.
    tolerance: Option<PoseTolerance>,
    approach: Approach,
    phase: Phase,
    /// Whether it has stepped back. Once is enough: what stands there then is real.
    has_looked_again: bool,
    /// Beginning of the last blockage of which it was asked whether only things that are not seen close the path.
    asked_about: Option<Stamp>,
    /// Attempts of walks that have ended.
    attempts: Vec<GoalAttempt>,
}

#[derive(Debug)]
enum Phase {
    Walking(Box<WalkBehaviour>),
    Stepping {
        deadline: Stamp,
        /// Since when the robot stands in the pose.
        in_pose_since: Option<Stamp>,
        /// Since when the robot is not allowed to make a step.
        held_since: Option<Stamp>,
        is_blind: bool,
    },
    /// On the way to a point from where the pose can be seen.
    SteppingBack(Box<WalkBehaviour>),
    /// There, until this instant or until there is a path to the pose. It is looked for again at `next_plan`.
    Looking {
        until: Stamp,
        next_plan: Stamp,
    },
}

impl Phase {
    fn stepping(deadline: Stamp) -> Self {
        Self::Stepping { deadline, in_pose_since: None, held_since: None, is_blind: false }
    }
}

/// Distance that is left, in the frame of the base.
struct Offset {
    forward_m: f64,
    left_m: f64,
    turn_rad: f64,
}

impl PoseWalkBehaviour {
    /// Walks into the pose of `goal`. If there is no path now, the robot waits for one. None if the pose is not a pose.
    pub fn new(
        mut config: PoseWalkConfig,
        mut walk_config: WalkConfig,
        limits: &SpeedLimits,
        at: Stamp,
        elevation_map: &ElevationMap,
        frames: &Frames,
        goal: &PoseGoal,
    ) -> Option<Self> {
        let map_from_goal = isometry_from_pose(&goal.map_from_goal)?;
        let speed_m_s = goal.max_speed_m_s.filter(|speed| *speed > 0.0).unwrap_or(f64::INFINITY);
        walk_config.follower.max_speed_m_s = walk_config.follower.max_speed_m_s.min(speed_m_s);
        config.max_step_speed_m_s = config.max_step_speed_m_s.min(speed_m_s);
        if goal.tolerance.is_none() {
            walk_config.follower.end_speed_m_s = walk_config.follower.max_speed_m_s;
            walk_config.follower.goal_tolerance_m = config.passing_distance_m;
        }
        let mut behaviour = Self {
            config,
            walk_config,
            limits: *limits,
            map_from_goal,
            tolerance: goal.tolerance,
            approach: goal.approach,
            phase: Phase::stepping(at),
            has_looked_again: false,
            asked_about: None,
            attempts: Vec::new(),
        };
        match goal.approach {
            Approach::Path => behaviour.walk(at, elevation_map, frames),
            Approach::Straight => behaviour.step(at, frames),
        }
        Some(behaviour)
    }

    fn walk(&mut self, at: Stamp, elevation_map: &ElevationMap, frames: &Frames) {
        let goal = self.map_from_goal.translation.vector;
        let walk = WalkBehaviour::resume(self.walk_config, at, elevation_map, frames, goal);
        self.phase = Phase::Walking(Box::new(walk));
    }

    fn step(&mut self, at: Stamp, frames: &Frames) {
        let offset = self.offset(frames);
        let distance_m = offset.forward_m.hypot(offset.left_m).ceil().clamp(1.0, 10.0);
        let deadline = at + self.config.step_time_limit * distance_m as i64;
        self.phase = Phase::stepping(deadline);
    }

    fn offset(&self, frames: &Frames) -> Offset {
        let base_from_goal = frames.map_from_base().inverse() * self.map_from_goal;
        let ahead = base_from_goal.rotation * Vector3::x();
        let to_goal = base_from_goal.translation.vector;
        Offset { forward_m: to_goal.x, left_m: to_goal.y, turn_rad: ahead.y.atan2(ahead.x) }
    }

    /// Whether the base is within a share of the tolerance.
    fn is_in_pose(&self, offset: &Offset, share: f64) -> bool {
        let Some(tolerance) = &self.tolerance else {
            return offset.forward_m.hypot(offset.left_m) <= self.config.passing_distance_m;
        };
        // The ellipse lies in the frame of the goal.
        let (sin, cos) = offset.turn_rad.sin_cos();
        let along_m = cos * offset.forward_m + sin * offset.left_m;
        let across_m = cos * offset.left_m - sin * offset.forward_m;
        let radius = (along_m / (tolerance.along_m * share)).hypot(across_m / (tolerance.across_m * share));
        radius <= 1.0 && offset.turn_rad.abs() <= tolerance.yaw_rad * share
    }

    fn update_steps(&mut self, context: &mut BehaviourContext<'_>) -> Poll<BehaviourOutcome> {
        let offset = self.offset(&context.frames);
        let (is_ending, is_in_pose) =
            (self.is_in_pose(&offset, self.config.tolerance_share), self.is_in_pose(&offset, 1.0));
        let Phase::Stepping { deadline, in_pose_since, held_since, is_blind } = &mut self.phase else {
            return Poll::Pending;
        };
        let at = context.at;
        *is_blind = !context.sees_ground;
        if *is_blind {
            (*in_pose_since, *held_since) = (None, None);
            return Poll::Pending;
        }
        if at >= *deadline {
            return Poll::Ready(if is_in_pose { Ok(()) } else { Err(GoalFailure::PathBlocked) });
        }
        if is_ending || (in_pose_since.is_some() && is_in_pose) {
            let since = *in_pose_since.get_or_insert(at);
            let is_settled = at - since >= self.config.control.settle_time;
            return if is_settled { Poll::Ready(Ok(())) } else { Poll::Pending };
        }
        *in_pose_since = None;
        let held_since = *held_since;
        let is_far = offset.forward_m.hypot(offset.left_m) > self.config.walk_again_m;
        if is_far && self.approach == Approach::Path {
            self.walk(at, context.elevation_map, &context.frames);
            return Poll::Pending;
        }
        context.velocity = self.step_velocity(&offset);
        let held_since = is_held(context).then(|| held_since.unwrap_or(at));
        if let Phase::Stepping { held_since: known, .. } = &mut self.phase {
            *known = held_since;
        }
        if held_since.is_some_and(|since| at - since > self.config.back_up.held_time) {
            self.step_back(context);
        }
        Poll::Pending
    }

    /// Begins to step back, once and if there is room.
    fn step_back(&mut self, context: &mut BehaviourContext<'_>) {
        if self.has_looked_again || self.approach == Approach::Straight {
            return;
        }
        self.has_looked_again = true;
        let here = context.frames.odom_from_base.translation.vector;
        let goal = context.frames.to_odom(&self.map_from_goal.translation.vector);
        let Some(point) = back_up_point(&self.config.back_up, context.elevation_map, &here, &goal) else {
            return;
        };
        let point = context.frames.to_map(&point);
        let walk =
            WalkBehaviour::begin(self.walk_config, context.at, context.elevation_map, &context.frames, point);
        if let Ok(walk) = walk {
            self.phase = Phase::SteppingBack(Box::new(walk));
        }
    }

    /// Steps back if there is no path for a while, and only things that the robot does not see from here are in its way.
    fn step_back_from_unseen(&mut self, context: &mut BehaviourContext<'_>) {
        let Phase::Walking(walk) = &self.phase else { return };
        let Some(since) = walk.blocked_since() else { return };
        let BackUpConfig { held_time, unseen_reach_m, .. } = self.config.back_up;
        if self.has_looked_again || self.asked_about == Some(since) || context.at - since <= held_time {
            return;
        }
        // Asked once: it copies the map, and plans.
        self.asked_about = Some(since);
        let here = context.frames.odom_from_base.translation.vector;
        let goal = context.frames.to_odom(&self.map_from_goal.translation.vector);
        let seen = context.elevation_map.without_unseen(&here, unseen_reach_m);
        if plan(&self.walk_config.planner, &seen, &here, &goal).is_ok() {
            self.step_back(context);
        }
    }

    /// Stands and looks, and walks to the pose again when it is free and there is a path, or when it has looked for long enough.
    fn look(
        &mut self,
        context: &mut BehaviourContext<'_>,
        until: Stamp,
        next_plan: Stamp,
    ) -> Poll<BehaviourOutcome> {
        let BehaviourContext { at, elevation_map, frames, .. } = context;
        let goal = frames.to_odom(&self.map_from_goal.translation.vector);
        let is_over = *at >= until;
        let is_free = *at >= next_plan && elevation_map.is_free(elevation_map.index(goal.x, goal.y));
        if !is_over && !is_free {
            return Poll::Pending;
        }
        let goal_in_map = self.map_from_goal.translation.vector;
        match WalkBehaviour::begin(self.walk_config, *at, elevation_map, frames, goal_in_map) {
            Ok(walk) => self.phase = Phase::Walking(Box::new(walk)),
            Err(_) if is_over => return Poll::Ready(Err(GoalFailure::PathBlocked)),
            Err(_) => {
                let next_plan = *at + self.walk_config.replan_period;
                self.phase = Phase::Looking { until, next_plan };
            }
        }
        Poll::Pending
    }

    /// Towards the pose, within the limits. A robot that cannot walk sideways turns to the point first.
    fn step_velocity(&self, offset: &Offset) -> Twist {
        let PoseControlConfig { position_gain_per_s, heading_gain_per_s, .. } = self.config.control;
        let clamp = |value: f64, limit: f64, own: f64| {
            let limit = limit.min(own);
            value.clamp(-limit, limit)
        };
        let (speed_m_s, turn_rad_s) = (self.config.max_step_speed_m_s, self.config.max_step_turn_rad_s);
        let forward = clamp(position_gain_per_s * offset.forward_m, speed_m_s, self.limits.forward_m_s);
        let left = clamp(position_gain_per_s * offset.left_m, speed_m_s, self.limits.sideways_m_s);
        let turn = clamp(heading_gain_per_s * offset.turn_rad, turn_rad_s, self.limits.turn_rad_s);
        Twist { linear: Vec3::new(forward, left, 0.0), angular: Vec3::new(0.0, 0.0, turn) }
    }
}

impl Behaviour for PoseWalkBehaviour {
    fn update(&mut self, context: &mut BehaviourContext<'_>) -> Poll<BehaviourOutcome> {
        match &mut self.phase {
            Phase::Stepping { .. } => self.update_steps(context),
            Phase::Walking(walk) => match walk.update(context) {
                Poll::Ready(Ok(())) if self.tolerance.is_some() => {
                    self.attempts.extend(walk.attempts());
                    self.step(context.at, &context.frames);
                    self.update_steps(context)
                }
                Poll::Pending => {
                    self.step_back_from_unseen(context);
                    Poll::Pending
                }
                result => result,
            },
            // A way back that is blocked on the way shows enough.
            Phase::SteppingBack(walk) => {
                if walk.update(context).is_ready() {
                    self.attempts.extend(walk.attempts());
                    let until = context.at + self.config.back_up.look_time;
                    self.phase = Phase::Looking { until, next_plan: context.at };
                }
                Poll::Pending
            }
            Phase::Looking { until, next_plan } => {
                let (until, next_plan) = (*until, *next_plan);
                self.look(context, until, next_plan)
            }
        }
    }

    fn progress(&self, odom_from_base: &Isometry) -> GoalProgress {
        match &self.phase {
            Phase::Walking(walk) => walk.progress(odom_from_base),
            Phase::Stepping { is_blind, .. } => {
                GoalProgress { remaining_m: Some(0.0), waits_for: is_blind.then_some(WaitReason::Sight) }
            }
            // The way back and the look are time in front of a path that is not free.
            Phase::SteppingBack(_) | Phase::Looking { .. } => {
                GoalProgress { remaining_m: Some(0.0), waits_for: Some(WaitReason::FreePath) }
            }
        }
    }

    fn path(&self) -> &[Vector3] {
        match &self.phase {
            Phase::Walking(walk) | Phase::SteppingBack(walk) => walk.path(),
            Phase::Stepping { .. } | Phase::Looking { .. } => &[],
        }
    }

    fn attempts(&self) -> Vec<GoalAttempt> {
        let mut attempts = self.attempts.clone();
        if let Phase::Walking(walk) | Phase::SteppingBack(walk) = &self.phase {
            attempts.extend(walk.attempts());
        }
        attempts
    }
}

/// Whether the velocity of a behaviour would bring the robot too near to something at any speed.
fn is_held(context: &BehaviourContext<'_>) -> bool {
    let Twist { linear, angular } = context.velocity;
    let share = context.guard.allowed_share(&context.frames.odom_from_base, [linear.x, linear.y], angular.z);
    share <= 0.0
}
