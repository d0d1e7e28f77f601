//! The battery: drains with standing and walking, charges at the dock.

use messages::BatteryState;
use vocab::Stamp;

/// J.
const CAPACITY: f64 = 930.0 * 3600.0;
/// W: standing, and more per m/s of walking.
const STANDING_POWER: f64 = 190.0;
const WALKING_POWER: f64 = 320.0;
/// W.
const CHARGING_POWER: f64 = 700.0;
/// V at empty and at full.
const VOLTAGE: (f64, f64) = (44.0, 58.0);
/// Ω.
const RESISTANCE: f64 = 0.06;

/// The battery.
#[derive(Clone, Debug)]
pub(crate) struct Battery {
    /// 0 to 1.
    charge: f64,
    power: f64,
    charging: bool,
}

impl Battery {
    /// With that charge, 0 to 1.
    pub(crate) fn new(charge: f64) -> Self {
        Self { charge, power: -STANDING_POWER, charging: false }
    }

    /// `seconds` at that walking speed (m/s), at the dock or not.
    pub(crate) fn advance(&mut self, seconds: f64, speed: f64, docked: bool) {
        self.charging = docked && speed < 0.02;
        self.power = if self.charging && self.charge < 1.0 {
            CHARGING_POWER
        } else if self.charging {
            0.0
        } else {
            -STANDING_POWER - WALKING_POWER * speed
        };
        self.charge = (self.charge + self.power * seconds / CAPACITY).clamp(0.0, 1.0);
    }

    /// What the battery says.
    pub(crate) fn state(&self, stamp: Stamp) -> BatteryState {
        let open = VOLTAGE.0 + (VOLTAGE.1 - VOLTAGE.0) * self.charge;
        let current = self.power / open;
        BatteryState {
            stamp,
            charge: self.charge as f32,
            voltage: (open + current * RESISTANCE) as f32,
            current: current as f32,
            charging: self.charging,
        }
    }
}
