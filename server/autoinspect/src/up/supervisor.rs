//! Keeps core and gateway running.
//!
//! A process that ends is started again at once; if it keeps ending, after a pause that doubles each time and is forgotten
//! after a while of health. One that ends with exit code 2 was asked for something impossible (an address in use, a
//! broken file): then all ends, since trying again would not help.
//!
//! Children read their standard input and stop when it ends. Closing it is how they are told to stop, and it closes
//! by itself if this process dies: no orphan keeps walking a robot.

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

/// Time between looks at the children.
const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// Longest time that a child may take to stop in order: a map may be being saved.
const GRACE: Duration = Duration::from_secs(30);
/// Longest time that the gateway waits for the core to listen for the first time.
const CORE_START_MAX: Duration = Duration::from_secs(3);
const PAUSE_FIRST: Duration = Duration::from_millis(250);
const PAUSE_MAX: Duration = Duration::from_secs(10);
/// A child that lived so long is healthy.
const HEALTHY_AFTER: Duration = Duration::from_secs(30);

/// The two processes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Core,
    Gateway,
}

/// One process, running or about to.
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
    said: Receiver<String>,
}

/// Both of them.
pub struct Supervisor {
    core: Process,
    gateway: Process,
    listen: SocketAddr,
    /// Where the core listens for the gateway.
    socket: PathBuf,
    /// The gateway is not started before the core listens, or this has come: its errors would mean nothing.
    gateway_at: Instant,
    /// What the gateway really listens on, once known.
    bound: Option<SocketAddr>,
    ready: bool,
}

impl Supervisor {
    /// For these arguments; the gateway's `--listen` is added. The core will listen at `socket`.
    pub fn new(core: Vec<String>, gateway: Vec<String>, listen: SocketAddr, socket: PathBuf) -> Self {
        Self {
            core: Process::new(Role::Core, core),
            gateway: Process::new(Role::Gateway, gateway),
            listen,
            socket,
            gateway_at: Instant::now() + CORE_START_MAX,
            bound: None,
            ready: false,
        }
    }

    /// Runs both until `stop`. Tells `on_ready` the address once, when a browser can use it.
    pub fn run(&mut self, stop: &Stop, on_ready: impl Fn(SocketAddr)) -> Result<(), Failure> {
        let outcome = loop {
            if let Err(failure) = self.look(&on_ready) {
                break Err(failure);
            }
            if stop.wait(POLL_INTERVAL) {
                break Ok(());
            }
        };
        // The gateway first, so that browsers see the end of the connection and not of the robot.
        self.gateway.end();
        self.core.end();
        outcome
    }

    fn look(&mut self, on_ready: &impl Fn(SocketAddr)) -> Result<(), Failure> {
        // A gateway that comes back must be where browsers look for it.
        let listen = self.bound.unwrap_or(self.listen).to_string();
        self.core.keep_running(&[])?;
        if self.gateway.running.is_some() || self.socket.exists() || Instant::now() >= self.gateway_at {
            self.gateway.keep_running(&["--listen", &listen])?;
        }
        if let Some(line) = self.gateway.heard()
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

    /// Starts it if it is not running, and looks whether it has ended.
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
        let (sender, said) = mpsc::channel();
        if let Some(stdout) = child.stdout.take() {
            thread::spawn(move || {
                for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                    // Only the first line is waited for; the rest is read so that the child never blocks.
                    let _ = sender.send(line);
                }
            });
        }
        Ok(Running { child, stdin, since: Instant::now(), said })
    }

    fn plan_restart(&mut self, status: ExitStatus, lived: Duration) -> Result<(), Failure> {
        if status.code() == Some(2) {
            return Err(Failure::usage(texts::cannot_run_as_asked(self.role.name())));
        }
        if lived >= HEALTHY_AFTER {
            self.pause = Duration::ZERO;
        }
        self.start_at = Instant::now() + self.pause;
        output::print_note(&format!(
            "the {} ended ({status}) and is started again{}",
            self.role.name(),
            if self.pause.is_zero() {
                String::new()
            } else {
                format!(" in {:.1} s", self.pause.as_secs_f64())
            }
        ));
        self.pause = (self.pause * 2).clamp(PAUSE_FIRST, PAUSE_MAX);
        Ok(())
    }

    fn heard(&self) -> Option<String> {
        self.running.as_ref().and_then(|running| running.said.try_recv().ok())
    }

    /// Tells it to stop, and waits; kills it if it takes too long.
    fn end(&mut self) {
        let Some(Running { mut child, stdin, .. }) = self.running.take() else {
            return;
        };
        drop(stdin);
        let deadline = Instant::now() + GRACE;
        while Instant::now() < deadline {
            match child.try_wait() {
                Ok(None) => thread::sleep(POLL_INTERVAL),
                // Ended, or cannot be asked any more.
                Ok(Some(_)) | Err(_) => return,
            }
        }
        output::print_note(&format!("the {} does not stop and is killed", self.role.name()));
        let _ = child.kill();
        let _ = child.wait();
    }
}
