//! The simulated robot: a simulator that is paced by this computer's clock and listens for the core on a Unix socket, like a real robot's computer.
//!
//! The robot performs actions on a thread of its own (`actions`), so that nothing waits for a picture.
//!
//! The robot lives on without a core: it stands, charges, and its clock goes on. It stops its legs [`messages::DRIVE_LIFETIME`] after the last command, and at once
//! when the connection ends. It never waits for ever for a core that hangs: see [`SimulatedRobotConfig::max_queued_messages`] and [`wait_budget::WaitBudgetConfig`].

mod actions;
mod config;
mod connection;
mod simulation;
mod truth_log;
mod wait_budget;

pub use config::{OnStep, SimulatedRobotConfig};

use crate::protocol::{RobotCapabilities, RobotIdentity};
use crate::stoppable_thread::StoppableThread;
use actions::ActionRunner;
use connection::Listener;
use crossbeam_channel::{Receiver, Sender};
use sim::Simulator;
use simulation::Simulation;
use std::fs::{File, TryLockError};
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::path::{Path, PathBuf};
use truth_log::TruthLog;

/// Why a simulated robot could not be started.
#[derive(Debug, thiserror::Error)]
pub enum RobotStartError {
    /// The socket cannot be opened.
    #[error("could not listen for the core at {}", path.display())]
    Socket {
        /// Path of the socket.
        path: PathBuf,
        /// Error of the system.
        #[source]
        source: io::Error,
    },
    /// Another robot listens there.
    #[error("another simulated robot listens at {}; end it or choose another data directory", path.display())]
    InUse {
        /// Path of the socket.
        path: PathBuf,
    },
    /// The file for the ground truth cannot be written.
    #[error("could not write the ground truth to {}", path.display())]
    Truth {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        #[source]
        source: io::Error,
    },
    /// A thread cannot be started.
    #[error("could not start a thread of the simulated robot")]
    Thread(#[source] io::Error),
}

/// A running simulated robot. Dropping it ends its threads and removes the socket.
pub struct SimulatedRobot {
    ended: Receiver<()>,
    // Dropped in this order: no core connects to a robot that is ending.
    _listener: Listener,
    _simulation: StoppableThread,
    _lock: File,
}

impl SimulatedRobot {
    /// Builds the site, starts the simulation and listens.
    ///
    /// # Errors
    /// When the socket is in use, or the socket, the file of the truth or a thread cannot be created.
    pub fn start(config: SimulatedRobotConfig) -> Result<Self, RobotStartError> {
        let path = config.socket.clone();
        let lock = lock(&path)?;
        let truth = match &config.truth {
            Some(path) => Some(
                TruthLog::open(path)
                    .map_err(|source| RobotStartError::Truth { path: path.clone(), source })?,
            ),
            None => None,
        };
        let simulator = Simulator::new(config.sim.clone());
        let identity = RobotIdentity {
            // A hasher's keys are random.
            run: RandomState::new().hash_one(std::process::id()),
            now: simulator.now(),
            boot: simulator.boot(),
            site: Some(config.sim.site.name().to_owned()),
            capabilities: RobotCapabilities { simulated_faults: true },
            actions: actions::registrations(&simulator.cameras().head()),
        };
        let listener =
            Listener::start(&config, identity).map_err(|source| RobotStartError::Socket { path, source })?;
        let core = listener.core();
        let runner = ActionRunner::spawn(&simulator).map_err(RobotStartError::Thread)?;
        let (alive, ended) = crossbeam_channel::bounded(0);
        let simulation = StoppableThread::start("robot-sim", move |stop| {
            let _alive: Sender<()> = alive;
            Simulation::new(config, simulator, truth, runner, core, stop).run();
        })
        .map_err(RobotStartError::Thread)?;
        Ok(Self { ended, _listener: listener, _simulation: simulation, _lock: lock })
    }

    /// Disconnected when the simulation has ended. That happens only after a panic; the process should then end and be started again.
    pub fn ended(&self) -> Receiver<()> {
        self.ended.clone()
    }
}

/// Locks the file beside the socket, so that two robots never take the socket from each other. The system releases the lock even after a crash.
fn lock(socket: &Path) -> Result<File, RobotStartError> {
    let error = |source| RobotStartError::Socket { path: socket.to_owned(), source };
    if let Some(directory) = socket.parent() {
        std::fs::create_dir_all(directory).map_err(error)?;
    }
    let file = File::create(socket.with_extension("lock")).map_err(error)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(RobotStartError::InUse { path: socket.to_owned() }),
        Err(TryLockError::Error(source)) => Err(error(source)),
    }
}

#[cfg(test)]
#[path = "../simulated_robot_tests.rs"]
mod tests;
