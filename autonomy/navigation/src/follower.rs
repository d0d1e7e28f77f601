//! Pure pursuit: aims at a point some way along the path.
//!
//! Source: Coulter, *Implementation of the Pure Pursuit Path Tracking Algorithm*, 1992; here for a body that can turn
//! on the spot, so large heading errors are turned off first.

use geometry::{Isometry, Vector3};

/// How to follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FollowerConfig {
    /// Walking speed, m/s.
    pub speed: f64,
    /// Turning speed at most, rad/s.
    pub turn: f64,
    /// Distance along the path to the point aimed at, metres.
    pub look_ahead: f64,
    /// Arrived within this, metres.
    pub tolerance: f64,
}

impl Default for FollowerConfig {
    fn default() -> Self {
        Self { speed: 0.9, turn: 0.9, look_ahead: 0.7, tolerance: 0.15 }
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
pub struct Follower {
    config: FollowerConfig,
    path: Vec<Vector3>,
}

impl Follower {
    /// Follows `path` (map frame, metres).
    pub fn new(config: FollowerConfig, path: Vec<Vector3>) -> Self {
        Self { config, path }
    }

    /// The whole path.
    pub fn path(&self) -> &[Vector3] {
        &self.path
    }

    /// Metres to go from a place near the path.
    pub fn remaining(&self, map_from_base: &Isometry) -> f64 {
        let (segment, along) = self.nearest(&map_from_base.translation.vector);
        self.length_after(segment, along)
    }

    /// Velocity to command now, or `None` on arrival.
    pub fn velocity(&self, map_from_base: &Isometry) -> Option<Velocity> {
        let end = self.path.last()?;
        let here = map_from_base.translation.vector;
        let to_end = (end - here).xy().norm();
        if to_end < self.config.tolerance {
            return None;
        }
        let target = self.point_ahead(&here);
        let forward = map_from_base.rotation * Vector3::x();
        let wanted = (target - here).y.atan2((target - here).x);
        let heading_error = wrap(wanted - forward.y.atan2(forward.x));
        let turn = (2.0 * heading_error).clamp(-self.config.turn, self.config.turn);
        // Turn first when facing away; slow down towards the end so as not to walk past it.
        let facing = (1.0 - heading_error.abs() / 0.8).max(0.0);
        let forward = self.config.speed.min(0.25 + to_end) * facing;
        Some(Velocity { forward, turn })
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
            // Later segments win ties, so that a path over its own beginning is still walked on.
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

    fn point_ahead(&self, here: &Vector3) -> Vector3 {
        let (segment, mut along) = self.nearest(here);
        let mut left = self.config.look_ahead;
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
#[path = "follower_tests.rs"]
mod tests;
