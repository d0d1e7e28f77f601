//! The robot of the platform: `sim:SITE` or `replay:FILE`.

use crate::failure::Failure;
use crate::texts;
use links::{ReplayConfig, ReplayLink, ReplaySource, SimLink, SimLinkConfig};
use messages::{BootRecord, RobotProfile, Sources};
use ports::RobotLink;
use recorder::{Recording, TopicSelection};
use sim::{FULL_COLUMNS, SimConfig};
use site_files::SiteSource;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;
use vocab::Stamp;

/// A robot, as named on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RobotName {
    /// A simulated robot at this site.
    Sim(SiteSource),
    /// A recording that is replayed.
    Replay(PathBuf),
}

impl fmt::Display for RobotName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sim(site) => write!(f, "sim:{site}"),
            Self::Replay(path) => write!(f, "replay:{}", path.display()),
        }
    }
}

impl FromStr for RobotName {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            Some(("sim", site)) => site.parse().map(Self::Sim),
            Some(("replay", file)) if !file.is_empty() => Ok(Self::Replay(file.into())),
            _ => Err(texts::ROBOT_EXPECTED.to_owned()),
        }
    }
}

/// Parameters of the simulation or replay.
#[derive(clap::Args, Clone, Debug)]
pub struct RobotArgs {
    /// The robot: sim:SITE (b1, torus, plant, twins, generated:SEED or FILE.glb), or replay:FILE.
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
        .flat_map(|(name, value)| [name.to_owned(), value])
        .collect()
    }

    /// Links to the robot. The clock of a simulated robot starts at `epoch`.
    pub fn link(&self, epoch: Stamp) -> Result<Box<dyn RobotLink>, Failure> {
        Ok(match &self.robot {
            RobotName::Sim(source) => {
                let site = source.load().map_err(Failure::usage)?;
                let sim = SimConfig {
                    lidar_columns: self.lidar_columns,
                    people: self.people,
                    epoch,
                    ..SimConfig::new(site, self.seed)
                };
                Box::new(SimLink::start(SimLinkConfig::new(sim, self.speed)).map_err(Failure::failed)?)
            }
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
                Box::new(ReplayLink::start(source, config).map_err(Failure::failed)?)
            }
        })
    }
}

/// Boot record of a robot that is known from a recording only.
pub fn boot_record(recording: &Recording, sources: Sources) -> BootRecord {
    BootRecord {
        profile: RobotProfile { name: "Recorded robot".to_owned(), ..RobotProfile::default() },
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
