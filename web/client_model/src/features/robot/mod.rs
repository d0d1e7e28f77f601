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

/// One standard deviation of the position in the worst horizontal direction, metres.
pub fn position_sigma_m(estimate: &Estimate) -> f64 {
    let covariance = &estimate.covariance.0;
    let (xx, yy, xy) = (covariance[3][3], covariance[4][4], covariance[3][4]);
    let largest = 0.5 * (xx + yy) + (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
    largest.max(0.0).sqrt()
}

#[cfg(test)]
mod tests;
