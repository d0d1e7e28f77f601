//! Metres walked, without counting the trembling of a robot that stands.

use geometry::Vector3;

/// Moves shorter than this are summed up first: breathing legs and noise come to a few millimetres.
const LEAST_MOVE: f64 = 0.05;

/// Sums the length of a walk.
#[derive(Clone, Copy, Debug, Default)]
pub struct Odometer {
    counted_to: Option<Vector3>,
    distance: f64,
}

impl Odometer {
    /// The body is here now, metres in any fixed frame. Counts once it has gone 5 cm from where it was counted to.
    pub fn move_to(&mut self, position: &Vector3) {
        let from = *self.counted_to.get_or_insert(*position);
        let moved = (position - from).norm();
        if moved >= LEAST_MOVE {
            self.counted_to = Some(*position);
            self.distance += moved;
        }
    }

    /// Metres so far.
    pub fn distance(&self) -> f64 {
        self.distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trembling_is_no_walk() {
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
