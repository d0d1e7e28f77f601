//! Extent of the crash test, from environment variables that `cargo xtask test crash` sets.

use std::path::PathBuf;

/// Kills in each situation in the tests of every change.
const KILLS_OF_EVERY_CHANGE: usize = 2;

/// Kills during missions. The tests of every change have five of their own (`crate::missions`).
const MISSION_KILLS: usize = 100;

/// Extent of the crash test.
pub struct CrashOptions {
    /// Kills in each situation.
    pub kills: usize,
    /// Kills during missions.
    pub mission_kills: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The only case to run, if one is to be repeated.
    pub only: Option<usize>,
    /// Whether every file gets every damage, and not a sample of them.
    pub all_damages: bool,
    /// Folder for the report.
    pub report: Option<PathBuf>,
}

impl CrashOptions {
    /// Of the environment.
    pub fn from_environment() -> Self {
        let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
        Self {
            kills: number("AUTOINSPECT_CRASH_KILLS").map_or(KILLS_OF_EVERY_CHANGE, |kills| kills as usize),
            mission_kills: number("AUTOINSPECT_CRASH_MISSION_KILLS")
                .map_or(MISSION_KILLS, |kills| kills as usize),
            seed: number("AUTOINSPECT_CRASH_SEED").unwrap_or(1),
            only: number("AUTOINSPECT_CRASH_CASE").map(|case| case as usize),
            all_damages: std::env::var("AUTOINSPECT_CRASH_DAMAGES").is_ok_and(|text| text == "all"),
            report: std::env::var_os("AUTOINSPECT_CRASH_REPORT").map(PathBuf::from),
        }
    }

    /// The numbers of the cases to run.
    pub fn cases(&self) -> Vec<usize> {
        self.only.map_or_else(|| (0..self.kills).collect(), |case| vec![case])
    }
}
