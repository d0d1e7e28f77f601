//! The simulated robot, paced by this computer's clock.

use crate::pace::Pace;
use crate::{LinkThread, Outlet, Stopped};
use crossbeam_channel::Receiver;
use messages::{BootRecord, Drive};
use ports::{Arrival, LinkError, News, RobotLink};
use sim::{SimConfig, Simulator};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use vocab::Span;

/// Simulated time between looks at the clock and at the commands.
const STEP: Span = Span::from_millis(10);

/// What to simulate, and how fast.
pub struct SimLinkConfig {
    /// The simulation.
    pub sim: SimConfig,
    /// Robot seconds per second.
    pub speed: f64,
}

/// The simulator on a thread of its own. What it computes depends on the commands and when they come in simulated
/// time, not on how fast this computer is. The simulator itself stops its robot [`ports::DRIVE_TIMEOUT`] after the last
/// command.
pub struct SimLink {
    boot: BootRecord,
    site: String,
    drive: Arc<Mutex<Option<Drive>>>,
    arrivals: Receiver<Arrival>,
    _thread: LinkThread,
}

impl SimLink {
    /// Builds the site and starts the simulation.
    ///
    /// # Errors
    /// When the thread cannot be started.
    pub fn start(config: SimLinkConfig) -> Result<Self, LinkError> {
        let simulator = Simulator::new(config.sim.clone());
        let boot = simulator.boot();
        let drive = Arc::new(Mutex::new(None));
        let commands = Arc::clone(&drive);
        let (thread, arrivals) = LinkThread::start("link-sim", move |outlet| {
            // The only way out is that the link was dropped.
            let Err(Stopped) = simulate(simulator, config.speed, &commands, &outlet);
        })?;
        Ok(Self { boot, site: config.sim.site.to_string(), drive, arrivals, _thread: thread })
    }
}

impl RobotLink for SimLink {
    fn boot(&self) -> BootRecord {
        self.boot.clone()
    }

    fn site(&self) -> Option<String> {
        Some(self.site.clone())
    }

    fn arrivals(&self) -> Receiver<Arrival> {
        self.arrivals.clone()
    }

    fn drive(&self, drive: Drive) {
        *self.drive.lock().unwrap_or_else(PoisonError::into_inner) = Some(drive);
    }
}

/// Simulates until the link is dropped.
fn simulate(
    mut simulator: Simulator,
    speed: f64,
    drive: &Mutex<Option<Drive>>,
    outlet: &Outlet,
) -> Result<std::convert::Infallible, Stopped> {
    let mut pace = Pace::new(speed);
    let mut events = Vec::new();
    loop {
        outlet.sleep(pace.delay(simulator.now(), Instant::now()))?;
        if let Some(drive) = drive.lock().unwrap_or_else(PoisonError::into_inner).take() {
            simulator.command(drive);
        }
        simulator.advance(simulator.now() + STEP, &mut events);
        for event in events.drain(..) {
            outlet.send(Arrival { at: event.at, news: News::Sensor(event.sensor) })?;
        }
        outlet.send(Arrival { at: simulator.now(), news: News::Clock })?;
    }
}

#[cfg(test)]
#[path = "sim_link_tests.rs"]
mod tests;
