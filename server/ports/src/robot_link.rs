//! Interface to a robot: a source of stamped events and a sink of drive commands.

use crate::{ActionServer, REAL_ROBOT_HAS_NO_FAULTS};
use api::SimulatedFault;
use crossbeam_channel::Receiver;
use messages::{BootRecord, Drive, Sensor};
use std::sync::Arc;
use vocab::{CommandId, Stamp};

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
    /// The robot's answer to [`RobotLink::inject_fault`].
    FaultAnswered {
        /// The request.
        id: CommandId,
        /// One sentence with the reason, if the robot refuses.
        refused: Option<String>,
    },
    /// The connection to the robot was lost, with the reason in one sentence. The link tries to connect again; requests without an answer get none.
    Disconnected(String),
    /// The same robot is connected again.
    Reconnected,
    /// The link has ended, with the reason in one sentence.
    Ended(String),
}

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

    /// Asks a simulated robot to inject a fault. Never blocks. The answer is a [`RobotEvent::FaultAnswered`], unless the connection is lost before.
    ///
    /// # Errors
    /// One sentence with the reason why the robot was not asked.
    fn inject_fault(&self, _id: CommandId, _fault: SimulatedFault) -> Result<(), String> {
        Err(REAL_ROBOT_HAS_NO_FAULTS.to_owned())
    }

    /// Performs the robot's actions, if it has any.
    fn action_server(&self) -> Option<Arc<dyn ActionServer>> {
        None
    }

    /// Gets a message when another robot answers at the other end of the link, for example because the robot's process was restarted: its
    /// clock and its place may have changed. The link has ended then, with a [`RobotEvent::Ended`] before the message, and its owner must begin anew.
    fn robot_restarted(&self) -> Receiver<()> {
        crossbeam_channel::never()
    }
}
