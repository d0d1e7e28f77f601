//! What is killed: a core alone, or the whole platform with its supervisor.

use super::client::CoreClient;
use crate::core_process::CoreProcess;
use crate::platform::{RunningPlatform, has_ended};
use geometry::Rng;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time from the start of the program to its first answer.
pub const START_LIMIT: Duration = Duration::from_secs(5);

/// Longest time that the test waits for an answer, so that a slow start is measured and not only refused.
const START_PATIENCE: Duration = Duration::from_secs(60);

/// Coarse scans and fast simulation, as [`CoreProcess`] has them.
const ROBOT: [&str; 4] = ["--lidar-columns", "200", "--speed", "4"];

/// Which processes run and are killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Victim {
    /// The core, which runs alone.
    Core,
    /// The whole platform at once: supervisor, core, gateway and what they have started.
    Platform,
}

impl Victim {
    /// The core in most cases, because it starts faster.
    pub fn draw(rng: &mut Rng) -> Self {
        if rng.uniform() < 0.25 { Self::Platform } else { Self::Core }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Core => "core",
            Self::Platform => "platform",
        }
    }
}

/// A running program with a connection to its core.
pub struct Target {
    processes: Processes,
    pub client: CoreClient,
    /// Time from the start of the process to its first answer.
    pub start: Duration,
    /// What it writes to standard error.
    log: PathBuf,
}

enum Processes {
    Core(CoreProcess),
    Platform(RunningPlatform),
}

impl Target {
    /// Starts the program on `dir/data`.
    pub fn start(victim: Victim, dir: &Path) -> Result<Self, String> {
        let log = RunningPlatform::log(dir);
        let data = dir.join("data");
        let started = Instant::now();
        match victim {
            Victim::Core => {
                let stderr = File::create(&log).expect("the log can be written");
                let mut core = CoreProcess::start_with_log(&data, stderr.into());
                while started.elapsed() < START_PATIENCE && !core.has_ended() {
                    if let Some(client) = CoreClient::connect(&core.socket) {
                        let start = started.elapsed();
                        return Ok(Self { processes: Processes::Core(core), client, start, log });
                    }
                    // A pause between checks, so that they leave the CPU to the core.
                    std::thread::sleep(Duration::from_millis(2));
                }
            }
            Victim::Platform => {
                let platform = RunningPlatform::start_with_robot(dir, &ROBOT);
                let start = started.elapsed();
                platform.freeze_gateway();
                let socket = ports::DataDir::new(&data).core_socket();
                if let Some(client) = CoreClient::connect(&socket) {
                    return Ok(Self { processes: Processes::Platform(platform), client, start, log });
                }
            }
        }
        let said = fs::read_to_string(&log).unwrap_or_default();
        Err(format!("the {} did not start: {}", victim.name(), said.trim()))
    }

    /// Starts a core, and kills it after some time, while it starts.
    pub fn kill_while_starting(dir: &Path, after: Duration) {
        let stderr = File::create(dir.join("log.txt")).expect("the log can be written");
        let core = CoreProcess::start_with_log(&dir.join("data"), stderr.into());
        // The moment of the kill is what is tried here.
        std::thread::sleep(after);
        core.kill();
    }

    /// Kills all processes at once. Returns the client, to be read to the end.
    pub fn kill(self) -> CoreClient {
        match self.processes {
            Processes::Core(core) => core.kill(),
            Processes::Platform(platform) => platform.kill_all(),
        }
        self.client
    }

    /// What it has written to standard error.
    pub fn log(&self) -> String {
        fs::read_to_string(&self.log).unwrap_or_default()
    }
}

/// Ids of the running processes with this role that have a path below `data` among their arguments.
pub fn processes_of(role: &str, data: &Path) -> Vec<u32> {
    let data = data.to_string_lossy().into_owned();
    let entries = fs::read_dir("/proc").into_iter().flatten().filter_map(Result::ok);
    let ids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    ids.filter(|id| {
        let command = fs::read(format!("/proc/{id}/cmdline")).unwrap_or_default();
        let command = String::from_utf8_lossy(&command).into_owned();
        command.split('\0').nth(1) == Some(role) && command.contains(&data) && !has_ended(*id)
    })
    .collect()
}
