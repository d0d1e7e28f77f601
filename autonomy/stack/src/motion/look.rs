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
/// A walk on which it gets no farther than so many metres in such a time is over: something that it does not see is in its way.
const STUCK: (f64, Span) = (0.1, Span::from_millis(6_000));
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
    Stands {
        since: Stamp,
    },
    /// `passed`: where it was, and when, as it last got any farther.
    Walks {
        follower: Follower,
        planned: Stamp,
        passed: (Stamp, Vector3),
    },
}

impl Look {
    pub fn new(at: Stamp, goal: Option<Vector3>) -> Self {
        Self { goal, been: Vec::new(), now: Now::Stands { since: at } }
    }

    /// Where it walks to, odometry's frame, if it walks.
    #[cfg(test)]
    pub fn goes_to(&self) -> Option<Vector3> {
        if let Now::Walks { follower, .. } = &self.now { follower.path().last().copied() } else { None }
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
                    Some(path) => Now::Walks { follower: follower(path), planned: at, passed: (at, here) },
                    None => Now::Stands { since: at },
                };
            }
            Now::Walks { follower: following, planned, passed } => {
                if at - *planned >= REPLAN_EVERY {
                    *planned = at;
                    match replan(terrain, &here, following.path()) {
                        Some(path) => *following = follower(path),
                        None => {
                            self.now = Now::Stands { since: at };
                            return Step::Go(Velocity::default());
                        }
                    }
                }
                if (here - passed.1).norm() > STUCK.0 {
                    *passed = (at, here);
                }
                let stuck = at - passed.0 > STUCK.1;
                if let Some(velocity) = following.velocity(odom_from_base).filter(|_| !stuck) {
                    return Step::Go(velocity);
                }
                // Not there again.
                self.been.extend(following.path().last().filter(|_| stuck));
                self.now = Now::Stands { since: at };
            }
        }
        Step::Go(Velocity::default())
    }
}

fn follower(path: Vec<Vector3>) -> Follower {
    Follower::new(FollowerConfig { speed: SPEED, ..FollowerConfig::default() }, path)
}

/// The way to the end of a path as it is seen now; none if nobody would go there for it: it is longer than the whole path, and than the way
/// as the crow flies by more than half a metre.
fn replan(terrain: &Terrain, here: &Vector3, path: &[Vector3]) -> Option<Vec<Vector3>> {
    let end = path.last()?;
    let length = |path: &[Vector3]| path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
    let nearly = (end - here).norm() + 0.5;
    plan(terrain, here, end).ok().filter(|now| length(now) <= length(path).max(nearly))
}
