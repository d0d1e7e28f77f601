//! Sentences of links for people, by key, and the clauses of their errors. English.

use std::fmt::Display;
use vocab::{MAX_SHOWN_NAME_CHARS, legible};

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
/// More requests for actions at once than the robot stores.
pub(crate) const TOO_MANY_ACTION_REQUESTS: &str = "it asked for too many actions at once";
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
/// The connection was lost while the robot performed an action. A sentence.
pub(crate) const ROBOT_LOST_IN_ACTION: &str =
    "The connection to the robot was lost during the action, so nobody knows whether it was done.";
/// More actions at once than a robot is asked for. A sentence.
pub(crate) const TOO_MANY_ACTIONS: &str =
    "The robot performs too many actions at once. Try again in a moment.";
/// Parameters that do not fit into a request. A sentence.
pub(crate) const PARAMETERS_TOO_LONG: &str = "The parameters of the action are too long.";
/// The end of an action was asked for that the robot does not perform. A sentence.
pub(crate) const NO_SUCH_CALL: &str = "The robot performs no such action.";
/// A picture was asked for in a direction that the head does not reach. A sentence.
pub(crate) const OUT_OF_REACH: &str = "The camera cannot point there. Turn the robot first.";
/// A picture could not be encoded. A sentence.
pub(crate) const PICTURE_NOT_ENCODED: &str = "The picture could not be encoded.";

/// The robot has no action of this name. A sentence.
pub(crate) fn no_such_action(action: &str) -> String {
    format!("The robot has no action \"{}\".", legible(action, MAX_SHOWN_NAME_CHARS))
}

/// Parameters of an action are wrong for `reason`, a clause. A sentence.
pub(crate) fn wrong_parameters(reason: &dyn Display) -> String {
    format!(
        "The parameters of the action are not those of its schema: {}.",
        legible(&reason.to_string(), 200)
    )
}

/// The result of an action was left out. A sentence.
pub(crate) fn result_too_large(bytes: usize, max_bytes: usize) -> String {
    format!("The result of the action has {bytes} bytes, and {max_bytes} are allowed. Ask for less.")
}

/// A measurement is under way.
pub(crate) fn measuring(done_s: f64, total_s: f64) -> String {
    format!("Measuring, {done_s:.0} of {total_s:.0} s")
}

/// The core does not read for longer than the robot waits.
pub(crate) const CORE_DOES_NOT_READ: &str = "it does not read what the robot sends";
