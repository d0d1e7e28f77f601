//! The server's clock, estimated from the answers to pings.

use crate::ClientTime;
use vocab::Stamp;

/// Parameters of [`ServerClock`].
struct ServerClockConfig {
    /// Answers closer together than this give no new estimate of the rate, seconds: the delay of the network would dominate it. Chosen: a delay that varies by 50 ms is a
    /// tenth of it.
    min_rate_interval_s: f64,
    /// Greatest rate that is believed. Chosen: replays and simulations run faster than real time, none a hundred times as fast.
    max_rate: f64,
}

const CONFIG: ServerClockConfig = ServerClockConfig { min_rate_interval_s: 0.5, max_rate: 100.0 };

/// Maps client time to the robot's clock.
///
/// The robot's clock may run at another rate than the client's (simulations, replays), so the rate is measured between answers.
#[derive(Clone, Debug, Default)]
pub struct ServerClock {
    latest: Option<ClockSample>,
    /// Robot seconds per client second.
    rate: f64,
    round_trip_s: f64,
}

/// Two clocks at one instant.
#[derive(Clone, Copy, Debug)]
struct ClockSample {
    client: ClientTime,
    robot: Stamp,
}

impl ServerClock {
    /// The answer to a ping that was sent at `sent` came at `now`; the robot's clock showed `robot` in between.
    pub fn update(&mut self, sent: ClientTime, now: ClientTime, robot: Stamp) {
        self.round_trip_s = now.since(sent);
        let sample = ClockSample { client: now.after(-0.5 * self.round_trip_s), robot };
        match self.latest {
            Some(last) if sample.client.since(last.client) >= CONFIG.min_rate_interval_s => {
                let rate = (sample.robot - last.robot).secs_f64() / sample.client.since(last.client);
                self.rate = rate.clamp(0.0, CONFIG.max_rate);
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
        Some(last.robot + vocab::Span::from_secs_f64((now.0 - last.client.0) * self.rate))
    }

    /// Seconds between the last ping and its answer; `None` before the first answer.
    pub fn round_trip_s(&self) -> Option<f64> {
        self.latest.map(|_| self.round_trip_s)
    }

    /// Age of something made at `stamp`, seconds of the robot's clock, never negative; `None` before the first answer.
    pub fn age_of(&self, stamp: Stamp, now: ClientTime) -> Option<f64> {
        Some((self.stamp_at(now)? - stamp).secs_f64().max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::Span;

    #[test]
    fn the_robots_clock_may_run_slower_than_the_clients() {
        let mut clock = ServerClock::default();
        for second in 0..5 {
            let client = ClientTime(f64::from(second));
            clock.update(client, client, Stamp::EPOCH + Span::from_secs_f64(0.25 * f64::from(second)));
        }
        let later = clock.stamp_at(ClientTime(8.0)).unwrap().secs_f64();
        assert!((later - 2.0).abs() < 1e-6, "{later}");
    }
}
