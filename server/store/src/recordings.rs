//! Disk space for recordings: they take a bounded share of the disk, and the oldest are removed first.

use crate::{StoreError, files};
use std::fs;
use std::path::{Path, PathBuf};
use vocab::Stamp;

/// Limits of what recordings may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordingsConfig {
    /// Share of the disk (bytes of recordings plus free bytes) that recordings may take.
    pub disk_share_max: f64,
    /// Free space that recordings leave for maps, bytes.
    pub free_bytes_min: u64,
    /// Bytes that recordings may take in any case; no such limit if none.
    pub bytes_max: Option<u64>,
}

impl Default for RecordingsConfig {
    fn default() -> Self {
        Self { disk_share_max: 0.5, free_bytes_min: 1 << 30, bytes_max: None }
    }
}

/// The recordings of a data directory.
#[derive(Clone, Debug)]
pub struct Recordings {
    dir: PathBuf,
    config: RecordingsConfig,
}

/// Whether a running recording may go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordingSpace {
    /// It may.
    Available,
    /// The running recording alone takes all that recordings may take.
    Exhausted,
}

impl Recordings {
    /// Recordings in `dir`.
    pub fn new(dir: impl Into<PathBuf>, config: RecordingsConfig) -> Self {
        Self { dir: dir.into(), config }
    }

    /// Path of a recording that begins at `begins`. Names sort by time.
    pub fn path(&self, begins: Stamp) -> PathBuf {
        self.dir.join(format!("{}.mcap", file_name_time(begins)))
    }

    /// Free space on the disk, bytes.
    ///
    /// # Errors
    /// When the system does not say.
    pub fn free_bytes(&self) -> Result<u64, StoreError> {
        files::free_bytes(&self.dir)
    }

    /// Removes the oldest recordings, never the running one, until the rest is within the limit.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn evict_oldest(&self, running: &Path) -> Result<RecordingSpace, StoreError> {
        let mut recordings = Vec::new();
        for path in files::entries(&self.dir)? {
            let bytes = fs::metadata(&path).map_err(|source| StoreError::io("read", &path, source))?.len();
            recordings.push((path, bytes));
        }
        let mut used: u64 = recordings.iter().map(|(_, bytes)| bytes).sum();
        let limit = self.limit(used)?;
        for (path, bytes) in recordings.iter().filter(|(path, _)| path != running) {
            if used <= limit {
                break;
            }
            fs::remove_file(path).map_err(|source| StoreError::io("remove", path, source))?;
            used -= bytes;
        }
        Ok(if used <= limit { RecordingSpace::Available } else { RecordingSpace::Exhausted })
    }

    /// Bytes that recordings may take, given that they take `used` now.
    fn limit(&self, used: u64) -> Result<u64, StoreError> {
        let disk = used.saturating_add(self.free_bytes()?);
        let share = (disk as f64 * self.config.disk_share_max) as u64;
        let limit = share.min(disk.saturating_sub(self.config.free_bytes_min));
        Ok(self.config.bytes_max.map_or(limit, |bytes_max| limit.min(bytes_max)))
    }
}

/// UTC as `2026-11-21T10-36-22.123Z`, which sorts as time does and is a file name everywhere.
fn file_name_time(at: Stamp) -> String {
    let (seconds, nanos) = at.parts();
    let (year, month, day) = civil_date(seconds.div_euclid(86_400));
    let second = seconds.rem_euclid(86_400);
    let (hour, minute) = (second / 3600, second / 60 % 60);
    format!(
        "{year:04}-{month:02}-{day:02}T{hour:02}-{minute:02}-{:02}.{:03}Z",
        second % 60,
        nanos / 1_000_000
    )
}

/// Gregorian (year, month, day) of a day counted from 1970-01-01.
///
/// Source: Howard Hinnant, "chrono-Compatible Low-Level Date Algorithms", `civil_from_days`.
fn civil_date(days: i64) -> (i64, i64, i64) {
    let shifted = days + 719_468;
    let era = shifted.div_euclid(146_097);
    let day_of_era = shifted.rem_euclid(146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    (year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_utc() {
        let name = |secs| file_name_time(Stamp::from_parts(secs, 7_000_000));
        assert_eq!(name(0), "1970-01-01T00-00-00.007Z");
        assert_eq!(name(951_782_400), "2000-02-29T00-00-00.007Z");
        assert_eq!(name(1_700_000_000), "2023-11-14T22-13-20.007Z");
        assert_eq!(name(-1), "1969-12-31T23-59-59.007Z");
    }

    #[test]
    fn the_oldest_are_removed_and_the_running_one_never_is() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let recordings = Recordings::new(
            dir.path(),
            RecordingsConfig { bytes_max: Some(250), ..RecordingsConfig::default() },
        );
        let [oldest, older, running] = [1, 2, 3].map(|secs| recordings.path(Stamp::from_parts(secs, 0)));
        for path in [&oldest, &older, &running] {
            fs::write(path, [0; 100]).expect("writable");
        }
        assert_eq!(recordings.evict_oldest(&running).expect("evicted"), RecordingSpace::Available);
        assert!(!oldest.exists() && older.exists() && running.exists());

        fs::write(&running, [0; 300]).expect("writable");
        assert_eq!(recordings.evict_oldest(&running).expect("evicted"), RecordingSpace::Exhausted);
        assert!(!older.exists() && running.exists());
    }
}
