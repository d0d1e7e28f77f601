//! Requests to stop: a signal, or the end of standard input for a supervised process.

use crate::failure::Failure;
use crossbeam_channel::{Receiver, Sender};
use std::io::Read;
use std::time::Duration;
use watchdog::{BEAT_PERIOD, Heartbeat, Watchdog};

/// Receives the request to stop.
#[derive(Clone)]
pub struct ShutdownSignal {
    receiver: Receiver<()>,
}

impl ShutdownSignal {
    /// A request by Ctrl-C, termination or hang-up.
    pub fn on_signals() -> Result<Self, Failure> {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        listen_to_signals(sender)?;
        Ok(Self { receiver })
    }

    /// A request by these signals or the end of standard input, which means that the supervisor has closed it or has ended.
    pub fn on_signals_or_end_of_input(watchdog: &Watchdog) -> Result<Self, Failure> {
        let (sender, receiver) = crossbeam_channel::bounded(1);
        listen_to_signals(sender.clone())?;
        let read = move |heartbeat: &Heartbeat| {
            // It waits for its supervisor as long as it lives.
            let _waiting = heartbeat.begin_wait();
            let mut buffer = [0; 64];
            while matches!(std::io::stdin().read(&mut buffer), Ok(1..)) {}
            // The channel is full if the request was sent before.
            let _ = sender.try_send(());
        };
        watchdog.spawn("stdin", BEAT_PERIOD, read).map_err(Failure::failed)?;
        Ok(Self { receiver })
    }

    /// The channel of requests, for `select!`.
    pub fn receiver(&self) -> &Receiver<()> {
        &self.receiver
    }

    /// Waits for a request; true if there was one.
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
