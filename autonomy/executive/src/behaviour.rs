//! The interface of behaviours. A behaviour is a small state machine that sets the robot's velocity until its goal is reached.

use geometry::{Isometry, Vector3};
use localisation::ExplorationHint;
use messages::{GoalAttempt, GoalFailure, GoalProgress};
use navigation::{ElevationMap, MotionGuard};
use std::fmt::Debug;
use std::task::Poll;
use vocab::{Stamp, Twist};

/// Outcome of a behaviour.
pub type BehaviourOutcome = Result<(), GoalFailure>;

/// A behaviour. The executive updates one at a time. It ends a behaviour by dropping it.
pub trait Behaviour: Debug + Send + Sync {
    /// One step, at 20 Hz. Sets [`BehaviourContext::velocity`]. With zero velocity the robot stands.
    fn update(&mut self, context: &mut BehaviourContext<'_>) -> Poll<BehaviourOutcome>;

    /// A scan was located, in the base frame, metres. Only behaviours that look for something need it.
    fn observe_scan(&mut self, _at: Stamp, _odom_from_base: &Isometry, _points: &[[f32; 3]]) {}

    /// Progress towards the goal.
    fn progress(&self, _odom_from_base: &Isometry) -> GoalProgress {
        GoalProgress::default()
    }

    /// The path that it follows, in the odometry frame. Empty if it follows none.
    fn path(&self) -> &[Vector3] {
        &[]
    }

    /// Attempts so far.
    fn attempts(&self) -> Vec<GoalAttempt> {
        Vec::new()
    }
}

/// What a behaviour reads of the robot's situation, and the velocity that it sets.
#[derive(Debug)]
pub struct BehaviourContext<'a> {
    /// Present time.
    pub at: Stamp,
    /// Poses of the robot.
    pub frames: Frames,
    /// Heights of ground and obstacles, in the odometry frame.
    pub elevation_map: &'a ElevationMap,
    /// The obstacles around the robot, and the velocities that they allow. The executive applies it to whatever a behaviour that walks by itself commands.
    pub guard: &'a MotionGuard,
    /// Whether the ground was seen lately. A behaviour that walks by itself stands still while it was not.
    pub sees_ground: bool,
    /// Whether the robot's pose in the saved map is known and not in doubt.
    pub is_localised: bool,
    /// Plan of localisation for finding the pose by walking.
    pub exploration_hint: &'a ExplorationHint,
    /// Commanded velocity of the base in its own frame. Zero at the beginning of every update.
    pub velocity: Twist,
}

/// Poses of the frames at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Frames {
    /// Odometry frame in the map.
    pub map_from_odom: Isometry,
    /// Base in the odometry frame.
    pub odom_from_base: Isometry,
}

impl Frames {
    /// Base in the map.
    pub fn map_from_base(&self) -> Isometry {
        self.map_from_odom * self.odom_from_base
    }

    /// A point of the odometry frame in the map.
    pub fn to_map(self, point: &Vector3) -> Vector3 {
        self.map_from_odom.rotation * point + self.map_from_odom.translation.vector
    }

    /// A point of the map in the odometry frame.
    pub fn to_odom(self, point: &Vector3) -> Vector3 {
        self.map_from_odom.rotation.inverse() * (point - self.map_from_odom.translation.vector)
    }
}
