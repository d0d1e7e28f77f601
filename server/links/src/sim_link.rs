//! The simulated robot, paced by this computer's clock.

use crate::pace::Pace;
use crate::{LinkThread, Outlet, Stopped};
use crossbeam_channel::Receiver;
use messages::{BootRecord, Drive};
use ports::{Arrival, LinkError, Mishap, News, RobotLink};
use sim::{Fault, SimConfig, Simulator};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use vocab::{Span, Vec3};

/// Simulated time between looks at the clock and at the commands.
const STEP: Span = Span::from_millis(10);

/// What to simulate, and how fast.
pub struct SimLinkConfig {
    /// The simulation.
    pub sim: SimConfig,
    /// Robot seconds per second.
    pub speed: f64,
}

/// What the simulation is to take in.
#[derive(Default)]
struct Wanted {
    drive: Option<Drive>,
    mishaps: Vec<Mishap>,
}

/// Mishaps that may wait for the simulation, which takes them in within 10 ms.
const MISHAPS_MAX: usize = 16;
/// Speed of feet that slip, m/s.
const SLIP: Vec3 = Vec3::new(0.25, 0.1, 0.0);
/// Being carried away takes so long.
const CARRIED_FOR: Span = Span::from_millis(10_000);

/// The simulator on a thread of its own. What it computes depends on the commands and when they come in simulated
/// time, not on how fast this computer is. The simulator itself stops its robot [`ports::DRIVE_TIMEOUT`] after the last
/// command.
pub struct SimLink {
    boot: BootRecord,
    site: String,
    wanted: Arc<Mutex<Wanted>>,
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
        let wanted = Arc::<Mutex<Wanted>>::default();
        let commands = Arc::clone(&wanted);
        let (thread, arrivals) = LinkThread::start("link-sim", move |outlet| {
            // The only way out is that the link was dropped.
            let Err(Stopped) = simulate(simulator, config.speed, &commands, &outlet);
        })?;
        Ok(Self { boot, site: config.sim.site.to_string(), wanted, arrivals, _thread: thread })
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
        self.wanted.lock().unwrap_or_else(PoisonError::into_inner).drive = Some(drive);
    }

    fn cause(&self, mishap: Mishap) -> Result<(), String> {
        let mut wanted = self.wanted.lock().unwrap_or_else(PoisonError::into_inner);
        if wanted.mishaps.len() == MISHAPS_MAX {
            return Err("Too much goes wrong at once. Try again in a moment.".to_owned());
        }
        wanted.mishaps.push(mishap);
        Ok(())
    }
}

/// Simulates until the link is dropped.
fn simulate(
    mut simulator: Simulator,
    speed: f64,
    wanted: &Mutex<Wanted>,
    outlet: &Outlet,
) -> Result<std::convert::Infallible, Stopped> {
    let mut pace = Pace::new(speed);
    let mut events = Vec::new();
    loop {
        outlet.sleep(pace.delay(simulator.now(), Instant::now()))?;
        let Wanted { drive, mishaps } =
            std::mem::take(&mut *wanted.lock().unwrap_or_else(PoisonError::into_inner));
        drive.into_iter().for_each(|drive| simulator.command(drive));
        mishaps.into_iter().for_each(|mishap| cause(&mut simulator, mishap));
        simulator.advance(simulator.now() + STEP, &mut events);
        for event in events.drain(..) {
            outlet.send(Arrival { at: event.at, news: News::Sensor(event.sensor) })?;
        }
        outlet.send(Arrival { at: simulator.now(), news: News::Clock })?;
    }
}

fn cause(simulator: &mut Simulator, mishap: Mishap) {
    let from = simulator.elapsed();
    let fault = match mishap {
        Mishap::CoverLidar(span) => Fault::BlindLidar { from, until: from + span },
        Mishap::SilenceLidar(span) => Fault::SilentLidar { from, until: from + span },
        Mishap::SilenceImu(span) => Fault::SilentImu { from, until: from + span },
        Mishap::SlipFeet(span) => Fault::LegSlip { from, until: from + span, velocity: SLIP },
        Mishap::CarryAway => return simulator.carry_away(CARRIED_FOR),
        Mishap::End => return simulator.clear_faults(),
    };
    simulator.inject(fault);
}

#[cfg(test)]
#[path = "sim_link_tests.rs"]
mod tests;
