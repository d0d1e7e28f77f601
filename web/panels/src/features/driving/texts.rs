//! Texts of driving by hand, by key.

use crate::format;

pub(super) const CARD: &str = "Drive";
pub(super) const JOYSTICK: &str = "Joystick";
pub(super) const JOYSTICK_HINT: &str =
    "Drag: up walks ahead, sideways turns. The keys W, A, S, D, Q and E do the same.";
pub(super) const LIMITS_UNKNOWN: &str = "The robot has not told its speed limits yet.";
pub(super) const STOP: &str = "Stop motion";
pub(super) const STOP_SHORT: &str = "Stop";
pub(super) const STOP_HINT: &str = "Stops the robot now. Esc or Space";
pub(super) const ALLOW: &str = "Allow motion";
pub(super) const ALLOW_SHORT: &str = "Allow";

/// The speed, and the distance that remains of a walk.
pub(super) fn speed_and_distance(speed_m_s: f64, remaining_m: Option<f64>) -> String {
    let speed = format::speed(speed_m_s);
    match remaining_m {
        Some(remaining_m) => format!("{speed} · {} to go", format::distance(remaining_m)),
        None => speed,
    }
}
