//! The `autoinspect` program: finding it, and running it to its end.

use std::ffi::OsStr;
use std::io::Read;
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

use super::{wait_for, workspace_root};

/// The program under test: `AUTOINSPECT_BIN`, else the newest of what cargo built beside this test.
pub fn autoinspect() -> PathBuf {
    if let Some(named) = std::env::var_os("AUTOINSPECT_BIN") {
        return named.into();
    }
    // This test is at target/PROFILE/deps/all-HASH.
    let test = std::env::current_exe().unwrap();
    let target = test.ancestors().nth(3).unwrap();
    let built = ["release", "debug"].map(|profile| target.join(profile).join("autoinspect"));
    built
        .into_iter()
        .filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path)))
        .max()
        .map(|(_, path)| path)
        .unwrap_or_else(|| panic!("no autoinspect below {}; `cargo build -p autoinspect` first", target.display()))
}

/// How a run of the program ended, and what it said.
pub struct Run {
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

/// Runs `autoinspect` with `arguments`; fails when it takes longer than `limit`.
#[track_caller]
pub fn run<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>, limit: Duration) -> Run {
    let mut child = Command::new(autoinspect())
        .args(arguments)
        .current_dir(workspace_root())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Read both while waiting: a full pipe would stop the program.
    let stdout = read_aside(child.stdout.take().unwrap());
    let stderr = read_aside(child.stderr.take().unwrap());
    let status = wait_for("the program's end", limit, || child.try_wait().unwrap());
    Run { status, stdout: stdout.join().unwrap(), stderr: stderr.join().unwrap() }
}

fn read_aside(mut pipe: impl Read + Send + 'static) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.read_to_end(&mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    })
}
