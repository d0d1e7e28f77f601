//! Recordings as inputs of offline commands: opens them, reads ahead on a thread, and adds ticks on their clock.

mod reader;
mod sources;
mod ticks;

pub use reader::{InputReader, Message, ReadStatistics};
pub use ticks::Ticks;

use crate::calibration::Calibration;
use crate::failure::Failure;
use crate::robot::boot_record;
use clap::Args;
use messages::BootRecord;
use recorder::{Recording, TopicSelection};
use sources::SourceName;
use std::path::PathBuf;

/// Recordings to read, and how to interpret them.
#[derive(Args, Debug)]
pub struct InputArgs {
    /// Recordings or folders of scans, one after the other in time.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// Sources that odometry may use; LiDAR alone works.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = SourceName::ALL)]
    sources: Vec<SourceName>,
    /// Topic of a role, as PURPOSE=TOPIC with lidar, imu, legs, external or battery.
    #[arg(long)]
    topic: Vec<String>,
    /// Mounting of the sensors and the robot, if the recording does not have them: JSON with base_from_lidar, base_from_imu or
    /// base_from_external, each with translation_m and quaternion_xyzw, standing_height_m, and the robot's profile under robot (guide: robot-profile.md).
    #[arg(long)]
    calibration: Option<PathBuf>,
}

impl InputArgs {
    /// Opens the recordings with the chosen roles of their topics.
    pub fn open(&self) -> Result<Vec<Recording>, Failure> {
        self.open_these(&self.inputs)
    }

    /// Opens other recordings with the same roles.
    pub fn open_these(&self, paths: &[PathBuf]) -> Result<Vec<Recording>, Failure> {
        let mut topics = TopicSelection::default();
        for choice in &self.topic {
            topics.choose(choice).map_err(Failure::usage)?;
        }
        paths.iter().map(|path| Recording::open(path, &topics).map_err(Failure::usage)).collect()
    }

    /// The stack's first input: sensors of the first recording and their mounting.
    pub fn boot(&self, recordings: &[Recording]) -> Result<BootRecord, Failure> {
        let sources = sources::sources(&self.sources);
        let mut boot =
            recordings.first().map_or_else(BootRecord::default, |first| boot_record(first, sources));
        if let Some(path) = &self.calibration {
            Calibration::read(path)?.apply(&mut boot)?;
        }
        Ok(boot)
    }
}

/// Total duration of recordings, seconds.
pub fn duration(recordings: &[Recording]) -> f64 {
    recordings.iter().map(|recording| recording.info().duration).sum()
}
