//! What the robot last reported of itself. Values stay when the link is lost; their ages show it.

use super::Feature;
use crate::Aged;
use crate::shared::Context;
use api::{Battery, Estimate, Health, Motion};

/// The last report of each kind.
#[derive(Clone, Debug, Default)]
pub struct RobotTelemetry {
    /// Its pose estimate.
    pub estimate: Option<Aged<Estimate>>,
    /// Its battery.
    pub battery: Option<Aged<Battery>>,
    /// Its sensors.
    pub health: Option<Aged<Health>>,
    /// How it moves.
    pub motion: Option<Aged<Motion>>,
}

impl Feature for RobotTelemetry {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        let arrived = cx.now();
        match event {
            api::Event::Estimate(value) => self.estimate = Some(Aged { value: *value, arrived }),
            api::Event::Battery(value) => self.battery = Some(Aged { value: *value, arrived }),
            api::Event::Health(value) => self.health = Some(Aged { value: value.clone(), arrived }),
            api::Event::Motion(value) => self.motion = Some(Aged { value: value.clone(), arrived }),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
