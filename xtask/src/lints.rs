//! Lints while compiling: clippy's driver is a compiler that also lints, so that code that is compiled anyway is not analysed a second time by `cargo clippy`.
//!
//! Lints are warnings here, and no errors: the tests run on what was compiled, also if a lint failed.

use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::shell;

const DRIVER: &str = "clippy-driver";

/// Which compiler compiles the packages of the workspace.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Compiler {
    /// The plain one.
    Plain,
    /// Clippy's driver. It makes the same code but for one thing: optimisations before LLVM are off.
    Linting,
}

impl Compiler {
    /// The linting compiler, where it is installed.
    pub(crate) fn linting() -> Option<Self> {
        shell::on_path(DRIVER).then_some(Self::Linting)
    }

    /// Makes `cargo` compile with it. Commands with the same compiler use each other's outputs.
    pub(crate) fn compiles(self, cargo: &mut Command) -> &mut Command {
        match self {
            Self::Plain => cargo,
            Self::Linting => cargo.env("RUSTC_WORKSPACE_WRAPPER", DRIVER),
        }
    }
}

/// Compiles with the linting compiler. `cargo` is a command that compiles and does not run anything.
///
/// # Errors
/// When it does not compile, and when there were warnings; both are printed.
pub(crate) fn compile(cargo: impl Fn() -> Command) -> Result<()> {
    shell::run(Compiler::Linting.compiles(&mut cargo()))?;
    // Everything is compiled; cargo repeats the warnings, this time as JSON, a line each.
    let mut repeated = cargo();
    repeated.args(["--quiet", "--message-format=json"]).stderr(Stdio::null());
    let output = Compiler::Linting.compiles(&mut repeated).output().context("could not start cargo")?;
    match warnings(&String::from_utf8_lossy(&output.stdout)) {
        0 => Ok(()),
        1 => bail!("one warning of the compiler or clippy, printed above"),
        count => bail!("{count} warnings of the compiler and clippy, printed above"),
    }
}

/// Warnings among cargo's messages.
fn warnings(messages: &str) -> usize {
    let is_warning = |line: &&str| {
        line.starts_with(r#"{"reason":"compiler-message""#) && line.contains(r#""level":"warning""#)
    };
    messages.lines().filter(is_warning).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_are_counted_among_other_messages() {
        let messages = r#"{"reason":"compiler-artifact","package_id":"a","fresh":true}
{"reason":"compiler-message","package_id":"a","message":{"rendered":"warning: unused","level":"warning","code":null}}
{"reason":"compiler-message","package_id":"a","message":{"rendered":"note: \"level\":\"warning\"","level":"note"}}
{"reason":"build-finished","success":true}"#;
        assert_eq!(warnings(messages), 1);
    }
}
