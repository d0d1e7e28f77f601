//! Finds the kind of a recording by its content, not by its name.

use super::Container;
use super::bag_file::BagFile;
use super::database_file::DatabaseFile;
use super::file_sequence::FileSequence;
use super::mcap_file::McapFile;
use super::scan_folder::ScanFolder;
use crate::error::OpenError;
use crate::texts;
use crate::writer::{RUN_KEY, SEGMENT_KEY};
use formats::scan_file::ScanFormat;
use formats::{natural, pcd, ply, rosbag1, rosbag2};
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

type Opened = (String, Arc<dyn Container>);

/// Opens a recording of any kind; the text names the kind.
///
/// # Errors
/// When it cannot be read or is not a recording.
pub(crate) fn open(path: &Path) -> Result<Opened, OpenError> {
    let kind = fs::metadata(path).map_err(|source| OpenError::Io { path: path.to_owned(), source })?;
    if kind.is_dir() { open_folder(path) } else { open_file(path) }
}

/// As [`open`], but the first segment of a run is opened with the other segments of that run in its folder.
///
/// # Errors
/// As [`open`].
pub(crate) fn open_run(path: &Path) -> Result<Opened, OpenError> {
    let (format, container) = open(path)?;
    let is_first = container.metadata(SEGMENT_KEY) == Some("0") && path.is_file();
    let Some(run) = container.metadata(RUN_KEY).filter(|_| is_first) else { return Ok((format, container)) };
    // The parent of a bare file name is empty.
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let segments = bag_files(folder)?
        .into_iter()
        .filter(|path| open_file(path).is_ok_and(|(_, container)| container.metadata(RUN_KEY) == Some(run)));
    join(texts::SEGMENTS_OF_RUN, segments.collect(), Vec::new())
}

fn open_file(path: &Path) -> Result<Opened, OpenError> {
    let mut start = Vec::new();
    File::open(path)
        .and_then(|file| file.take(512).read_to_end(&mut start))
        .map_err(|source| OpenError::Io { path: path.to_owned(), source })?;
    let not =
        |problem: &str| Err(OpenError::NotARecording { path: path.to_owned(), problem: problem.to_owned() });
    let single = |format: ScanFormat| -> Result<Opened, OpenError> {
        Ok((format!("{} scan", format.name()), Arc::new(ScanFolder::single(format, path))))
    };
    match start.as_slice() {
        [] => not(texts::EMPTY_FILE),
        s if McapFile::is_mcap(s) => Ok(("MCAP".into(), Arc::new(McapFile::open(path)?))),
        s if rosbag1::is_bag(s) => Ok(("ROS 1 bag".into(), Arc::new(BagFile::open(path)?))),
        s if rosbag2::is_database(s) => {
            Ok(("ROS 2 bag (SQLite)".into(), Arc::new(DatabaseFile::open(path)?)))
        }
        s if pcd::is_pcd(s) => single(ScanFormat::Pcd),
        s if ply::is_ply(s) => single(ScanFormat::Ply),
        s if s.starts_with(b"LASF") || s.starts_with(b"ASTM-E57") => not(texts::FINISHED_CLOUD),
        [0x28, 0xb5, 0x2f, 0xfd, ..] => not(texts::PACKED_WITH_ZSTD),
        [0x1f, 0x8b, ..] => not(texts::PACKED_WITH_GZIP),
        s if is_pcap(s) => not(texts::NETWORK_CAPTURE),
        _ if ScanFormat::of_path(path) == Some(ScanFormat::Kitti) => single(ScanFormat::Kitti),
        _ => not(texts::UNKNOWN_KIND),
    }
}

/// Magic numbers of pcap with micro- and nanoseconds in both byte orders, and of pcapng.
fn is_pcap(start: &[u8]) -> bool {
    const MAGICS: [u32; 5] = [0xa1b2_c3d4, 0xa1b2_3c4d, 0xd4c3_b2a1, 0x4d3c_b2a1, 0x0a0d_0d0a];
    start.first_chunk().is_some_and(|magic| MAGICS.contains(&u32::from_be_bytes(*magic)))
}

fn open_folder(folder: &Path) -> Result<Opened, OpenError> {
    let io = |source| OpenError::Io { path: folder.to_owned(), source };
    let metadata = folder.join("metadata.yaml");
    if metadata.is_file() {
        let text = fs::read(&metadata).map_err(io)?;
        return open_bag_folder(folder, &String::from_utf8_lossy(&text));
    }
    let files = bag_files(folder)?;
    match files.is_empty() {
        true => Ok((texts::FOLDER_OF_SCANS.into(), Arc::new(ScanFolder::open(folder)?))),
        false => join(texts::FOLDER_OF_BAGS, files, Vec::new()),
    }
}

/// Files in a folder that are recordings by their names, in natural order.
fn bag_files(folder: &Path) -> Result<Vec<PathBuf>, OpenError> {
    let entries = fs::read_dir(folder).map_err(|source| OpenError::Io { path: folder.to_owned(), source })?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| is_bag_name(path))
        .collect();
    files.sort_by(|a, b| natural::compare(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(files)
}

fn is_bag_name(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    ["mcap", "db3", "bag"].contains(&extension.to_ascii_lowercase().as_str())
}

fn open_bag_folder(folder: &Path, metadata: &str) -> Result<Opened, OpenError> {
    let metadata = rosbag2::read_metadata(metadata);
    let not = |problem: String| OpenError::NotARecording { path: folder.to_owned(), problem };
    if !metadata.compression.is_empty() {
        return Err(not(texts::packed_bag(&metadata.compression)));
    }
    // Older bags write the folder before the file's name.
    let place = |name: &String| {
        let inside = folder.join(Path::new(name).file_name().unwrap_or_default());
        Some(folder.join(name)).filter(|path| path.is_file()).unwrap_or(inside)
    };
    let (present, absent): (Vec<_>, Vec<_>) =
        metadata.files.iter().map(place).partition(|path| path.is_file());
    if present.is_empty() {
        return Err(not(texts::BAG_WITHOUT_FILES.to_owned()));
    }
    join("ROS 2 bag", present, absent.iter().map(|path| texts::bag_file_missing(path)).collect())
}

/// Opens all files. Files that cannot be opened become warnings; if all of them fail, the result is an error.
fn join(kind: &str, files: Vec<PathBuf>, mut warnings: Vec<String>) -> Result<Opened, OpenError> {
    let mut parts = Vec::new();
    let mut first_error = None;
    let mut format = String::new();
    for path in files {
        match open_file(&path) {
            Ok((file_format, container)) => {
                format = file_format;
                parts.push(container);
            }
            Err(error) => {
                warnings.push(error.to_string());
                first_error.get_or_insert(error);
            }
        }
    }
    match first_error {
        Some(error) if parts.is_empty() => Err(error),
        _ => Ok((format!("{kind} ({format})"), Arc::new(FileSequence::new(parts, warnings)))),
    }
}
