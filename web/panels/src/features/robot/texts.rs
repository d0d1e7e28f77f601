//! Texts of the robot's state, by key.

use crate::format;
use api::{Battery, Motion};

pub(super) const HEAD: &str = "Robot";
pub(super) const MOTION: &str = "Motion";
pub(super) const MAP: &str = "Map";
pub(super) const DELETED_MAP: &str = "One that was deleted";
pub(super) const NO_ESTIMATE: &str = "The robot has not reported its position yet.";
pub(super) const SPEED: &str = "Speed";
pub(super) const POSITION: &str = "Position in the map";
pub(super) const ACCURACY: &str = "Accuracy";
pub(super) const DISTANCE: &str = "Walked";
pub(super) const BATTERY: &str = "Battery";

/// What the robot does; `None` before its first report.
pub(super) fn motion(motion: Option<&Motion>) -> &'static str {
    let Some(motion) = motion else { return "No report yet" };
    match motion {
        Motion::Idle => "Standing",
        Motion::Stopped { .. } => "Motion stopped",
        Motion::Teleoperated => "Driven by hand",
        Motion::Walking { .. } => "Walking",
        Motion::Waiting { .. } => "Waiting to see",
        Motion::Relocalising { .. } => "Relocalising",
        Motion::Blocked { .. } => "Path blocked",
    }
}

/// Time until the battery is empty, or full while it is charged.
pub(super) fn battery_time_left(battery: &Battery) -> Option<String> {
    let time = format::duration(battery.left?.secs_f64());
    Some(if battery.charging { format!("full in {time}") } else { format!("{time} left") })
}
