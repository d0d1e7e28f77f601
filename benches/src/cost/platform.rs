//! A running `autoinspect up`: its requests over HTTP, and the processor times of its processes.

use anyhow::{Context, Result, bail, ensure};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Roles of the processes that are measured.
pub const PROCESSES: [&str; 3] = ["core", "gateway", "simulated-robot"];
/// The text before the address, once the platform can be reached.
const READY: &str = "AutoInspect is running: http://";
/// Time between two looks at the progress of the example.
const PERIOD: Duration = Duration::from_secs(1);

/// A platform, which is stopped when dropped.
pub struct MeasuredPlatform {
    process: Child,
    address: SocketAddr,
    /// Of [`PROCESSES`].
    ids: [u32; 3],
}

impl MeasuredPlatform {
    /// Starts a platform with a simulated robot and waits until it can be reached.
    pub fn start(site: &str, data: &Path, listen: &str, columns: &str) -> Result<Self> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let mut process = Command::new(root.join("target/release/autoinspect"))
            .args([
                "up",
                "--demo",
                "--robot",
                &format!("sim:{site}"),
                "--listen",
                listen,
                "--lidar-columns",
                columns,
            ])
            .arg("--static")
            .arg(root.join("static"))
            .arg("--data")
            .arg(data)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .context("target/release/autoinspect cannot be started; cargo xtask bench builds it")?;
        let mut line = String::new();
        BufReader::new(process.stdout.take().context("piped")?).read_line(&mut line)?;
        let address = line.trim().trim_end_matches('/').strip_prefix(READY).map(str::parse);
        let Some(Ok(address)) = address else {
            let _ = process.kill();
            bail!("the platform has not started: it said '{}'", line.trim());
        };
        let mut platform = Self { process, address, ids: [0; 3] };
        let ids = PROCESSES.map(|role| platform.child(role));
        for (id, found) in platform.ids.iter_mut().zip(ids) {
            *id = found?;
        }
        Ok(platform)
    }

    /// Its address.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The child process with this role.
    fn child(&self, role: &str) -> Result<u32> {
        let id = self.process.id();
        let children = std::fs::read_to_string(format!("/proc/{id}/task/{id}/children"))?;
        let has_role = |child: &u32| {
            let command = std::fs::read(format!("/proc/{child}/cmdline")).unwrap_or_default();
            command.split(|byte| *byte == 0).nth(1) == Some(role.as_bytes())
        };
        let mut children = children.split_whitespace().filter_map(|child| child.parse().ok());
        children.find(has_role).with_context(|| format!("there is no process {role}"))
    }

    /// Processor time of each process so far, seconds.
    pub fn cpu_s(&self) -> Result<[f64; 3]> {
        let ticks_hz = rustix::param::clock_ticks_per_second() as f64;
        let mut times = [0.0; 3];
        for (time, (id, role)) in times.iter_mut().zip(self.ids.iter().zip(PROCESSES)) {
            let stat = std::fs::read_to_string(format!("/proc/{id}/stat"));
            let stat = stat.with_context(|| format!("the process {role} has ended"))?;
            // After the name, which is in brackets: user and system time are the 12th and 13th field.
            let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
            let ticks: Vec<f64> = fields.skip(11).take(2).filter_map(|field| field.parse().ok()).collect();
            ensure!(ticks.len() == 2, "/proc/{id}/stat cannot be understood");
            *time = ticks.iter().sum::<f64>() / ticks_hz;
        }
        Ok(times)
    }

    /// Makes the example site.
    pub fn make_example(&self, patience: Duration) -> Result<()> {
        self.post(api::paths::EXAMPLE_PATH, &json!({ "time_zone": "Europe/London" }))?;
        let started = Instant::now();
        loop {
            let progress = self.get(api::paths::EXAMPLE_PATH)?;
            if progress.get("done").is_some() {
                return Ok(());
            }
            ensure!(progress.get("failed").is_none(), "the example cannot be made: {progress}");
            ensure!(started.elapsed() < patience, "the example was not made in time: {progress}");
            std::thread::sleep(PERIOD);
        }
    }

    /// Id of the first mission of the site.
    pub fn first_mission(&self) -> Result<String> {
        let missions = self.get("/api/v1/site/missions")?;
        let id = missions["items"][0]["object"]["id"].as_str();
        Ok(id.context("the site has no mission")?.to_owned())
    }

    /// Queues a run of a mission.
    pub fn start_run(&self, mission: &str) -> Result<()> {
        self.post(api::paths::RUNS_PATH, &json!({ "mission": mission, "mode": "queue" })).map(drop)
    }

    /// Whether a run is under way.
    pub fn is_running(&self) -> Result<bool> {
        let now = self.get(api::paths::CURRENT_RUNS_PATH)?;
        let runs = now["missions"]["runs"].as_array();
        Ok(runs.into_iter().flatten().any(|run| run["state"] == "running" || run["state"] == "ending"))
    }

    fn get(&self, path: &str) -> Result<Value> {
        self.request("GET", path, "")
    }

    fn post(&self, path: &str, document: &Value) -> Result<Value> {
        self.request("POST", path, &document.to_string())
    }

    fn request(&self, method: &str, path: &str, body: &str) -> Result<Value> {
        let mut stream = TcpStream::connect(self.address)?;
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Type: application/json\r\nContent-Length: {}\r\n\r\n{body}",
            self.address,
            body.len()
        )?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer)?;
        let (head, content) = answer.split_once("\r\n\r\n").context("no HTTP")?;
        let status = head.split_whitespace().nth(1).unwrap_or_default();
        ensure!(status.starts_with('2'), "{method} {path}: {status}: {content}");
        if content.is_empty() { Ok(Value::Null) } else { Ok(serde_json::from_str(content)?) }
    }
}

impl Drop for MeasuredPlatform {
    fn drop(&mut self) {
        let id = rustix::process::Pid::from_child(&self.process);
        // In order, so that its processes end too.
        let _ = rustix::process::kill_process(id, rustix::process::Signal::TERM);
        let _ = self.process.wait();
    }
}
