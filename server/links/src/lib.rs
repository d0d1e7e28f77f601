//! Links to robots: to a robot in a process of its own, and to a recording that is replayed as if it were live. The other end of the socket is here
//! too: the simulated robot.
//!
//! The links deliver into a queue of bounded size. While it is full, the replay waits and loses nothing; its clock then runs more slowly than requested,
//! which the platform shows as a real-time factor below one. A robot waits for a short time only, see [`SimulatedRobot`]. Sweeps are prepared for the stack on the
//! thread of the link, see [`scan_codec::ScanPreparation`].

mod current_connection;
mod pacer;
mod protocol;
mod replay;
mod robot_actions;
mod simulated_robot;
mod socket_link;
mod stoppable_thread;
mod texts;

pub use protocol::{
    MAX_REQUEST_BYTES, MAX_ROBOT_MESSAGE_BYTES, PROTOCOL_VERSION, RobotCapabilities, RobotIdentity,
    RobotMessage, RobotRequest,
};
pub use replay::{ReplayConfig, ReplayLink, ReplaySource};
pub use simulated_robot::{OnStep, RobotStartError, SimulatedRobot, SimulatedRobotConfig};
pub use socket_link::{ConnectError, SocketLink, SocketLinkConfig};
