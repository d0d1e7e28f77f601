//! Reads a password: from the terminal without showing it, or from standard input.

use crate::texts;
use rustix::termios::{LocalModes, OptionalActions, tcgetattr, tcsetattr};
use std::io::{self, BufRead, IsTerminal, Write};

/// A password for this account.
///
/// # Errors
/// When standard input cannot be read.
pub fn read(account: &str) -> io::Result<String> {
    let input = io::stdin();
    if !input.is_terminal() {
        return line();
    }
    write!(io::stderr(), "{}", texts::password_prompt(account))?;
    let shown = tcgetattr(&input)?;
    let mut hidden = shown.clone();
    hidden.local_modes.remove(LocalModes::ECHO);
    tcsetattr(&input, OptionalActions::Flush, &hidden)?;
    let password = line();
    tcsetattr(&input, OptionalActions::Now, &shown)?;
    writeln!(io::stderr())?;
    password
}

fn line() -> io::Result<String> {
    let mut line = String::new();
    io::stdin().lock().read_line(&mut line)?;
    Ok(line.trim_end_matches(['\r', '\n']).to_owned())
}
