//! The stream to a robot on which requests are written, shared by all who ask something of the robot.

use crate::protocol::RobotRequest;
use crate::texts;
use ports::encode_frame;
use std::io::{self, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::{Mutex, PoisonError};

/// The stream on which requests are written, if the robot is connected.
#[derive(Default)]
pub(crate) struct CurrentConnection(Mutex<ConnectionState>);

#[derive(Default)]
struct ConnectionState {
    stream: Option<UnixStream>,
    is_ending: bool,
}

/// Error: the robot is not connected.
pub(crate) struct NotConnected;

impl CurrentConnection {
    fn state(&self) -> std::sync::MutexGuard<'_, ConnectionState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes requests to this stream from now on.
    pub(crate) fn install(&self, stream: &UnixStream) -> io::Result<()> {
        let mut state = self.state();
        if state.is_ending {
            return Err(io::ErrorKind::ConnectionAborted.into());
        }
        state.stream = Some(stream.try_clone()?);
        Ok(())
    }

    #[cfg(test)]
    pub(crate) fn is_connected(&self) -> bool {
        self.state().stream.is_some()
    }

    pub(crate) fn send(&self, request: &RobotRequest) -> Result<(), NotConnected> {
        let mut state = self.state();
        let Some(stream) = &mut state.stream else {
            return Err(NotConnected);
        };
        let Err(error) = stream.write_all(&encode_frame(request)) else {
            return Ok(());
        };
        if error.kind() == io::ErrorKind::WouldBlock {
            tracing::warn!("the robot's connection ends: {}", texts::ROBOT_DOES_NOT_READ);
        }
        state.close();
        Err(NotConnected)
    }

    pub(crate) fn close(&self) {
        self.state().close();
    }

    /// Closes the connection for good.
    pub(crate) fn end(&self) {
        let mut state = self.state();
        state.is_ending = true;
        state.close();
    }
}

impl ConnectionState {
    /// Closes the stream, which also wakes the thread that reads it.
    fn close(&mut self) {
        if let Some(stream) = self.stream.take() {
            // It may be closed already.
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}
