//! Active localisation: finding the pose in the map by walking.
//!
//! First the robot stands, so that its surroundings can be recognised. If they are not, it walks a short path over seen ground to an unvisited
//! point, and stands again. If several poses fit, only walking distinguishes them. Then the robot walks without standing, along the path that
//! localisation has planned for this. It walks only to points of that path where it has seen the ground.

use crate::walk::{WalkConfig, twist};
use crate::{Behaviour, BehaviourContext, BehaviourOutcome};
use geometry::{Isometry, Vector3};
use localisation::ExplorationHint;
use messages::{GoalAttempt, GoalFailure, GoalProgress, WaitReason};
use navigation::{
    ElevationMap, ExplorationConfig, PathFollower, PathFollowerConfig, PlannerConfig, explore, plan,
};
use std::sync::Arc;
use std::task::Poll;
use vocab::{Span, Stamp};

/// Parameters of [`RelocalisationBehaviour`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelocalisationConfig {
    /// The robot stands for this time before its first walk. Relocalisation takes half a second. Chosen: some five attempts.
    pub first_stand: Span,
    /// The robot stands for this time between walks. Chosen: two attempts of relocalisation.
    pub stand: Span,
    /// If there is no path, the robot searches for one again after this time. Chosen: a search for a path takes up to 50 ms, and a person walks 0.3 m in it.
    pub retry_period: Span,
    /// A path is planned again after this time, because the elevation map has been seen better. It is that of walks ([`WalkConfig::replan_period`]).
    pub replan_period: Span,
    /// Look-ahead distance along the hint's path, metres. Chosen: the robot sees the floor about as far (docs/maths/localisation.md).
    pub hint_ahead_m: f64,
    /// A planned piece of the hint's path may be longer than that path by this detour, metres. Chosen: room to walk round a person or a box; a longer detour leaves what
    /// the hint is about.
    pub max_hint_detour_m: f64,
    /// Pieces of the hint's path that are shorter than this are not walked, metres. Chosen: as the look-ahead of the follower; shorter pieces show nothing new.
    pub min_hint_piece_m: f64,
    /// With several hypotheses, the next walk starts at this distance before the end of the last one, metres. Chosen: about 2 s of walking, in which the next path is
    /// planned, so that the robot does not stop in between.
    pub continue_before_end_m: f64,
    /// A path that is planned again may be longer than the straight line by this, metres. Chosen: room to pass a person; a longer one may lead away from the goal.
    pub max_replan_detour_m: f64,
    /// Least distance between points that are remembered as visited, metres. Chosen: views a metre apart show nearly the same. The cost of exploration grows with their
    /// number.
    pub visited_spacing_m: f64,
    /// A robot that has moved less than this within `stuck_timeout` is stuck, metres: an unseen obstacle blocks it. Chosen: a cell of the elevation map.
    pub stuck_distance_m: f64,
    /// See `stuck_distance_m`. Chosen: longer than half a turn in place, 3.5 s.
    pub stuck_timeout: Span,
    /// A hint's path on which the robot got stuck is not followed for this time. Then it is tried again, because people leave. Chosen: people who stand in a way have
    /// mostly gone on by then.
    pub blocked_hint_timeout: Span,
    /// A robot that has stood for this time has found no path, and reports that it waits for one. It has to exceed `first_stand`. Chosen: twice `first_stand` and more.
    pub report_wait_after: Span,
    /// The search ends after this time, without the time in which the ground is not seen. Chosen: 2.5 minutes, after which a person should look.
    /// docs/benchmarks/fault-recovery.md has the times in which poses are found.
    pub search_timeout: Span,
    /// Parameters of the choice of points to walk to.
    pub exploration: ExplorationConfig,
    /// Parameters of path planning.
    pub planner: PlannerConfig,
    /// Parameters of path following.
    pub follower: PathFollowerConfig,
}

impl RelocalisationConfig {
    /// With the planning and following of other walks.
    pub fn new(walk: &WalkConfig) -> Self {
        Self {
            first_stand: Span::from_millis(2_500),
            stand: Span::from_millis(1_000),
            retry_period: Span::from_millis(250),
            replan_period: walk.replan_period,
            hint_ahead_m: 6.0,
            max_hint_detour_m: 1.5,
            min_hint_piece_m: 0.7,
            continue_before_end_m: 1.5,
            max_replan_detour_m: 0.5,
            visited_spacing_m: 1.0,
            stuck_distance_m: 0.1,
            stuck_timeout: Span::from_millis(6_000),
            blocked_hint_timeout: Span::from_millis(10_000),
            report_wait_after: Span::from_millis(5_500),
            search_timeout: Span::from_millis(150_000),
            exploration: ExplorationConfig::default(),
            planner: walk.planner,
            follower: walk.follower,
        }
    }
}

/// Searches for the pose in the map until it is known.
#[derive(Debug)]
pub struct RelocalisationBehaviour {
    config: RelocalisationConfig,
    /// Points where the robot has been, odometry frame.
    visited: Vec<Vector3>,
    /// Search time while the ground was seen.
    searched: Span,
    /// Time at which `searched` was last increased. `None` after time without sight.
    searched_at: Option<Stamp>,
    walks: u32,
    /// The hint's path on which the robot got stuck, and when.
    blocked_hint: Option<(Arc<[Vector3]>, Stamp)>,
    phase: Phase,
}

#[derive(Debug)]
enum Phase {
    Standing {
        since: Stamp,
        /// Time of the last search for a path.
        tried: Option<Stamp>,
    },
    Walking {
        /// The hint's path, if this walk follows a piece of it.
        hint: Option<Arc<[Vector3]>>,
        follower: PathFollower,
        planned_at: Stamp,
        /// Time and position of the robot when it last moved.
        moved: (Stamp, Vector3),
    },
}

/// A path, and the hint's path if the first is a piece of it.
type Piece = (Option<Arc<[Vector3]>>, Vec<Vector3>);

impl RelocalisationBehaviour {
    /// Begins with standing.
    pub fn new(config: RelocalisationConfig, at: Stamp) -> Self {
        Self {
            config,
            visited: Vec::new(),
            searched: Span::ZERO,
            searched_at: Some(at),
            walks: 0,
            blocked_hint: None,
            phase: Phase::Standing { since: at, tried: None },
        }
    }

    fn stand(&mut self, at: Stamp) {
        self.phase = Phase::Standing { since: at, tried: None };
    }

    /// Adds up the search time and remembers the robot's position.
    fn record_visit(&mut self, at: Stamp, here: &Vector3) {
        self.searched = self.searched + self.searched_at.replace(at).map_or(Span::ZERO, |last| at - last);
        if self.visited.iter().all(|visited| (visited - here).norm() >= self.config.visited_spacing_m) {
            self.visited.push(*here);
        }
    }

    fn update_walk(&mut self, context: &BehaviourContext<'_>) {
        let (at, elevation_map, hint_now) = (context.at, context.elevation_map, context.exploration_hint);
        let odom_from_base = &context.frames.odom_from_base;
        let here = odom_from_base.translation.vector;
        let Phase::Walking { hint, follower, planned_at, moved } = &mut self.phase else { return };
        if (here - moved.1).norm() > self.config.stuck_distance_m {
            *moved = (at, here);
        }
        if at - moved.0 > self.config.stuck_timeout {
            // The end of the path counts as visited, so that it is not chosen again.
            self.visited.extend(follower.path().last());
            self.blocked_hint = hint.take().map(|hint| (hint, at)).or(self.blocked_hint.take());
            return self.stand(at);
        }
        if at - *planned_at < self.config.replan_period {
            return;
        }
        let (hint, moved, old) = (hint.take(), *moved, follower.path().to_vec());
        let is_ending =
            hint_now.hypotheses > 1 && follower.remaining(odom_from_base) < self.config.continue_before_end_m;
        let path = self
            .follow_hint(elevation_map, &here, hint_now)
            .or_else(|| if is_ending { self.explore(elevation_map, &here) } else { None })
            .or_else(|| self.replan(elevation_map, &here, &old).map(|path| (hint, path)));
        match path {
            Some((hint, path)) => {
                let follower = PathFollower::new(self.config.follower, path);
                self.phase = Phase::Walking { hint, follower, planned_at: at, moved };
            }
            None => self.stand(at),
        }
    }

    /// The next path of a robot that has stood for this time, if there is one. Standing does not distinguish poses that look alike. So without a
    /// path that does, the robot explores at once. With such a path that is blocked, perhaps by people, it explores after `stand`.
    fn next_walk(
        &self,
        stood: Span,
        elevation_map: &ElevationMap,
        here: &Vector3,
        hint: &ExplorationHint,
    ) -> Option<Piece> {
        let stands = match hint {
            ExplorationHint { hypotheses: 2.., path: Some(path) } if path.is_empty() => Span::ZERO,
            ExplorationHint { hypotheses: 2.., path: Some(_) } => self.config.stand,
            _ if self.walks > 0 => self.config.stand,
            _ => self.config.first_stand,
        };
        let explore = || if stood >= stands { self.explore(elevation_map, here) } else { None };
        self.follow_hint(elevation_map, here, hint).or_else(explore)
    }

    /// A path to an unvisited point.
    fn explore(&self, elevation_map: &ElevationMap, here: &Vector3) -> Option<Piece> {
        let RelocalisationConfig { exploration, planner, .. } = &self.config;
        explore(exploration, planner, elevation_map, here, &self.visited).map(|path| (None, path))
    }

    /// A path to the farthest point of the hint's path, within the look-ahead distance, that a short path over seen ground reaches.
    fn follow_hint(
        &self,
        elevation_map: &ElevationMap,
        here: &Vector3,
        hint: &ExplorationHint,
    ) -> Option<Piece> {
        let hint_path = hint.path.as_ref().filter(|path| {
            hint.hypotheses > 1
                && !self.blocked_hint.as_ref().is_some_and(|(blocked, _)| Arc::ptr_eq(blocked, path))
        })?;
        let distance = |to: &Vector3| (to - here).xy().norm();
        let nearest = (0..hint_path.len())
            .min_by(|&a, &b| distance(&hint_path[a]).total_cmp(&distance(&hint_path[b])))?;
        let mut along_m = distance(&hint_path[nearest]);
        let mut ahead = Vec::new();
        for (number, end) in hint_path.iter().enumerate().skip(nearest) {
            if number > nearest {
                along_m += (end - hint_path[number - 1]).xy().norm();
            }
            if along_m > self.config.hint_ahead_m {
                break;
            }
            if distance(end) >= self.config.min_hint_piece_m {
                ahead.push((along_m, end));
            }
        }
        let is_seen =
            |end: &Vector3| elevation_map.cell(elevation_map.index(end.x, end.y)).ground().is_some();
        let path = ahead.into_iter().rev().filter(|(_, end)| is_seen(end)).find_map(|(along_m, end)| {
            let path = plan(&self.config.planner, elevation_map, here, end).ok()?;
            // The path to a blocked point ends at the nearest free cell. If the robot stands there already, following it would move the robot
            // nowhere, and would keep it from exploring.
            let leads_on = distance(path.last()?) >= self.config.min_hint_piece_m;
            (leads_on && length(&path) <= along_m + self.config.max_hint_detour_m).then_some(path)
        })?;
        Some((Some(Arc::clone(hint_path)), path))
    }

    /// A new path to the end of another one, on the elevation map as it is known now. `None` if it is longer than the other path and much longer than
    /// the straight line.
    fn replan(&self, elevation_map: &ElevationMap, here: &Vector3, path: &[Vector3]) -> Option<Vec<Vector3>> {
        let end = path.last()?;
        let straight_m = (end - here).norm() + self.config.max_replan_detour_m;
        let planned = plan(&self.config.planner, elevation_map, here, end).ok()?;
        (length(&planned) <= length(path).max(straight_m)).then_some(planned)
    }
}

impl Behaviour for RelocalisationBehaviour {
    fn update(&mut self, context: &mut BehaviourContext<'_>) -> Poll<BehaviourOutcome> {
        let at = context.at;
        if context.is_localised {
            return Poll::Ready(Ok(()));
        }
        if !context.sees_ground {
            self.stand(at);
            self.searched_at = None;
            return Poll::Pending;
        }
        let here = context.frames.odom_from_base.translation.vector;
        self.record_visit(at, &here);
        if self.searched > self.config.search_timeout {
            return Poll::Ready(Err(GoalFailure::PoseNotFound));
        }
        let timeout = self.config.blocked_hint_timeout;
        self.blocked_hint = self.blocked_hint.take().filter(|(_, since)| at - *since < timeout);
        if let Phase::Standing { since, tried } = &mut self.phase {
            let stood = at - *since;
            if tried.is_some_and(|tried| at - tried < self.config.retry_period) {
                return Poll::Pending;
            }
            *tried = Some(at);
            if let Some((hint, path)) =
                self.next_walk(stood, context.elevation_map, &here, context.exploration_hint)
            {
                self.walks += 1;
                let follower = PathFollower::new(self.config.follower, path);
                self.phase = Phase::Walking { hint, follower, planned_at: at, moved: (at, here) };
            }
            return Poll::Pending;
        }
        self.update_walk(context);
        if let Phase::Walking { follower, .. } = &self.phase {
            match follower.velocity(&context.frames.odom_from_base, context.guard) {
                Some(velocity) => context.velocity = twist(velocity),
                None => self.stand(at),
            }
        }
        Poll::Pending
    }

    fn progress(&self, _odom_from_base: &Isometry) -> GoalProgress {
        let waits_for = match (self.searched_at, &self.phase) {
            (None, _) => Some(WaitReason::Sight),
            (Some(now), Phase::Standing { since, .. }) if now - *since >= self.config.report_wait_after => {
                Some(WaitReason::FreePath)
            }
            _ => None,
        };
        GoalProgress { remaining_m: None, waits_for }
    }

    fn path(&self) -> &[Vector3] {
        match &self.phase {
            Phase::Standing { .. } => &[],
            Phase::Walking { follower, .. } => follower.path(),
        }
    }

    fn attempts(&self) -> Vec<GoalAttempt> {
        vec![GoalAttempt::SearchedForPose(self.searched), GoalAttempt::ExploredPaths(self.walks)]
    }
}

fn length(path: &[Vector3]) -> f64 {
    path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}
