//! Robots to link to: a simulated one, and a recording played as if it happened now.
//!
//! Both deliver into a queue of [`QUEUE_MAX`] arrivals, about a second of a robot with all sensors. When the queue is full, the link
//! *waits*: its time then passes more slowly than asked for. The platform shows this as a real-time factor below one; nothing is lost.

mod pacer;
mod replay;
mod sim_link;
mod texts;

pub use replay::{ReplayConfig, ReplayLink, ReplaySource};
pub use sim_link::{SimLink, SimLinkConfig};

use crossbeam_channel::{Receiver, Sender, select};
use ports::{Arrival, LinkError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Arrivals that the queue to the control loop holds.
pub const QUEUE_MAX: usize = 1_000;

/// The thread of a link. Dropping it ends the thread.
struct LinkThread {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// The sending end of the queue, for the link's thread.
struct ArrivalSender {
    arrivals: Sender<Arrival>,
    stop: Receiver<()>,
}

/// The link has been dropped.
struct Stopped;

impl LinkThread {
    /// Starts a thread that fills the returned queue.
    fn start(
        name: &str,
        run: impl FnOnce(ArrivalSender) + Send + 'static,
    ) -> Result<(Self, Receiver<Arrival>), LinkError> {
        let (sender, arrivals) = crossbeam_channel::bounded(QUEUE_MAX);
        let (stop, stopped) = crossbeam_channel::bounded(0);
        let sender = ArrivalSender { arrivals: sender, stop: stopped };
        let thread =
            thread::Builder::new().name(name.to_owned()).spawn(|| run(sender)).map_err(LinkError::Thread)?;
        Ok((Self { stop: Some(stop), thread: Some(thread) }, arrivals))
    }
}

impl Drop for LinkThread {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A panic has been reported on standard error already.
            let _ = thread.join();
        }
    }
}

impl ArrivalSender {
    /// Delivers, waiting while the queue is full.
    fn send(&self, arrival: Arrival) -> Result<(), Stopped> {
        select! {
            send(self.arrivals, arrival) -> sent => sent.map_err(|_| Stopped),
            recv(self.stop) -> _ => Err(Stopped),
        }
    }

    /// Waits on this computer's clock.
    fn sleep(&self, duration: Duration) -> Result<(), Stopped> {
        if duration.is_zero() {
            return Ok(());
        }
        match self.stop.recv_timeout(duration) {
            Err(crossbeam_channel::RecvTimeoutError::Timeout) => Ok(()),
            _ => Err(Stopped),
        }
    }
}
