//! Recent poses of the body at the rate of the IMU. They give the pose at which each point of a sweep was measured.

use geometry::{Isometry, se3};
use std::collections::VecDeque;
use vocab::{Span, Stamp};

/// Stamped poses in ascending order.
#[derive(Clone, Debug, Default)]
pub struct PoseTable {
    entries: VecDeque<(Stamp, Isometry)>,
}

impl PoseTable {
    /// Removes all poses and starts with one.
    pub fn restart(&mut self, stamp: Stamp, odom_from_body: Isometry) {
        self.entries.clear();
        self.entries.push_back((stamp, odom_from_body));
    }

    /// Appends a pose. A pose at the newest stamp replaces the newest one; an older one is ignored.
    pub fn push(&mut self, stamp: Stamp, odom_from_body: Isometry) {
        match self.entries.back_mut() {
            Some(last) if last.0 == stamp => last.1 = odom_from_body,
            Some(last) if last.0 > stamp => {}
            _ => self.entries.push_back((stamp, odom_from_body)),
        }
    }

    /// Removes the poses older than a stamp, except the last of them, from which later poses are interpolated.
    pub fn discard_before(&mut self, stamp: Stamp) {
        while self.entries.get(1).is_some_and(|entry| entry.0 <= stamp) {
            self.entries.pop_front();
        }
    }

    /// Removes the poses between two stamps, borders excluded, so that the motion there becomes uniform.
    pub fn make_uniform(&mut self, from: Stamp, to: Stamp) {
        self.entries.retain(|entry| entry.0 <= from || entry.0 >= to);
    }

    /// Multiplies every pose from the left by a correction in the odom frame.
    pub fn apply_correction(&mut self, odom_from_odom: &Isometry) {
        for entry in &mut self.entries {
            entry.1 = odom_from_odom * entry.1;
        }
    }

    /// Replaces the newest pose.
    pub fn set_last(&mut self, odom_from_body: Isometry) {
        if let Some(last) = self.entries.back_mut() {
            last.1 = odom_from_body;
        }
    }

    /// Pose at a stamp, interpolated. Outside the table it is the nearest entry. `None` for an empty table.
    pub fn at(&self, stamp: Stamp) -> Option<Isometry> {
        let mut cursor = 0;
        self.at_from(stamp, &mut cursor)
    }

    /// As [`Self::at`], with a search that starts where the last call with this cursor ended. For ascending stamps.
    pub fn at_from(&self, stamp: Stamp, cursor: &mut usize) -> Option<Isometry> {
        while self.entries.get(*cursor + 1).is_some_and(|entry| entry.0 <= stamp) {
            *cursor += 1;
        }
        let before = self.entries.get(*cursor)?;
        let Some(after) = self.entries.get(*cursor + 1).filter(|_| stamp > before.0) else {
            return Some(before.1);
        };
        Some(se3::interpolate(&before.1, &after.1, fraction(stamp - before.0, after.0 - before.0)))
    }
}

fn fraction(part: Span, whole: Span) -> f64 {
    part.nanos() as f64 / whole.nanos().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector3;

    fn pose(x: f64) -> Isometry {
        Isometry::new(Vector3::new(x, 0.0, 0.0), Vector3::new(0.0, 0.0, x))
    }

    #[test]
    fn poses_are_interpolated_between_entries_and_held_outside() {
        let mut table = PoseTable::default();
        assert_eq!(table.at(Stamp::EPOCH), None);
        for i in 0..10_i64 {
            table.push(Stamp::from_nanos(i * 100), pose(i as f64 * 0.1));
        }
        let x = |nanos| table.at(Stamp::from_nanos(nanos)).map(|p| p.translation.x);
        for (nanos, expected) in [(-50, 0.0), (0, 0.0), (250, 0.25), (900, 0.9), (2_000, 0.9)] {
            assert!(x(nanos).is_some_and(|x| (x - expected).abs() < 1e-12), "{nanos}");
        }
        let mut trimmed = table.clone();
        trimmed.discard_before(Stamp::from_nanos(250));
        assert_eq!(trimmed.at(Stamp::from_nanos(250)), table.at(Stamp::from_nanos(250)));
        trimmed.make_uniform(Stamp::from_nanos(200), Stamp::from_nanos(900));
        assert!(trimmed.at(Stamp::from_nanos(550)).is_some_and(|p| (p.translation.x - 0.55).abs() < 1e-12));
    }
}
