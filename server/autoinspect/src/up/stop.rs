//! Requests to stop: a signal, or the end of standard input for a supervised process.

use crate::failure::Failure;
use crossbeam_channel::{Receiver, Sender};
use std::io::Read;
use std::thread;
use std::time::Duration;

/// Receives the request to stop.
#[derive(Clone)]
pub struct Stop {
    receiver: Receiver<()>,
}

impl Stop {
    /// On Ctrl-C, termination or hang-up.
    pub fn on_signals() -> Result<Self, Failure> {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        listen_to_signals(sender)?;
        Ok(Self { receiver })
    }

    /// Also when standard input ends, which is when the supervisor closes it or dies.
    pub fn on_signals_or_end_of_input() -> Result<Self, Failure> {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        listen_to_signals(sender.clone())?;
        let read = move || {
            let mut buffer = [0; 64];
            while matches!(std::io::stdin().read(&mut buffer), Ok(1..)) {}
            // The channel is full if the request was sent before.
            let _ = sender.try_send(());
        };
        thread::Builder::new().name("stdin".to_owned()).spawn(read).map_err(Failure::failed)?;
        Ok(Self { receiver })
    }

    /// For `select!`.
    pub fn receiver(&self) -> &Receiver<()> {
        &self.receiver
    }

    /// Waits; true if stopping was requested.
    pub fn wait(&self, duration: Duration) -> bool {
        !matches!(self.receiver.recv_timeout(duration), Err(crossbeam_channel::RecvTimeoutError::Timeout))
    }
}

fn listen_to_signals(sender: Sender<()>) -> Result<(), Failure> {
    ctrlc::set_handler(move || {
        let _ = sender.try_send(());
    })
    .map_err(Failure::failed)
}
