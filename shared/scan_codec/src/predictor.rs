//! Predicts each point of a sweep from the points before it, in the same way when encoding and decoding.

use crate::grid::{ANGLE_STEPS, GridPoint};

/// Classes of ranges and of intensities.
pub(crate) const CLASSES: usize = 4;
/// Largest sums of the differences of two neighbours, range steps, of all classes but the last.
const RANGE_CLASS_LIMITS: [u32; CLASSES - 1] = [6, 14, 40];
/// Expected intensities from which the second and the third class begin.
const INTENSITY_CLASS_LIMITS: [i64; 2] = [12, 40];
/// Difference of a range from its expectation that means another surface, steps.
const EDGE_STEPS: u32 = 40;

/// What is known of a channel from its earlier points.
#[derive(Clone, Copy, Default)]
struct ChannelState {
    /// Azimuth after that of the column, steps.
    azimuth_lag: i32,
    elevation: i32,
    /// Time after that of the column, ns.
    time_lag: i64,
    range: u32,
    /// Last difference of the range from its expectation.
    range_difference: u32,
    /// The last three, the newest first.
    intensities: [i64; 3],
}

/// Expectations for the next point, the same when encoding and decoding.
pub(crate) struct Predictor {
    channels: Vec<ChannelState>,
    ring_last: u16,
    /// The point before: its channel, range, range before in the same channel, difference from the expectation, and intensity.
    above: Option<RowAbove>,
    column_azimuth: i32,
    azimuth_step: i32,
    column_time: i64,
    time_step: i64,
}

#[derive(Clone, Copy)]
struct RowAbove {
    ring: u16,
    range: u32,
    range_before: u32,
    range_difference: u32,
    intensity: i64,
}

/// Expectation of a range, with its class.
#[derive(Clone, Copy)]
pub(crate) struct RangeExpectation {
    pub range: u32,
    pub class: usize,
}

impl Predictor {
    pub fn new(ring_last: u16) -> Self {
        Self {
            channels: vec![ChannelState::default(); usize::from(ring_last) + 1],
            ring_last,
            above: None,
            column_azimuth: 0,
            azimuth_step: 0,
            column_time: 0,
            time_step: 0,
        }
    }

    /// The channel after the previous one; the lowest after the highest.
    pub fn expected_ring(&self) -> u16 {
        self.above.filter(|above| above.ring < self.ring_last).map_or(0, |above| above.ring + 1)
    }

    /// Begins a point; a new column if its channel is not above the previous one. Returns whether it is one.
    pub fn begin(&mut self, ring: u16) -> bool {
        let is_new = self.above.is_none_or(|above| ring <= above.ring);
        if is_new {
            self.above = None;
        }
        is_new
    }

    pub fn expected_time(&self, ring: u16, is_new_column: bool) -> i64 {
        let step = if is_new_column { self.time_step } else { 0 };
        self.column_time + step + self.channels[usize::from(ring)].time_lag
    }

    pub fn learn_time(&mut self, ring: u16, is_new_column: bool, time: i64) {
        let channel = &mut self.channels[usize::from(ring)];
        if is_new_column {
            let column = time - channel.time_lag;
            self.time_step = column - self.column_time;
            self.column_time = column;
        } else {
            channel.time_lag = time - self.column_time;
        }
    }

    pub fn expected_azimuth(&self, ring: u16, is_new_column: bool) -> i32 {
        let step = if is_new_column { self.azimuth_step } else { 0 };
        self.column_azimuth + step + self.channels[usize::from(ring)].azimuth_lag
    }

    pub fn learn_azimuth(&mut self, ring: u16, is_new_column: bool, azimuth: i32) {
        let channel = &mut self.channels[usize::from(ring)];
        if is_new_column {
            let column = azimuth - channel.azimuth_lag;
            self.azimuth_step = wrap_angle_steps(column - self.column_azimuth);
            self.column_azimuth = column;
        } else {
            channel.azimuth_lag = wrap_angle_steps(azimuth - self.column_azimuth);
        }
    }

    pub fn expected_elevation(&self, ring: u16) -> i32 {
        self.channels[usize::from(ring)].elevation
    }

    pub fn expected_range(&self, ring: u16) -> RangeExpectation {
        let channel = &self.channels[usize::from(ring)];
        let left = channel.range;
        let (above, above_left, above_difference) = match self.above {
            Some(above) => (above.range, above.range_before, above.range_difference),
            None => (left, left, 0),
        };
        let range = if above_left >= left.max(above) {
            left.min(above)
        } else if above_left <= left.min(above) {
            left.max(above)
        } else {
            left + above - above_left
        };
        let activity = channel.range_difference.saturating_add(above_difference);
        let class = RANGE_CLASS_LIMITS.iter().filter(|limit| activity >= **limit).count();
        RangeExpectation { range, class }
    }

    /// The expected intensity with its class, given how far the range is from its expectation.
    pub fn expected_intensity(&self, ring: u16, range_difference: u32) -> (i64, usize) {
        let [a, b, c] = self.channels[usize::from(ring)].intensities;
        let is_near = |x: i64, y: i64| (x - y).abs() * 5 <= x;
        if range_difference > EDGE_STEPS {
            return (self.above.map_or(a, |above| above.intensity), CLASSES - 1);
        }
        let expected = match (is_near(a, b), is_near(b, c)) {
            (true, true) => (a + b + c) / 3,
            (true, false) => (a + b) / 2,
            _ => a,
        };
        (expected, INTENSITY_CLASS_LIMITS.iter().filter(|limit| expected >= **limit).count())
    }

    /// Ends a point.
    pub fn learn(&mut self, ring: u16, point: GridPoint, expected: RangeExpectation, intensity: i64) {
        let channel = &mut self.channels[usize::from(ring)];
        let range_difference = point.range.abs_diff(expected.range);
        self.above = Some(RowAbove {
            ring,
            range: point.range,
            range_before: channel.range,
            range_difference,
            intensity,
        });
        channel.range = point.range;
        channel.range_difference = range_difference;
        channel.elevation = point.elevation;
        channel.intensities = [intensity, channel.intensities[0], channel.intensities[1]];
    }
}

/// A difference of angles in steps, wrapped to half a turn at most.
pub(crate) fn wrap_angle_steps(steps: i32) -> i32 {
    let half = ANGLE_STEPS / 2;
    (steps + half).rem_euclid(ANGLE_STEPS) - half
}
