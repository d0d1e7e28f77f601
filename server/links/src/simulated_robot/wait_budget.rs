//! How long the simulated robot waits for a core that does not read.

use std::time::Duration;
use vocab::Span;

/// Parameters of a [`WaitBudget`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaitBudgetConfig {
    /// Longest wait at a stretch, of this computer's time. A core that hangs for longer is disconnected. Chosen: less than the 5 s after which the supervisor starts a
    /// core again that hangs.
    pub max_wait: Duration,
    /// Wait that each robot second gives back, in seconds of this computer. A core that lets the robot run more slowly than the inverse of this
    /// is disconnected in the end: 10 means a tenth of real time. Chosen: a busy computer is seldom slower than that.
    pub wait_per_robot_second: f64,
}

impl Default for WaitBudgetConfig {
    fn default() -> Self {
        Self { max_wait: Duration::from_secs(3), wait_per_robot_second: 10.0 }
    }
}

/// The remaining time to wait: a token bucket.
#[derive(Debug)]
pub(super) struct WaitBudget {
    config: WaitBudgetConfig,
    remaining: Duration,
}

impl WaitBudget {
    pub(super) fn new(config: WaitBudgetConfig) -> Self {
        Self { config, remaining: config.max_wait }
    }

    pub(super) fn remaining(&self) -> Duration {
        self.remaining
    }

    pub(super) fn spend(&mut self, waited: Duration) {
        self.remaining = self.remaining.saturating_sub(waited);
    }

    /// Gives time back after `simulated` robot time.
    pub(super) fn refill(&mut self, simulated: Span) {
        let seconds = simulated.secs_f64() * self.config.wait_per_robot_second;
        let more = Duration::try_from_secs_f64(seconds).unwrap_or_default();
        self.remaining = (self.remaining + more).min(self.config.max_wait);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_core_is_waited_for_and_a_hanging_one_is_not() {
        let config = WaitBudgetConfig::default();
        let mut budget = WaitBudget::new(config);
        // A fifth of real time, for a minute.
        for _ in 0..6_000 {
            budget.refill(Span::from_millis(10));
            budget.spend(Duration::from_millis(50));
            assert!(!budget.remaining().is_zero());
        }
        // A twentieth of real time.
        let steps = (0..6_000).take_while(|_| {
            budget.refill(Span::from_millis(10));
            budget.spend(Duration::from_millis(200));
            !budget.remaining().is_zero()
        });
        assert!(steps.count() < 100);
        budget.refill(Span::from_millis(60_000));
        assert_eq!(budget.remaining(), config.max_wait);
    }
}
