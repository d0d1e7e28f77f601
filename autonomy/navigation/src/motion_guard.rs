//! The last check before a robot that walks by itself is given a velocity: it has to be able to stop before it touches anything.
//!
//! The swept footprint of a motion is tested against the obstacles of the elevation map: the arc of the velocity, over the distance in which the robot stops. Source:
//! Fox, Burgard, Thrun, *The Dynamic Window Approach to Collision Avoidance*, 1997, whose admissible velocities these are. The page `docs/maths/navigation.md` has the
//! equations.

use crate::ElevationMap;
use geometry::{Isometry, Vector3};

/// Parameters of [`MotionGuard`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionGuardConfig {
    /// Time from a thing being where it is to the legs acting on it, seconds: a sweep of the LiDAR (0.1 s), a step of control (0.05 s), and as much for the computer.
    /// Sensitivity: 0.1 s more makes the robot slow down 9 cm earlier at 0.9 m/s.
    pub reaction_time_s: f64,
    /// Deceleration that the legs certainly achieve, m/s². The simulated robot achieves 1.4. Sensitivity: the distance to stop is inverse to it, 0.4 m at 0.9 m/s.
    pub deceleration_m_s2: f64,
    /// Room that the robot keeps beside its footprint for each m/s above `creep_speed_m_s`, seconds: what legs, odometry and a person's step add to a motion in this
    /// time. It makes 11 cm at 0.9 m/s. Sensitivity: with 0, the robot passes things within the error of its tracking at full speed; with 0.3, it slows down in doorways.
    pub room_time_s: f64,
    /// At this speed no room beside the footprint is needed, m/s: the robot squeezes through. And at most at this speed a robot that is too near to something may go on, if that
    /// brings it no nearer. Chosen: the robot stops from it within 4 cm, the time to react included.
    pub creep_speed_m_s: f64,
    /// A motion brings the robot no nearer to something if it takes less than this of the room, metres. Far below the noise of the LiDAR; above 0, because a wall is known
    /// as points that are up to a cell apart.
    pub room_tolerance_m: f64,
    /// Distance between the poses that are tested along the arc, metres. Far below the footprint.
    pub sample_m: f64,
    /// Shares of a speed that are tried, the greatest first. At a walking speed of 0.9 m/s the smallest one is 0.1 m/s. Chosen: each is about two thirds to four fifths
    /// of the one before, so that the robot is slower than it has to be by a third at most; each that is tried costs a check of the arc.
    pub speed_shares: [f64; 7],
}

impl Default for MotionGuardConfig {
    fn default() -> Self {
        Self {
            reaction_time_s: 0.2,
            deceleration_m_s2: 1.0,
            room_time_s: 0.15,
            creep_speed_m_s: 0.15,
            room_tolerance_m: 0.002,
            sample_m: 0.04,
            speed_shares: [1.0, 0.8, 0.6, 0.45, 0.3, 0.2, 0.11],
        }
    }
}

/// The obstacles around the robot at one instant, and what they allow.
#[derive(Clone, Debug)]
pub struct MotionGuard {
    config: MotionGuardConfig,
    /// Radius of the footprint, metres.
    radius_m: f64,
    /// Obstacles farther away than this are not known here, metres.
    reach_m: f64,
    /// Their positions, in the frame of the elevation map, metres.
    obstacles: Vec<[f64; 2]>,
}

impl MotionGuard {
    /// With the obstacles around a robot that walks at `max_speed_m_s` at most.
    pub fn new(
        config: MotionGuardConfig,
        elevation_map: &ElevationMap,
        position: &Vector3,
        max_speed_m_s: f64,
    ) -> Self {
        let radius_m = elevation_map.shape().radius_m;
        let room_m = config.room_time_s * max_speed_m_s;
        let reach_m = radius_m + config.stopping_distance_m(max_speed_m_s) + room_m;
        let [low, high] =
            [-reach_m, reach_m].map(|reach| elevation_map.index(position.x + reach, position.y + reach));
        let obstacles = elevation_map.obstacles_between(low, high);
        Self { config, radius_m, reach_m, obstacles }
    }

    /// Room between the footprint and the nearest obstacle when the base is at a point, metres. Negative where they overlap.
    pub fn room_m(&self, [x, y]: [f64; 2]) -> f64 {
        let squared = |obstacle: &[f64; 2]| (obstacle[0] - x).powi(2) + (obstacle[1] - y).powi(2);
        let nearest = self.obstacles.iter().map(squared).fold(self.reach_m.powi(2), f64::min);
        nearest.sqrt() - self.radius_m
    }

    /// Whether the robot can walk straight from one point to another without touching anything. Where it is too near to something at the beginning, it may not come nearer.
    pub fn is_line_free(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        let needed_m = self.room_m(from).min(0.0) - self.config.room_tolerance_m;
        let samples = ((to[0] - from[0]).hypot(to[1] - from[1]) / self.config.sample_m).ceil().max(1.0);
        (1..=samples as usize).all(|sample| {
            let along = |axis: usize| from[axis] + (to[axis] - from[axis]) * sample as f64 / samples;
            self.room_m([along(0), along(1)]) >= needed_m
        })
    }

    /// The greatest share of a velocity (forward and left, m/s, with `turn`, rad/s) with which the robot can stop in time. 0: it must not walk. Turning is free, because
    /// the footprint is the circle in which the robot turns.
    pub fn allowed_share(&self, frame_from_base: &Isometry, linear_m_s: [f64; 2], turn_rad_s: f64) -> f64 {
        let speed_m_s = linear_m_s[0].hypot(linear_m_s[1]);
        if speed_m_s <= 0.0 || self.obstacles.is_empty() {
            return 1.0;
        }
        let ahead = frame_from_base.rotation * Vector3::x();
        let start = frame_from_base.translation.vector;
        let course = ArcMotion {
            start: [start.x, start.y],
            yaw_rad: ahead.y.atan2(ahead.x) + linear_m_s[1].atan2(linear_m_s[0]),
            turn_rad_s,
        };
        let room_m = self.room_m(course.start);
        self.config
            .speed_shares
            .into_iter()
            .find(|share| self.is_admissible(&course, speed_m_s * share, room_m))
            .unwrap_or(0.0)
    }

    /// Whether the robot can stop in time on a course, if it has this room now (docs/maths/navigation.md, equations 3 and 4).
    fn is_admissible(&self, course: &ArcMotion, speed_m_s: f64, room_m: f64) -> bool {
        let MotionGuardConfig { creep_speed_m_s, room_tolerance_m, sample_m, .. } = self.config;
        let needed_m = match speed_m_s <= creep_speed_m_s {
            true => room_m.min(0.0) - room_tolerance_m,
            false => self.config.room_time_s * (speed_m_s - creep_speed_m_s),
        };
        let distance_m = self.config.stopping_distance_m(speed_m_s);
        let samples = (distance_m / sample_m).ceil().max(1.0);
        let step_s = distance_m / speed_m_s / samples;
        let [mut x, mut y] = course.start;
        (0..samples as usize).all(|sample| {
            let yaw_rad = course.yaw_rad + course.turn_rad_s * step_s * (sample as f64 + 0.5);
            x += yaw_rad.cos() * speed_m_s * step_s;
            y += yaw_rad.sin() * speed_m_s * step_s;
            self.room_m([x, y]) >= needed_m
        })
    }
}

impl MotionGuardConfig {
    /// Distance in which a robot of this speed stops, metres (docs/maths/navigation.md, equation 2).
    fn stopping_distance_m(&self, speed_m_s: f64) -> f64 {
        speed_m_s * self.reaction_time_s + speed_m_s.powi(2) / (2.0 * self.deceleration_m_s2)
    }
}

/// A motion along an arc.
struct ArcMotion {
    /// Its beginning, metres.
    start: [f64; 2],
    /// Direction of the velocity there, radians.
    yaw_rad: f64,
    turn_rad_s: f64,
}

#[cfg(test)]
#[path = "motion_guard_tests.rs"]
mod tests;
