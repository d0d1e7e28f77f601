//! Driving by hand: the velocity that is commanded, and when to send it.

use crate::ClientTime;
use vocab::Twist;

/// Rate of driving by hand. Its speed limits are those of the robot's profile, see [`api::Platform`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TeleoperationConfig {
    /// Time between two velocity commands, seconds. The robot stops 0.5 s after the last one. Chosen: a fifth of that, so that four lost commands do not stop it.
    pub(crate) period_s: f64,
}

impl Default for TeleoperationConfig {
    fn default() -> Self {
        Self { period_s: 0.1 }
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
