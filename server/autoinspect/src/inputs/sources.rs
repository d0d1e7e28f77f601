//! The sources that odometry may use, with their names on the command line.

use clap::ValueEnum;
use messages::Sources;

/// One source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SourceName {
    /// Scans.
    Lidar,
    /// Inertial samples.
    Imu,
    /// Leg or wheel odometry.
    Legs,
    /// Visual or other odometry.
    Visual,
}

impl SourceName {
    /// All sources.
    pub const ALL: [Self; 4] = [Self::Lidar, Self::Imu, Self::Legs, Self::Visual];
}

/// Converts names to the stack's type.
pub fn sources(names: &[SourceName]) -> Sources {
    Sources {
        lidar: names.contains(&SourceName::Lidar),
        imu: names.contains(&SourceName::Imu),
        legs: names.contains(&SourceName::Legs),
        external: names.contains(&SourceName::Visual),
    }
}
