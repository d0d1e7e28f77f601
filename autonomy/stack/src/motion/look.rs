//! Looking about: the robot stands, so that what it sees can be recognised, and if it is not, walks a little over ground that it has
//! seen, to where it has not been, and stands again. Where what it sees is recognised in several places, only walking tells them apart:
//! then it walks without standing, on the way that promises to, as far as it can see that way.

use super::walk::{REPLAN_EVERY, Step};
use geometry::{Isometry, Vector3};
use localisation::ExplorationHint;
use navigation::{
    ExplorationConfig, PathFollower, PathFollowerConfig, PlannerConfig, Terrain, Velocity, explore, plan,
};
use std::sync::Arc;
use vocab::{Span, Stamp};

/// It stands so long at first, and later: recognising a place takes half a second.
const STAND_FIRST: Span = Span::from_millis(2_500);
const STAND: Span = Span::from_millis(1_000);
/// Where there is no walk, one is looked for so often.
const TRIES: Span = Span::from_millis(250);
/// Along the way that tells places apart it looks so far ahead, metres, and a piece of it may lead round so much more.
const AHEAD: f64 = 6.0;
const ROUND: f64 = 1.5;
/// A shorter piece of it is none, metres.
const LEAST: f64 = 0.7;
/// With several places to tell apart it sets out anew so far before the end of a walk, metres.
const WALK_ON: f64 = 1.5;
/// Where it has been is noted after so many metres.
const NOTED: f64 = 1.0;
/// A walk on which it gets no farther than so many metres in such a time is over: something that it does not see is in its way.
const STUCK: (f64, Span) = (0.1, Span::from_millis(6_000));
/// Having looked for so long it gives up, until somebody helps.
const PATIENCE: Span = Span::from_millis(150_000);

#[derive(Debug)]
pub(super) struct Look {
    /// Where the robot was going, map frame.
    pub goal: Option<Vector3>,
    /// Where it has looked, odometry's frame.
    been: Vec<Vector3>,
    /// For how long, and when that was last added to.
    looked: (Span, Option<Stamp>),
    has_walked: bool,
    /// A way on which it could not get on.
    barred: Option<Arc<[Vector3]>>,
    now: Now,
}

#[derive(Debug)]
enum Now {
    /// `tried`: when it last looked for a walk.
    Stands { since: Stamp, tried: Option<Stamp> },
    /// `on`: the way that tells places apart, if it is on that; `passed`: where it was, and when, as it last got any farther.
    Walks { on: Option<Arc<[Vector3]>>, follower: PathFollower, planned: Stamp, passed: (Stamp, Vector3) },
}

/// A path, with the way that tells places apart if it is a piece of that.
type Piece = (Option<Arc<[Vector3]>>, Vec<Vector3>);

impl Look {
    pub fn new(at: Stamp, goal: Option<Vector3>) -> Self {
        Self {
            goal,
            been: Vec::new(),
            looked: (Span::from_millis(0), Some(at)),
            has_walked: false,
            barred: None,
            now: Now::Stands { since: at, tried: None },
        }
    }

    /// Where it walks to, odometry's frame, if it walks.
    #[cfg(test)]
    pub fn goes_to(&self) -> Option<Vector3> {
        if let Now::Walks { follower, .. } = &self.now { follower.path().last().copied() } else { None }
    }

    /// Sees nothing.
    pub fn wait(&mut self, at: Stamp) {
        self.now = Now::Stands { since: at, tried: None };
        self.looked.1 = None;
    }

    /// What comes next, going by what is known of where the robot may be.
    pub fn tick(
        &mut self,
        at: Stamp,
        terrain: &Terrain,
        odom_from_base: &Isometry,
        exploration_hint: &ExplorationHint,
    ) -> Step {
        let here = odom_from_base.translation.vector;
        self.note(at, &here);
        if self.looked.0 > PATIENCE {
            return Step::GaveUp(
                "The robot looked about and did not find its place in the map. Set its place on the map, or drive it to where the map is \
                 right.",
            );
        }
        match &mut self.now {
            Now::Stands { since, tried } => {
                let stood = at - *since;
                if tried.is_some_and(|tried| at - tried < TRIES) {
                    return Step::Go(Velocity::default());
                }
                *tried = Some(at);
                if let Some((on, path)) = self.set_out(stood, terrain, &here, exploration_hint) {
                    self.has_walked = true;
                    let follower = to_follow(path);
                    self.now = Now::Walks { on, follower, planned: at, passed: (at, here) };
                }
                Step::Go(Velocity::default())
            }
            Now::Walks { on, follower, planned, passed } => {
                if (here - passed.1).norm() > STUCK.0 {
                    *passed = (at, here);
                }
                if at - passed.0 > STUCK.1 {
                    // Not there again.
                    self.been.extend(follower.path().last());
                    self.barred = on.take().or(self.barred.take());
                    self.now = Now::Stands { since: at, tried: None };
                    return Step::Go(Velocity::default());
                }
                if at - *planned >= REPLAN_EVERY {
                    let (on, passed, old) = (on.take(), *passed, follower.path().to_vec());
                    let ends =
                        exploration_hint.hypotheses > 1 && follower.remaining(odom_from_base) < WALK_ON;
                    let path = self
                        .told(terrain, &here, exploration_hint)
                        .or_else(|| if ends { self.roam(terrain, &here) } else { None })
                        .or_else(|| replan(terrain, &here, &old).map(|path| (on, path)));
                    self.now = match path {
                        Some((on, path)) => Now::Walks { on, follower: to_follow(path), planned: at, passed },
                        None => Now::Stands { since: at, tried: None },
                    };
                }
                self.walk_on(at, odom_from_base)
            }
        }
    }

    /// What is in the walk for now.
    fn walk_on(&mut self, at: Stamp, odom_from_base: &Isometry) -> Step {
        if let Now::Walks { follower, .. } = &self.now {
            if let Some(velocity) = follower.velocity(odom_from_base) {
                return Step::Go(velocity);
            }
            self.now = Now::Stands { since: at, tried: None };
        }
        Step::Go(Velocity::default())
    }

    /// The next walk of a robot that has stood for so long, if there is one. Standing tells no look-alikes apart; but where to walk is thought
    /// out first, and people who stand in that way go on.
    fn set_out(
        &self,
        stood: Span,
        terrain: &Terrain,
        here: &Vector3,
        exploration_hint: &ExplorationHint,
    ) -> Option<Piece> {
        let stands = match exploration_hint {
            ExplorationHint { hypotheses: 2.., path: Some(way) } if way.is_empty() => Span::from_millis(0),
            ExplorationHint { hypotheses: 2.., path: Some(_) } => STAND,
            _ if self.has_walked => STAND,
            _ => STAND_FIRST,
        };
        let roam = || if stood >= stands { self.roam(terrain, here) } else { None };
        self.told(terrain, here, exploration_hint).or_else(roam)
    }

    /// Some way to where it has not been.
    fn roam(&self, terrain: &Terrain, here: &Vector3) -> Option<Piece> {
        explore(&ExplorationConfig::default(), &PlannerConfig::default(), terrain, here, &self.been)
            .map(|path| (None, path))
    }

    /// On along the way that tells places apart.
    fn told(&self, terrain: &Terrain, here: &Vector3, exploration_hint: &ExplorationHint) -> Option<Piece> {
        let way = exploration_hint.path.as_ref().filter(|way| {
            exploration_hint.hypotheses > 1
                && !self.barred.as_ref().is_some_and(|barred| Arc::ptr_eq(barred, way))
        })?;
        along(terrain, here, way).map(|path| (Some(Arc::clone(way)), path))
    }

    /// Where it is, and that time passes.
    fn note(&mut self, at: Stamp, here: &Vector3) {
        let (looked, last) = &mut self.looked;
        *looked = *looked + last.replace(at).map_or(Span::from_millis(0), |last| at - last);
        if self.been.iter().all(|been| (been - here).norm() >= NOTED) {
            self.been.push(*here);
        }
    }
}

fn to_follow(path: Vec<Vector3>) -> PathFollower {
    PathFollower::new(PathFollowerConfig::default(), path)
}

/// A plan on along a way from where it passes by: to its farthest point to which that leads over ground that is seen.
fn along(terrain: &Terrain, here: &Vector3, way: &[Vector3]) -> Option<Vec<Vector3>> {
    let off = |at: &Vector3| (at - here).xy().norm();
    let nearest = (0..way.len()).min_by(|&a, &b| off(&way[a]).total_cmp(&off(&way[b])))?;
    let mut metres = off(&way[nearest]);
    let mut ahead = Vec::new();
    for (number, end) in way.iter().enumerate().skip(nearest) {
        if number > nearest {
            metres += (end - way[number - 1]).xy().norm();
        }
        if metres > AHEAD {
            break;
        }
        if off(end) >= LEAST {
            ahead.push((metres, end));
        }
    }
    let is_seen = |end: &Vector3| terrain.cell(terrain.index(end.x, end.y)).ground().is_some();
    ahead.into_iter().rev().filter(|(_, end)| is_seen(end)).find_map(|(metres, end)| {
        plan(&PlannerConfig::default(), terrain, here, end).ok().filter(|path| length(path) <= metres + ROUND)
    })
}

/// The way to the end of a path as it is seen now; none if nobody would go there for it: it is longer than the whole path, and than the way
/// as the crow flies by more than half a metre.
fn replan(terrain: &Terrain, here: &Vector3, path: &[Vector3]) -> Option<Vec<Vector3>> {
    let end = path.last()?;
    let nearly = (end - here).norm() + 0.5;
    plan(&PlannerConfig::default(), terrain, here, end)
        .ok()
        .filter(|now| length(now) <= length(path).max(nearly))
}

fn length(path: &[Vector3]) -> f64 {
    path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}
