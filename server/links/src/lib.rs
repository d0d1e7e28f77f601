//! Links to robots: to a simulated one, and to a recording that is replayed as if it were live.
//!
//! Both deliver into a queue of [`LinkConfig::max_queued_arrivals`] arrivals, about 1 s of a robot with all sensors. While the queue is full, the link waits and
//! loses nothing. Its clock then runs more slowly than requested, which the platform shows as a real-time factor below one. Sweeps are prepared for the stack on the
//! thread of the link, see [`ScanPreparation`].

mod pacer;
mod replay;
mod sim_link;
mod texts;

pub use replay::{ReplayConfig, ReplayLink, ReplaySource};
pub use sim_link::{SimLink, SimLinkConfig};

use crossbeam_channel::{Receiver, Sender, select};
use ports::{Arrival, LinkError, RobotEvent};
use scan_codec::ScanPreparation;
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Parameters of all links.
#[derive(Clone, Copy, Debug)]
struct LinkConfig {
    /// Largest number of arrivals in the queue to the control loop. While it is full, the link waits.
    max_queued_arrivals: usize,
}

const CONFIG: LinkConfig = LinkConfig { max_queued_arrivals: 1_000 };

/// The thread of a link. Dropping it ends the thread.
struct LinkThread {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// The sending end of the queue, for the link's thread.
struct ArrivalSender {
    arrivals: Sender<Arrival>,
    stop: Receiver<()>,
    /// Prepares the sweeps for the stack.
    preparation: ScanPreparation,
}

/// Error: the link has been dropped.
struct Stopped;

impl LinkThread {
    /// Starts a thread that fills the returned queue.
    fn start(
        name: &str,
        run: impl FnOnce(ArrivalSender) + Send + 'static,
    ) -> Result<(Self, Receiver<Arrival>), LinkError> {
        let (sender, arrivals) = crossbeam_channel::bounded(CONFIG.max_queued_arrivals);
        let (stop, stopped) = crossbeam_channel::bounded(0);
        let sender =
            ArrivalSender { arrivals: sender, stop: stopped, preparation: ScanPreparation::default() };
        let thread =
            thread::Builder::new().name(name.to_owned()).spawn(|| run(sender)).map_err(LinkError::Thread)?;
        Ok((Self { stop: Some(stop), thread: Some(thread) }, arrivals))
    }
}

impl Drop for LinkThread {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A panic was already reported on standard error.
            let _ = thread.join();
        }
    }
}

impl ArrivalSender {
    /// Prepares a measurement and delivers it; waits while the queue is full.
    fn send(&mut self, mut arrival: Arrival) -> Result<(), Stopped> {
        if let RobotEvent::Sensor(sensor) = arrival.event {
            arrival.event = RobotEvent::Sensor(self.preparation.prepare(arrival.at, sensor));
        }
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
