//! The `autoinspect` program: one binary that runs the platform (`up`) and has further commands, which need no robot.
//!
//! Standard output has results only; with `--json` its last line is one JSON object. Progress and errors go to
//! standard error. Exit codes: 0 done, 1 failed, 2 bad usage or unreadable input.

mod account;
mod align;
mod calibration;
mod changes;
mod cli;
mod convert;
mod example;
mod export;
mod failure;
mod gauge;
mod import;
mod info;
mod inputs;
mod journal;
mod keyframe_descriptors;
mod limited_command;
mod localise;
mod make_normal;
mod map;
mod map_version;
mod merge;
mod optimise;
mod output;
mod patch;
mod picture_changes;
mod picture_file;
mod process;
mod process_limits;
mod progress;
mod replay;
mod robot;
mod robot_file;
mod sim_record;
mod site;
mod site_changes;
mod summaries;
#[cfg(test)]
mod test_data;
mod texts;
mod topomap;
mod trajectory;
mod up;
mod verify;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = cli::Cli::parse();
    output::start_logging();
    match cli.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if let Some(sentence) = failure.sentence() {
                output::print_error(sentence);
            }
            failure.exit_code()
        }
    }
}
