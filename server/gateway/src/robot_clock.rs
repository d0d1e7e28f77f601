//! The robot's clock as the gateway estimates it. Clients compute the age of their data from it.

use crate::limits::FIXED;
use api::Event;
use std::time::Instant;
use vocab::{Span, Stamp};

/// Last stamp received, and when it was received.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RobotClockEstimate {
    last: Option<(Stamp, Instant)>,
}

impl RobotClockEstimate {
    /// Stays at the epoch until the first stamp.
    pub(crate) fn new() -> Self {
        Self { last: None }
    }

    /// Updates the clock by an event with a stamp. [`api::Platform::now`] is the clock itself and may set it back, as when a recording starts again.
    /// An estimate is some milliseconds old and can only set it forward.
    pub(crate) fn update(&mut self, event: &Event, now: Instant) {
        match event {
            Event::Platform(platform) => self.last = Some((platform.now, now)),
            Event::Estimate(estimate) if self.last.is_none() || estimate.stamp > self.now(now) => {
                self.last = Some((estimate.stamp, now));
            }
            _ => {}
        }
    }

    /// The robot's clock at `now`.
    pub(crate) fn now(&self, now: Instant) -> Stamp {
        let Some((stamp, received)) = self.last else { return Stamp::EPOCH };
        let since = now.saturating_duration_since(received).min(FIXED.max_clock_extrapolation);
        stamp + Span::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use api::{Estimate, Platform};
    use std::time::Duration;

    #[test]
    fn follows_the_platform_in_both_directions_and_estimates_forward_only() {
        let start = Instant::now();
        let estimate =
            |s| Event::Estimate(Estimate { stamp: Stamp::from_parts(s, 0), ..Estimate::default() });
        let platform = |s| Event::Platform(Platform { now: Stamp::from_parts(s, 0), ..Platform::default() });
        let mut clock = RobotClockEstimate::new();
        assert_eq!(clock.now(start), Stamp::EPOCH);
        clock.update(&estimate(100), start);
        assert_eq!(clock.now(start + Duration::from_secs(1)), Stamp::from_parts(101, 0));
        assert_eq!(
            clock.now(start + Duration::from_secs(60)),
            Stamp::from_parts(102, 0),
            "extrapolated for 2 s"
        );
        clock.update(&estimate(90), start);
        assert_eq!(clock.now(start), Stamp::from_parts(100, 0));
        clock.update(&platform(50), start);
        assert_eq!(clock.now(start), Stamp::from_parts(50, 0));
    }
}
