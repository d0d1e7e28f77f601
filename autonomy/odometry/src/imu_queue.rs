//! Inertial readings that wait to be processed, and their mean over an interval.

use geometry::Vector3;
use std::collections::VecDeque;
use vocab::{Span, Stamp};

/// One reading, IMU frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuReading {
    /// When it was measured.
    pub stamp: Stamp,
    /// Turn rate, rad/s.
    pub gyro: Vector3,
    /// Specific force, m/s²: what an accelerometer reads, pointing up at rest.
    pub specific_force: Vector3,
    /// Whether an axis is at the end of its range.
    pub is_saturated: bool,
}

/// Parameters of an [`ImuQueue`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuQueueConfig {
    /// A turn rate above this that repeats to the last bit is the end of the range, rad/s. Chosen: the smallest range of gyroscopes in use is 125 degrees a second, 2.2
    /// rad/s.
    pub min_saturated_gyro_rad_s: f64,
    /// A specific force above this that repeats to the last bit is the end of the range, m/s². Chosen: the smallest range in use is 2 g, 19.6 m/s².
    pub min_saturated_accel_m_s2: f64,
    /// Gaps between readings longer than this are not interpolated. Chosen: six readings at 100 Hz, a tenth of a step of a walk.
    pub max_gap: Span,
}

impl Default for ImuQueueConfig {
    fn default() -> Self {
        Self { min_saturated_gyro_rad_s: 2.0, min_saturated_accel_m_s2: 18.0, max_gap: Span::from_millis(60) }
    }
}

/// Readings in ascending order. The first one may lie before the present, to interpolate from it.
#[derive(Clone, Debug)]
pub struct ImuQueue {
    config: ImuQueueConfig,
    readings: VecDeque<ImuReading>,
}

impl ImuQueue {
    /// An empty queue.
    pub fn new(config: ImuQueueConfig) -> Self {
        Self { config, readings: VecDeque::new() }
    }

    /// Appends a reading. Returns whether it was newer than all before; an older one is dropped.
    pub fn push(&mut self, mut reading: ImuReading) -> bool {
        let is_newer = self.readings.back().is_none_or(|last| reading.stamp > last.stamp);
        if is_newer {
            if let Some(last) = self.readings.back_mut() {
                // Noise never repeats to the last bit, the end of a range does.
                reading.is_saturated =
                    repeats_above(&last.gyro, &reading.gyro, self.config.min_saturated_gyro_rad_s)
                        || repeats_above(
                            &last.specific_force,
                            &reading.specific_force,
                            self.config.min_saturated_accel_m_s2,
                        );
                last.is_saturated |= reading.is_saturated;
            }
            self.readings.push_back(reading);
        }
        is_newer
    }

    /// Whether the newest reading is at the end of its range.
    pub fn is_saturated(&self) -> bool {
        self.readings.back().is_some_and(|reading| reading.is_saturated)
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

    /// Drops the readings that nothing after `time` needs.
    pub fn discard_before(&mut self, time: Stamp) {
        while self.readings.get(1).is_some_and(|reading| reading.stamp <= time) {
            self.readings.pop_front();
        }
    }

    /// Drops all readings.
    pub fn clear(&mut self) {
        self.readings.clear();
    }

    /// Mean reading between two instants that have no reading strictly between them, by linear interpolation. After the last and
    /// before the first reading, that reading is held for up to the greatest gap. `None` inside a longer gap.
    pub fn mean_between(&self, from: Stamp, to: Stamp) -> Option<ImuReading> {
        let middle =
            Stamp::from_nanos(from.nanos() / 2 + to.nanos() / 2 + (from.nanos() % 2 + to.nanos() % 2) / 2);
        let after = self.readings.iter().position(|reading| reading.stamp >= to);
        let Some(after) = after else {
            let last = self.readings.back()?;
            return (to - last.stamp <= self.config.max_gap).then_some(*last);
        };
        let next = &self.readings[after];
        let Some(previous) = after.checked_sub(1).map(|before| &self.readings[before]) else {
            return (next.stamp - from <= self.config.max_gap).then_some(*next);
        };
        if next.stamp - previous.stamp > self.config.max_gap {
            return None;
        }
        let share = (middle - previous.stamp).nanos() as f64 / (next.stamp - previous.stamp).nanos() as f64;
        Some(ImuReading {
            stamp: middle,
            gyro: previous.gyro.lerp(&next.gyro, share),
            specific_force: previous.specific_force.lerp(&next.specific_force, share),
            is_saturated: previous.is_saturated || next.is_saturated,
        })
    }
}

/// Whether a component above a limit is the same in both.
fn repeats_above(a: &Vector3, b: &Vector3, limit: f64) -> bool {
    a.iter().zip(b.iter()).any(|(a, b)| a == b && a.abs() > limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: i64) -> Stamp {
        Stamp::EPOCH + Span::from_millis(millis)
    }

    #[test]
    fn means_are_interpolated_and_gaps_have_none() {
        let mut queue = ImuQueue::new(ImuQueueConfig::default());
        for millis in [0, 10, 20, 200] {
            let value = Vector3::repeat(millis as f64);
            assert!(queue.push(ImuReading {
                stamp: at(millis),
                gyro: value,
                specific_force: -value,
                is_saturated: false
            }));
        }
        assert!(!queue.push(ImuReading { stamp: at(150), ..ImuReading::default() }));
        let gyro = |from, to| queue.mean_between(at(from), at(to)).map(|mean| mean.gyro.x);
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
    fn saturation_is_detected_in_both_readings() {
        let mut queue = ImuQueue::new(ImuQueueConfig::default());
        for (millis, rate) in [(0, 17.3), (10, 17.453), (20, 17.453), (30, 17.2)] {
            queue.push(ImuReading { stamp: at(millis), gyro: Vector3::x() * rate, ..ImuReading::default() });
        }
        assert_eq!(queue.iter().map(|r| r.is_saturated).collect::<Vec<_>>(), [false, true, true, false]);
    }
}
