//! Looking about: the robot stands, so that what it sees can be recognised, and if it is not, walks a little over ground that it has
//! seen, to where it has not been, and stands again.

use super::walk::{REPLAN_EVERY, Step};
use geometry::{Isometry, Vector3};
use navigation::{Follower, FollowerConfig, Terrain, Velocity, plan, roam};
use vocab::{Span, Stamp};

/// It stands so long at first, and later: recognising a place takes half a second.
const STAND_FIRST: Span = Span::from_millis(2_500);
const STAND: Span = Span::from_millis(1_000);
/// One walk, metres: the lowest beams of a LiDAR on a mast meet the ground three metres away.
const WALK: f64 = 4.0;
/// Slower than where it knows its way, m/s.
const SPEED: f64 = 0.6;
/// After so many places it gives up, until somebody helps.
const PLACES: usize = 16;

#[derive(Debug)]
pub(super) struct Look {
    /// Where the robot was going, map frame.
    pub goal: Option<Vector3>,
    /// Where it has looked, odometry's frame.
    been: Vec<Vector3>,
    now: Now,
}

#[derive(Debug)]
enum Now {
    Stands { since: Stamp },
    Walks { follower: Follower, planned: Stamp },
}

impl Look {
    pub fn new(at: Stamp, goal: Option<Vector3>) -> Self {
        Self { goal, been: Vec::new(), now: Now::Stands { since: at } }
    }

    /// Sees nothing.
    pub fn wait(&mut self, at: Stamp) {
        self.now = Now::Stands { since: at };
    }

    pub fn tick(&mut self, at: Stamp, terrain: &Terrain, odom_from_base: &Isometry) -> Step {
        let here = odom_from_base.translation.vector;
        match &mut self.now {
            Now::Stands { since } => {
                if at - *since < if self.been.is_empty() { STAND_FIRST } else { STAND } {
                    return Step::Go(Velocity::default());
                }
                if self.been.len() >= PLACES {
                    return Step::GaveUp(
                        "The robot looked about and did not find its place in the map. Set its place on the map, or drive it to where \
                         the map is right.",
                    );
                }
                self.been.push(here);
                self.now = match roam(terrain, &here, &self.been, WALK) {
                    Some(path) => {
                        let config = FollowerConfig { speed: SPEED, ..FollowerConfig::default() };
                        Now::Walks { follower: Follower::new(config, path), planned: at }
                    }
                    None => Now::Stands { since: at },
                };
            }
            Now::Walks { follower, planned } => {
                let free = at - *planned < REPLAN_EVERY || is_free(terrain, &here, follower.path());
                match follower.velocity(odom_from_base).filter(|_| free) {
                    Some(velocity) => {
                        if at - *planned >= REPLAN_EVERY {
                            *planned = at;
                        }
                        return Step::Go(velocity);
                    }
                    None => self.now = Now::Stands { since: at },
                }
            }
        }
        Step::Go(Velocity::default())
    }
}

/// Whether nobody has stepped into the way: the rest of it is planned as it was, to half a metre.
fn is_free(terrain: &Terrain, here: &Vector3, path: &[Vector3]) -> bool {
    let Some(end) = path.last() else { return false };
    let length = |path: &[Vector3]| path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
    let nearly = (end - here).norm() + 0.5;
    plan(terrain, here, end).is_ok_and(|now| length(&now) <= length(path).max(nearly))
}
