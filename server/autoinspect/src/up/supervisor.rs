//! Keeps the simulated robot, the core and the gateway running.
//!
//! A process that ends is started again at once. If it ends again, the restart waits for a pause that doubles each time, until the process
//! stays healthy for some time. A process that gives no heartbeat for 5 s is killed and started again. It is told why, so that it can tell clients.
//!
//! A process ends with exit code 2 if its arguments cannot work (an address in use, a broken file). Before the platform has run for the first time, the
//! supervisor then ends too, because a restart would not help. Later it is a failure like any other: a disk that is back helps.
//!
//! Children read their standard input and stop when it ends. Closing it asks them to stop. The system closes it if this process dies, so that no
//! orphaned core keeps driving a robot.

use super::health::{is_healthy, reachable};
use super::process::Process;
use super::role::ProcessRole;
use super::stop::ShutdownSignal;
use crate::failure::Failure;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Parameters of a [`Supervisor`].
#[derive(Clone, Copy, Debug)]
struct SupervisorConfig {
    /// Time between checks of the children. Chosen: as that of a process.
    poll_interval: Duration,
    /// Longest time that the gateway's first start waits for the core to listen. Chosen: the core listens within a second mostly; then clients are told that it starts.
    core_start_timeout: Duration,
}

const CONFIG: SupervisorConfig =
    SupervisorConfig { poll_interval: Duration::from_millis(50), core_start_timeout: Duration::from_secs(3) };

/// Arguments of the processes.
pub struct SupervisorArguments {
    /// `None` if another program runs the robot.
    pub simulated_robot: Option<Vec<String>>,
    pub core: Vec<String>,
    /// Without `--listen`, which is added.
    pub gateway: Vec<String>,
}

/// Runs the processes.
pub struct Supervisor {
    simulated_robot: Option<Process>,
    core: Process,
    gateway: Process,
    listen: SocketAddr,
    /// Socket on which the core listens for the gateway.
    socket: PathBuf,
    /// The gateway starts when the core listens, because it would only report errors before. It starts at this instant at the latest.
    gateway_at: Instant,
    /// The address that the gateway listens on, once known.
    bound: Option<SocketAddr>,
    ready: bool,
}

impl Supervisor {
    /// Supervises processes with these arguments. The core will listen at `socket`.
    pub fn new(arguments: SupervisorArguments, listen: SocketAddr, socket: PathBuf) -> Self {
        let SupervisorArguments { simulated_robot, core, gateway } = arguments;
        Self {
            simulated_robot: simulated_robot.map(|robot| Process::new(ProcessRole::SimulatedRobot, robot)),
            core: Process::new(ProcessRole::Core, core),
            gateway: Process::new(ProcessRole::Gateway, gateway),
            listen,
            socket,
            gateway_at: Instant::now() + CONFIG.core_start_timeout,
            bound: None,
            ready: false,
        }
    }

    /// Runs them until `stop`. Calls `on_ready` once with the address when browsers can use it.
    pub fn run(&mut self, stop: &ShutdownSignal, on_ready: impl Fn(SocketAddr)) -> Result<(), Failure> {
        let outcome = loop {
            if let Err(failure) = self.check_processes(&on_ready) {
                break Err(failure);
            }
            if stop.wait(CONFIG.poll_interval) {
                break Ok(());
            }
        };
        // The gateway ends first, so that browsers report a closed connection and not a lost robot.
        self.gateway.end();
        self.core.end();
        if let Some(robot) = &mut self.simulated_robot {
            robot.end();
        }
        outcome
    }

    fn check_processes(&mut self, on_ready: &impl Fn(SocketAddr)) -> Result<(), Failure> {
        // A restarted gateway must listen on the address that browsers use.
        let listen = ["--listen".to_owned(), self.bound.unwrap_or(self.listen).to_string()];
        let mut of_robot = Vec::new();
        if let Some(robot) = &mut self.simulated_robot {
            robot.keep_running(&[], self.ready)?;
            of_robot = robot.restart_arguments("--robot-restart");
        }
        self.core.keep_running(&of_robot, self.ready)?;
        if self.gateway.is_running() || self.socket.exists() || Instant::now() >= self.gateway_at {
            self.gateway.keep_running(&listen, self.ready)?;
        }
        self.bound = self.gateway.address().or(self.bound);
        if let Some(address) = self.bound.filter(|_| !self.ready)
            && is_healthy(reachable(address))
        {
            self.ready = true;
            on_ready(address);
        }
        Ok(())
    }
}
