//! Interface to a robot: a source of stamped events and a sink of drive commands.

use api::SimulatedFault;
use crossbeam_channel::Receiver;
use messages::{BootRecord, Drive, Sensor};
use vocab::Stamp;

/// An event from the robot with its time of arrival.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrival {
    /// The robot's clock on arrival, which never decreases. A measurement's own stamp is earlier.
    pub at: Stamp,
    /// The event.
    pub event: RobotEvent,
}

/// An event of a link.
#[derive(Clone, Debug, PartialEq)]
pub enum RobotEvent {
    /// A measurement.
    Sensor(Sensor),
    /// Only the time. It is sent every [`messages::TICK_PERIOD`] of robot time, so that a longer silence means a broken link.
    Clock,
    /// The link has ended, with the reason in one sentence.
    Ended(String),
}

/// Refusal of a fault by a robot that is not simulated.
const REAL_ROBOT_HAS_NO_FAULTS: &str =
    "This robot is a real one: nothing can be made to go wrong with it from here.";

/// Error of connecting to a robot.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The link's parameters name something that does not exist.
    #[error("{0}")]
    Setup(String),
    /// The thread of the link could not be started.
    #[error("could not start the robot link's thread")]
    Thread(#[source] std::io::Error),
}

/// A robot, simulated or real. Dropping it stops the robot and ends its threads.
pub trait RobotLink: Send {
    /// The robot's identity and the mounting of its sensors: the first input of the stack.
    fn boot(&self) -> BootRecord;

    /// Name of the simulated site, if it is one.
    fn site(&self) -> Option<String> {
        None
    }

    /// The queue of events from the robot, in order of arrival. It is bounded; each link documents what it does when the queue is full.
    /// It is disconnected once the link has ended.
    fn arrivals(&self) -> Receiver<Arrival>;

    /// Sends a drive command. Never blocks. It must be repeated: see [`messages::DRIVE_LIFETIME`].
    fn drive(&self, drive: Drive);

    /// Injects a fault, if the robot is simulated. Never blocks.
    ///
    /// # Errors
    /// One sentence with the reason.
    fn inject_fault(&self, _fault: SimulatedFault) -> Result<(), String> {
        Err(REAL_ROBOT_HAS_NO_FAULTS.to_owned())
    }
}
