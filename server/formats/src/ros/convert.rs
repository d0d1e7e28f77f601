//! Between ROS messages and the stack's own.

use super::standard::{BatteryState, Header, Imu, Odometry};
use messages::{ExternalOdometry, ImuSample, LegOdometry};

const CHARGING: u8 = 1;
const DISCHARGING: u8 = 2;
const FULL: u8 = 4;

impl From<&Imu> for ImuSample {
    fn from(imu: &Imu) -> Self {
        Self {
            stamp: imu.header.stamp,
            angular_velocity: imu.angular_velocity,
            specific_force: imu.linear_acceleration,
        }
    }
}

impl Imu {
    /// The ROS message of a sample, measured in `frame_id`.
    pub fn from_sample(sample: &ImuSample, frame_id: &str) -> Self {
        Self {
            header: Header { stamp: sample.stamp, frame_id: frame_id.into() },
            angular_velocity: sample.angular_velocity,
            linear_acceleration: sample.specific_force,
            ..Self::default()
        }
    }
}

impl From<&Odometry> for LegOdometry {
    fn from(odometry: &Odometry) -> Self {
        Self { stamp: odometry.header.stamp, base_velocity: odometry.twist, odom_from_base: odometry.pose }
    }
}

impl From<&Odometry> for ExternalOdometry {
    fn from(odometry: &Odometry) -> Self {
        Self { stamp: odometry.header.stamp, odom_from_external: odometry.pose }
    }
}

impl Odometry {
    /// The ROS message of leg odometry.
    pub fn from_legs(legs: &LegOdometry, frame_id: &str, child_frame_id: &str) -> Self {
        Self {
            header: Header { stamp: legs.stamp, frame_id: frame_id.into() },
            child_frame_id: child_frame_id.into(),
            pose: legs.odom_from_base,
            twist: legs.base_velocity,
        }
    }

    /// The ROS message of another odometry; it has no velocity.
    pub fn from_external(external: &ExternalOdometry, frame_id: &str, child_frame_id: &str) -> Self {
        Self {
            header: Header { stamp: external.stamp, frame_id: frame_id.into() },
            child_frame_id: child_frame_id.into(),
            pose: external.odom_from_external,
            ..Self::default()
        }
    }
}

impl From<&BatteryState> for messages::BatteryState {
    /// A full battery draws no current from its dock. It counts as docked while it is not discharged.
    fn from(battery: &BatteryState) -> Self {
        Self {
            stamp: battery.header.stamp,
            charge: battery.percentage,
            voltage_v: battery.voltage,
            current_a: battery.current,
            charging: match battery.power_supply_status {
                CHARGING => true,
                FULL => battery.current >= 0.0,
                _ => false,
            },
        }
    }
}

impl From<&messages::BatteryState> for BatteryState {
    fn from(battery: &messages::BatteryState) -> Self {
        Self {
            header: Header { stamp: battery.stamp, frame_id: String::new() },
            voltage: battery.voltage_v,
            current: battery.current_a,
            percentage: battery.charge,
            power_supply_status: if battery.charging { CHARGING } else { DISCHARGING },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_battery_is_docked_while_it_is_not_discharged() {
        let charging = |power_supply_status, current| {
            let battery = BatteryState { power_supply_status, current, ..BatteryState::default() };
            messages::BatteryState::from(&battery).charging
        };
        assert!(charging(CHARGING, 3.0) && charging(CHARGING, f32::NAN));
        assert!(charging(FULL, 0.0) && !charging(FULL, -4.0));
        assert!(!charging(FULL, f32::NAN), "it may as well stand in the yard");
        assert!(!charging(DISCHARGING, 0.0));
    }
}
