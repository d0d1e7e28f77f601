//! The simulation's thread: one step at a time, in step with this computer's clock.

use super::actions::ActionRunner;
use super::config::SimulatedRobotConfig;
use super::connection::{ActionCommand, CoreConnection, CoreSlot, PendingRequests};
use super::truth_log::TruthLog;
use super::wait_budget::WaitBudget;
use crate::pacer::RealTimePacer;
use crate::protocol::RobotMessage;
use crate::stoppable_thread::{StopSignal, Stopped};
use crate::texts;
use crossbeam_channel::{TrySendError, select};
use messages::Drive;
use ports::SimulatedFault;
use sim::{ScheduledFault, SimEvent, Simulator};
use std::sync::Arc;
use std::time::Instant;
use vocab::Span;

pub(super) struct Simulation {
    config: SimulatedRobotConfig,
    simulator: Simulator,
    truth: Option<TruthLog>,
    pacer: RealTimePacer,
    /// Holds the connected core.
    slot: CoreSlot,
    /// The core that gets the messages.
    core: Option<Arc<CoreConnection>>,
    wait: WaitBudget,
    actions: ActionRunner,
    stop: StopSignal,
}

impl Simulation {
    pub(super) fn new(
        config: SimulatedRobotConfig,
        simulator: Simulator,
        truth: Option<TruthLog>,
        actions: ActionRunner,
        slot: CoreSlot,
        stop: StopSignal,
    ) -> Self {
        let (pacer, wait) = (RealTimePacer::new(config.speed), WaitBudget::new(config.wait));
        Self { config, simulator, truth, pacer, slot, core: None, wait, actions, stop }
    }

    /// Simulates until it is told to stop.
    pub(super) fn run(mut self) {
        let mut events = Vec::new();
        while let Ok(()) = self.step(&mut events) {}
    }

    fn step(&mut self, events: &mut Vec<SimEvent>) -> Result<(), Stopped> {
        self.wait_until_due()?;
        self.follow_connection();
        let PendingRequests { drive, faults, actions } =
            self.core.as_ref().map(|core| core.take_requests()).unwrap_or_default();
        if let Some(drive) = drive {
            self.simulator.command(drive);
        }
        for (id, fault) in faults {
            let refused = self.inject_fault(fault).err();
            self.send(RobotMessage::FaultAnswer { id, refused })?;
        }
        for request in actions {
            match request {
                ActionCommand::Start(call) => self.actions.start(call, &mut self.simulator),
                ActionCommand::Cancel(call) => self.actions.cancel(call),
            }
        }
        self.simulator.advance(self.simulator.now() + self.config.step, events);
        self.actions.advance(&mut self.simulator)?;
        for event in self.actions.take_events() {
            self.send(RobotMessage::Action(event))?;
        }
        self.wait.refill(self.config.step);
        if let Some(truth) = &mut self.truth {
            truth.append(&self.simulator);
        }
        for SimEvent { at, sensor } in events.drain(..) {
            self.send(RobotMessage::Sensor { at, sensor })?;
        }
        self.send(RobotMessage::Clock(self.simulator.now()))
    }

    /// Waits until the next step is due, with a sign of life at least every [`SimulatedRobotConfig::sign_of_life_period`].
    fn wait_until_due(&mut self) -> Result<(), Stopped> {
        loop {
            if let Some(on_step) = &self.config.on_step {
                on_step();
            }
            let delay = self.pacer.delay(self.simulator.now(), Instant::now());
            self.stop.sleep(delay.min(self.config.sign_of_life_period))?;
            if delay <= self.config.sign_of_life_period {
                return Ok(());
            }
        }
    }

    /// Takes the core that is connected now. The legs stop when a connection ends: nobody would correct the robot's course.
    fn follow_connection(&mut self) {
        let connected = self.slot.connected(self.simulator.now());
        let is_same = match (&self.core, &connected) {
            (Some(core), Some(connected)) => Arc::ptr_eq(core, connected),
            (None, None) => true,
            _ => false,
        };
        if !is_same {
            if self.core.is_some() {
                self.simulator.command(Drive::default());
            }
            self.core = connected;
            // The core that called is told by its own link.
            self.actions.forget_all();
            self.wait = WaitBudget::new(self.config.wait);
        }
    }

    /// Queues a message for the core, if one is connected. While the queue is full, the simulation waits as long as its budget allows. Then the core is
    /// disconnected.
    fn send(&mut self, message: RobotMessage) -> Result<(), Stopped> {
        let Some(core) = &self.core else {
            return Ok(());
        };
        let message = match core.messages.try_send(message) {
            Ok(()) | Err(TrySendError::Disconnected(_)) => return Ok(()),
            Err(TrySendError::Full(message)) => message,
        };
        let since = Instant::now();
        select! {
            // A closed connection is noticed before the next step.
            send(core.messages, message) -> _ => {}
            recv(self.stop.0) -> _ => return Err(Stopped),
            default(self.wait.remaining()) => {
                tracing::warn!("the core is disconnected: {}", texts::CORE_DOES_NOT_READ);
                core.close();
            }
        }
        self.wait.spend(since.elapsed());
        Ok(())
    }

    fn inject_fault(&mut self, fault: SimulatedFault) -> Result<(), String> {
        let from = self.simulator.elapsed();
        let until = |span: Span| from + span.max(Span::ZERO).min(self.config.max_fault_duration);
        let fault = match fault {
            SimulatedFault::CoverLidar(span) => ScheduledFault::BlindLidar { from, until: until(span) },
            SimulatedFault::SilenceLidar(span) => ScheduledFault::SilentLidar { from, until: until(span) },
            SimulatedFault::SilenceImu(span) => ScheduledFault::SilentImu { from, until: until(span) },
            SimulatedFault::SlipFeet(span) => {
                let velocity = self.config.slip_velocity_m_s;
                ScheduledFault::LegSlip { from, until: until(span), velocity }
            }
            SimulatedFault::CarryAway => {
                return match self.simulator.carry_away(self.config.carry_duration) {
                    true => Ok(()),
                    false => Err(texts::NOWHERE_TO_CARRY.to_owned()),
                };
            }
            SimulatedFault::End => {
                self.simulator.clear_faults();
                return Ok(());
            }
        };
        self.simulator.inject_fault(fault);
        Ok(())
    }
}
