//! Limits of an import, an alignment and a comparison: memory and processor time. The work is done in a child process with these limits, so that its parent can say
//! which one it has reached. None may take the memory that the robot's core needs.

use crate::failure::Failure;
use crate::limited_command::{Limit, LimitedCommand};
use crate::texts;
use clap::Args;
use rustix::process::{Resource, Rlimit, Signal, setrlimit};
use std::env;
use std::os::unix::process::ExitStatusExt;
use std::process::{Command, ExitStatus};

/// First option of the process that does the work.
pub const WITHIN_LIMITS: &str = "--within-limits";

/// Allowances beside the limits that people give.
struct ProcessLimitConfig {
    /// Memory that the system's limit does not count, bytes: the program's code, of which some 30 MB are in use. Chosen: half more.
    code_bytes: u64,
    /// Time between the signal at the limit of processor time and the end by force, seconds. Chosen: long enough to write a sentence and remove files.
    grace_s: u64,
}

const CONFIG: ProcessLimitConfig = ProcessLimitConfig { code_bytes: 48 << 20, grace_s: 5 };

/// Options of a command that limit it.
#[derive(Args, Clone, Copy, Debug)]
pub struct ProcessLimits {
    /// Most memory, MB.
    #[arg(long, value_name = "MB", default_value_t = 512, value_parser = clap::value_parser!(u64).range(64..=1 << 20))]
    max_memory: u64,
    /// Most processor time, minutes.
    #[arg(long, value_name = "MINUTES", default_value_t = 20.0, value_parser = parse_minutes)]
    max_minutes: f64,
    /// This process is the one that does the work.
    #[arg(long, hide = true)]
    within_limits: bool,
}

fn parse_minutes(text: &str) -> Result<f64, String> {
    let minutes: f64 = text.parse().map_err(|_| texts::MINUTES_EXPECTED.to_owned())?;
    if (0.01..=10_000.0).contains(&minutes) { Ok(minutes) } else { Err(texts::MINUTES_EXPECTED.to_owned()) }
}

impl ProcessLimits {
    /// In the process that the user or the core has started, runs the same command in a child within the limits and returns its result. In that child, sets
    /// the limits and returns none.
    pub fn enter(&self, command: LimitedCommand) -> Option<Result<(), Failure>> {
        if !self.within_limits {
            return Some(self.run_child(command));
        }
        self.limit_this_process();
        None
    }

    /// If the system refuses a limit, the command runs without it.
    fn limit_this_process(&self) {
        let limit = |resource, current: u64, maximum: u64| {
            let _ = setrlimit(resource, Rlimit { current: Some(current), maximum: Some(maximum) });
        };
        let memory_bytes = (self.max_memory << 20) - CONFIG.code_bytes;
        let cpu_s = (60.0 * self.max_minutes).ceil() as u64;
        limit(Resource::Data, memory_bytes, memory_bytes);
        limit(Resource::Cpu, cpu_s, cpu_s + CONFIG.grace_s);
        // The system would write a file of the size of its memory when it ends the process.
        limit(Resource::Core, 0, 0);
        #[cfg(target_os = "linux")]
        let _ = rustix::process::set_parent_process_death_signal(Some(Signal::KILL));
    }

    fn run_child(&self, command: LimitedCommand) -> Result<(), Failure> {
        let program = env::current_exe().map_err(Failure::failed)?;
        // The first two arguments are the program and the name of the command.
        let mut child = Command::new(program);
        child.arg(command.name()).arg(WITHIN_LIMITS).args(env::args_os().skip(2));
        // The backtrace of the failed allocation would not help a person.
        child.env("RUST_BACKTRACE", "0");
        let status = child.status().map_err(Failure::failed)?;
        match (status.code(), limit_reached(status)) {
            (Some(0), _) => Ok(()),
            (_, Some(Limit::Memory)) => Err(Failure::Failed(texts::out_of_memory(command, self.max_memory))),
            (_, Some(Limit::Time)) => Err(Failure::Failed(texts::out_of_time(command, self.max_minutes))),
            // It has said why.
            (Some(1 | 2), None) => Err(Failure::Reported { usage: status.code() == Some(2) }),
            (_, None) => Err(Failure::Failed(texts::limited_command_ended(command, &status))),
        }
    }
}

/// The limit by which a process that ran within limits has ended.
pub fn limit_reached(status: ExitStatus) -> Option<Limit> {
    match Signal::from_named_raw(status.signal()?)? {
        Signal::XCPU => Some(Limit::Time),
        // Rust aborts when it gets no memory. The system kills when it has none.
        Signal::ABORT | Signal::KILL => Some(Limit::Memory),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_signal_says_which_limit_was_reached() {
        let ended_by = |signal: Signal| limit_reached(ExitStatus::from_raw(signal.as_raw()));
        assert_eq!(ended_by(Signal::XCPU), Some(Limit::Time));
        assert_eq!(ended_by(Signal::ABORT), Some(Limit::Memory));
        assert_eq!(ended_by(Signal::TERM), None);
        // An exit code.
        assert_eq!(limit_reached(ExitStatus::from_raw(2 << 8)), None);
        let sentence = texts::out_of_memory(LimitedCommand::Align, 512);
        assert!(sentence.starts_with("the alignment needs more than 512 MB of memory"), "{sentence}");
        for text in ["0", "nan", "-1", "x"] {
            assert!(parse_minutes(text).is_err(), "{text}");
        }
    }
}
