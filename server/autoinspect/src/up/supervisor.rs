//! Keeps the simulated robot, the core and the gateway running.
//!
//! A process that ends is started again at once. If it ends again, the restart waits for a pause that doubles each time, until the process
//! stays healthy for some time. A process ends with exit code 2 if its arguments cannot work (an address in use, a broken file). The
//! supervisor then ends too, because a restart would not help.
//!
//! Children read their standard input and stop when it ends. Closing it asks them to stop. The system closes it if this process dies, so that no
//! orphaned core keeps driving a robot.

use super::health::is_healthy;
use super::stop::Stop;
use crate::failure::Failure;
use crate::{output, texts};
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// Parameters of a [`Supervisor`].
#[derive(Clone, Copy, Debug)]
struct SupervisorConfig {
    /// Time between checks of the children.
    poll_interval: Duration,
    /// Longest time for an orderly stop of a child, which may be saving a map.
    stop_timeout: Duration,
    /// Longest time that the gateway's first start waits for the core to listen.
    core_start_timeout: Duration,
    /// Pause before the second restart in a row; the first one has none.
    first_pause: Duration,
    /// Longest pause before a restart. Pauses double up to this.
    pause_max: Duration,
    /// A child that ran for this time is healthy: its next restart has no pause.
    healthy_after: Duration,
}

const CONFIG: SupervisorConfig = SupervisorConfig {
    poll_interval: Duration::from_millis(50),
    stop_timeout: Duration::from_secs(30),
    core_start_timeout: Duration::from_secs(3),
    first_pause: Duration::from_millis(250),
    pause_max: Duration::from_secs(10),
    healthy_after: Duration::from_secs(30),
};

/// The processes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    SimulatedRobot,
    Core,
    Gateway,
}

/// One process, which runs or waits for its start.
struct Process {
    role: Role,
    arguments: Vec<String>,
    running: Option<Running>,
    start_at: Instant,
    pause: Duration,
}

struct Running {
    child: Child,
    stdin: Option<ChildStdin>,
    since: Instant,
    /// First line of its standard output.
    first_line: Receiver<String>,
}

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
            simulated_robot: simulated_robot.map(|robot| Process::new(Role::SimulatedRobot, robot)),
            core: Process::new(Role::Core, core),
            gateway: Process::new(Role::Gateway, gateway),
            listen,
            socket,
            gateway_at: Instant::now() + CONFIG.core_start_timeout,
            bound: None,
            ready: false,
        }
    }

    /// Runs them until `stop`. Calls `on_ready` once with the address when browsers can use it.
    pub fn run(&mut self, stop: &Stop, on_ready: impl Fn(SocketAddr)) -> Result<(), Failure> {
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
        let listen = self.bound.unwrap_or(self.listen).to_string();
        if let Some(robot) = &mut self.simulated_robot {
            robot.keep_running(&[])?;
        }
        self.core.keep_running(&[])?;
        if self.gateway.running.is_some() || self.socket.exists() || Instant::now() >= self.gateway_at {
            self.gateway.keep_running(&["--listen", &listen])?;
        }
        if let Some(line) = self.gateway.first_line()
            && let Ok(address) = line.trim().parse()
        {
            self.bound = Some(address);
        }
        if let Some(address) = self.bound.filter(|_| !self.ready)
            && is_healthy(address)
        {
            self.ready = true;
            on_ready(address);
        }
        Ok(())
    }
}

impl Process {
    fn new(role: Role, arguments: Vec<String>) -> Self {
        Self { role, arguments, running: None, start_at: Instant::now(), pause: Duration::ZERO }
    }

    /// Starts the process if it is not running, and checks whether it has ended.
    fn keep_running(&mut self, more: &[&str]) -> Result<(), Failure> {
        let now = Instant::now();
        match &mut self.running {
            None if now >= self.start_at => self.running = Some(self.start(more)?),
            None => {}
            Some(running) => {
                if let Some(status) = running.child.try_wait().map_err(Failure::failed)? {
                    let lived = running.since.elapsed();
                    self.running = None;
                    self.plan_restart(status, lived)?;
                }
            }
        }
        Ok(())
    }

    fn start(&self, more: &[&str]) -> Result<Running, Failure> {
        let program = std::env::current_exe().map_err(Failure::failed)?;
        let mut child = Command::new(program)
            .args(&self.arguments)
            .args(more)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| Failure::failed(texts::cannot_start(self.role.name(), &error)))?;
        let stdin = child.stdin.take();
        let (sender, first_line) = mpsc::channel();
        if let Some(stdout) = child.stdout.take() {
            thread::spawn(move || {
                for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                    // Only the first line is used; the other lines are read so that the child never blocks.
                    let _ = sender.send(line);
                }
            });
        }
        Ok(Running { child, stdin, since: Instant::now(), first_line })
    }

    fn plan_restart(&mut self, status: ExitStatus, lived: Duration) -> Result<(), Failure> {
        if status.code() == Some(2) {
            return Err(Failure::usage(texts::cannot_run_as_asked(self.role.name())));
        }
        if lived >= CONFIG.healthy_after {
            self.pause = Duration::ZERO;
        }
        self.start_at = Instant::now() + self.pause;
        output::print_note(&texts::process_restarts(self.role.name(), &status, self.pause));
        self.pause = (self.pause * 2).clamp(CONFIG.first_pause, CONFIG.pause_max);
        Ok(())
    }

    fn first_line(&self) -> Option<String> {
        self.running.as_ref().and_then(|running| running.first_line.try_recv().ok())
    }

    /// Requests the process to stop and waits; kills it after the timeout.
    fn end(&mut self) {
        let Some(Running { mut child, stdin, .. }) = self.running.take() else {
            return;
        };
        drop(stdin);
        let deadline = Instant::now() + CONFIG.stop_timeout;
        while Instant::now() < deadline {
            match child.try_wait() {
                Ok(None) => thread::sleep(CONFIG.poll_interval),
                // It has ended, or the system does not know its state.
                Ok(Some(_)) | Err(_) => return,
            }
        }
        output::print_note(&texts::process_killed(self.role.name()));
        let _ = child.kill();
        let _ = child.wait();
    }
}
