//! Standard output and standard error of the program.

use crate::failure::Failure;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::io::{self, IsTerminal, Write};
use tracing_subscriber::EnvFilter;

/// Logs to standard error, at the level of `RUST_LOG`; without it, warnings and errors.
pub fn start_logging() {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("warn"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .with_target(false)
        .init();
}

/// Prints the error of a command on standard error.
pub fn print_error(sentence: &str) {
    // Fails only if standard error is closed.
    let _ = writeln!(io::stderr(), "error: {sentence}");
}

/// Prints a note on standard error.
pub fn print_note(sentence: &str) {
    let _ = writeln!(io::stderr(), "{sentence}");
}

/// Prints a result for people, unless JSON is wanted.
pub fn print_human(json: bool, text: &str) {
    if !json {
        print_line(text);
    }
}

/// Prints a result as one line of JSON, if wanted.
pub fn print_json(json: bool, result: &impl Serialize) -> Result<(), Failure> {
    if json {
        print_line(&serde_json::to_string(result).map_err(Failure::failed)?);
    }
    Ok(())
}

/// Prints a line on standard output and flushes it, because a program may wait for it at a pipe. An error means a closed pipe and is ignored.
pub fn print_line(text: &str) {
    let _ = try_line(text);
}

/// [`print_line`] with an error if the reader has closed the pipe.
pub fn try_line(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "{text}").and_then(|()| out.flush())
}

/// A progress bar on standard error from 0 to 1000; hidden if standard error is not a terminal.
pub fn share_bar(doing: &'static str) -> ProgressBar {
    let bar = progress_bar(1e3);
    bar.set_style(
        ProgressStyle::with_template("{wide_bar} {percent} %  {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    bar.set_message(doing);
    bar
}

/// A progress bar on standard error for `total` seconds of recording; hidden if standard error is not a terminal.
pub fn progress_bar(total: f64) -> ProgressBar {
    let target = if io::stderr().is_terminal() {
        ProgressDrawTarget::stderr_with_hz(5)
    } else {
        ProgressDrawTarget::hidden()
    };
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} s  {msg}");
    let bar = ProgressBar::with_draw_target(Some(total.max(0.0).ceil() as u64), target);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
