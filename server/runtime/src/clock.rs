//! The robot's clock as the control loop last read it, for those who only want to know.

use std::sync::atomic::{AtomicI64, Ordering};
use vocab::Stamp;

/// Robot's clock, shared.
#[derive(Debug, Default)]
pub struct RobotClock(AtomicI64);

impl RobotClock {
    /// Sets it; only the control loop does.
    pub fn set(&self, now: Stamp) {
        self.0.store(now.nanos(), Ordering::Relaxed);
    }

    /// The instant of the last input.
    pub fn now(&self) -> Stamp {
        Stamp::from_nanos(self.0.load(Ordering::Relaxed))
    }
}
