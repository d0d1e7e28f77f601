//! A running `autoinspect up`, with a data folder of its own, ended when dropped.

use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::program::autoinspect;
use super::{wait_for, workspace_root};

/// Starting includes building the simulated site's ray-casting structure, on a machine that may be busy.
const START_LIMIT: Duration = Duration::from_secs(60);
const STOP_LIMIT: Duration = Duration::from_secs(20);

pub struct Server {
    process: Child,
    pub port: u16,
}

impl Server {
    /// Starts a server with the simulated site `site` and waits until it takes connections.
    pub fn start(site: &str, data: &Path) -> Self {
        let port = free_port();
        let process = Command::new(autoinspect())
            .args(["up", "--robot", &format!("sim:{site}"), "--listen", &format!("127.0.0.1:{port}"), "--data"])
            .arg(data)
            .current_dir(workspace_root())
            .stdin(Stdio::null())
            .spawn()
            .unwrap();
        let mut server = Self { process, port };
        wait_for("the server to take connections", START_LIMIT, || {
            let ended = server.process.try_wait().unwrap();
            assert!(ended.is_none(), "the server ended by itself: {}", ended.unwrap());
            TcpStream::connect((Ipv4Addr::LOCALHOST, port)).ok()
        });
        server
    }

    /// Asks the server to stop, as a service manager would, and waits for it.
    pub fn stop(mut self) {
        self.terminate();
        let status = wait_for("the server's orderly end", STOP_LIMIT, || self.process.try_wait().unwrap());
        assert!(status.success(), "the server ended with {status}");
    }

    fn terminate(&self) {
        let asked = Command::new("kill").args(["-TERM", &self.process.id().to_string()]).status();
        assert!(asked.is_ok_and(|status| status.success()), "could not signal the server");
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        if matches!(self.process.try_wait(), Ok(None)) {
            // Its children end with it when it is asked first; a plain kill is for one that no longer listens.
            let _ = Command::new("kill").args(["-TERM", &self.process.id().to_string()]).status();
            let started = std::time::Instant::now();
            while matches!(self.process.try_wait(), Ok(None)) && started.elapsed() < STOP_LIMIT {
                std::thread::sleep(Duration::from_millis(40));
            }
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}

/// A port nobody uses just now.
pub fn free_port() -> u16 {
    TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap().local_addr().unwrap().port()
}
