//! The robot's computer, and faults that a simulated robot is made to have.

use super::Feature;
use crate::shared::Context;
use crate::{Aged, ClientCommand};
use api::{Platform, RobotBody, SpeedLimits};

/// Height of the base of common robots with four legs, m.
const DEFAULT_STANDING_HEIGHT_M: f64 = 0.55;

/// The last report of the robot's computer.
#[derive(Clone, Debug, Default)]
pub struct PlatformFeature {
    platform: Option<Aged<Platform>>,
}

impl PlatformFeature {
    /// The last report; `None` before the first one.
    pub fn report(&self) -> Option<&Platform> {
        self.platform.as_ref().map(|platform| &platform.value)
    }

    /// Speed limits while a person drives the robot; `None` until it has told them.
    pub fn manual_limits(&self) -> Option<SpeedLimits> {
        self.report().and_then(|report| report.manual_limits)
    }

    /// The robot's body; `None` until it has told it.
    pub fn body(&self) -> Option<RobotBody> {
        self.report().and_then(|report| report.body)
    }

    /// Height of the robot's base over the ground while it stands, m: that of its profile, and until it has told it that of a common robot with four legs.
    pub fn standing_height_m(&self) -> f64 {
        self.body().map_or(DEFAULT_STANDING_HEIGHT_M, |body| body.standing_height_m)
    }
}

impl Feature for PlatformFeature {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        if let api::Event::Platform(platform) = event {
            self.platform = Some(Aged { value: platform.clone(), arrived: cx.now() });
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        if let ClientCommand::InjectFault(fault) = command {
            cx.send(api::Command::InjectFault(*fault));
        }
    }
}

#[cfg(test)]
mod tests;
