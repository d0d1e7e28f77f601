//! One supervised process: it is started, listened to, and started again when it has ended or does not answer.

use super::child_report::ChildReport;
use super::role::ProcessRole;
use crate::failure::Failure;
use crate::{output, texts};
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// Parameters of a [`Process`].
#[derive(Clone, Copy, Debug)]
struct ProcessConfig {
    /// Longest time for an orderly stop, which may be saving a map. Chosen: a large map takes some seconds to write; systemd waits for 90 s by default.
    stop_timeout: Duration,
    /// Time between checks whether a process has stopped. Chosen: nobody notices it, and it costs nothing.
    poll_interval: Duration,
    /// Pause before the second restart in a row; the first one has none. Chosen: what a killed process held, such as its socket, is free by then.
    first_pause: Duration,
    /// Longest pause before a restart. Pauses double up to this. Chosen: people who have mended the cause wait no longer than that.
    max_pause: Duration,
    /// A process that ran for this time is healthy: its next restart has no pause. Chosen: three times [`Self::max_pause`].
    healthy_after: Duration,
    /// A process that gives no heartbeat for this time hangs. It is killed and started again. Chosen: ten heartbeats, two a second. Less kills processes on a busy disk,
    /// more leaves a robot without its core for longer.
    max_silence: Duration,
    /// The same from its start to its first heartbeat: the core reads all saved maps then, and the simulated robot builds its site. Chosen: longer than both take on a
    /// slow computer.
    max_start: Duration,
    /// Longest silence that counts between two checks: after the computer was suspended, heartbeats of that time are missing. Chosen: five checks
    /// ([`Self::poll_interval`]).
    max_check_gap: Duration,
    /// Lines of a process that wait to be read. Further ones are dropped. Chosen: what a process says at a time is some lines.
    max_queued_lines: usize,
}

const CONFIG: ProcessConfig = ProcessConfig {
    stop_timeout: Duration::from_secs(30),
    poll_interval: Duration::from_millis(50),
    first_pause: Duration::from_millis(250),
    max_pause: Duration::from_secs(10),
    healthy_after: Duration::from_secs(30),
    max_silence: Duration::from_secs(5),
    max_start: Duration::from_secs(120),
    max_check_gap: Duration::from_millis(250),
    max_queued_lines: 64,
};

/// Exit code of a process whose arguments cannot work.
const EXIT_USAGE: i32 = 2;
/// Exit code of a Rust program whose main thread panicked.
const EXIT_PANIC: i32 = 101;

/// One process, which runs or waits for its start.
pub struct Process {
    role: ProcessRole,
    arguments: Vec<String>,
    running: Option<Running>,
    start_at: Instant,
    pause: Duration,
    /// How often it was started again.
    restarts: u32,
    /// Why it was started again last: a clause after its name.
    cause: String,
}

struct Running {
    child: Child,
    stdin: Option<ChildStdin>,
    since: Instant,
    reports: Receiver<ChildReport>,
    /// The address that it listens on, if it says so.
    address: Option<SocketAddr>,
    /// Whether it has given a heartbeat.
    has_answered: bool,
    silence: Duration,
    last_check: Instant,
    /// Why it will end, as it says itself.
    failure: Option<String>,
}

impl Process {
    pub fn new(role: ProcessRole, arguments: Vec<String>) -> Self {
        Self {
            role,
            arguments,
            running: None,
            start_at: Instant::now(),
            pause: Duration::ZERO,
            restarts: 0,
            cause: String::new(),
        }
    }

    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// The address that the running process listens on, once it has said so.
    pub fn address(&self) -> Option<SocketAddr> {
        self.running.as_ref()?.address
    }

    /// How often and why this process was started again, as arguments of a process; none if it was not.
    pub fn restart_arguments(&self, prefix: &str) -> Vec<String> {
        match self.restarts {
            0 => Vec::new(),
            count => vec![format!("{prefix}-count={count}"), format!("{prefix}-cause={}", self.cause)],
        }
    }

    /// Starts the process if it is not running, and plans its restart if it has ended or does not answer.
    ///
    /// # Errors
    /// When it cannot be started. Also when it ends because its arguments cannot work, before the platform `was_ready` for the first time; later that is
    /// one failure among others.
    pub fn keep_running(&mut self, more: &[String], was_ready: bool) -> Result<(), Failure> {
        let Some(running) = &mut self.running else {
            if Instant::now() >= self.start_at {
                self.running = Some(self.start(more)?);
            }
            return Ok(());
        };
        running.read_reports();
        let ended = match running.child.try_wait().map_err(Failure::failed)? {
            Some(status) => {
                // What it said last.
                running.read_reports();
                Some((status, running.failure.take()))
            }
            None => match running.exceeded_silence() {
                // A process that has said why it ends, and takes too long for it, ends for that cause.
                Some(limit) => {
                    let status = running.kill()?;
                    Some((status, running.failure.take().or_else(|| Some(texts::did_not_answer(limit)))))
                }
                None => None,
            },
        };
        if let Some((status, failure)) = ended {
            if status.code() == Some(EXIT_USAGE) && !was_ready {
                return Err(Failure::usage(texts::cannot_run_as_asked(self.role.name())));
            }
            let lived = running.since.elapsed();
            self.running = None;
            self.plan_restart(failure.unwrap_or_else(|| cause_of(status)), lived);
        }
        Ok(())
    }

    fn start(&self, more: &[String]) -> Result<Running, Failure> {
        let program = std::env::current_exe().map_err(Failure::failed)?;
        let mut command = Command::new(program);
        command.args(&self.arguments).args(more).stdin(Stdio::piped()).stdout(Stdio::piped());
        command.arg("--heartbeats").args(self.restart_arguments("--restart"));
        let mut child = command
            .spawn()
            .map_err(|error| Failure::failed(texts::cannot_start(self.role.name(), &error)))?;
        let stdin = child.stdin.take();
        let (sender, reports) = mpsc::sync_channel(CONFIG.max_queued_lines);
        if let Some(stdout) = child.stdout.take() {
            thread::spawn(move || {
                // Read to the end, so that the child never blocks.
                for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                    if let Some(report) = ChildReport::from_line(&line) {
                        let _ = sender.try_send(report);
                    }
                }
            });
        }
        let now = Instant::now();
        Ok(Running {
            child,
            stdin,
            since: now,
            reports,
            address: None,
            has_answered: false,
            silence: Duration::ZERO,
            last_check: now,
            failure: None,
        })
    }

    fn plan_restart(&mut self, cause: String, lived: Duration) {
        if lived >= CONFIG.healthy_after {
            self.pause = Duration::ZERO;
        }
        self.start_at = Instant::now() + self.pause;
        output::print_note(&texts::process_restarts(self.role.name(), &cause, self.pause));
        self.pause = (self.pause * 2).clamp(CONFIG.first_pause, CONFIG.max_pause);
        self.restarts += 1;
        self.cause = cause;
    }

    /// Requests the process to stop and waits; kills it after the timeout.
    pub fn end(&mut self) {
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

impl Running {
    fn read_reports(&mut self) {
        for report in self.reports.try_iter() {
            match report {
                ChildReport::Address(address) => self.address = Some(address),
                ChildReport::Alive => (self.has_answered, self.silence) = (true, Duration::ZERO),
                // The first one is the cause of further ones.
                ChildReport::Failed(cause) => _ = self.failure.get_or_insert(cause),
            }
        }
    }

    /// Counts the silence since the last check. Returns the limit, if it is exceeded.
    fn exceeded_silence(&mut self) -> Option<Duration> {
        let now = Instant::now();
        self.silence += (now - self.last_check).min(CONFIG.max_check_gap);
        self.last_check = now;
        let limit = if self.has_answered { CONFIG.max_silence } else { CONFIG.max_start };
        (self.silence > limit).then_some(limit)
    }

    fn kill(&mut self) -> Result<ExitStatus, Failure> {
        self.child.kill().and_then(|()| self.child.wait()).map_err(Failure::failed)
    }
}

/// Why a process ended that did not say it itself: a clause after its name.
fn cause_of(status: ExitStatus) -> String {
    match (status.code(), status.signal()) {
        (Some(EXIT_PANIC), _) => texts::PANICKED.to_owned(),
        (Some(code), _) => texts::ended_with_code(code),
        (None, signal) => texts::was_killed(signal.unwrap_or_default()),
    }
}
