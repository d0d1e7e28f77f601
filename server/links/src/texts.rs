//! Sentences of links for people, by key, and the clauses of their errors. English.

use std::fmt::Display;

/// A replay has no more messages.
pub(crate) const RECORDING_ENDED: &str =
    "The recording has been played to its end. The map so far can be saved.";

/// Another robot answers where the robot was. A sentence.
pub(crate) const ANOTHER_ROBOT: &str = "The robot was started again, so its place and its clock may have changed. The platform begins anew with it.";

/// The robot closed the connection.
pub(crate) const CONNECTION_CLOSED: &str = "it closed the connection";
/// The robot does not read what the core sends.
pub(crate) const ROBOT_DOES_NOT_READ: &str = "it does not read its commands";
/// The first messages on a connection are not those of the protocol.
pub(crate) const NO_GREETING: &str = "its first message is not a greeting";
/// A greeting in the middle of a connection.
pub(crate) const UNEXPECTED_GREETING: &str = "it sent a greeting among other messages";
/// More simulated faults at once than the robot stores.
pub(crate) const TOO_MANY_FAULTS: &str = "it asked for too many faults at once";

/// Other versions of the protocol on both ends.
pub(crate) fn other_version(other: u16, own: u16) -> String {
    format!("it speaks version {other} of the robot protocol and this program version {own}")
}

/// The connection to the robot was lost for `reason`, a clause about the robot. A sentence.
pub(crate) fn robot_lost(reason: &dyn Display) -> String {
    format!(
        "The connection to the robot was lost: {reason}. It stops by itself. The connection is tried again."
    )
}

/// A simulated fault cannot be asked for, because the robot is not connected. A sentence.
pub(crate) const ROBOT_NOT_CONNECTED: &str = "The robot is not connected. Try again in a moment.";
/// Nobody can carry the robot away. A sentence.
pub(crate) const NOWHERE_TO_CARRY: &str = "There is no free place to which the robot could be carried.";
/// The core does not read for longer than the robot waits.
pub(crate) const CORE_DOES_NOT_READ: &str = "it does not read what the robot sends";
