//! A running `autoinspect up` with its own data folder, which ends when dropped.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

use super::chromium::LAN_HOST;
use super::program::autoinspect;
use super::{wait_for, workspace_root};

/// Longest wait for the start, which includes building the simulated site on a machine that may be busy.
const START_LIMIT: Duration = Duration::from_secs(60);
const STOP_LIMIT: Duration = Duration::from_secs(20);

/// The text that the server prints before its address, once it can be reached.
const READY: &str = "AutoInspect is running: http://";

pub struct Server {
    process: Child,
    pub port: u16,
}

impl Server {
    /// Starts a server with the simulated site `site` and waits until it prints its address.
    pub fn start(site: &str, data: &Path) -> Self {
        Self::start_with(site, data, &[])
    }

    /// As [`Self::start`], with further arguments.
    pub fn start_with(site: &str, data: &Path, more: &[&str]) -> Self {
        Self::launch(site, data, &[&["--demo"], more].concat())
    }

    /// As [`Self::start`], for people who sign in.
    pub fn start_with_accounts(site: &str, data: &Path) -> Self {
        Self::launch(site, data, &[])
    }

    fn launch(site: &str, data: &Path, more: &[&str]) -> Self {
        let mut process = Command::new(autoinspect())
            .args(["up", "--allow-host", LAN_HOST, "--robot", &format!("sim:{site}")])
            .args(["--listen", "127.0.0.1:0", "--data"])
            .arg(data)
            .arg("--static")
            .arg(workspace_root().join("static"))
            .args(more)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let output = BufReader::new(process.stdout.take().unwrap());
        let (sender, lines) = mpsc::channel();
        // Reads to the end also without a receiver, because a full pipe would block the server.
        std::thread::spawn(move || {
            output.lines().map_while(Result::ok).for_each(|line| drop(sender.send(line)))
        });
        let mut server = Self { process, port: 0 };
        let address = wait_for("the server's address", START_LIMIT, || {
            let ended = server.process.try_wait().unwrap();
            assert!(ended.is_none(), "the server ended by itself: {}", ended.unwrap());
            lines.try_iter().find_map(|line| line.strip_prefix(READY).map(str::to_owned))
        });
        server.port = address.rsplit(':').next().unwrap().trim_end_matches('/').parse().unwrap();
        server
    }

    /// The address on this machine, which browsers treat as a trusted origin.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Stops the server with the signal of a service manager, and waits for its end.
    pub fn stop(mut self) {
        terminate(&self.process);
        let status = wait_for("the server's end", STOP_LIMIT, || self.process.try_wait().unwrap());
        assert!(status.success(), "the server ended with {status}");
    }
}

fn terminate(process: &Child) {
    let asked = Command::new("kill").args(["-TERM", &process.id().to_string()]).status();
    assert!(asked.is_ok_and(|status| status.success()), "could not signal the server");
}

impl Drop for Server {
    fn drop(&mut self) {
        // After a failed test. Its child processes end by themselves when it is gone.
        if matches!(self.process.try_wait(), Ok(None)) {
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}
