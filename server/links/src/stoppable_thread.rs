//! Threads that end when their owner is dropped.

use crossbeam_channel::{Receiver, Sender, select};
use ports::{Arrival, RobotEvent};
use scan_codec::ScanPreparation;
use std::io;
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// A thread that is told to stop, and waited for, when this is dropped.
pub(crate) struct StoppableThread {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// The thread's end: disconnected when it is to stop.
pub(crate) struct StopSignal(pub(crate) Receiver<()>);

/// Error: the owner of the thread has been dropped.
pub(crate) struct Stopped;

impl StoppableThread {
    pub(crate) fn start(name: &str, run: impl FnOnce(StopSignal) + Send + 'static) -> io::Result<Self> {
        let (stop, stopped) = crossbeam_channel::bounded(0);
        let thread = thread::Builder::new().name(name.to_owned()).spawn(|| run(StopSignal(stopped)))?;
        Ok(Self { stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for StoppableThread {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A panic was already reported on standard error.
            let _ = thread.join();
        }
    }
}

impl StopSignal {
    /// Waits on this computer's clock.
    pub(crate) fn sleep(&self, duration: Duration) -> Result<(), Stopped> {
        // Also without a wait it says whether to stop.
        match self.0.recv_timeout(duration) {
            Err(crossbeam_channel::RecvTimeoutError::Timeout) => Ok(()),
            _ => Err(Stopped),
        }
    }
}

/// The sending end of a link's queue, for the link's thread.
pub(crate) struct ArrivalSender {
    arrivals: Sender<Arrival>,
    pub(crate) stop: StopSignal,
    /// Prepares the sweeps for the stack.
    preparation: ScanPreparation,
}

impl ArrivalSender {
    pub(crate) fn new(arrivals: Sender<Arrival>, stop: StopSignal) -> Self {
        Self { arrivals, stop, preparation: ScanPreparation::default() }
    }

    /// Prepares a measurement and delivers it; waits while the queue is full.
    pub(crate) fn send(&mut self, mut arrival: Arrival) -> Result<(), Stopped> {
        if let RobotEvent::Sensor(sensor) = arrival.event {
            arrival.event = RobotEvent::Sensor(self.preparation.prepare(arrival.at, sensor));
        }
        select! {
            send(self.arrivals, arrival) -> sent => sent.map_err(|_| Stopped),
            recv(self.stop.0) -> _ => Err(Stopped),
        }
    }
}
