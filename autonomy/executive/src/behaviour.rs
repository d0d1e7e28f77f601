//! What a behaviour is: a small state machine that sets the robot's velocity until it has reached what it is for.

use geometry::{Isometry, Vector3};
use localisation::ExplorationHint;
use messages::{GoalAttempt, GoalFailure, GoalProgress};
use navigation::ElevationMap;
use std::fmt::Debug;
use std::task::Poll;
use vocab::{Stamp, Twist};

/// How a behaviour ended.
pub type Outcome = Result<(), GoalFailure>;

/// A behaviour. The executive updates one at a time; dropping it ends it.
pub trait Behaviour: Debug + Send + Sync {
    /// One step, at 20 Hz. Sets [`BehaviourContext::velocity`]; zero stands.
    fn update(&mut self, context: &mut BehaviourContext<'_>) -> Poll<Outcome>;

    /// How far it is.
    fn progress(&self, _odom_from_base: &Isometry) -> GoalProgress {
        GoalProgress::default()
    }

    /// The path that it follows, odometry's frame; empty without one.
    fn path(&self) -> &[Vector3] {
        &[]
    }

    /// What it has tried so far.
    fn attempts(&self) -> Vec<GoalAttempt> {
        Vec::new()
    }
}

/// What a behaviour sees of the world, and the velocity that it sets.
#[derive(Debug)]
pub struct BehaviourContext<'a> {
    /// Now.
    pub at: Stamp,
    /// Where the robot is.
    pub frames: Frames,
    /// Where it can walk, odometry's frame.
    pub terrain: &'a ElevationMap,
    /// Whether the ground was seen lately. A behaviour that walks by itself stands while it was not.
    pub sees_ground: bool,
    /// Whether the place in the saved map in use is known and nothing speaks against it.
    pub is_place_known: bool,
    /// What is known of the place while it is looked for.
    pub exploration_hint: &'a ExplorationHint,
    /// Wanted velocity of the base in its own frame; zero at the beginning of every update.
    pub velocity: Twist,
}

/// Where everything is at an instant.
#[derive(Clone, Copy, Debug)]
pub struct Frames {
    /// Odometry's frame in the map.
    pub map_from_odom: Isometry,
    /// Base in odometry's frame.
    pub odom_from_base: Isometry,
}

impl Frames {
    /// Base in the map.
    pub fn map_from_base(&self) -> Isometry {
        self.map_from_odom * self.odom_from_base
    }

    /// A point of odometry's frame in the map.
    pub fn to_map(self, point: &Vector3) -> Vector3 {
        self.map_from_odom.rotation * point + self.map_from_odom.translation.vector
    }

    /// A point of the map in odometry's frame.
    pub fn to_odom(self, point: &Vector3) -> Vector3 {
        self.map_from_odom.rotation.inverse() * (point - self.map_from_odom.translation.vector)
    }
}
