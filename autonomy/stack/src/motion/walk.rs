//! A walk to a point of the map.

use super::Frames;
use geometry::{Isometry, Vector3};
use navigation::{PathFollower, PathFollowerConfig, PlanError, PlannerConfig, Terrain, Velocity, plan};
use vocab::{Span, Stamp};

/// A walk is planned anew this often, because the terrain has been seen better.
pub(super) const REPLAN_EVERY: Span = Span::from_millis(1_000);
/// And as soon as its goal has moved by this, metres, because a loop was closed.
const GOAL_MOVED: f64 = 0.05;
/// A way that stays blocked for this long ends the walk.
const GIVE_UP_AFTER: Span = Span::from_millis(8_000);

/// What comes next of something that the robot does by itself.
#[derive(Debug)]
pub(super) enum Step {
    /// Move like this.
    Go(Velocity),
    /// It is done.
    Arrived,
    /// It cannot be done; the sentence is for people.
    GaveUp(&'static str),
}

#[derive(Debug)]
pub(super) struct Walk {
    /// Map frame.
    pub goal: Vector3,
    /// Where the goal was in the odometry's frame when the way was planned.
    pub(super) planned_to: Vector3,
    /// In the odometry's frame.
    follower: PathFollower,
    planned: Stamp,
    /// Since when no way has been found, if so.
    pub(super) stuck: Option<Stamp>,
}

impl Walk {
    /// To `goal`, map frame, metres.
    ///
    /// # Errors
    /// When there is no way.
    pub fn plan(at: Stamp, terrain: &Terrain, frames: &Frames, goal: Vector3) -> Result<Self, PlanError> {
        let planned_to = frames.to_odom(&goal);
        let path =
            plan(&PlannerConfig::default(), terrain, &frames.odom_from_base.translation.vector, &planned_to)?;
        let follower = PathFollower::new(PathFollowerConfig::default(), path);
        Ok(Self { goal, planned_to, follower, planned: at, stuck: None })
    }

    /// The same, of a robot that was on its way already: where there is no way now, it waits for one.
    pub fn resume(at: Stamp, terrain: &Terrain, frames: &Frames, goal: Vector3) -> Self {
        Self::plan(at, terrain, frames, goal).unwrap_or_else(|_| {
            let here = vec![frames.odom_from_base.translation.vector];
            let follower = PathFollower::new(PathFollowerConfig::default(), here);
            Self { goal, planned_to: frames.to_odom(&goal), follower, planned: at, stuck: Some(at) }
        })
    }

    /// In the odometry's frame.
    pub fn path(&self) -> &[Vector3] {
        self.follower.path()
    }

    /// Metres to go.
    pub fn remaining(&self, odom_from_base: &Isometry) -> f64 {
        self.follower.remaining(odom_from_base)
    }

    /// Stands still for reasons that are not the way's.
    pub fn wait(&mut self, at: Stamp) {
        self.stuck = self.stuck.map(|_| at);
    }

    pub fn tick(&mut self, at: Stamp, terrain: &Terrain, frames: &Frames) -> Step {
        let goal = frames.to_odom(&self.goal);
        if at - self.planned > REPLAN_EVERY || (goal - self.planned_to).norm() > GOAL_MOVED {
            self.replan(at, terrain, &frames.odom_from_base, goal);
        }
        if let Some(since) = self.stuck {
            // Waits for people to pass.
            return if at - since > GIVE_UP_AFTER {
                Step::GaveUp("The way has stayed blocked. Choose another point or drive round by hand.")
            } else {
                Step::Go(Velocity::default())
            };
        }
        self.follower.velocity(&frames.odom_from_base).map_or(Step::Arrived, Step::Go)
    }

    /// To `goal`, which is where the walk's goal is now in the odometry's frame.
    fn replan(&mut self, at: Stamp, terrain: &Terrain, odom_from_base: &Isometry, goal: Vector3) {
        (self.planned, self.planned_to) = (at, goal);
        match plan(&PlannerConfig::default(), terrain, &odom_from_base.translation.vector, &goal) {
            Ok(path) => {
                self.follower = PathFollower::new(PathFollowerConfig::default(), path);
                self.stuck = None;
            }
            Err(_) => self.stuck = self.stuck.or(Some(at)),
        }
    }
}
