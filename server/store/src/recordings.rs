//! Recordings on the disk: segments of runs, their pins, and the space that they may take.
//!
//! ```text
//! recordings/<time>/000000.mcap     segments of one run
//! recordings/<time>/000003.pinned   why segment 3 is pinned, one line for each reason
//! recordings/<time>/ended           the run has ended as it should
//! recordings/<time>.mcap            a whole run, as programs up to November 2026 recorded it
//! ```
//!
//! Recordings take a bounded share of the disk. What exceeds it is removed, the oldest first, pinned segments after all others, and the running segment never.

use crate::{StoreError, files, texts};
use std::collections::BTreeSet;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use vocab::Stamp;

/// Name of the file that says that a run has ended as it should.
const ENDED: &str = "ended";

/// Limits of what recordings may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordingsConfig {
    /// Share of the disk (bytes of recordings plus free bytes) that recordings may take. Chosen: half, so that maps and files of actions have as much.
    pub max_disk_share: f64,
    /// Free space that recordings leave for maps, bytes. Chosen: 1 GB, a map of several million points and its next version.
    pub min_free_bytes: u64,
    /// Bytes that recordings may take in any case; no such limit if none. Given by the caller; the default is none.
    pub max_bytes: Option<u64>,
    /// Bytes that recordings must be allowed to take before a paused recording begins again: a minute and a half of a walk. Chosen: so that a full disk does not make a
    /// segment for each second.
    pub min_bytes: u64,
    /// Size at which a segment ends, bytes. Chosen: some minutes of a walk; larger segments are lost as a whole when space is short.
    pub max_segment_bytes: u64,
    /// Share of the space of all recordings at which a segment ends, so that in little space too many segments can be pinned one by one. Chosen: a pinned segment and its
    /// neighbours then are a tenth of the space.
    pub max_segment_share: f64,
    /// Time before the end of an interrupted run whose segments are pinned. Chosen: as those of incidents.
    pub interruption_margin: Duration,
}

impl Default for RecordingsConfig {
    fn default() -> Self {
        Self {
            max_disk_share: 0.5,
            min_free_bytes: 1 << 30,
            max_bytes: None,
            min_bytes: 64 << 20,
            max_segment_bytes: 256 << 20,
            max_segment_share: 1.0 / 32.0,
            interruption_margin: Duration::from_secs(120),
        }
    }
}

/// The recordings of a data directory.
#[derive(Clone, Debug)]
pub struct Recordings {
    dir: PathBuf,
    config: RecordingsConfig,
}

/// Whether there is space for a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordingSpace {
    /// There is enough.
    Available,
    /// There is not enough, although all recordings that may be removed are gone.
    Exhausted,
}

/// The segments of the running run.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    recordings: Recordings,
    name: String,
    dir: PathBuf,
    follows_interruption: bool,
}

/// One file of a recording.
struct RecordingFile {
    path: PathBuf,
    bytes: u64,
    is_pinned: bool,
}

impl Recordings {
    /// Recordings in `dir`.
    pub fn new(dir: impl Into<PathBuf>, config: RecordingsConfig) -> Self {
        Self { dir: dir.into(), config }
    }

    /// Free space on the disk, bytes.
    ///
    /// # Errors
    /// When the system does not say.
    pub fn free_bytes(&self) -> Result<u64, StoreError> {
        files::free_bytes(&self.dir)
    }

    /// Begins the recording of a run. If the run before it was interrupted, its last segments are pinned.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn begin_run(&self, begins: Stamp) -> Result<RecordedRun, StoreError> {
        let follows_interruption = match self.runs()?.last() {
            Some(last) if !last.join(ENDED).exists() => self.pin_end(last)?,
            _ => false,
        };
        let time = file_name_time(begins);
        let taken = |name: &String| self.dir.join(name).exists();
        let names = std::iter::once(time.clone()).chain((2..1_000).map(|number| format!("{time}-{number}")));
        let name = { names }.find(|name| !taken(name)).unwrap_or(time);
        let dir = self.dir.join(&name);
        files::make_directory(&dir)?;
        Ok(RecordedRun { recordings: self.clone(), name, dir, follows_interruption })
    }

    /// Folders of runs, the oldest first.
    fn runs(&self) -> Result<Vec<PathBuf>, StoreError> {
        Ok(files::entries(&self.dir)?.into_iter().filter(|path| path.is_dir()).collect())
    }

    /// Pins the last segments of an interrupted run; returns whether it has any.
    fn pin_end(&self, run: &Path) -> Result<bool, StoreError> {
        // A segment was written last when it ended.
        let ended = |path: &Path| fs::metadata(path).and_then(|metadata| metadata.modified());
        let segments: Vec<(PathBuf, SystemTime)> = files::entries(run)?
            .into_iter()
            .filter(|path| is_recording(path))
            .filter_map(|path| ended(&path).ok().map(|at| (path, at)))
            .collect();
        let Some((_, end)) = segments.last().cloned() else { return Ok(false) };
        for (path, at) in &segments {
            if end.duration_since(*at).unwrap_or_default() <= self.config.interruption_margin {
                pin(path, texts::PROGRAM_INTERRUPTED)?;
            }
        }
        Ok(true)
    }

    /// All files of recordings, the oldest first.
    fn recording_files(&self) -> Result<Vec<RecordingFile>, StoreError> {
        let mut paths = Vec::new();
        for entry in files::entries(&self.dir)? {
            match entry.is_dir() {
                true => paths.extend(files::entries(&entry)?),
                false => paths.push(entry),
            }
        }
        let mut recordings = Vec::new();
        for path in paths.into_iter().filter(|path| is_recording(path)) {
            let bytes = fs::metadata(&path).map_err(|source| StoreError::io("read", &path, source))?.len();
            let is_pinned = pin_path(&path).exists();
            recordings.push(RecordingFile { path, bytes, is_pinned });
        }
        Ok(recordings)
    }

    /// Bytes that recordings may take, given that they take `used` now.
    fn limit(&self, used: u64) -> Result<u64, StoreError> {
        let disk = used.saturating_add(self.free_bytes()?);
        let share = (disk as f64 * self.config.max_disk_share) as u64;
        let limit = share.min(disk.saturating_sub(self.config.min_free_bytes));
        Ok(self.config.max_bytes.map_or(limit, |max_bytes| limit.min(max_bytes)))
    }

    /// Size at which a segment ends, if recordings may take `limit` bytes.
    fn max_segment_bytes(&self, limit: u64) -> u64 {
        self.config.max_segment_bytes.min((limit as f64 * self.config.max_segment_share) as u64)
    }
}

impl RecordedRun {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the run before it was interrupted.
    pub fn follows_interruption(&self) -> bool {
        self.follows_interruption
    }

    /// Path of a segment.
    pub fn segment(&self, number: u32) -> PathBuf {
        self.dir.join(format!("{number:06}.mcap"))
    }

    /// Pins a segment: it is removed after all that are not pinned.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn pin(&self, number: u32, reason: &str) -> Result<(), StoreError> {
        pin(&self.segment(number), reason)
    }

    /// Whether the running segment has reached its size.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn is_full(&self, running: u32) -> Result<bool, StoreError> {
        let path = self.segment(running);
        let bytes = fs::metadata(&path).map_err(|source| StoreError::io("read", &path, source))?.len();
        let used = self.recordings.recording_files()?.iter().map(|file| file.bytes).sum();
        Ok(bytes >= self.recordings.max_segment_bytes(self.recordings.limit(used)?))
    }

    /// Removes recordings until the rest is within the limit and the running segment may grow or, if none runs, another one may begin.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn make_room(&self, running: Option<u32>) -> Result<RecordingSpace, StoreError> {
        let files = self.recordings.recording_files()?;
        let mut used: u64 = files.iter().map(|file| file.bytes).sum();
        let limit = self.recordings.limit(used)?;
        let wanted = match running {
            Some(_) => limit,
            None => limit.saturating_sub(self.recordings.max_segment_bytes(limit)),
        };
        let running = running.map(|number| self.segment(number));
        let removable = |is_pinned: bool| {
            let running = running.clone();
            files
                .iter()
                .filter(move |file| file.is_pinned == is_pinned && Some(&file.path) != running.as_ref())
        };
        let mut left = BTreeSet::new();
        for file in removable(false).chain(removable(true)) {
            if used <= wanted {
                break;
            }
            files::remove_file(&file.path)?;
            files::remove_file(&pin_path(&file.path))?;
            left.extend(file.path.parent().map(Path::to_owned));
            used -= file.bytes;
        }
        for run in left.iter().filter(|run| **run != self.dir && **run != self.recordings.dir) {
            remove_if_empty(run)?;
        }
        let is_available = used <= wanted && (running.is_some() || limit >= self.recordings.config.min_bytes);
        Ok(if is_available { RecordingSpace::Available } else { RecordingSpace::Exhausted })
    }

    /// Marks that the run has ended as it should.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn end(&self) -> Result<(), StoreError> {
        let path = self.dir.join(ENDED);
        fs::write(&path, []).map_err(|source| StoreError::io("write", &path, source))
    }
}

fn is_recording(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "mcap")
}

/// The file that pins a segment.
fn pin_path(segment: &Path) -> PathBuf {
    segment.with_extension("pinned")
}

fn pin(segment: &Path, reason: &str) -> Result<(), StoreError> {
    let path = pin_path(segment);
    let written = OpenOptions::new()
        .create(true)
        .append(true)
        .open(&path)
        .and_then(|mut file| file.write_all(format!("{reason}\n").as_bytes()));
    written.map_err(|source| StoreError::io("write", &path, source))
}

/// Removes the folder of a run that has no segments any more.
fn remove_if_empty(run: &Path) -> Result<(), StoreError> {
    if files::entries(run)?.iter().any(|path| is_recording(path)) {
        return Ok(());
    }
    files::remove_file(&run.join(ENDED))?;
    match fs::remove_dir(run) {
        // Somebody has put a file there.
        Err(error) if error.kind() == io::ErrorKind::DirectoryNotEmpty => Ok(()),
        Err(source) => Err(StoreError::io("remove", run, source)),
        Ok(()) => Ok(()),
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

    /// Recordings that may take 1000 bytes, with segments of up to 100.
    fn recordings(dir: &Path) -> Recordings {
        let config = RecordingsConfig {
            max_bytes: Some(1_000),
            min_bytes: 1_000,
            min_free_bytes: 0,
            max_segment_share: 0.1,
            ..RecordingsConfig::default()
        };
        Recordings::new(dir, config)
    }

    fn write(path: &Path, bytes: usize) {
        fs::write(path, vec![0; bytes]).expect("writable");
    }

    #[test]
    fn the_oldest_unpinned_segments_are_removed_first_and_the_running_one_never() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let recordings = recordings(dir.path());
        let whole = dir.path().join("1970-01-01T00-00-00.000Z.mcap");
        write(&whole, 100);
        let older = recordings.begin_run(Stamp::from_parts(1, 0)).expect("begins");
        write(&older.segment(0), 100);
        older.end().expect("ends");
        let run = recordings.begin_run(Stamp::from_parts(2, 0)).expect("begins");
        assert!(!run.follows_interruption());
        (0..8).for_each(|number| write(&run.segment(number), 100));
        run.pin(0, "Because.").expect("pinned");
        run.pin(0, "And because.").expect("pinned again");
        assert_eq!(
            fs::read_to_string(dir.path().join(run.name()).join("000000.pinned")).expect("read"),
            "Because.\nAnd because.\n"
        );

        let exists = |run: &RecordedRun| -> Vec<u32> {
            (0..20).filter(|number| run.segment(*number).exists()).collect()
        };
        assert_eq!(run.make_room(Some(7)).expect("room"), RecordingSpace::Available);
        assert_eq!(
            (whole.exists(), exists(&older).len(), exists(&run).len()),
            (true, 1, 8),
            "1000 bytes are allowed"
        );
        write(&run.segment(8), 100);
        run.make_room(Some(8)).expect("room");
        assert!(!whole.exists() && older.segment(0).exists());
        (9..11).for_each(|number| write(&run.segment(number), 100));
        run.make_room(Some(10)).expect("room");
        assert!(!dir.path().join(older.name()).exists(), "nor is its folder");
        assert_eq!(exists(&run), [0, 2, 3, 4, 5, 6, 7, 8, 9, 10], "the pinned one stays");
        write(&run.segment(10), 950);
        assert_eq!(run.make_room(Some(10)).expect("room"), RecordingSpace::Available);
        assert_eq!(exists(&run), [10], "now the pinned one had to go");
        assert!(!dir.path().join(run.name()).join("000000.pinned").exists());
        write(&run.segment(10), 1_001);
        assert_eq!(run.make_room(Some(10)).expect("room"), RecordingSpace::Exhausted);
        assert_eq!(exists(&run), [10]);
        assert_eq!(run.make_room(None).expect("room"), RecordingSpace::Available, "it runs no more");
        assert_eq!(exists(&run), [0; 0]);
    }

    #[test]
    fn a_segment_is_full_at_its_share_of_the_space() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let run = recordings(dir.path()).begin_run(Stamp::EPOCH).expect("begins");
        write(&run.segment(0), 99);
        assert!(!run.is_full(0).expect("known"));
        write(&run.segment(0), 100);
        assert!(run.is_full(0).expect("known"));
    }

    #[test]
    fn the_last_segments_of_an_interrupted_run_are_pinned() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let recordings = recordings(dir.path());
        let interrupted = recordings.begin_run(Stamp::EPOCH).expect("begins");
        for (number, age_s) in [(0, 300), (1, 110), (2, 0)] {
            write(&interrupted.segment(number), 10);
            let file = OpenOptions::new().append(true).open(interrupted.segment(number)).expect("opens");
            file.set_modified(SystemTime::now() - Duration::from_secs(age_s)).expect("a time");
        }
        let next = recordings.begin_run(Stamp::EPOCH).expect("begins");
        assert!(next.follows_interruption());
        assert_ne!(next.name(), interrupted.name(), "two runs may begin in the same millisecond");
        let pinned = [0, 1, 2].map(|number| pin_path(&interrupted.segment(number)).exists());
        assert_eq!(pinned, [false, true, true]);
    }
}
