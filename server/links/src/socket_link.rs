//! The link to a robot in another process, over a Unix socket.

use crate::current_connection::{CurrentConnection, NotConnected};
use crate::protocol::{MAX_ROBOT_MESSAGE_BYTES, PROTOCOL_VERSION, RobotIdentity, RobotMessage, RobotRequest};
use crate::robot_actions::RobotActions;
use crate::stoppable_thread::{ArrivalSender, StoppableThread, Stopped};
use crate::texts;
use crossbeam_channel::{Receiver, Sender};
use messages::{BootRecord, Drive, Scan, Sensor};
use ports::{
    ActionServer, Arrival, REAL_ROBOT_HAS_NO_FAULTS, RobotEvent, RobotLink, SimulatedFault, encode_frame,
    read_frame,
};
use std::io::{self, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use vocab::{CommandId, Stamp};

/// Parameters of a [`SocketLink`], on this computer's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SocketLinkConfig {
    /// Largest number of arrivals in the queue to the control loop. While it is full, the link does not read. Short, because what waits here is older than what the robot
    /// would send next. Chosen: about 0.08 s of a robot with all sensors.
    pub max_queued_arrivals: usize,
    /// Longest time from connecting to the robot's identity. Chosen: a robot that lives answers within milliseconds.
    pub hello_timeout: Duration,
    /// Longest time for one request to the robot. The buffer of a socket holds hundreds of requests, so a write that waits means a robot that hangs. Chosen: a tenth of a
    /// step of control (50 ms).
    pub write_timeout: Duration,
    /// Pause before the first attempt to reconnect; it doubles with each further attempt. Chosen: nobody notices it.
    pub min_retry_pause: Duration,
    /// Longest pause between two attempts to reconnect. Chosen: a robot that listens again is found within half a second.
    pub max_retry_pause: Duration,
}

impl Default for SocketLinkConfig {
    fn default() -> Self {
        Self {
            max_queued_arrivals: 50,
            hello_timeout: Duration::from_secs(2),
            write_timeout: Duration::from_millis(5),
            min_retry_pause: Duration::from_millis(20),
            max_retry_pause: Duration::from_millis(500),
        }
    }
}

/// Why a robot could not be connected, as a clause about the robot.
#[derive(Debug, thiserror::Error)]
pub enum ConnectError {
    /// Nobody listens, or the connection broke.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// Its first messages are not those of the protocol.
    #[error("{}", texts::NO_GREETING)]
    NoGreeting,
    /// It speaks another version.
    #[error("{}", texts::other_version(*.0, PROTOCOL_VERSION))]
    Version(u16),
}

/// A robot behind a Unix socket. When the connection is lost, the link connects again to the same robot. If another robot answers, the link ends,
/// see [`RobotLink::robot_restarted`].
pub struct SocketLink {
    identity: RobotIdentity,
    connection: Arc<CurrentConnection>,
    actions: Arc<RobotActions>,
    arrivals: Receiver<Arrival>,
    restarted: Receiver<()>,
    _thread: StoppableThread,
}

impl SocketLink {
    /// Connects to the robot that listens at `path`. One attempt.
    ///
    /// # Errors
    /// When no robot of this version of the protocol answers.
    pub fn connect(path: &Path, config: SocketLinkConfig) -> Result<Self, ConnectError> {
        let (reader, identity) = greet(path, &config)?;
        let connection = Arc::<CurrentConnection>::default();
        connection.install(reader.get_ref())?;
        let (sender, arrivals) = crossbeam_channel::bounded(config.max_queued_arrivals);
        let (restarted_sender, restarted) = crossbeam_channel::bounded(1);
        let actions = Arc::new(RobotActions::new(&identity, Arc::clone(&connection)));
        let receiver = ArrivalReceiver {
            config,
            path: path.to_owned(),
            run: identity.run,
            connection: Arc::clone(&connection),
            actions: Arc::clone(&actions),
            restarted: restarted_sender,
            clock: identity.now,
        };
        let thread = StoppableThread::start("link-robot", move |stop| {
            // The link was dropped or the robot was restarted: the thread ends either way.
            let _ = receiver.run(reader, &mut ArrivalSender::new(sender, stop));
        })?;
        Ok(Self { identity, connection, actions, arrivals, restarted, _thread: thread })
    }
}

impl Drop for SocketLink {
    fn drop(&mut self) {
        self.connection.end();
    }
}

impl RobotLink for SocketLink {
    fn boot(&self) -> BootRecord {
        self.identity.boot.clone()
    }

    fn site(&self) -> Option<String> {
        self.identity.site.clone()
    }

    fn arrivals(&self) -> Receiver<Arrival> {
        self.arrivals.clone()
    }

    fn drive(&self, drive: Drive) {
        // Without a connection the robot has stopped by itself.
        let _ = self.connection.send(&RobotRequest::Drive(drive));
    }

    fn inject_fault(&self, id: CommandId, fault: SimulatedFault) -> Result<(), String> {
        if !self.identity.capabilities.simulated_faults {
            return Err(REAL_ROBOT_HAS_NO_FAULTS.to_owned());
        }
        self.connection
            .send(&RobotRequest::InjectFault { id, fault })
            .map_err(|NotConnected| texts::ROBOT_NOT_CONNECTED.to_owned())
    }

    fn action_server(&self) -> Option<Arc<dyn ActionServer>> {
        let actions = Arc::clone(&self.actions);
        (!self.identity.actions.is_empty()).then_some(actions as Arc<dyn ActionServer>)
    }

    fn robot_restarted(&self) -> Receiver<()> {
        self.restarted.clone()
    }
}

/// Connects and exchanges greetings.
fn greet(
    path: &Path,
    config: &SocketLinkConfig,
) -> Result<(BufReader<UnixStream>, RobotIdentity), ConnectError> {
    let mut stream = UnixStream::connect(path)?;
    stream.set_read_timeout(Some(config.hello_timeout))?;
    stream.set_write_timeout(Some(config.write_timeout))?;
    stream.write_all(&encode_frame(&RobotRequest::Hello { version: PROTOCOL_VERSION }))?;
    let mut reader = BufReader::new(stream);
    match read_frame(&mut reader, MAX_ROBOT_MESSAGE_BYTES)? {
        Some(RobotMessage::Hello { version: PROTOCOL_VERSION }) => {}
        Some(RobotMessage::Hello { version }) => return Err(ConnectError::Version(version)),
        _ => return Err(ConnectError::NoGreeting),
    }
    let Some(RobotMessage::Identity(identity)) = read_frame(&mut reader, MAX_ROBOT_MESSAGE_BYTES)? else {
        return Err(ConnectError::NoGreeting);
    };
    reader.get_ref().set_read_timeout(None)?;
    Ok((reader, *identity))
}

/// The link's thread: reads arrivals and reconnects.
struct ArrivalReceiver {
    config: SocketLinkConfig,
    path: PathBuf,
    /// [`RobotIdentity::run`] of the connected robot.
    run: u64,
    connection: Arc<CurrentConnection>,
    actions: Arc<RobotActions>,
    restarted: Sender<()>,
    /// The robot's clock at the last arrival.
    clock: Stamp,
}

impl ArrivalReceiver {
    fn run(mut self, mut reader: BufReader<UnixStream>, sender: &mut ArrivalSender) -> Result<(), Stopped> {
        loop {
            let error = self.receive(&mut reader, sender)?;
            self.connection.close();
            self.actions.fail_all();
            tracing::warn!("the robot's connection ends: {error}");
            let lost = RobotEvent::Disconnected(texts::robot_lost(&error));
            sender.send(Arrival { at: self.clock, event: lost })?;
            match self.reconnect(sender)? {
                Some(again) => reader = again,
                None => {
                    // This event comes before the thread ends. So the control loop knows that the link has ended, and does not take the end of its thread for a failure.
                    let ended = RobotEvent::Ended(texts::ANOTHER_ROBOT.to_owned());
                    sender.send(Arrival { at: self.clock, event: ended })?;
                    // The channel has room for the only message.
                    let _ = self.restarted.try_send(());
                    return Ok(());
                }
            }
            sender.send(Arrival { at: self.clock, event: RobotEvent::Reconnected })?;
        }
    }

    /// Passes arrivals on until the connection ends. Returns why.
    fn receive(
        &mut self,
        reader: &mut BufReader<UnixStream>,
        sender: &mut ArrivalSender,
    ) -> Result<io::Error, Stopped> {
        loop {
            let (at, event) = match read_frame(reader, MAX_ROBOT_MESSAGE_BYTES) {
                Ok(Some(RobotMessage::Clock(at))) => (at, RobotEvent::Clock),
                Ok(Some(RobotMessage::Sensor { at, sensor })) if is_valid(&sensor) => {
                    (at, RobotEvent::Sensor(sensor))
                }
                Ok(Some(RobotMessage::Sensor { at, .. })) => {
                    tracing::warn!("a measurement of the robot is not valid and is left out");
                    (at, RobotEvent::Clock)
                }
                Ok(Some(RobotMessage::FaultAnswer { id, refused })) => {
                    (self.clock, RobotEvent::FaultAnswered { id, refused })
                }
                Ok(Some(RobotMessage::Action(event))) => {
                    self.actions.receive(event);
                    continue;
                }
                Ok(Some(RobotMessage::Hello { .. } | RobotMessage::Identity(_))) => {
                    return Ok(io::Error::new(io::ErrorKind::InvalidData, texts::UNEXPECTED_GREETING));
                }
                Ok(None) => {
                    return Ok(io::Error::new(io::ErrorKind::UnexpectedEof, texts::CONNECTION_CLOSED));
                }
                Err(error) => return Ok(error),
            };
            self.clock = self.clock.max(at);
            sender.send(Arrival { at: self.clock, event })?;
        }
    }

    /// Connects again to the same robot; `None` if another one answers.
    fn reconnect(&self, sender: &mut ArrivalSender) -> Result<Option<BufReader<UnixStream>>, Stopped> {
        let mut pause = self.config.min_retry_pause;
        loop {
            sender.stop.sleep(pause)?;
            pause = (2 * pause).min(self.config.max_retry_pause);
            match greet(&self.path, &self.config) {
                Ok((_, identity)) if identity.run != self.run => return Ok(None),
                Ok((reader, _)) => match self.connection.install(reader.get_ref()) {
                    Ok(()) => return Ok(Some(reader)),
                    Err(error) => tracing::debug!("the robot is not connected: {error}"),
                },
                Err(error) => tracing::debug!("the robot is not connected: {error}"),
            }
        }
    }
}

/// Whether a measurement keeps the promises of [`Sensor`].
fn is_valid(sensor: &Sensor) -> bool {
    let Sensor::Scan(scan) = sensor else {
        return true;
    };
    let Scan { xyz, intensity, offset_ns, ring, .. } = &**scan;
    let is_column = |length: usize| length == 0 || length == xyz.len();
    is_column(intensity.len())
        && is_column(offset_ns.len())
        && is_column(ring.len())
        && xyz.iter().flatten().all(|coordinate| coordinate.is_finite())
}

#[cfg(test)]
#[path = "socket_link_tests.rs"]
mod tests;
