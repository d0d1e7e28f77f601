//! Names of the built-in monitors, by key. Apart from `texts.rs`, whose sentences name the monitors.

pub(super) const BATTERY_LOW: &str = "Battery low";
pub(super) const BATTERY_RESERVE: &str = "Battery reserve";
