//! Inertial readings that wait for their time, and their mean over any stretch of it.

use geometry::Vector3;
use std::collections::VecDeque;
use vocab::{Span, Stamp};

/// One reading in the IMU's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuReading {
    /// When.
    pub stamp: Stamp,
    /// Turn rate, rad/s.
    pub gyro: Vector3,
    /// Specific force (what an accelerometer reads, upwards at rest), m/s².
    pub specific_force: Vector3,
    /// Whether an axis is at the end of its range.
    pub saturated: bool,
}

/// Larger readings than these, repeated to the last bit, are the end of the range: rad/s and m/s².
const GYRO_LARGE: f64 = 2.0;
const ACCEL_LARGE: f64 = 18.0;

/// A hole between readings longer than this is not bridged.
const HOLE: Span = Span::from_millis(60);

/// Readings in ascending order; the front one may lie before the present, to interpolate from.
#[derive(Clone, Debug, Default)]
pub struct ImuQueue {
    readings: VecDeque<ImuReading>,
}

impl ImuQueue {
    /// Appends; says whether the reading was newer than all before.
    pub fn push(&mut self, mut reading: ImuReading) -> bool {
        let newer = self.readings.back().is_none_or(|last| reading.stamp > last.stamp);
        if newer {
            if let Some(last) = self.readings.back_mut() {
                // Noise never repeats to the last bit, a limit does.
                reading.saturated = repeats(&last.gyro, &reading.gyro, GYRO_LARGE)
                    || repeats(&last.specific_force, &reading.specific_force, ACCEL_LARGE);
                last.saturated |= reading.saturated;
            }
            self.readings.push_back(reading);
        }
        newer
    }

    /// Whether the newest reading is at the end of its range.
    pub fn saturated(&self) -> bool {
        self.readings.back().is_some_and(|reading| reading.saturated)
    }

    /// Newest stamp.
    pub fn newest(&self) -> Option<Stamp> {
        self.readings.back().map(|reading| reading.stamp)
    }

    /// Oldest stamp still held.
    pub fn oldest(&self) -> Option<Stamp> {
        self.readings.front().map(|reading| reading.stamp)
    }

    /// First stamp after `time`.
    pub fn next_after(&self, time: Stamp) -> Option<Stamp> {
        self.readings.iter().map(|reading| reading.stamp).find(|&stamp| stamp > time)
    }

    /// All readings held.
    pub fn iter(&self) -> impl Iterator<Item = &ImuReading> + Clone {
        self.readings.iter()
    }

    /// Forgets readings that nothing after `time` needs.
    pub fn discard_before(&mut self, time: Stamp) {
        while self.readings.get(1).is_some_and(|reading| reading.stamp <= time) {
            self.readings.pop_front();
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.readings.clear();
    }

    /// Mean turn rate and specific force between two instants that have no reading strictly between them, by
    /// linear interpolation; after the last reading or before the first that one is held for a short while. `None` in a
    /// hole.
    pub fn mean(&self, from: Stamp, to: Stamp) -> Option<ImuReading> {
        let middle =
            Stamp::from_nanos(from.nanos() / 2 + to.nanos() / 2 + (from.nanos() % 2 + to.nanos() % 2) / 2);
        let after = self.readings.iter().position(|reading| reading.stamp >= to);
        let Some(after) = after else {
            let last = self.readings.back()?;
            return (to - last.stamp <= HOLE).then_some(*last);
        };
        let next = &self.readings[after];
        let Some(previous) = after.checked_sub(1).map(|before| &self.readings[before]) else {
            return (next.stamp - from <= HOLE).then_some(*next);
        };
        if next.stamp - previous.stamp > HOLE {
            return None;
        }
        let share = (middle - previous.stamp).nanos() as f64 / (next.stamp - previous.stamp).nanos() as f64;
        Some(ImuReading {
            stamp: middle,
            gyro: previous.gyro.lerp(&next.gyro, share),
            specific_force: previous.specific_force.lerp(&next.specific_force, share),
            saturated: previous.saturated || next.saturated,
        })
    }
}

/// Whether a large component is the same in both.
fn repeats(a: &Vector3, b: &Vector3, large: f64) -> bool {
    a.iter().zip(b.iter()).any(|(a, b)| a == b && a.abs() > large)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: i64) -> Stamp {
        Stamp::EPOCH + Span::from_millis(millis)
    }

    #[test]
    fn means_are_those_of_the_broken_line_and_holes_have_none() {
        let mut queue = ImuQueue::default();
        for millis in [0, 10, 20, 200] {
            let value = Vector3::repeat(millis as f64);
            assert!(queue.push(ImuReading {
                stamp: at(millis),
                gyro: value,
                specific_force: -value,
                saturated: false
            }));
        }
        assert!(!queue.push(ImuReading { stamp: at(150), ..ImuReading::default() }));
        let gyro = |from, to| queue.mean(at(from), at(to)).map(|mean| mean.gyro.x);
        assert_eq!(gyro(0, 10), Some(5.0));
        assert_eq!(gyro(12, 16), Some(14.0));
        assert_eq!(gyro(30, 200), None);
        assert_eq!(gyro(200, 230), Some(200.0));
        assert_eq!(gyro(250, 300), None);
        assert_eq!(queue.next_after(at(10)), Some(at(20)));
        queue.discard_before(at(15));
        assert_eq!(queue.oldest(), Some(at(10)));
    }

    #[test]
    fn the_end_of_the_range_is_noticed_in_both_readings() {
        let mut queue = ImuQueue::default();
        for (millis, rate) in [(0, 17.3), (10, 17.453), (20, 17.453), (30, 17.2)] {
            queue.push(ImuReading { stamp: at(millis), gyro: Vector3::x() * rate, ..ImuReading::default() });
        }
        assert_eq!(queue.iter().map(|r| r.saturated).collect::<Vec<_>>(), [false, true, true, false]);
    }
}
