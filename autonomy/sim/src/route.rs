//! Set walks through a site, and the operator who drives the robot along one. The operator has eyes, so it uses the true
//! pose: it serves to make recordings, never to help the autonomy.

use crate::simulator::Truth;
use messages::Drive;
use vocab::{Twist, Vec3};

/// Where and how the robot stands at first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// On or somewhat above the ground, site frame, metres.
    pub position: Vec3,
    /// Radians, counter-clockwise from the site's x axis.
    pub yaw: f64,
}

/// A walk through a site.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// "round" or "short".
    pub name: &'static str,
    /// Where it begins.
    pub start: Start,
    /// Corners of the walk, site frame x and y, metres. Heights follow from the ground.
    pub waypoints: Vec<[f64; 2]>,
    /// Speed on straight stretches, m/s.
    pub speed: f64,
}

/// Standing still at both ends, seconds.
const STAND: f64 = 2.5;
/// A waypoint counts as reached within this distance, metres.
const REACHED: f64 = 0.25;
/// The operator looks this far ahead along the leg, metres.
const LOOKAHEAD: f64 = 0.9;

/// Turns a route into drive commands.
#[derive(Clone, Debug)]
pub struct RouteWalker {
    route: Route,
    /// Walking from `leg - 1` to `leg`.
    leg: usize,
    began: Option<f64>,
    ended: Option<f64>,
}

impl RouteWalker {
    /// At the start of the route.
    pub fn new(route: Route) -> Self {
        Self { route, leg: 0, began: None, ended: None }
    }

    /// Waypoints reached and all there are.
    pub fn progress(&self) -> (usize, usize) {
        (self.leg, self.route.waypoints.len())
    }

    /// What to command now, at 10 Hz or more; `None` once the route is walked and the robot has stood a while.
    pub fn drive(&mut self, truth: &Truth) -> Option<Drive> {
        let now = truth.stamp.secs_f64();
        if now - *self.began.get_or_insert(now) < STAND {
            return Some(Drive::default());
        }
        let place = [truth.site_from_base.position.x, truth.site_from_base.position.y];
        while self.leg < self.route.waypoints.len() && self.passed(place) {
            self.leg += 1;
        }
        if self.leg == self.route.waypoints.len() {
            let ended = *self.ended.get_or_insert(now);
            return (now - ended < STAND).then(Drive::default);
        }
        Some(self.pursue(place, heading(truth)))
    }

    fn corner(&self, leg: usize) -> [f64; 2] {
        let start = [self.route.start.position.x, self.route.start.position.y];
        if leg == 0 { start } else { self.route.waypoints[leg - 1] }
    }

    fn passed(&self, place: [f64; 2]) -> bool {
        let goal = self.route.waypoints[self.leg];
        (goal[0] - place[0]).hypot(goal[1] - place[1]) < REACHED
    }

    fn pursue(&self, place: [f64; 2], yaw: f64) -> Drive {
        let (from, goal) = (self.corner(self.leg), self.route.waypoints[self.leg]);
        let along = [goal[0] - from[0], goal[1] - from[1]];
        let length = along[0].hypot(along[1]).max(1e-6);
        let unit = [along[0] / length, along[1] / length];
        let done = (place[0] - from[0]) * unit[0] + (place[1] - from[1]) * unit[1];
        let carrot = (done + LOOKAHEAD).clamp(0.0, length);
        let aim = [from[0] + unit[0] * carrot - place[0], from[1] + unit[1] * carrot - place[1]];
        let error = wrap(aim[1].atan2(aim[0]) - yaw);
        // Turn on the spot for sharp corners, round off the others, and slow down before the goal.
        let left = (goal[0] - place[0]).hypot(goal[1] - place[1]);
        let ease = (1.0 - error.abs() / 0.9).max(0.0) * ((left + 0.15) / 0.7).min(1.0);
        let turn = (1.8 * error).clamp(-0.9, 0.9);
        let linear = Vec3::new(self.route.speed * ease, 0.0, 0.0);
        Drive { velocity: Twist { linear, angular: Vec3::new(0.0, 0.0, turn) } }
    }
}

fn heading(truth: &Truth) -> f64 {
    let q = truth.site_from_base.orientation;
    (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z))
}

/// To (-π, π].
fn wrap(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}
