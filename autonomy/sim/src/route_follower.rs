//! An operator who drives the robot along a route. The operator sees the robot, so the true pose is used. Only for recordings and tests, never
//! for the autonomy.

use crate::ground_truth::GroundTruth;
use crate::route::SiteRoute;
use messages::Drive;
use vocab::{Twist, Vec3};

/// Time that the robot stands still at both ends of the route, seconds.
const STANDSTILL_S: f64 = 2.5;
/// Distance to a waypoint at which it counts as reached, metres.
const ARRIVAL_DISTANCE_M: f64 = 0.25;
/// Distance along the leg from the robot to the point that it steers to, metres.
const LOOKAHEAD_M: f64 = 0.9;
/// Turning rate per radian of heading error, 1/s.
const TURN_GAIN_PER_S: f64 = 1.8;
/// Greatest turning rate, rad/s.
const MAX_TURN_RATE_RAD_S: f64 = 0.9;
/// Heading error from which on the robot turns in place, radians.
const TURN_IN_PLACE_RAD: f64 = 0.9;
/// Within this distance of a waypoint the robot slows down, metres.
const SLOWDOWN_DISTANCE_M: f64 = 0.7;
/// Added to the distance left, so that the robot does not creep towards the waypoint, metres.
const SLOWDOWN_MARGIN_M: f64 = 0.15;

/// Turns a route into drive commands by pure pursuit: it steers to a point of the present leg that is some distance ahead.
#[derive(Clone, Debug)]
pub struct RouteFollower {
    route: SiteRoute,
    /// Index of the waypoint that the robot walks to.
    leg: usize,
    started_s: Option<f64>,
    arrived_s: Option<f64>,
}

impl RouteFollower {
    /// A follower at the start of the route.
    pub fn new(route: SiteRoute) -> Self {
        Self { route, leg: 0, started_s: None, arrived_s: None }
    }

    /// Number of waypoints reached, and the number of all waypoints.
    pub fn progress(&self) -> (usize, usize) {
        (self.leg, self.route.waypoints.len())
    }

    /// The drive command for the present pose. To be called at 10 Hz or more; `None` at the end of the route.
    pub fn drive(&mut self, truth: &GroundTruth) -> Option<Drive> {
        let now = truth.stamp.secs_f64();
        if now - *self.started_s.get_or_insert(now) < STANDSTILL_S {
            return Some(Drive::default());
        }
        let place = [truth.site_from_base.position.x, truth.site_from_base.position.y];
        while self.leg < self.route.waypoints.len() && self.is_reached(place) {
            self.leg += 1;
        }
        if self.leg == self.route.waypoints.len() {
            let arrived_s = *self.arrived_s.get_or_insert(now);
            return (now - arrived_s < STANDSTILL_S).then(Drive::default);
        }
        Some(self.pursue(place, heading(truth)))
    }

    fn corner(&self, leg: usize) -> [f64; 2] {
        let start = [self.route.start.position.x, self.route.start.position.y];
        if leg == 0 { start } else { self.route.waypoints[leg - 1] }
    }

    fn is_reached(&self, place: [f64; 2]) -> bool {
        let goal = self.route.waypoints[self.leg];
        (goal[0] - place[0]).hypot(goal[1] - place[1]) < ARRIVAL_DISTANCE_M
    }

    fn pursue(&self, place: [f64; 2], yaw: f64) -> Drive {
        let (from, goal) = (self.corner(self.leg), self.route.waypoints[self.leg]);
        let leg = [goal[0] - from[0], goal[1] - from[1]];
        let length = leg[0].hypot(leg[1]).max(1e-6);
        let unit = [leg[0] / length, leg[1] / length];
        let walked = (place[0] - from[0]) * unit[0] + (place[1] - from[1]) * unit[1];
        let carrot = (walked + LOOKAHEAD_M).clamp(0.0, length);
        let aim = [from[0] + unit[0] * carrot - place[0], from[1] + unit[1] * carrot - place[1]];
        let error = wrap_angle(aim[1].atan2(aim[0]) - yaw);
        // Turn in place at sharp corners, round off the others, and slow down before the waypoint.
        let distance_left = (goal[0] - place[0]).hypot(goal[1] - place[1]);
        let speed_share = (1.0 - error.abs() / TURN_IN_PLACE_RAD).max(0.0)
            * ((distance_left + SLOWDOWN_MARGIN_M) / SLOWDOWN_DISTANCE_M).min(1.0);
        let turn = (TURN_GAIN_PER_S * error).clamp(-MAX_TURN_RATE_RAD_S, MAX_TURN_RATE_RAD_S);
        let linear = Vec3::new(self.route.speed * speed_share, 0.0, 0.0);
        Drive { velocity: Twist { linear, angular: Vec3::new(0.0, 0.0, turn) } }
    }
}

fn heading(truth: &GroundTruth) -> f64 {
    let q = truth.site_from_base.orientation;
    (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z))
}

/// The angle between -π and π.
fn wrap_angle(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}
