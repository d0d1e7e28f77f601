//! Driving by hand, and standing still.

use crate::{Behaviour, BehaviourContext, BehaviourOutcome};
use messages::SpeedLimits;
use std::task::Poll;
use vocab::{Span, Stamp, Twist, Vec3};

/// Moves with one commanded velocity until the watchdog's time has passed.
#[derive(Clone, Copy, Debug)]
pub struct ManualDriving {
    velocity: Twist,
    since: Stamp,
    watchdog: Span,
}

impl ManualDriving {
    /// A velocity commanded at `at`, clamped to the limits. Only forward, sideways and turning velocity are kept.
    pub fn new(at: Stamp, velocity: &Twist, limits: &SpeedLimits, watchdog: Span) -> Self {
        let SpeedLimits { forward_m_s, sideways_m_s, turn_rad_s } = *limits;
        let velocity = Twist {
            linear: Vec3::new(
                velocity.linear.x.clamp(-forward_m_s, forward_m_s),
                velocity.linear.y.clamp(-sideways_m_s, sideways_m_s),
                0.0,
            ),
            angular: Vec3::new(0.0, 0.0, velocity.angular.z.clamp(-turn_rad_s, turn_rad_s)),
        };
        Self { velocity, since: at, watchdog }
    }
}

impl Behaviour for ManualDriving {
    fn update(&mut self, context: &mut BehaviourContext<'_>) -> Poll<BehaviourOutcome> {
        if context.at - self.since > self.watchdog {
            return Poll::Ready(Ok(()));
        }
        context.velocity = self.velocity;
        Poll::Pending
    }
}

/// Stands still until it is replaced.
#[derive(Clone, Copy, Debug)]
pub struct StandBehaviour;

impl Behaviour for StandBehaviour {
    fn update(&mut self, _context: &mut BehaviourContext<'_>) -> Poll<BehaviourOutcome> {
        Poll::Pending
    }
}
