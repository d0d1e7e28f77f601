//! The robot of the platform: `sim:SITE`, `replay:FILE` or `socket:PATH`.

use crate::failure::Failure;
use crate::site_changes::SiteChangeArgs;
use crate::up::ShutdownSignal;
use crate::{summaries, texts};
use links::{ConnectError, ReplayConfig, ReplayLink, ReplaySource, SocketLink, SocketLinkConfig};
use messages::{BootRecord, RobotProfile, Sources};
use ports::RobotLink;
use recorder::{Recording, TopicSelection};
use sim::FULL_COLUMNS;
use site_files::SiteSource;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Parameters of the core's connection to a robot.
#[derive(Clone, Copy, Debug)]
struct ConnectConfig {
    /// Longest wait for the robot to listen. It builds its site first. The supervisor then starts the core again. Chosen: a large site takes some seconds to build, and
    /// people see the reason soon.
    timeout: Duration,
    /// Pause between two attempts. Chosen: a connection that fails costs nothing, and nobody notices 20 ms.
    retry_pause: Duration,
}

const CONFIG: ConnectConfig =
    ConnectConfig { timeout: Duration::from_secs(20), retry_pause: Duration::from_millis(20) };

/// A robot, as named on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RobotName {
    /// A simulated robot at this site.
    Sim(SiteSource),
    /// A recording that is replayed.
    Replay(PathBuf),
    /// A robot in another process, which listens on this Unix socket.
    Socket(PathBuf),
}

impl fmt::Display for RobotName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sim(site) => write!(f, "sim:{site}"),
            Self::Replay(path) => write!(f, "replay:{}", path.display()),
            Self::Socket(path) => write!(f, "socket:{}", path.display()),
        }
    }
}

impl FromStr for RobotName {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            Some(("sim", site)) => site.parse().map(Self::Sim),
            Some(("replay", file)) if !file.is_empty() => Ok(Self::Replay(file.into())),
            Some(("socket", path)) if !path.is_empty() => Ok(Self::Socket(path.into())),
            _ => Err(texts::ROBOT_EXPECTED.to_owned()),
        }
    }
}

/// Parameters of the simulation or replay.
#[derive(clap::Args, Clone, Debug)]
pub struct RobotArgs {
    /// The robot: sim:SITE (b1, torus, plant, twins, generated:SEED or FILE.glb), replay:FILE, or socket:PATH of a robot in another
    /// process.
    #[arg(long, default_value = "sim:b1")]
    pub robot: RobotName,
    /// Robot seconds per second of this computer.
    #[arg(long, default_value_t = 1.0, value_parser = positive)]
    pub speed: f64,
    /// Seed of the simulation.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Columns of a simulated LiDAR sweep; 2000 is the real sensor's full resolution.
    #[arg(long, default_value_t = FULL_COLUMNS, value_parser = clap::value_parser!(u32).range(10..=20_000))]
    pub lidar_columns: u32,
    /// Number of people who walk in the simulation.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(0..=50))]
    pub people: u32,
    /// Number of another day at the simulated site: some furniture is moved or removed, and doors are open or shut. The same number gives the same day.
    #[arg(long)]
    pub day: Option<u64>,
    #[command(flatten)]
    pub changes: SiteChangeArgs,
}

impl RobotArgs {
    /// The same as arguments of a child process.
    pub fn to_arguments(&self) -> Vec<String> {
        [
            ("--robot", self.robot.to_string()),
            ("--speed", self.speed.to_string()),
            ("--seed", self.seed.to_string()),
            ("--lidar-columns", self.lidar_columns.to_string()),
            ("--people", self.people.to_string()),
        ]
        .into_iter()
        .chain(self.day.map(|day| ("--day", day.to_string())))
        .chain(self.changes.to_arguments())
        .flat_map(|(name, value)| [name.to_owned(), value])
        .collect()
    }

    /// The same for another robot, on the usual day and with nothing changed.
    pub fn with_robot(&self, robot: RobotName) -> Self {
        Self { robot, day: None, changes: SiteChangeArgs::default(), ..self.clone() }
    }

    /// # Errors
    /// On another day, or with changes, for a robot that is not simulated.
    pub fn check(&self) -> Result<(), Failure> {
        match self.robot {
            RobotName::Replay(_) | RobotName::Socket(_) if self.day.is_some() => {
                Err(Failure::usage(texts::ONLY_SITES_HAVE_DAYS))
            }
            RobotName::Replay(_) | RobotName::Socket(_) if self.changes.is_given() => {
                Err(Failure::usage(texts::ONLY_SITES_CHANGE))
            }
            _ => Ok(()),
        }
    }

    /// Links to the robot. Waits until it listens; `None` after a request to stop.
    pub fn link(&self, stop: &ShutdownSignal) -> Result<Option<Box<dyn RobotLink>>, Failure> {
        Ok(match &self.robot {
            RobotName::Sim(_) => return Err(Failure::usage(texts::SIMULATED_ROBOT_IS_A_PROCESS)),
            RobotName::Socket(path) => connect(path, stop)?.map(|link| Box::new(link) as Box<dyn RobotLink>),
            RobotName::Replay(path) => {
                let recording = Recording::open(path, &TopicSelection::default()).map_err(Failure::usage)?;
                let messages = recording
                    .inputs()
                    .filter_map(|message| message.inspect_err(|error| tracing::warn!("{error}")).ok());
                let config = ReplayConfig { speed: self.speed, ..ReplayConfig::default() };
                let source = ReplaySource {
                    boot: boot_record(&recording, Sources::default()),
                    messages: Box::new(messages),
                };
                Some(Box::new(ReplayLink::start(source, config).map_err(Failure::failed)?))
            }
        })
    }
}

/// Connects to the robot that listens there, or will soon.
fn connect(path: &Path, stop: &ShutdownSignal) -> Result<Option<SocketLink>, Failure> {
    let since = Instant::now();
    loop {
        match SocketLink::connect(path, SocketLinkConfig::default()) {
            Ok(link) => return Ok(Some(link)),
            Err(error) if since.elapsed() >= CONFIG.timeout || !matches!(error, ConnectError::Io(_)) => {
                return Err(Failure::failed(texts::robot_not_connected(path, &error)));
            }
            Err(error) => tracing::debug!("the robot is not connected yet: {error}"),
        }
        if stop.wait(CONFIG.retry_pause) {
            return Ok(None);
        }
    }
}

/// Boot record of a robot that is known from a recording only.
pub fn boot_record(recording: &Recording, sources: Sources) -> BootRecord {
    BootRecord {
        profile: RobotProfile { name: summaries::RECORDED_ROBOT.to_owned(), ..RobotProfile::default() },
        mounting: recording.mounting(),
        sources,
        start_mapping: None,
        leave_loops_open: false,
        last_pose: None,
        docks: Arc::default(),
        stop_latch: None,
    }
}

fn positive(text: &str) -> Result<f64, String> {
    let speed: f64 = text.parse().map_err(|_| texts::not_a_number(text))?;
    if speed.is_finite() && speed > 0.0 { Ok(speed) } else { Err(texts::POSITIVE_EXPECTED.to_owned()) }
}
