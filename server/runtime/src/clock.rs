//! The robot's clock as the control loop last read it, for the other threads; and the calendar time of this computer.

use std::path::Path;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};
use vocab::Stamp;

/// systemd-timesyncd makes this file once the clock follows a time server. Under another time service the clock counts as not synchronised.
const CLOCK_SYNCHRONISED: &str = "/run/systemd/timesync/synchronized";

/// The calendar time as this computer has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CalendarTime {
    /// UTC. A time before 1970 counts as 1970.
    pub utc: Stamp,
    /// Whether the computer's clock follows a time server.
    pub is_synchronised: bool,
}

impl CalendarTime {
    /// Reads the computer's clock.
    pub fn read() -> Self {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let utc = Stamp::from_nanos(i64::try_from(since_1970.as_nanos()).unwrap_or(i64::MAX));
        Self { utc, is_synchronised: Path::new(CLOCK_SYNCHRONISED).exists() }
    }

    /// UTC, if it can be relied on.
    pub fn synchronised(self) -> Option<Stamp> {
        Some(self.utc).filter(|_| self.is_synchronised)
    }
}

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
