//! Distance walked, without counting the swaying of a robot that stands.

use geometry::Vector3;

/// Parameters of [`Odometer`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometerConfig {
    /// Distance from the last counted position at which a move is counted, metres. Swaying legs and noise amount to a few millimetres. Chosen: ten times that, and far
    /// below a keyframe's distance.
    pub min_move_m: f64,
}

impl Default for OdometerConfig {
    fn default() -> Self {
        Self { min_move_m: 0.05 }
    }
}

/// Sums the length of a walk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Odometer {
    config: OdometerConfig,
    last_counted: Option<Vector3>,
    distance_m: f64,
}

impl Odometer {
    /// Takes the position of the body in any fixed frame, metres. A move is counted once it exceeds the configured distance.
    pub fn move_to(&mut self, position: &Vector3) {
        let from = *self.last_counted.get_or_insert(*position);
        let moved = (position - from).norm();
        if moved >= self.config.min_move_m {
            self.last_counted = Some(*position);
            self.distance_m += moved;
        }
    }

    /// Distance so far, metres.
    pub fn distance(&self) -> f64 {
        self.distance_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swaying_is_not_counted() {
        let mut odometer = Odometer::default();
        for step in 0..1000 {
            odometer.move_to(&Vector3::new(0.01 * f64::from(step % 3), 0.0, 0.0));
        }
        assert_eq!(odometer.distance(), 0.0);
        for step in 0..=100 {
            odometer.move_to(&Vector3::new(0.03 * f64::from(step), 0.0, 0.0));
        }
        assert!((odometer.distance() - 3.0).abs() < 0.06, "{}", odometer.distance());
    }
}
