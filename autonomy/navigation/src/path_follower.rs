//! Pure pursuit: the robot steers towards a point ahead of it on the path.
//!
//! Source: Coulter, *Implementation of the Pure Pursuit Path Tracking Algorithm*, 1992. This robot can turn in place, so it corrects a large
//! heading error before it walks. Looking far ahead cuts corners. So several distances are tried, and the one with which the [`MotionGuard`] lets the robot walk fastest is
//! taken.

use crate::MotionGuard;
use geometry::{Isometry, Vector3};

/// Parameters of [`PathFollower`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathFollowerConfig {
    /// Walking speed, m/s. It is that of the robot's profile.
    pub max_speed_m_s: f64,
    /// Highest turning speed, rad/s. It is that of the robot's profile.
    pub max_turn_rad_s: f64,
    /// Turning speed for each radian of heading error, 1/s. Chosen: errors fall by a factor of e in 0.5 s, more than twice the delay of scan and legs. More makes the
    /// robot swing.
    pub turn_gain_per_s: f64,
    /// Least heading error at which the robot turns in place, radians. Chosen: 46 degrees; the speed falls in proportion to the error up to it. With more the robot
    /// swings out in corners, with less it stops there.
    pub turn_in_place_rad: f64,
    /// Greatest distance along the path to the point steered towards, metres. Sensitivity: with 0.4 m the robot swings round its path, with 1.2 m it seldom can take the
    /// greatest one.
    pub look_ahead_m: f64,
    /// Shares of that distance that are tried, the greatest first. With the last one, 0.2 m, the robot turns at a corner of the path and then walks along its next part.
    /// Chosen: two smaller ones; each that is tried costs a check of the motion.
    pub look_ahead_shares: [f64; 3],
    /// A shorter distance is taken only if the robot may walk faster with it by this factor, so that it does not swing between two of them. Chosen: a fifth, more than
    /// the speed varies from one step of control to the next.
    pub min_look_ahead_gain: f64,
    /// Speed at the end of the path, m/s. Each metre before the end adds 1 m/s, so that the robot does not overshoot. Chosen: at the deceleration of
    /// [`crate::MotionGuardConfig`] the robot stops from it within 3 cm.
    pub end_speed_m_s: f64,
    /// Distance to the end at which the robot has arrived, metres. Chosen: the last steps into a pose begin there.
    pub goal_tolerance_m: f64,
}

impl PathFollowerConfig {
    /// For a robot with these speed limits, m/s and rad/s. The other values suit robots that turn in place.
    pub fn new(max_speed_m_s: f64, max_turn_rad_s: f64) -> Self {
        Self {
            max_speed_m_s,
            max_turn_rad_s,
            turn_gain_per_s: 2.0,
            turn_in_place_rad: 0.8,
            look_ahead_m: 0.7,
            look_ahead_shares: [1.0, 0.6, 0.3],
            min_look_ahead_gain: 1.2,
            end_speed_m_s: 0.25,
            goal_tolerance_m: 0.15,
        }
    }
}

/// Wanted velocity of the base in its own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity {
    /// m/s.
    pub forward: f64,
    /// rad/s, left positive.
    pub turn: f64,
}

/// A path being followed.
#[derive(Clone, Debug)]
pub struct PathFollower {
    config: PathFollowerConfig,
    path: Vec<Vector3>,
}

impl PathFollower {
    /// Follows `path` (map frame, metres).
    pub fn new(config: PathFollowerConfig, path: Vec<Vector3>) -> Self {
        Self { config, path }
    }

    /// The whole path.
    pub fn path(&self) -> &[Vector3] {
        &self.path
    }

    /// Distance along the path from a point near the path to its end, metres.
    pub fn remaining(&self, map_from_base: &Isometry) -> f64 {
        let (segment, along) = self.nearest(&map_from_base.translation.vector);
        self.length_after(segment, along)
    }

    /// Velocity to command now, with which the robot can stop before it touches anything; `None` on arrival.
    pub fn velocity(&self, map_from_base: &Isometry, guard: &MotionGuard) -> Option<Velocity> {
        let end = self.path.last()?;
        let here = map_from_base.translation.vector;
        let to_end = (end - here).xy().norm();
        if to_end < self.config.goal_tolerance_m {
            return None;
        }
        let mut best: Option<Velocity> = None;
        let shortest = self.config.look_ahead_shares.last().copied();
        for share in self.config.look_ahead_shares {
            let target = self.point_ahead(&here, share * self.config.look_ahead_m);
            let wanted = self.pursue(map_from_base, &target, to_end);
            // The shortest one is taken even so: the robot goes as near as the guard lets it, to a goal beside something for example.
            let is_free =
                Some(share) == shortest || guard.is_line_free([here.x, here.y], [target.x, target.y]);
            let allowed = match is_free {
                true => guard.allowed_share(map_from_base, [wanted.forward, 0.0], wanted.turn),
                false => 0.0,
            };
            let velocity = Velocity { forward: allowed * wanted.forward, ..wanted };
            // Where no distance lets the robot walk, it turns along the next piece of the path.
            let is_better = |best: Velocity| {
                best.forward <= 0.0 || velocity.forward > self.config.min_look_ahead_gain * best.forward
            };
            if best.is_none_or(is_better) {
                best = Some(velocity);
            }
            if allowed >= 1.0 {
                break;
            }
        }
        best
    }

    /// Velocity towards a point ahead on the path.
    fn pursue(&self, map_from_base: &Isometry, target: &Vector3, to_end: f64) -> Velocity {
        let here = map_from_base.translation.vector;
        let forward = map_from_base.rotation * Vector3::x();
        let wanted = (target - here).y.atan2((target - here).x);
        let heading_error = wrap(wanted - forward.y.atan2(forward.x));
        let turn = (self.config.turn_gain_per_s * heading_error)
            .clamp(-self.config.max_turn_rad_s, self.config.max_turn_rad_s);
        let facing = (1.0 - heading_error.abs() / self.config.turn_in_place_rad).max(0.0);
        let forward = self.config.max_speed_m_s.min(self.config.end_speed_m_s + to_end) * facing;
        Velocity { forward, turn }
    }

    fn nearest(&self, here: &Vector3) -> (usize, f64) {
        let mut best = (0, 0.0, f64::INFINITY);
        for (index, pair) in self.path.windows(2).enumerate() {
            let (a, b) = (pair[0].xy(), pair[1].xy());
            let length_squared = (b - a).norm_squared();
            let along = if length_squared > 0.0 {
                ((here.xy() - a).dot(&(b - a)) / length_squared).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let distance = (a + (b - a) * along - here.xy()).norm();
            // Later segments win ties, so that the robot goes on where a path crosses its own beginning.
            if distance <= best.2 {
                best = (index, along, distance);
            }
        }
        (best.0, best.1)
    }

    fn length_after(&self, segment: usize, along: f64) -> f64 {
        self.path
            .windows(2)
            .enumerate()
            .skip(segment)
            .map(|(index, pair)| {
                let length = (pair[1] - pair[0]).xy().norm();
                if index == segment { length * (1.0 - along) } else { length }
            })
            .sum()
    }

    fn point_ahead(&self, here: &Vector3, look_ahead_m: f64) -> Vector3 {
        let (segment, mut along) = self.nearest(here);
        let mut left = look_ahead_m;
        for pair in self.path.windows(2).skip(segment) {
            let length = (pair[1] - pair[0]).xy().norm();
            let rest = length * (1.0 - along);
            if rest >= left && length > 0.0 {
                return pair[0] + (pair[1] - pair[0]) * (along + left / length);
            }
            left -= rest;
            along = 0.0;
        }
        self.path.last().copied().unwrap_or(*here)
    }
}

/// An angle in (-π, π].
fn wrap(angle: f64) -> f64 {
    let turned = angle.rem_euclid(std::f64::consts::TAU);
    if turned > std::f64::consts::PI { turned - std::f64::consts::TAU } else { turned }
}

#[cfg(test)]
#[path = "path_follower_tests.rs"]
mod tests;
