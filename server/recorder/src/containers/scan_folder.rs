//! Reads folders of scans (PCD, PLY, KITTI) with one file for each scan, in the natural order of their names.

use super::{Container, MessageEncoding, MessageOrder, Messages, RawMessage, Topic};
use crate::error::{OpenError, ReadError};
use crate::texts;
use formats::scan_file::ScanFormat;
use formats::{natural, tum};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Name and type of the one topic of a folder.
pub(crate) const TOPIC: &str = "scans";
/// Parameters of a folder of scans.
#[derive(Clone, Copy, Debug)]
struct ScanFolderConfig {
    /// Time between scans without known times: most LiDARs rotate at 10 Hz.
    default_scan_period: Span,
}

const CONFIG: ScanFolderConfig = ScanFolderConfig { default_scan_period: Span::from_millis(100) };

/// Scans with one file each, and their times.
pub(crate) struct ScanFolder {
    scans: Arc<Vec<(Stamp, PathBuf)>>,
    topics: Vec<Topic>,
    warnings: Vec<String>,
}

impl ScanFolder {
    /// Lists the scans of a folder, or of its only subfolder that has any.
    ///
    /// # Errors
    /// When the folder cannot be read or has no scans.
    pub fn open(folder: &Path) -> Result<Self, OpenError> {
        let mut warnings = Vec::new();
        let mut found = list_scans(folder, &mut warnings)?;
        let mut scan_folder = folder.to_owned();
        if found.is_none() {
            let mut below = Vec::new();
            for entry in entries(folder)?.into_iter().filter(|entry| entry.is_dir()) {
                below.extend(list_scans(&entry, &mut warnings)?.map(|scans| (entry, scans)));
            }
            if let [_] = below.as_slice() {
                (scan_folder, found) =
                    below.pop().map(|(folder, scans)| (folder, Some(scans))).unwrap_or_default();
            }
        }
        let Some((format, paths)) = found else {
            let problem = texts::NOTHING_IN_FOLDER;
            return Err(OpenError::NotARecording { path: folder.to_owned(), problem: problem.into() });
        };
        Ok(Self::with_times(format, &scan_folder, paths, warnings))
    }

    /// A single scan.
    pub fn single(format: ScanFormat, path: &Path) -> Self {
        let folder = path.parent().unwrap_or(Path::new("."));
        Self::with_times(format, folder, vec![path.to_owned()], Vec::new())
    }

    fn with_times(format: ScanFormat, folder: &Path, paths: Vec<PathBuf>, mut warnings: Vec<String>) -> Self {
        let times =
            times_in_names(&paths).or_else(|| times_beside(folder, paths.len())).unwrap_or_else(|| {
                if paths.len() > 1 {
                    warnings.push(texts::no_scan_times(folder));
                }
                (0..paths.len()).map(|i| Stamp::EPOCH + CONFIG.default_scan_period * i as i64).collect()
            });
        let topic = Topic {
            name: TOPIC.to_owned(),
            type_name: format!("{} file", format.name()),
            encoding: MessageEncoding::ScanFile(format),
            count: paths.len() as u64,
        };
        Self { scans: Arc::new(times.into_iter().zip(paths).collect()), topics: vec![topic], warnings }
    }
}

impl Container for ScanFolder {
    fn topics(&self) -> &[Topic] {
        &self.topics
    }

    fn span(&self) -> Option<(Stamp, Stamp)> {
        let stamps = || self.scans.iter().map(|(stamp, _)| *stamp);
        Some((stamps().min()?, stamps().max()?))
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }

    fn messages(&self, wanted: &[bool], _order: MessageOrder) -> Messages {
        let scans = self.scans.clone();
        let count = if wanted.contains(&true) { scans.len() } else { 0 };
        Box::new((0..count).map(move |i| {
            let (stamp, path) = &scans[i];
            let bytes = fs::read(path).map_err(|source| ReadError::Io { path: path.clone(), source })?;
            Ok(RawMessage::of_file(*stamp, path.clone(), bytes))
        }))
    }
}

/// Files of a folder in natural order.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, OpenError> {
    let io = |source| OpenError::Io { path: folder.to_owned(), source };
    let read = fs::read_dir(folder).map_err(io)?;
    let mut paths =
        read.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>().map_err(io)?;
    paths.sort_by(|a, b| natural::compare(&name(a), &name(b)));
    Ok(paths)
}

type Scans = Option<(ScanFormat, Vec<PathBuf>)>;

/// The scans of the most frequent format in a folder.
fn list_scans(folder: &Path, warnings: &mut Vec<String>) -> Result<Scans, OpenError> {
    let files = entries(folder)?;
    let of = |format| files.iter().filter(move |path| ScanFormat::of_path(path) == Some(format));
    let formats = [ScanFormat::Kitti, ScanFormat::Ply, ScanFormat::Pcd];
    let Some(best) = formats.into_iter().max_by_key(|format| of(*format).count()) else { return Ok(None) };
    let scans: Vec<PathBuf> = of(best).cloned().collect();
    if scans.is_empty() {
        return Ok(None);
    }
    let others =
        files.iter().filter_map(|path| ScanFormat::of_path(path)).filter(|format| *format != best).count();
    if others > 0 {
        warnings.push(texts::several_formats(folder, scans.len(), best.name(), others));
    }
    Ok(Some((best, scans)))
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Times from file names: nanoseconds since 1970 (19 digits), or seconds with a fraction. `None` if a name is not a time.
fn times_in_names(paths: &[PathBuf]) -> Option<Vec<Stamp>> {
    let time = |path: &PathBuf| {
        let stem = path.file_stem()?.to_str()?;
        let digits = stem.bytes().all(|byte| byte.is_ascii_digit());
        match (digits, stem.len()) {
            (true, 19) => stem.parse().ok().map(Stamp::from_nanos),
            (false, 12..) if stem.as_bytes()[0].is_ascii_digit() && stem.contains('.') => tum::stamp(stem),
            _ => None,
        }
    };
    paths.iter().map(time).collect()
}

/// Times from a list in the folder or its parent, if it has enough lines.
fn times_beside(folder: &Path, count: usize) -> Option<Vec<Stamp>> {
    let folders = [Some(folder), folder.parent()];
    let files = folders
        .into_iter()
        .flatten()
        .flat_map(|folder| ["times.txt", "timestamps.txt"].map(|name| folder.join(name)));
    files.filter_map(|path| fs::read_to_string(path).ok()).find_map(|text| {
        let lines = text.lines().filter(|line| !line.trim().is_empty());
        let times: Vec<Stamp> = lines.map_while(|line| time_of_line(line.trim())).take(count).collect();
        (times.len() == count).then_some(times)
    })
}

/// Reads seconds, or KITTI's `2011-09-26 13:02:25.964389445`.
fn time_of_line(line: &str) -> Option<Stamp> {
    let first = line.split_whitespace().next()?;
    if let Some(stamp) = tum::stamp(first) {
        return Some(stamp);
    }
    let (date, time) = line.split_once(' ')?;
    let mut date = date.splitn(3, '-').map(str::parse::<i64>);
    let (year, month, day) = (date.next()?.ok()?, date.next()?.ok()?, date.next()?.ok()?);
    let mut time = time.splitn(3, ':');
    let (hour, minute) = (time.next()?.parse::<i64>().ok()?, time.next()?.parse::<i64>().ok()?);
    let seconds = tum::stamp(time.next()?)?;
    let days = days_since_1970(year, month, day)?;
    Some(seconds + Span::from_nanos(1_000_000_000) * (days * 86_400 + hour * 3600 + minute * 60))
}

/// Days since 1970 in the Gregorian calendar. Years are counted from March, so that the leap day is the last one.
fn days_since_1970(year: i64, month: i64, day: i64) -> Option<i64> {
    if !(1970..=2262).contains(&year) || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    let year = if month < 3 { year - 1 } else { year };
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    Some(365 * year + year / 4 - year / 100 + year / 400 + day_of_year - 719_468)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kitti_dates_and_seconds_are_read() {
        let expected = Stamp::from_parts(1_317_042_145, 964_389_445);
        assert_eq!(time_of_line("2011-09-26 13:02:25.964389445"), Some(expected));
        assert_eq!(time_of_line("1317042145.964389445"), Some(expected));
        assert_eq!(time_of_line("1.5e0"), Some(Stamp::from_nanos(1_500_000_000)));
        assert_eq!(time_of_line("hello world"), None);
    }

    #[test]
    fn file_names_that_are_times_are_read_as_times() {
        let paths = |names: [&str; 2]| names.map(PathBuf::from).to_vec();
        let nanos = times_in_names(&paths(["1673400677802009732.pcd", "1673400677902009732.pcd"])).unwrap();
        assert_eq!((nanos[1] - nanos[0]).nanos(), 100_000_000);
        assert!(times_in_names(&paths(["1317042145.964.pcd", "1317042146.064.pcd"])).is_some());
        assert!(times_in_names(&paths(["000001.pcd", "000002.pcd"])).is_none());
    }
}
