//! Driving by hand: which velocity is wanted, and when to say so.

use crate::ClientTime;
use vocab::Twist;

/// Seconds between two orders while the hand is on the stick.
pub const TELEOPERATION_PERIOD_S: f64 = 0.1;
/// Fastest walk by hand, metres per second.
pub const SPEED_MPS_MAX: f64 = 0.9;
/// Fastest turn by hand, radians per second.
pub const TURN_RADPS_MAX: f64 = 1.0;

/// The hand on the stick.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    wanted: Option<Twist>,
    said: Option<ClientTime>,
}

impl Drive {
    /// The velocity that the hand wants; `None` while it is off.
    pub fn wanted(&self) -> Option<Twist> {
        self.wanted
    }

    /// The hand moved or let go. Returns what must be said at once: zero, once, when it lets go.
    pub(crate) fn hold(&mut self, now: ClientTime, wanted: Option<Twist>) -> Option<Twist> {
        let was = std::mem::replace(&mut self.wanted, wanted);
        match (was, wanted) {
            (Some(_), None) => {
                self.said = None;
                Some(Twist::default())
            }
            _ => self.due(now),
        }
    }

    /// What must be said now because the last time is [`TELEOPERATION_PERIOD_S`] ago.
    pub(crate) fn due(&mut self, now: ClientTime) -> Option<Twist> {
        let wanted = self.wanted?;
        if self.said.is_some_and(|said| now.since(said) < TELEOPERATION_PERIOD_S) {
            return None;
        }
        self.said = Some(now);
        Some(wanted)
    }
}
