//! The robot's clock as the control loop last read it, for the other threads; and the calendar time of this computer.

use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};
use vocab::{Span, Stamp};

/// Added to the computer's clock, nanoseconds, see [`set_clock_offset`].
static OFFSET_NS: AtomicI64 = AtomicI64::new(0);

/// Moves the clock of schedules in this process, to try them. The clock of the robot stays. To be called before a core starts.
pub fn set_clock_offset(offset: Span) {
    OFFSET_NS.store(offset.nanos(), Ordering::Relaxed);
}

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
        Self { utc, is_synchronised: follows_a_time_server() }
    }

    /// Reads the clock of schedules and of what the ledger notes: the computer's, moved by [`set_clock_offset`]. The age of stored data is computed from the computer's own clock.
    pub fn read_of_schedules() -> Self {
        let offset = Span::from_nanos(OFFSET_NS.load(Ordering::Relaxed));
        let Self { utc, is_synchronised } = Self::read();
        // Whoever has moved the clock relies on it.
        Self { utc: utc + offset, is_synchronised: is_synchronised || offset != Span::ZERO }
    }

    /// UTC, if it can be relied on.
    pub fn synchronised(self) -> Option<Stamp> {
        Some(self.utc).filter(|_| self.is_synchronised)
    }
}

/// Whether a time service keeps this computer's clock, whichever it is (chrony, systemd-timesyncd, ntpd, PTP): all of them tell the kernel. After some hours without
/// news from its server the kernel says no again.
#[allow(unsafe_code, reason = "no crate in use has a safe form of this call")]
fn follows_a_time_server() -> bool {
    // SAFETY: `timex` consists of numbers, for all of which zero is valid. With `modes` 0 the call only writes to it.
    let (state, status) = unsafe {
        let mut reading: libc::timex = std::mem::zeroed();
        let state = libc::adjtimex(&mut reading);
        (state, reading.status)
    };
    is_synchronised(state, status)
}

/// What adjtimex(2) returned, and the status that it gave.
fn is_synchronised(state: libc::c_int, status: libc::c_int) -> bool {
    state >= 0 && state != libc::TIME_ERROR && status & libc::STA_UNSYNC == 0
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_says_whether_its_clock_is_synchronised() {
        assert!(is_synchronised(libc::TIME_OK, libc::STA_PLL));
        assert!(is_synchronised(libc::TIME_INS, 0), "a leap second is announced");
        assert!(!is_synchronised(libc::TIME_ERROR, libc::STA_UNSYNC));
        assert!(!is_synchronised(libc::TIME_OK, libc::STA_UNSYNC));
        assert!(!is_synchronised(-1, 0), "the call is forbidden");
        // It does not fail here, whatever it says.
        assert_eq!(follows_a_time_server(), follows_a_time_server());
    }
}
