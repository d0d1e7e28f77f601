//! Keeps a simulated or replayed robot's clock in step with this computer's clock.

use std::time::{Duration, Instant};
use vocab::Stamp;

/// Parameters of a [`RealTimePacer`].
#[derive(Clone, Copy, Debug)]
struct RealTimePacerConfig {
    /// A lag up to this is made up for by running faster. A longer one is dropped, so that a suspended laptop does not replay an hour at full speed. Chosen: as long as a
    /// drive command is valid ([`messages::DRIVE_LIFETIME`]).
    max_lag: Duration,
}

const CONFIG: RealTimePacerConfig = RealTimePacerConfig { max_lag: Duration::from_millis(500) };

/// Computes the time until an instant of the robot's clock is due.
#[derive(Debug)]
pub struct RealTimePacer {
    /// Robot seconds per second of this computer.
    speed: f64,
    /// One instant on both clocks.
    origin: Option<(Instant, Stamp)>,
}

impl RealTimePacer {
    /// Runs `speed` times as fast as this computer's clock. A speed that is not positive and finite counts as 1.
    pub fn new(speed: f64) -> Self {
        let speed = if speed.is_finite() && speed > 0.0 { speed } else { 1.0 };
        Self { speed, origin: None }
    }

    /// Makes the next instant due at once.
    pub fn restart(&mut self) {
        self.origin = None;
    }

    /// How long after `now` the instant `at` is due. The first call sets the origin.
    pub fn delay(&mut self, at: Stamp, now: Instant) -> Duration {
        let (wall, robot) = *self.origin.get_or_insert((now, at));
        let since = (at - robot).secs_f64() / self.speed;
        let due = Duration::try_from_secs_f64(since).ok().and_then(|since| wall.checked_add(since));
        match due {
            Some(due) if now <= due + CONFIG.max_lag => due.saturating_duration_since(now),
            // The lag is too long, or the robot's clock stepped.
            _ => {
                self.origin = Some((now, at));
                Duration::ZERO
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: i64) -> Stamp {
        Stamp::EPOCH + vocab::Span::from_millis(millis)
    }

    #[test]
    fn robot_time_runs_at_the_chosen_speed() {
        let (mut pacer, start) = (RealTimePacer::new(4.0), Instant::now());
        assert_eq!(pacer.delay(at(0), start), Duration::ZERO);
        assert_eq!(pacer.delay(at(400), start), Duration::from_millis(100));
        assert_eq!(pacer.delay(at(400), start + Duration::from_millis(60)), Duration::from_millis(40));
    }

    #[test]
    fn a_short_lag_is_made_up_for_and_a_long_one_is_dropped() {
        let (mut pacer, start) = (RealTimePacer::new(1.0), Instant::now());
        pacer.delay(at(0), start);
        let late = start + Duration::from_millis(300);
        assert_eq!(pacer.delay(at(100), late), Duration::ZERO);
        assert_eq!(pacer.delay(at(400), late), Duration::from_millis(100));

        let much_later = start + Duration::from_secs(60);
        assert_eq!(pacer.delay(at(500), much_later), Duration::ZERO);
        assert_eq!(pacer.delay(at(600), much_later), Duration::from_millis(100));
    }
}
