//! Client time, the robot's clock as seen from here, and how old values are.

use vocab::Stamp;

/// Seconds since the page was opened, monotonic.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct ClientTime(pub f64);

impl ClientTime {
    /// Seconds from `earlier` to here; never negative.
    pub fn since(self, earlier: Self) -> f64 {
        (self.0 - earlier.0).max(0.0)
    }

    /// This many seconds later.
    pub fn after(self, seconds: f64) -> Self {
        Self(self.0 + seconds)
    }
}

/// A value and when it arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct Aged<T> {
    /// The value.
    pub value: T,
    /// When it arrived here.
    pub arrived: ClientTime,
}

impl<T> Aged<T> {
    /// Seconds since it arrived.
    pub fn age(&self, now: ClientTime) -> f64 {
        now.since(self.arrived)
    }
}

/// What the robot's clock shows, from the answers to pings.
///
/// The robot's clock may run at another rate than ours (simulations, replays), so the rate is measured between answers.
#[derive(Clone, Debug, Default)]
pub struct ServerClock {
    latest: Option<Sample>,
    /// Robot seconds per second of ours.
    rate: f64,
    round_trip: f64,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    here: ClientTime,
    there: Stamp,
}

/// Answers closer together than this say little about the rate.
const RATE_BASE_S: f64 = 0.5;

impl ServerClock {
    /// Takes the answer to a ping that was sent at `sent` and came back at `now` with the robot's clock `there`.
    pub fn learn(&mut self, sent: ClientTime, now: ClientTime, there: Stamp) {
        self.round_trip = now.since(sent);
        let sample = Sample { here: now.after(-0.5 * self.round_trip), there };
        match self.latest {
            Some(last) if sample.here.since(last.here) >= RATE_BASE_S => {
                let rate = (sample.there - last.there).secs_f64() / sample.here.since(last.here);
                self.rate = rate.clamp(0.0, 100.0);
                self.latest = Some(sample);
            }
            Some(_) => {}
            None => {
                self.rate = 1.0;
                self.latest = Some(sample);
            }
        }
    }

    /// Forgets everything: the next connection may be to another robot, or to one whose clock was set.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// The robot's clock at `now`; `None` before the first answer.
    pub fn stamp_at(&self, now: ClientTime) -> Option<Stamp> {
        let last = self.latest?;
        Some(last.there + vocab::Span::from_secs_f64((now.0 - last.here.0) * self.rate))
    }

    /// Seconds from a ping to its answer, the last one's.
    pub fn round_trip_s(&self) -> Option<f64> {
        self.latest.map(|_| self.round_trip)
    }

    /// How old something made at `stamp` on the robot's clock is, seconds of the robot's clock; never negative.
    pub fn age_of(&self, stamp: Stamp, now: ClientTime) -> Option<f64> {
        Some((self.stamp_at(now)? - stamp).secs_f64().max(0.0))
    }
}
