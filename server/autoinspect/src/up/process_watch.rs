//! Watches the threads of a supervised process, and tells its supervisor that it works, or why it ends.

use super::child_report::ChildReport;
use crate::failure::Failure;
use crate::{output, texts};
use api::{ProcessRestart, ProcessRole};
use clap::Args;
use crossbeam_channel::{Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;
use watchdog::{BEAT_PERIOD, FaultInjection, ThreadFailure, Watchdog};

/// Parameters of [`watch_process`].
#[derive(Clone, Copy, Debug)]
struct ProcessWatchConfig {
    /// Time between two reports to the supervisor, which has patience for ten of them. Chosen: a tenth of that patience, 5 s.
    report_period: Duration,
    /// Longest time for an orderly end after a thread has failed: what waits for the disk is written. Then the process ends all the same. Chosen: less than that
    /// patience.
    end_timeout: Duration,
}

const CONFIG: ProcessWatchConfig =
    ProcessWatchConfig { report_period: Duration::from_millis(500), end_timeout: Duration::from_secs(3) };

/// Environment variable with the folder in which tests ask for faults of threads, see [`FaultInjection`].
const FAULTS: &str = "AUTOINSPECT_TEST_FAULTS";

/// How a process is supervised.
#[derive(Args, Clone, Debug)]
pub struct SupervisionArgs {
    /// Print a heartbeat on standard output twice a second.
    #[arg(long, hide = true)]
    heartbeats: bool,
    /// Why the process was started again.
    #[arg(long, hide = true)]
    restart_cause: Option<String>,
    /// How often it was started again.
    #[arg(long, hide = true, default_value_t = 1)]
    restart_count: u32,
}

impl SupervisionArgs {
    /// Tells the supervisor, if there is one.
    pub fn report(&self, report: &ChildReport) {
        if self.heartbeats {
            output::print_line(&report.to_string());
        }
    }

    /// Whether this process was started again for this cause.
    pub fn was_restarted_because(&self, cause: &str) -> bool {
        self.restart_cause.as_deref() == Some(cause)
    }

    /// Why this process was started again, if it was.
    pub fn restart(&self, process: ProcessRole) -> Option<ProcessRestart> {
        let cause = self.restart_cause.clone()?;
        Some(ProcessRestart { process, cause, count: self.restart_count })
    }
}

/// The watchdog of this process.
pub fn watchdog() -> Watchdog {
    Watchdog::new(FaultInjection::from_folder(std::env::var_os(FAULTS).map(Into::into)))
}

/// The error of a process that ends because a thread failed.
pub fn thread_failed(failure: Option<ThreadFailure>) -> Failure {
    let cause = failure.map_or_else(|| texts::PANICKED.to_owned(), |failure| failure.to_string());
    Failure::failed(texts::process_failed(&cause))
}

/// Watches the threads from a thread of its own. Heartbeats are printed while the thread named `main` gives its own, so that a process whose main thread
/// hangs is silent. The first failure of a thread is printed and returned; the process is to end then, and is ended after a while if it does not.
///
/// # Errors
/// When no thread can be started.
pub fn watch_process(
    watchdog: &Watchdog,
    main: &'static str,
    args: &SupervisionArgs,
) -> Result<Receiver<ThreadFailure>, Failure> {
    let (failed, failure) = crossbeam_channel::bounded(1);
    let (watchdog, supervision) = (watchdog.clone(), args.clone());
    let watch = move || {
        let failures = watchdog.failures();
        loop {
            match failures.recv_timeout(CONFIG.report_period) {
                Ok(failure) => {
                    supervision.report(&ChildReport::Failed(failure.to_string()));
                    let _ = failed.try_send(failure);
                    thread::sleep(CONFIG.end_timeout);
                    std::process::exit(1);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            watchdog.check();
            if watchdog.silence_of(main).is_some_and(|silence| silence <= BEAT_PERIOD) {
                supervision.report(&ChildReport::Alive);
            }
        }
    };
    thread::Builder::new().name("watchdog".to_owned()).spawn(watch).map_err(Failure::failed)?;
    Ok(failure)
}
