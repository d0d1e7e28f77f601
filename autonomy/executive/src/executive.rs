//! Applies the state table: commands and events in, drive commands and published states out.

use crate::running_goal::RunningGoal;
use crate::table::{Action, Guard, TABLE};
use crate::texts;
use crate::{
    Behaviour, BehaviourContext, BehaviourOutcome, DockingConfig, Frames, GoalEvent, ManualDriving, MapZone,
    MapZones, PoseWalkConfig, RelocalisationBehaviour, RelocalisationConfig, RouteRemainder, StandBehaviour,
    Surroundings, SurroundingsConfig, WalkBehaviour, WalkConfig,
};
use geometry::{Isometry, Vector3, pose_from_isometry, vec_from_plain, vec_to_plain};
use localisation::ExplorationHint;
use messages::{
    CancelCause, Drive, ExecutiveEvent, ExecutiveState, ExecutiveStatus, GoalFailure, GoalKind, GoalResult,
    GoalStatus, MotionState, Principal, Publication, RobotProfile, StackEffect, WaitReason,
};
use navigation::{MotionGuard, MotionGuardConfig};
use std::collections::VecDeque;
use std::task::Poll;
use vocab::{ClientId, GoalId, Stamp, Twist};

/// Parameters of the executive and its behaviours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExecutiveConfig {
    /// Number of goal ids that are remembered, so that a repeated request has no effect. Chosen: a client repeats only its last requests.
    pub max_recent_goals: usize,
    /// Parameters of walks.
    pub walk: WalkConfig,
    /// Parameters of the last steps into a pose.
    pub pose_walk: PoseWalkConfig,
    /// Parameters of walks into docks.
    pub docking: DockingConfig,
    /// Parameters of the search for the pose.
    pub relocalisation: RelocalisationConfig,
    /// Parameters of the elevation map around the robot.
    pub surroundings: SurroundingsConfig,
    /// Parameters of the check that the robot can stop in time.
    pub guard: MotionGuardConfig,
}

impl ExecutiveConfig {
    /// For a robot of this profile, whose speed limits hold.
    pub fn new(profile: &RobotProfile) -> Self {
        let walk = WalkConfig::new(&profile.autonomous_limits);
        Self {
            max_recent_goals: 64,
            walk,
            pose_walk: PoseWalkConfig::default(),
            docking: DockingConfig::default(),
            relocalisation: RelocalisationConfig::new(&walk),
            surroundings: SurroundingsConfig::default(),
            guard: MotionGuardConfig::default(),
        }
    }
}

/// The state of localisation and odometry that the executive reads.
#[derive(Clone, Debug)]
pub struct Situation {
    /// Poses of the robot.
    pub frames: Frames,
    /// Whether a saved map is in use: the pose in it is known or searched for.
    pub is_in_saved_map: bool,
    /// Whether the pose in it is known and not in doubt.
    pub is_localised: bool,
    /// Whether the pose in it is searched for, or may be wrong.
    pub is_pose_unconfirmed: bool,
    /// Plan of localisation for finding the pose by walking.
    pub exploration_hint: ExplorationHint,
}

/// The executive. Effects are appended in order of execution.
#[derive(Debug)]
pub struct Executive {
    pub(crate) config: ExecutiveConfig,
    pub(crate) profile: RobotProfile,
    pub(crate) surroundings: Surroundings,
    pub(crate) zones: MapZones,
    pub(crate) state: ExecutiveState,
    /// Start of the present state, and the event that caused it.
    entered: (Stamp, ExecutiveEvent),
    pub(crate) behaviour: Option<Box<dyn Behaviour>>,
    pub(crate) goal: Option<RunningGoal>,
    recent_goals: VecDeque<GoalId>,
    /// What has become of goals and legs, until it is taken.
    pub(crate) events: Vec<GoalEvent>,
    stopped_by: Option<ClientId>,
    /// Whether motion was stopped before the program started, while [`ExecutiveEvent::Started`] is handled.
    is_stop_kept: bool,
    /// A walk that failed. It is kept until the next event.
    blocked: Option<(Vector3, GoalFailure)>,
    published: Option<ExecutiveStatus>,
    published_motion: Option<MotionState>,
    /// Indices of the table rows that were taken, for tests.
    #[cfg(test)]
    pub(crate) taken: Vec<usize>,
}

/// The data of an event.
#[derive(Debug, Default)]
struct Trigger {
    by: Option<Principal>,
    velocity: Option<Twist>,
    goal: Option<(RunningGoal, Box<dyn Behaviour>)>,
    failure: Option<GoalFailure>,
}

impl Executive {
    /// The executive of a standing robot that has not seen the ground yet.
    pub fn new(config: ExecutiveConfig, profile: &RobotProfile) -> Self {
        Self {
            config,
            profile: profile.clone(),
            surroundings: Surroundings::new(config.surroundings, profile),
            zones: MapZones::default(),
            state: ExecutiveState::Idle,
            entered: (Stamp::EPOCH, ExecutiveEvent::Started),
            behaviour: None,
            goal: None,
            recent_goals: VecDeque::new(),
            events: Vec::new(),
            stopped_by: None,
            is_stop_kept: false,
            blocked: None,
            published: None,
            published_motion: None,
            #[cfg(test)]
            taken: Vec::new(),
        }
    }

    /// The elevation map around the robot, for inserting scans.
    pub fn surroundings(&mut self) -> &mut Surroundings {
        &mut self.surroundings
    }

    /// Replaces the zones that hold for a robot that walks by itself. A person who drives may enter all.
    pub fn set_zones(&mut self, zones: Vec<MapZone>) {
        self.zones.set(zones);
    }

    /// Starts a goal. One that was started before has no effect. A goal on the topological map begins with the robot standing: its legs are begun with
    /// [`Self::begin_leg`].
    ///
    /// # Errors
    /// One sentence for people: why the goal cannot start.
    pub fn start_goal(
        &mut self,
        at: Stamp,
        goal: (GoalId, GoalKind, Principal),
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), String> {
        self.start(at, goal, true, situation, effects)
    }

    /// Starts a goal that is a part of something else, and which clients do not see. Its end is among [`Self::take_events`].
    ///
    /// # Errors
    /// As [`Self::start_goal`].
    pub fn start_hidden_goal(
        &mut self,
        at: Stamp,
        goal: (GoalId, GoalKind, Principal),
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), String> {
        self.start(at, goal, false, situation, effects)
    }

    /// What has become of goals and legs since the last call, in its order.
    pub fn take_events(&mut self) -> Vec<GoalEvent> {
        std::mem::take(&mut self.events)
    }

    /// A scan was located: the running behaviour may look for something in it. In the base frame, metres.
    pub fn observe_scan(&mut self, at: Stamp, odom_from_base: &Isometry, points: &[[f32; 3]]) {
        if let Some(behaviour) = &mut self.behaviour {
            behaviour.observe_scan(at, odom_from_base, points);
        }
    }

    fn start(
        &mut self,
        at: Stamp,
        (id, kind, by): (GoalId, GoalKind, Principal),
        is_published: bool,
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), String> {
        if self.recent_goals.contains(&id) {
            return Ok(());
        }
        self.surroundings.set_zones(self.zones.in_odom(&situation.frames));
        let is_refused = self
            .find_row(ExecutiveEvent::GoalRequested, situation)
            .is_some_and(|row| TABLE[row].actions.contains(&Action::Refuse));
        let goal = match is_refused {
            true => None,
            false => {
                let behaviour = self.begin(at, kind, situation)?;
                let goal = RunningGoal {
                    id,
                    kind,
                    leg: None,
                    remainder: RouteRemainder::default(),
                    by,
                    accepted: at,
                    status: GoalStatus::Accepted,
                    tried: Vec::new(),
                    is_published,
                };
                Some((goal, behaviour))
            }
        };
        self.apply(
            at,
            ExecutiveEvent::GoalRequested,
            Trigger { goal, ..Trigger::default() },
            situation,
            effects,
        )
    }

    /// Cancels a goal if it is running.
    pub fn cancel_goal(
        &mut self,
        at: Stamp,
        goal: GoalId,
        by: Principal,
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) {
        if self.goal.as_ref().is_some_and(|running| running.id == goal) {
            self.fire(at, ExecutiveEvent::CancelRequested, Some(by), situation, effects);
        }
    }

    /// Drives by hand with a velocity.
    ///
    /// # Errors
    /// One sentence for people: why the velocity is refused.
    pub fn drive(
        &mut self,
        at: Stamp,
        velocity: Twist,
        by: Principal,
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), String> {
        if !velocity.linear.is_finite() || !velocity.angular.is_finite() {
            return Err(texts::VELOCITY_NOT_FINITE.to_owned());
        }
        let trigger = Trigger { by: Some(by), velocity: Some(velocity), ..Trigger::default() };
        self.apply(at, ExecutiveEvent::VelocityCommanded, trigger, situation, effects)
    }

    /// Stops motion until it is allowed again.
    pub fn stop(&mut self, at: Stamp, by: Principal, situation: &Situation, effects: &mut Vec<StackEffect>) {
        self.stopped_by = Some(by.client);
        self.fire(at, ExecutiveEvent::StopRequested, Some(by), situation, effects);
    }

    /// Motion was stopped by this client before the program started, and still is. To be called before the first update.
    pub fn restore_stop(&mut self, by: Option<ClientId>) {
        self.stopped_by = by;
        self.is_stop_kept = true;
        // The robot has neither moved nor a map yet, and the row has no effects.
        let situation = Situation {
            frames: Frames { map_from_odom: Isometry::identity(), odom_from_base: Isometry::identity() },
            is_in_saved_map: false,
            is_localised: false,
            is_pose_unconfirmed: false,
            exploration_hint: ExplorationHint::default(),
        };
        self.fire(Stamp::EPOCH, ExecutiveEvent::Started, None, &situation, &mut Vec::new());
        self.is_stop_kept = false;
    }

    /// Handles an event without data.
    pub fn handle_event(
        &mut self,
        at: Stamp,
        event: ExecutiveEvent,
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) {
        self.fire(at, event, None, situation, effects);
    }

    /// Updates the behaviour, which moves the robot. To be called at 20 Hz.
    pub fn update(&mut self, at: Stamp, situation: &Situation, effects: &mut Vec<StackEffect>) {
        if self.state == ExecutiveState::Recovering && situation.is_localised {
            // Localisation reports a found pose only once. The pose may have been in doubt then, and after a restart of odometry there may be no
            // report.
            self.fire(at, ExecutiveEvent::PoseFound, None, situation, effects);
        }
        let Some(behaviour) = &mut self.behaviour else { return };
        self.surroundings.set_zones(self.zones.in_odom(&situation.frames));
        let odom_from_base = &situation.frames.odom_from_base;
        let guard =
            self.surroundings.guard(self.config.guard, odom_from_base, &self.profile.autonomous_limits);
        let mut context = BehaviourContext {
            at,
            frames: situation.frames,
            elevation_map: self.surroundings.elevation_map(),
            guard: &guard,
            sees_ground: self.surroundings.sees_ground(at),
            is_localised: situation.is_localised,
            exploration_hint: &situation.exploration_hint,
            velocity: Twist::default(),
        };
        match behaviour.update(&mut context) {
            Poll::Pending => {
                let mut velocity = context.velocity;
                if self.state != ExecutiveState::ManualDriving {
                    velocity = guarded(velocity, &guard, odom_from_base);
                    let ground = self.surroundings.elevation_map().zones();
                    velocity = self.zones.limited(velocity, ground, &situation.frames);
                }
                effects.push(StackEffect::Drive(Drive { velocity }));
                self.publish_progress(situation, effects);
            }
            Poll::Ready(_) if self.state == ExecutiveState::ManualDriving => {
                self.fire(at, ExecutiveEvent::VelocityTimedOut, None, situation, effects);
            }
            Poll::Ready(outcome) => {
                let is_of_leg = self.goal.as_ref().is_some_and(|goal| goal.leg.is_some());
                match self.state == ExecutiveState::Executing && is_of_leg {
                    true => self.finish_leg(outcome, effects),
                    false => self.end_behaviour(at, outcome, situation, effects),
                }
            }
        }
    }

    /// What was done for the running goal has ended.
    pub(crate) fn end_behaviour(
        &mut self,
        at: Stamp,
        outcome: BehaviourOutcome,
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) {
        let event = match outcome {
            Ok(()) => ExecutiveEvent::BehaviourSucceeded,
            Err(_) => ExecutiveEvent::BehaviourFailed,
        };
        let trigger = Trigger { failure: outcome.err(), ..Trigger::default() };
        // No row of these events refuses anything.
        let _ = self.apply(at, event, trigger, situation, effects);
    }

    /// What moves the robot.
    pub fn state(&self) -> ExecutiveState {
        self.state
    }

    /// The goal that is executed or waits, if any.
    pub fn goal(&self) -> Option<GoalId> {
        self.goal.as_ref().map(|goal| goal.id)
    }

    /// The kind of the goal that is executed or waits, and who asked for it.
    pub fn request(&self) -> Option<(GoalKind, &Principal)> {
        self.goal.as_ref().map(|goal| (goal.kind, &goal.by))
    }

    /// Whether a goal of this id was started, lately at least.
    pub fn knows_goal(&self, goal: GoalId) -> bool {
        self.recent_goals.contains(&goal)
    }

    /// Whether a goal waits until the pose is found.
    pub fn is_recovering(&self) -> bool {
        self.state == ExecutiveState::Recovering
    }

    /// Publishes the state of the executive and of motion if they have changed.
    pub fn publish_changes(&mut self, at: Stamp, frames: &Frames, effects: &mut Vec<StackEffect>) {
        let status = ExecutiveStatus {
            state: self.state,
            since: self.entered.0,
            cause: self.entered.1,
            goal: self.goal.as_ref().filter(|goal| goal.is_published).map(|goal| goal.id),
        };
        if self.published.replace(status) != Some(status) {
            effects.push(StackEffect::Publish(Publication::Executive(status)));
        }
        let motion = self.motion(at, frames);
        if self.published_motion.as_ref() != Some(&motion) {
            self.published_motion = Some(motion.clone());
            effects.push(StackEffect::Publish(Publication::Motion(motion)));
        }
    }

    /// State of motion for display, derived from the state and its goal.
    fn motion(&self, at: Stamp, frames: &Frames) -> MotionState {
        let point = self.goal.as_ref().and_then(RunningGoal::point);
        let is_search = self.goal.as_ref().is_some_and(|goal| goal.kind == GoalKind::Relocalise);
        match (self.state, point, &self.behaviour) {
            (ExecutiveState::Stopped, ..) => MotionState::Stopped { by: self.stopped_by },
            (ExecutiveState::ManualDriving, ..) => MotionState::Teleoperated,
            (ExecutiveState::Recovering, ..) => MotionState::Relocalising { goal: point },
            (ExecutiveState::Executing, ..) if is_search => MotionState::Relocalising { goal: None },
            (ExecutiveState::Executing, Some(goal), _) if !self.surroundings.sees_ground(at) => {
                MotionState::Waiting { goal }
            }
            (ExecutiveState::Executing, Some(goal), Some(behaviour)) => MotionState::Walking {
                goal,
                path: behaviour.path().iter().map(|point| vec_to_plain(&frames.to_map(point))).collect(),
                remaining_m: behaviour.progress(&frames.odom_from_base).remaining_m.unwrap_or_default(),
            },
            (ExecutiveState::Idle | ExecutiveState::Executing, ..) => match &self.blocked {
                Some((goal, reason)) => {
                    MotionState::Blocked { goal: vec_to_plain(goal), reason: reason.sentence().to_owned() }
                }
                None => MotionState::Idle,
            },
        }
    }

    /// The behaviour of a new goal.
    fn begin(&self, at: Stamp, kind: GoalKind, situation: &Situation) -> Result<Box<dyn Behaviour>, String> {
        match kind {
            GoalKind::WalkTo(_) | GoalKind::WalkToPose(_) if situation.is_pose_unconfirmed => {
                Err(texts::NOT_LOCALISED.to_owned())
            }
            GoalKind::WalkTo(point) if !point.is_finite() => Err(texts::POINT_NOT_FINITE.to_owned()),
            GoalKind::WalkTo(point) => {
                let (elevation_map, frames) = (self.surroundings.elevation_map(), &situation.frames);
                let walk =
                    WalkBehaviour::begin(self.config.walk, at, elevation_map, frames, vec_from_plain(point));
                walk.map(|walk| Box::new(walk) as Box<dyn Behaviour>).map_err(|error| error.to_string())
            }
            GoalKind::WalkToPose(pose) => {
                self.pose_walk(at, &pose, situation).ok_or_else(|| texts::POINT_NOT_FINITE.to_owned())
            }
            // Whoever knows the topological map begins the legs.
            GoalKind::GoToNode(_) | GoalKind::GoToDock(_) | GoalKind::Undock => Ok(Box::new(StandBehaviour)),
            GoalKind::Relocalise if !situation.is_pose_unconfirmed => Err(texts::NO_POSE_TO_FIND.to_owned()),
            GoalKind::Relocalise => Ok(self.search(at)),
        }
    }

    /// The behaviour of the running goal, which is resumed.
    fn resume(&self, at: Stamp, goal: &RunningGoal, situation: &Situation) -> Box<dyn Behaviour> {
        let stand_still = || Box::new(StandBehaviour) as Box<dyn Behaviour>;
        match goal.kind {
            GoalKind::WalkTo(point) => Box::new(WalkBehaviour::resume(
                self.config.walk,
                at,
                self.surroundings.elevation_map(),
                &situation.frames,
                vec_from_plain(point),
            )),
            // It was a pose when the goal began.
            GoalKind::WalkToPose(pose) => self.pose_walk(at, &pose, situation).unwrap_or_else(stand_still),
            GoalKind::Relocalise => self.search(at),
            GoalKind::GoToNode(_) | GoalKind::GoToDock(_) | GoalKind::Undock => {
                let leg = goal.leg.as_ref().and_then(|leg| self.leg_behaviour(at, leg, situation));
                leg.unwrap_or_else(stand_still)
            }
        }
    }

    fn search(&self, at: Stamp) -> Box<dyn Behaviour> {
        Box::new(RelocalisationBehaviour::new(self.config.relocalisation, at))
    }

    fn fire(
        &mut self,
        at: Stamp,
        event: ExecutiveEvent,
        by: Option<Principal>,
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) {
        // Only velocities and goals can be refused, and they do not use this function.
        let _ = self.apply(at, event, Trigger { by, ..Trigger::default() }, situation, effects);
    }

    /// Index of the first row that matches.
    fn find_row(&self, event: ExecutiveEvent, situation: &Situation) -> Option<usize> {
        let goal = self.goal.as_ref();
        let in_map = situation.is_in_saved_map;
        TABLE.iter().position(|row| {
            row.from == self.state
                && row.event == event
                && match row.guard {
                    Guard::Always => true,
                    Guard::StopIsKept => self.is_stop_kept,
                    Guard::GoalNeedsPose => in_map && goal.is_some_and(RunningGoal::needs_pose),
                    Guard::GoalFindsPose => {
                        in_map && goal.is_some_and(|goal| goal.kind == GoalKind::Relocalise)
                    }
                    Guard::InSavedMap => in_map,
                    Guard::NotInSavedMap => !in_map,
                }
        })
    }

    /// Takes the row of an event, if there is one. An event without a row changes nothing.
    fn apply(
        &mut self,
        at: Stamp,
        event: ExecutiveEvent,
        mut trigger: Trigger,
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), String> {
        if event != ExecutiveEvent::BehaviourFailed {
            self.blocked = None;
        }
        let Some(number) = self.find_row(event, situation) else { return Ok(()) };
        #[cfg(test)]
        self.taken.push(number);
        let row = &TABLE[number];
        if row.actions.contains(&Action::Refuse) {
            return Err(texts::MOTION_STOPPED.to_owned());
        }
        if row.to != self.state {
            (self.state, self.entered) = (row.to, (at, event));
        }
        for action in row.actions {
            self.act(at, *action, &mut trigger, situation, effects);
        }
        if self.state == ExecutiveState::Idle {
            self.behaviour = None;
        }
        Ok(())
    }

    fn act(
        &mut self,
        at: Stamp,
        action: Action,
        trigger: &mut Trigger,
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) {
        match action {
            Action::Refuse => {}
            Action::StopRobot => effects.push(StackEffect::Drive(Drive::default())),
            Action::StandBehaviour => self.behaviour = Some(Box::new(StandBehaviour)),
            Action::Drive => {
                if let Some(velocity) = &trigger.velocity {
                    let RobotProfile { manual_limits, manual_watchdog, .. } = &self.profile;
                    let driving = ManualDriving::new(at, velocity, manual_limits, *manual_watchdog);
                    self.behaviour = Some(Box::new(driving));
                }
            }
            Action::BeginGoal => {
                if let Some((goal, behaviour)) = trigger.goal.take() {
                    if goal.is_published {
                        self.remember(goal.id);
                    }
                    self.behaviour = Some(behaviour);
                    goal.publish(effects);
                    self.goal = Some(goal);
                }
            }
            Action::CancelGoal(reason) => {
                let new = trigger.goal.as_ref().map(|(goal, _)| goal);
                let cause: CancelCause = reason.cause(new.map(|goal| goal.id));
                let by = trigger.by.clone().or_else(|| new.map(|goal| goal.by.clone()));
                if let Some(goal) = self.goal.take() {
                    let by = by.unwrap_or_else(|| goal.by.clone());
                    self.end(goal, GoalStatus::Cancelled { by, cause }, effects);
                }
            }
            Action::SucceedGoal => {
                if let Some(goal) = self.goal.take() {
                    let map_from_base = pose_from_isometry(&situation.frames.map_from_base());
                    let result = GoalResult { map_from_base, duration: at - goal.accepted };
                    self.end(goal, GoalStatus::Succeeded(result), effects);
                }
            }
            Action::FailGoal => self.fail(trigger.failure.unwrap_or(GoalFailure::PoseNotFound), effects),
            Action::FailGoalBecause(reason) => self.fail(reason, effects),
            Action::SuspendGoal => {
                self.keep_attempts();
                self.behaviour = Some(self.search(at));
            }
            Action::ResumeGoal => {
                self.keep_attempts();
                if let Some(goal) = &self.goal {
                    self.behaviour = Some(self.resume(at, goal, situation));
                }
            }
            Action::RestartSearch => {
                self.keep_attempts();
                self.behaviour = Some(self.search(at));
            }
        }
    }

    fn fail(&mut self, reason: GoalFailure, effects: &mut Vec<StackEffect>) {
        self.keep_attempts();
        if let Some(goal) = self.goal.take() {
            if let GoalKind::WalkTo(point) = goal.kind
                && reason != GoalFailure::MapReplaced
            {
                self.blocked = Some((vec_from_plain(point), reason));
            }
            let tried = goal.tried.clone();
            self.end(goal, GoalStatus::Failed { reason, tried }, effects);
        }
    }

    /// Publishes the outcome of a goal.
    fn end(&mut self, mut goal: RunningGoal, outcome: GoalStatus, effects: &mut Vec<StackEffect>) {
        goal.status = outcome;
        goal.publish(effects);
        self.events.push(GoalEvent::Ended(goal.update()));
    }

    /// Keeps the id of a goal, so that the goal does not begin again when it is requested again.
    fn remember(&mut self, goal: GoalId) {
        if self.recent_goals.len() == self.config.max_recent_goals {
            self.recent_goals.pop_front();
        }
        self.recent_goals.push_back(goal);
    }

    /// Adds the behaviour's attempts to those of the goal.
    pub(crate) fn keep_attempts(&mut self) {
        let Some(behaviour) = self.behaviour.take() else { return };
        let Some(goal) = &mut self.goal else { return };
        for attempt in behaviour.attempts() {
            goal.add_attempt(&attempt);
        }
    }

    fn publish_progress(&mut self, situation: &Situation, effects: &mut Vec<StackEffect>) {
        let (Some(goal), Some(behaviour)) = (&mut self.goal, &self.behaviour) else { return };
        let mut progress =
            goal.progress(behaviour.progress(&situation.frames.odom_from_base), &situation.frames);
        if self.state == ExecutiveState::Recovering {
            // What the search waits for says more to people than that the robot relocalises.
            progress.waits_for = progress.waits_for.or(Some(WaitReason::Relocalisation));
        }
        let status = GoalStatus::Running(progress);
        if goal.status != status {
            goal.status = status;
            goal.publish(effects);
        }
    }
}

/// The velocity with which the robot can stop before it touches anything.
fn guarded(velocity: Twist, guard: &MotionGuard, odom_from_base: &Isometry) -> Twist {
    let share =
        guard.allowed_share(odom_from_base, [velocity.linear.x, velocity.linear.y], velocity.angular.z);
    let mut guarded = velocity;
    guarded.linear.x *= share;
    guarded.linear.y *= share;
    guarded
}
