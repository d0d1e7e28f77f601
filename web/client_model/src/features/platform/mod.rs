//! The robot's computer, and faults that a simulated robot is made to have.

use super::Feature;
use crate::shared::Context;
use crate::{Aged, ClientCommand};
use api::{Platform, RobotBody, SpeedLimits};

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
