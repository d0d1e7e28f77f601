//! The simulated robot, paced by this computer's clock.

use crate::pacer::RealTimePacer;
use crate::{ArrivalSender, LinkThread, Stopped, texts};
use crossbeam_channel::Receiver;
use messages::{BootRecord, Drive};
use ports::{Arrival, LinkError, RobotEvent, RobotLink, SimulatedFault};
use sim::{ScheduledFault, SimConfig, Simulator};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use vocab::{Span, Vec3};

/// Parameters of a [`SimLink`].
pub struct SimLinkConfig {
    /// Parameters of the simulation.
    pub sim: SimConfig,
    /// Robot seconds per second.
    pub speed: f64,
    /// Velocity of slipping feet over the ground in the base frame, m/s, for the fault "feet slip".
    pub slip_velocity_m_s: Vec3,
    /// Time for which the robot is carried, for the fault "carried away".
    pub carry_duration: Span,
    /// Simulated time of a step. Between steps the link reads this computer's clock and the commands.
    pub step: Span,
    /// Largest number of faults that wait. The simulation takes them within a step; further ones are refused.
    pub max_pending_faults: usize,
}

impl SimLinkConfig {
    /// Parameters with the default faults.
    pub fn new(sim: SimConfig, speed: f64) -> Self {
        Self {
            sim,
            speed,
            slip_velocity_m_s: Vec3::new(0.25, 0.1, 0.0),
            carry_duration: Span::from_millis(10_000),
            step: Span::from_millis(10),
            max_pending_faults: 16,
        }
    }
}

/// Commands and faults that the simulation has not taken yet.
#[derive(Default)]
struct PendingCommands {
    drive: Option<Drive>,
    faults: Vec<SimulatedFault>,
}

/// The simulator on a separate thread. Its results depend on the commands and their simulated times, not on the speed of
/// this computer. The simulator stops its robot [`messages::DRIVE_LIFETIME`] after the last command.
pub struct SimLink {
    max_pending_faults: usize,
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
        let (boot, site) = (simulator.boot(), config.sim.site.name().to_owned());
        let max_pending_faults = config.max_pending_faults;
        let pending = Arc::<Mutex<PendingCommands>>::default();
        let commands = Arc::clone(&pending);
        let (thread, arrivals) = LinkThread::start("link-sim", move |mut sender| {
            // It returns only after the link was dropped.
            let Err(Stopped) = simulate(simulator, &config, &commands, &mut sender);
        })?;
        Ok(Self { max_pending_faults, boot, site, pending, arrivals, _thread: thread })
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
        if pending.faults.len() == self.max_pending_faults {
            return Err(texts::TOO_MANY_FAULTS.to_owned());
        }
        pending.faults.push(fault);
        Ok(())
    }
}

/// Simulates until the link is dropped.
fn simulate(
    mut simulator: Simulator,
    config: &SimLinkConfig,
    pending: &Mutex<PendingCommands>,
    sender: &mut ArrivalSender,
) -> Result<std::convert::Infallible, Stopped> {
    let mut pacer = RealTimePacer::new(config.speed);
    let mut events = Vec::new();
    loop {
        sender.sleep(pacer.delay(simulator.now(), Instant::now()))?;
        let PendingCommands { drive, faults } =
            std::mem::take(&mut *pending.lock().unwrap_or_else(PoisonError::into_inner));
        drive.into_iter().for_each(|drive| simulator.command(drive));
        faults.into_iter().for_each(|fault| inject_fault(&mut simulator, fault, config));
        simulator.advance(simulator.now() + config.step, &mut events);
        for event in events.drain(..) {
            sender.send(Arrival { at: event.at, event: RobotEvent::Sensor(event.sensor) })?;
        }
        sender.send(Arrival { at: simulator.now(), event: RobotEvent::Clock })?;
    }
}

fn inject_fault(simulator: &mut Simulator, fault: SimulatedFault, config: &SimLinkConfig) {
    let from = simulator.elapsed();
    let fault = match fault {
        SimulatedFault::CoverLidar(span) => ScheduledFault::BlindLidar { from, until: from + span },
        SimulatedFault::SilenceLidar(span) => ScheduledFault::SilentLidar { from, until: from + span },
        SimulatedFault::SilenceImu(span) => ScheduledFault::SilentImu { from, until: from + span },
        SimulatedFault::SlipFeet(span) => {
            ScheduledFault::LegSlip { from, until: from + span, velocity: config.slip_velocity_m_s }
        }
        SimulatedFault::CarryAway => return simulator.carry_away(config.carry_duration),
        SimulatedFault::End => return simulator.clear_faults(),
    };
    simulator.inject_fault(fault);
}

#[cfg(test)]
#[path = "sim_link_tests.rs"]
mod tests;
