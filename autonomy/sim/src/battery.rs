//! The battery: drains with standing and walking, charges at the dock.

use messages::BatteryState;
use vocab::Stamp;

/// Energy of the full battery, joules.
const CAPACITY_J: f64 = 930.0 * 3600.0;
/// Power that the standing robot draws, watts.
const STANDING_POWER_W: f64 = 190.0;
/// Additional power per speed of walking, watts per m/s.
const WALKING_POWER_W_PER_M_S: f64 = 320.0;
/// Power of the charger, watts.
const CHARGING_POWER_W: f64 = 700.0;
/// Open-circuit voltage of the empty battery, volts.
const EMPTY_VOLTAGE_V: f64 = 44.0;
/// Open-circuit voltage of the full battery, volts.
const FULL_VOLTAGE_V: f64 = 58.0;
/// Internal resistance, ohms.
const RESISTANCE_OHM: f64 = 0.06;
/// A robot slower than this can be charged, m/s.
const MAX_CHARGING_SPEED_M_S: f64 = 0.02;

/// The battery.
#[derive(Clone, Debug)]
pub(crate) struct SimulatedBattery {
    /// State of charge, 0 to 1.
    charge: f64,
    /// Power into the battery, watts.
    power: f64,
    charging: bool,
}

impl SimulatedBattery {
    /// A battery with that state of charge, 0 to 1.
    pub(crate) fn new(charge: f64) -> Self {
        Self { charge, power: -STANDING_POWER_W, charging: false }
    }

    /// Advances by `seconds` at a walking speed (m/s); `docked` says whether the robot stands at a dock.
    pub(crate) fn advance(&mut self, seconds: f64, speed: f64, docked: bool) {
        self.charging = docked && speed < MAX_CHARGING_SPEED_M_S;
        self.power = if self.charging && self.charge < 1.0 {
            CHARGING_POWER_W
        } else if self.charging {
            0.0
        } else {
            -STANDING_POWER_W - WALKING_POWER_W_PER_M_S * speed
        };
        self.charge = (self.charge + self.power * seconds / CAPACITY_J).clamp(0.0, 1.0);
    }

    /// The message of the battery.
    pub(crate) fn state(&self, stamp: Stamp) -> BatteryState {
        let open = EMPTY_VOLTAGE_V + (FULL_VOLTAGE_V - EMPTY_VOLTAGE_V) * self.charge;
        let current = self.power / open;
        BatteryState {
            stamp,
            charge: self.charge as f32,
            voltage_v: (open + current * RESISTANCE_OHM) as f32,
            current_a: current as f32,
            charging: self.charging,
        }
    }
}
