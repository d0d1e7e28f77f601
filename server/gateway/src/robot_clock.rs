//! The robot's clock as the gateway knows it, for clients that want to know how old their data are.

use api::Event;
use std::time::{Duration, Instant};
use vocab::{Span, Stamp};

/// Longest time for which the clock is taken to go on without news: a robot that falls silent has no clock.
const COAST: Duration = Duration::from_secs(2);

/// Last instant heard, and when it was heard.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RobotClock {
    heard: Option<(Stamp, Instant)>,
}

impl RobotClock {
    /// Knows nothing and stays at the epoch.
    pub(crate) fn new() -> Self {
        Self { heard: None }
    }

    /// Learns from an event that tells the time. [`api::Platform::now`] is the clock itself and may set it back (a
    /// recording that starts over); an estimate is some milliseconds old and can only set it forward.
    pub(crate) fn learn(&mut self, event: &Event, now: Instant) {
        match event {
            Event::Platform(platform) => self.heard = Some((platform.now, now)),
            Event::Estimate(estimate) if self.heard.is_none() || estimate.stamp > self.now(now) => {
                self.heard = Some((estimate.stamp, now));
            }
            _ => {}
        }
    }

    /// The robot's clock at `now`.
    pub(crate) fn now(&self, now: Instant) -> Stamp {
        let Some((stamp, heard)) = self.heard else { return Stamp::EPOCH };
        let since = now.saturating_duration_since(heard).min(COAST);
        stamp + Span::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use api::{Estimate, Platform};

    #[test]
    fn follows_the_platform_both_ways_and_estimates_forward_only() {
        let start = Instant::now();
        let estimate =
            |s| Event::Estimate(Estimate { stamp: Stamp::from_parts(s, 0), ..Estimate::default() });
        let platform = |s| Event::Platform(Platform { now: Stamp::from_parts(s, 0), ..Platform::default() });
        let mut clock = RobotClock::new();
        assert_eq!(clock.now(start), Stamp::EPOCH);
        clock.learn(&estimate(100), start);
        assert_eq!(clock.now(start + Duration::from_secs(1)), Stamp::from_parts(101, 0));
        assert_eq!(clock.now(start + Duration::from_secs(60)), Stamp::from_parts(102, 0), "coasts 2 s");
        clock.learn(&estimate(90), start);
        assert_eq!(clock.now(start), Stamp::from_parts(100, 0));
        clock.learn(&platform(50), start);
        assert_eq!(clock.now(start), Stamp::from_parts(50, 0));
    }
}
