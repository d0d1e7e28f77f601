//! Driving by hand: the velocity that is commanded, and when to send it.

use crate::ClientTime;
use vocab::Twist;

/// Limits and rate of driving by hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TeleoperationConfig {
    /// Time between two velocity commands, seconds. The robot stops 0.5 s after the last one.
    pub period_s: f64,
    /// Fastest walk, metres per second.
    pub speed_max_mps: f64,
    /// Fastest turn, radians per second.
    pub turn_max_radps: f64,
}

impl Default for TeleoperationConfig {
    fn default() -> Self {
        Self { period_s: 0.1, speed_max_mps: 0.9, turn_max_radps: 1.0 }
    }
}

/// The velocity that the operator holds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Teleoperation {
    velocity: Option<Twist>,
    last_sent: Option<ClientTime>,
    config: TeleoperationConfig,
}

impl Teleoperation {
    /// The commanded velocity; `None` while joystick and keys are released.
    pub(crate) fn velocity(&self) -> Option<Twist> {
        self.velocity
    }

    /// Joystick or keys moved, or were released. Returns the velocity to send at once: on release zero, once.
    pub(crate) fn set_velocity(&mut self, now: ClientTime, velocity: Option<Twist>) -> Option<Twist> {
        let before = std::mem::replace(&mut self.velocity, velocity);
        match (before, velocity) {
            (Some(_), None) => {
                self.last_sent = None;
                Some(Twist::default())
            }
            _ => self.take_due(now),
        }
    }

    /// The velocity to send now, if the last one was sent [`TeleoperationConfig::period_s`] ago.
    pub(crate) fn take_due(&mut self, now: ClientTime) -> Option<Twist> {
        let velocity = self.velocity?;
        if self.last_sent.is_some_and(|sent| now.since(sent) < self.config.period_s) {
            return None;
        }
        self.last_sent = Some(now);
        Some(velocity)
    }
}
