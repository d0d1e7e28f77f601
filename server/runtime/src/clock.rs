//! The robot's clock as the control loop last read it, for the other threads.

use std::sync::atomic::{AtomicI64, Ordering};
use vocab::Stamp;

/// The stamp of the last input, shared by all threads.
#[derive(Debug, Default)]
pub struct RobotClock(AtomicI64);

impl RobotClock {
    /// Sets the clock. Only the control loop calls this.
    pub fn set(&self, now: Stamp) {
        self.0.store(now.nanos(), Ordering::Relaxed);
    }

    /// Stamp of the last input.
    pub fn now(&self) -> Stamp {
        Stamp::from_nanos(self.0.load(Ordering::Relaxed))
    }
}
