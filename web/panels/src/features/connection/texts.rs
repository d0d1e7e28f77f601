//! Texts of the connection, by key.

use crate::format;

pub(super) const LINK: &str = "Link";
pub(super) const CONNECTING: &str = "Connecting";
pub(super) const CONNECTING_TO_ROBOT: &str = "Connecting to the robot…";
pub(super) const LOST: &str = "Link lost";
pub(super) const REFUSED: &str = "Refused";
pub(super) const RECONNECT: &str = "Reconnect now";

/// While a lost connection is being opened again.
pub(super) fn reconnecting(lost_s: f64) -> String {
    format!("Link lost {} ago. Trying again now…", format::duration(lost_s))
}

/// While a lost connection waits for its next try.
pub(super) fn lost(lost_s: f64, retry_s: f64) -> String {
    format!("Link lost {} ago. Next try in {:.0} s.", format::duration(lost_s), retry_s.ceil())
}

pub(super) fn link_hint(round_trip_s: Option<f64>) -> String {
    let answer = round_trip_s.map(|s| format!(" Answer after {:.0} ms.", s * 1000.0));
    format!("Data coming in, and how old the robot's position is.{}", answer.unwrap_or_default())
}
