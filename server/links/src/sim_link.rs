//! The simulated robot, paced by this computer's clock.

use crate::pacer::RealTimePacer;
use crate::{ArrivalSender, LinkThread, Stopped};
use crossbeam_channel::Receiver;
use messages::{BootRecord, Drive};
use ports::{Arrival, LinkError, RobotEvent, RobotLink, SimulatedFault};
use sim::{ScheduledFault, SimConfig, Simulator};
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
struct PendingCommands {
    drive: Option<Drive>,
    faults: Vec<SimulatedFault>,
}

/// Faults that may wait for the simulation, which takes them in within 10 ms.
const FAULTS_MAX: usize = 16;
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
    pending: Arc<Mutex<PendingCommands>>,
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
        let pending = Arc::<Mutex<PendingCommands>>::default();
        let commands = Arc::clone(&pending);
        let (thread, arrivals) = LinkThread::start("link-sim", move |sender| {
            // The only way out is that the link was dropped.
            let Err(Stopped) = simulate(simulator, config.speed, &commands, &sender);
        })?;
        Ok(Self { boot, site: config.sim.site.to_string(), pending, arrivals, _thread: thread })
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
        self.pending.lock().unwrap_or_else(PoisonError::into_inner).drive = Some(drive);
    }

    fn inject_fault(&self, fault: SimulatedFault) -> Result<(), String> {
        let mut pending = self.pending.lock().unwrap_or_else(PoisonError::into_inner);
        if pending.faults.len() == FAULTS_MAX {
            return Err("Too much goes wrong at once. Try again in a moment.".to_owned());
        }
        pending.faults.push(fault);
        Ok(())
    }
}

/// Simulates until the link is dropped.
fn simulate(
    mut simulator: Simulator,
    speed: f64,
    pending: &Mutex<PendingCommands>,
    sender: &ArrivalSender,
) -> Result<std::convert::Infallible, Stopped> {
    let mut pacer = RealTimePacer::new(speed);
    let mut events = Vec::new();
    loop {
        sender.sleep(pacer.delay(simulator.now(), Instant::now()))?;
        let PendingCommands { drive, faults } =
            std::mem::take(&mut *pending.lock().unwrap_or_else(PoisonError::into_inner));
        drive.into_iter().for_each(|drive| simulator.command(drive));
        faults.into_iter().for_each(|fault| inject_fault(&mut simulator, fault));
        simulator.advance(simulator.now() + STEP, &mut events);
        for event in events.drain(..) {
            sender.send(Arrival { at: event.at, event: RobotEvent::Sensor(event.sensor) })?;
        }
        sender.send(Arrival { at: simulator.now(), event: RobotEvent::Clock })?;
    }
}

fn inject_fault(simulator: &mut Simulator, fault: SimulatedFault) {
    let from = simulator.elapsed();
    let fault = match fault {
        SimulatedFault::CoverLidar(span) => ScheduledFault::BlindLidar { from, until: from + span },
        SimulatedFault::SilenceLidar(span) => ScheduledFault::SilentLidar { from, until: from + span },
        SimulatedFault::SilenceImu(span) => ScheduledFault::SilentImu { from, until: from + span },
        SimulatedFault::SlipFeet(span) => {
            ScheduledFault::LegSlip { from, until: from + span, velocity: SLIP }
        }
        SimulatedFault::CarryAway => return simulator.carry_away(CARRIED_FOR),
        SimulatedFault::End => return simulator.clear_faults(),
    };
    simulator.inject_fault(fault);
}

#[cfg(test)]
#[path = "sim_link_tests.rs"]
mod tests;
