//! Messages between a robot's process and the core, on a Unix socket, in the frames of [`ports::encode_frame`].
//!
//! The robot listens. The core connects and opens with [`RobotRequest::Hello`]. The robot answers [`RobotMessage::Hello`] and, if both speak the same
//! version, [`RobotMessage::Identity`]; arrivals follow. One core is connected at a time: a new one replaces the old one.

use messages::{BootRecord, Drive, Sensor};
use ports::{ActionCall, ActionEvent, ActionRegistration, SimulatedFault};
use serde::{Deserialize, Serialize};
use vocab::{ActionCallId, CommandId, Stamp};

/// Version of all messages but the two greetings, which never change. Robot and core refuse each other when it differs.
pub const PROTOCOL_VERSION: u16 = 4;

/// Largest message of a robot, bytes: many times the largest scan, and twice the largest result of an action.
pub const MAX_ROBOT_MESSAGE_BYTES: usize = 32 << 20;

/// Largest request of a core, bytes: many times a drive command, and twice the longest parameters of an action.
pub const MAX_REQUEST_BYTES: usize = 4 << 10;

/// From the core to the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum RobotRequest {
    /// The first message.
    Hello {
        /// [`PROTOCOL_VERSION`] of the core.
        version: u16,
    },
    /// Move with this velocity. It must be repeated, see [`messages::DRIVE_LIFETIME`].
    Drive(Drive),
    /// Inject a fault. Answered with [`RobotMessage::FaultAnswer`].
    InjectFault {
        /// Returned in the answer.
        id: CommandId,
        /// The fault.
        fault: SimulatedFault,
    },
    /// Perform an action. Answered with [`RobotMessage::Action`], the last of which is its end.
    StartAction(ActionCall),
    /// End an action. Its end is answered all the same; for a call that the robot does not know, it is a failure.
    CancelAction(ActionCallId),
}

/// From the robot to the core.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum RobotMessage {
    /// The first message.
    Hello {
        /// [`PROTOCOL_VERSION`] of the robot.
        version: u16,
    },
    /// The second message.
    Identity(Box<RobotIdentity>),
    /// A measurement.
    Sensor {
        /// The robot's clock on arrival.
        at: Stamp,
        /// The measurement.
        sensor: Sensor,
    },
    /// The robot's clock.
    Clock(Stamp),
    /// Answer to [`RobotRequest::InjectFault`].
    FaultAnswer {
        /// The request.
        id: CommandId,
        /// One sentence with the reason, if the robot refuses.
        refused: Option<String>,
    },
    /// What becomes of an action.
    Action(ActionEvent),
}

/// Who a robot is and what it can do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotIdentity {
    /// Drawn at random when the robot's process starts. Another number after a reconnection means that clock and place of the robot may have changed.
    pub run: u64,
    /// Its clock now.
    pub now: Stamp,
    /// Identity, limits and sensors.
    pub boot: BootRecord,
    /// Name of the simulated site, if it is one.
    pub site: Option<String>,
    /// What it can do beyond measuring and driving.
    pub capabilities: RobotCapabilities,
    /// The actions that it performs.
    pub actions: Vec<ActionRegistration>,
}

/// What a robot can do beyond measuring and driving.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotCapabilities {
    /// Whether it injects simulated faults.
    pub simulated_faults: bool,
}
