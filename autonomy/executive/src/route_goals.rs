//! Goals on the topological map. The executive has the goal: its identity, its state and its one outcome. Whoever knows that map decides the legs of the route, and when
//! the goal has ended. Between two legs the robot stands and the goal is still executed, so that a stop, a person who drives, another goal and another map end it by the
//! same rows of the table as any goal.

use crate::running_goal::RunningGoal;
use crate::{
    Behaviour, BehaviourOutcome, DockingBehaviour, Executive, GoalEvent, PoseWalkBehaviour, RouteLeg,
    RouteRemainder, Situation, StandBehaviour,
};
use messages::{Drive, ExecutiveEvent, ExecutiveState, GoalAttempt, GoalFailure, PoseGoal, StackEffect};
use vocab::{GoalId, LegId, Stamp};

impl Executive {
    /// Begins a leg of a goal on the topological map, in place of the one that is walked. If the robot's pose in the map is in doubt, the goal waits until it is found,
    /// and then the leg begins. A goal that is not the running one stays as it is.
    ///
    /// # Errors
    /// [`GoalFailure::NoSuchPlace`] if the end of the leg is no pose.
    pub fn begin_leg(
        &mut self,
        at: Stamp,
        goal: GoalId,
        leg: RouteLeg,
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) -> Result<(), GoalFailure> {
        self.surroundings.set_zones(self.zones.in_odom(&situation.frames));
        let behaviour = self.leg_behaviour(at, &leg, situation).ok_or(GoalFailure::NoSuchPlace)?;
        let Some(running) = self.route_goal(goal) else { return Ok(()) };
        running.leg = Some(leg);
        if self.state == ExecutiveState::Executing {
            self.keep_attempts();
            self.behaviour = Some(behaviour);
            if situation.is_pose_unconfirmed {
                self.handle_event(at, ExecutiveEvent::PoseLost, situation, effects);
            }
        }
        Ok(())
    }

    /// Ends a leg before its end, if it is the one that is walked. The robot stands, and the goal goes on.
    pub fn end_leg(&mut self, leg: LegId, effects: &mut Vec<StackEffect>) {
        if self.take_leg(leg).is_some() && self.state == ExecutiveState::Executing {
            self.stand_between_legs(effects);
        }
    }

    /// Ends a goal on the topological map, if it is the running one.
    pub fn end_route(
        &mut self,
        at: Stamp,
        goal: GoalId,
        outcome: BehaviourOutcome,
        situation: &Situation,
        effects: &mut Vec<StackEffect>,
    ) {
        if self.route_goal(goal).is_some() {
            self.end_behaviour(at, outcome, situation, effects);
        }
    }

    /// Adds something that was tried between the legs of a goal on the topological map.
    pub fn add_attempt(&mut self, goal: GoalId, attempt: &GoalAttempt) {
        if let Some(goal) = self.route_goal(goal) {
            goal.add_attempt(attempt);
        }
    }

    /// What is left of the route from now on. It is published with the progress of the goal.
    pub fn set_remainder(&mut self, goal: GoalId, remainder: RouteRemainder) {
        if let Some(goal) = self.route_goal(goal) {
            goal.remainder = remainder;
        }
    }

    /// The leg that is walked, or is walked once the robot's pose is found.
    pub fn leg(&self) -> Option<LegId> {
        self.goal.as_ref()?.leg.map(|leg| leg.id)
    }

    /// The behaviour of the present leg has ended.
    pub(crate) fn finish_leg(&mut self, outcome: BehaviourOutcome, effects: &mut Vec<StackEffect>) {
        let Some(leg) = self.goal.as_mut().and_then(|goal| goal.leg.take()) else { return };
        self.stand_between_legs(effects);
        self.events.push(GoalEvent::LegEnded(leg.id, outcome));
    }

    /// The behaviour of a leg; none if its end is no pose.
    pub(crate) fn leg_behaviour(
        &self,
        at: Stamp,
        leg: &RouteLeg,
        situation: &Situation,
    ) -> Option<Box<dyn Behaviour>> {
        let Some(dock) = &leg.dock else { return self.pose_walk(at, &leg.pose, situation) };
        let (limits, height_m) = (&self.profile.autonomous_limits, self.profile.standing_height_m);
        let walk = DockingBehaviour::new(self.config.docking, limits, height_m, at, dock)?;
        Some(Box::new(walk))
    }

    /// A walk into a pose; none if that is no pose.
    pub(crate) fn pose_walk(
        &self,
        at: Stamp,
        goal: &PoseGoal,
        situation: &Situation,
    ) -> Option<Box<dyn Behaviour>> {
        let (config, limits) = (self.config.pose_walk, &self.profile.autonomous_limits);
        let (elevation_map, frames) = (self.surroundings.elevation_map(), &situation.frames);
        let walk = PoseWalkBehaviour::new(config, self.config.walk, limits, at, elevation_map, frames, goal)?;
        Some(Box::new(walk))
    }

    fn stand_between_legs(&mut self, effects: &mut Vec<StackEffect>) {
        self.keep_attempts();
        self.behaviour = Some(Box::new(StandBehaviour));
        effects.push(StackEffect::Drive(Drive::default()));
    }

    fn take_leg(&mut self, id: LegId) -> Option<RouteLeg> {
        self.goal.as_mut()?.leg.take_if(|leg| leg.id == id)
    }

    /// The running goal, if it is this one and on the topological map.
    fn route_goal(&mut self, id: GoalId) -> Option<&mut RunningGoal> {
        self.goal.as_mut().filter(|goal| goal.id == id && goal.is_route())
    }
}
