//! Clouds that the robot saw on a run of a mission, kept to compare visits: each with the position of the sensor, so that free, occupied and unseen space can be told apart by
//! rays later. They have a share of the disk of their own. When it is full, the clouds of the oldest run go first, and those of the run under way never.
//!
//! A file is a header and a scan of `map_codec`. The header has the magic number `AIrc`, the version, the length of the JSON of its [`RunCloudEntry`] without hash and length (4 bytes each,
//! little-endian), and that JSON. The index of a run has the entries, one JSON object a line, each written after its file is on the disk. A line that a crash has cut is left out.

use crate::{Store, StoreError, files, texts};
use serde::{Deserialize, Serialize};
use site_model::{MissionId, ReportPlace, RunId};
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use vocab::{BlobHash, Stamp};

const MAGIC: [u8; 4] = *b"AIrc";
const VERSION: u32 = 1;
/// Name of the index in the folder of a run.
pub(crate) const INDEX: &str = "index.jsonl";
/// Bytes before the JSON.
const FIXED_HEADER_BYTES: usize = 12;

/// Limits of the clouds of runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunCloudsConfig {
    /// Bytes that the clouds of all runs may take: some thousand missions of 200 m. Chosen: a small part of a disk of 256 GB.
    pub max_bytes: u64,
    /// Free space that they leave for everything else, bytes, as files of actions do. Chosen: 1 GB, as recordings do.
    pub min_free_bytes: u64,
}

impl Default for RunCloudsConfig {
    fn default() -> Self {
        Self { max_bytes: 8 << 30, min_free_bytes: 1 << 30 }
    }
}

/// Why a cloud was kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunCloudCause {
    /// The robot has walked far enough since the last one.
    Distance,
    /// A task's action began.
    Task,
}

/// What is known of a cloud besides its points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunCloudEntry {
    /// BLAKE3 of its file; the name of the file.
    #[serde(default = "no_hash")]
    pub cloud: BlobHash,
    /// Length of its file.
    #[serde(default)]
    pub bytes: u64,
    /// When it was seen, on the robot's clock.
    pub robot_time: Stamp,
    /// The same, UTC, nanoseconds since 1970.
    pub utc_ns: i64,
    /// Why it was kept.
    pub cause: RunCloudCause,
    /// The mission of the run; none of clouds of earlier programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mission: Option<MissionId>,
    /// Number of the task in the run, from 0, of one that was kept because of a task.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<u32>,
    /// Where the robot was, by its own estimate. The points are in the frame of the base.
    pub place: ReportPlace,
    /// The sensor in the base, metres: where the rays to the points began.
    pub base_from_sensor_m: [f64; 3],
    /// Points.
    pub points: u32,
}

/// The hash in a file's own header.
fn no_hash() -> BlobHash {
    BlobHash([0; 32])
}

/// A cloud as it was kept.
#[derive(Clone, Debug, PartialEq)]
pub struct RunCloud {
    /// What is known of it.
    pub entry: RunCloudEntry,
    /// Points in the frame of the base, metres, each coordinate within half a centimetre.
    pub xyz: Vec<[f32; 3]>,
}

impl Store {
    /// Keeps a cloud of a run, in the frame of the base. Removes the clouds of older runs where they have to make room. Returns its entry, or none where there is no room even so.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn put_run_cloud(
        &self,
        run: RunId,
        mut entry: RunCloudEntry,
        xyz: &[[f32; 3]],
        intensity: &[f32],
        config: &RunCloudsConfig,
    ) -> Result<Option<RunCloudEntry>, StoreError> {
        let scan = map_codec::encode_scan(xyz, intensity, map_codec::POINT_RESOLUTION_M);
        // Plain data always becomes JSON.
        let mut header = serde_json::to_value(&entry).unwrap_or_default();
        if let Some(fields) = header.as_object_mut() {
            fields.remove("cloud");
            fields.remove("bytes");
        }
        let json = header.to_string().into_bytes();
        let mut bytes = Vec::with_capacity(FIXED_HEADER_BYTES + json.len() + scan.len());
        bytes.extend_from_slice(&MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(&(json.len() as u32).to_le_bytes());
        bytes.extend_from_slice(&json);
        bytes.extend_from_slice(&scan);
        (entry.cloud, entry.bytes) = (BlobHash(*blake3::hash(&bytes).as_bytes()), bytes.len() as u64);
        if !self.make_room_for_run_cloud(run, entry.bytes, config)? {
            return Ok(None);
        }
        let path = self.dir().run_cloud(run, entry.cloud);
        if let Some(directory) = path.parent() {
            files::make_directory(directory)?;
        }
        files::replace_durably(&path, &bytes)?;
        let index = self.dir().run_cloud_index(run);
        let mut line = serde_json::to_vec(&entry).unwrap_or_default();
        line.push(b'\n');
        let failed = |source| StoreError::io("write", &index, source);
        let mut file = OpenOptions::new().create(true).append(true).open(&index).map_err(failed)?;
        file.write_all(&line).and_then(|()| file.sync_data()).map_err(failed)?;
        Ok(Some(entry))
    }

    /// The clouds of a run, in the order in which they were seen; empty if none were kept, or they made room for newer ones.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn run_clouds(&self, run: RunId) -> Result<Vec<RunCloudEntry>, StoreError> {
        read_index(&self.dir().run_cloud_index(run))
    }

    /// A cloud of a run.
    ///
    /// # Errors
    /// When there is no such cloud, or it is damaged.
    pub fn run_cloud(&self, run: RunId, cloud: BlobHash) -> Result<RunCloud, StoreError> {
        read_cloud(self.dir().run_cloud(run, cloud), cloud)
    }

    /// All runs but `current` of which clouds are kept, the newest first.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn other_runs_with_clouds(&self, current: RunId) -> Result<Vec<RunId>, StoreError> {
        let of_folder = |(_, path): (_, PathBuf)| path.file_name()?.to_str()?.parse().ok();
        Ok(self.runs_with_clouds(current)?.into_iter().filter_map(of_folder).collect())
    }

    /// Removes the clouds of the oldest runs but `current` until there is room. Returns whether there is.
    fn make_room_for_run_cloud(
        &self,
        current: RunId,
        bytes: u64,
        config: &RunCloudsConfig,
    ) -> Result<bool, StoreError> {
        let root = self.dir().run_clouds();
        files::make_directory(&root)?;
        let mut used = files::bytes_below(&root)?;
        let mut runs = self.runs_with_clouds(current)?;
        loop {
            let is_over = used.saturating_add(bytes) > config.max_bytes;
            let is_full = files::free_bytes(&root)? < config.min_free_bytes.saturating_add(bytes);
            if !is_over && !is_full {
                return Ok(true);
            }
            let Some((_, oldest)) = runs.pop() else { return Ok(false) };
            used = used.saturating_sub(files::bytes_below(&oldest)?);
            files::remove_directory(&oldest)?;
        }
    }

    /// Folders of runs but `current`, the newest first.
    fn runs_with_clouds(&self, current: RunId) -> Result<Vec<(SystemTime, PathBuf)>, StoreError> {
        let is_other = |path: &PathBuf| path.is_dir() && !path.ends_with(current.to_string());
        let folders = files::entries(&self.dir().run_clouds())?.into_iter().filter(is_other);
        let changed = |path: &PathBuf| {
            let index = fs::metadata(path.join(INDEX)).or_else(|_| fs::metadata(path));
            index.and_then(|metadata| metadata.modified()).unwrap_or(SystemTime::UNIX_EPOCH)
        };
        let mut runs: Vec<_> = folders.map(|path| (changed(&path), path)).collect();
        runs.sort_by(|a, b| b.cmp(a));
        Ok(runs)
    }
}

/// Whether a folder is that of the clouds of a run.
pub fn is_run_clouds_folder(folder: &Path) -> bool {
    folder.join(INDEX).is_file()
}

/// The clouds in the folder of a run, in the order in which they were seen, one at a time.
///
/// # Errors
/// When the index cannot be read. Each cloud: when it is missing or damaged.
pub fn read_run_clouds(
    folder: &Path,
) -> Result<impl Iterator<Item = Result<RunCloud, StoreError>>, StoreError> {
    let folder = folder.to_owned();
    let entries = read_run_index(&folder)?;
    Ok(entries.into_iter().map(move |entry| read_cloud(folder.join(entry.cloud.to_string()), entry.cloud)))
}

/// What is known of the clouds in the folder of a run, in the order in which they were seen.
///
/// # Errors
/// When the index cannot be read.
pub fn read_run_index(folder: &Path) -> Result<Vec<RunCloudEntry>, StoreError> {
    read_index(&folder.join(INDEX))
}

fn read_index(index: &Path) -> Result<Vec<RunCloudEntry>, StoreError> {
    if !index.exists() {
        return Ok(Vec::new());
    }
    let text = fs::read_to_string(index).map_err(|source| StoreError::io("read", index, source))?;
    Ok(text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect())
}

fn read_cloud(path: PathBuf, cloud: BlobHash) -> Result<RunCloud, StoreError> {
    let bytes = fs::read(&path).map_err(|source| StoreError::io("read", &path, source))?;
    decode(cloud, &bytes).ok_or(StoreError::Broken { path, what: texts::BROKEN_RUN_CLOUD })
}

fn decode(cloud: BlobHash, bytes: &[u8]) -> Option<RunCloud> {
    let number = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let is_known = bytes.get(..4)? == MAGIC && number(4)? == VERSION;
    let end = FIXED_HEADER_BYTES.checked_add(usize::try_from(number(8)?).ok()?)?;
    let entry: RunCloudEntry = serde_json::from_slice(bytes.get(FIXED_HEADER_BYTES..end)?).ok()?;
    let chunk = map_codec::decode(bytes.get(end..)?).ok().filter(|_| is_known)?;
    let xyz = chunk.points.iter().map(|point| chunk.position(point)).collect();
    let entry = RunCloudEntry { cloud, bytes: bytes.len() as u64, ..entry };
    (*blake3::hash(bytes).as_bytes() == cloud.0).then_some(RunCloud { entry, xyz })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use site_model::LocalisationQuality;
    use uuid::Uuid;
    use vocab::{Covariance6, MapId, Pose};

    pub(crate) fn entry(at_s: i64) -> RunCloudEntry {
        RunCloudEntry {
            cloud: no_hash(),
            bytes: 0,
            robot_time: Stamp::from_parts(at_s, 0),
            utc_ns: 5,
            cause: RunCloudCause::Distance,
            mission: None,
            step: None,
            place: ReportPlace {
                map: Some(MapId(Uuid::from_u128(1))),
                map_from_base: Pose::IDENTITY,
                covariance: Covariance6::default(),
                quality: LocalisationQuality::Good,
            },
            base_from_sensor_m: [0.0, 0.0, 0.25],
            points: 3,
        }
    }

    fn run(number: u128) -> RunId {
        RunId(Uuid::from_u128(number))
    }

    const POINTS: [[f32; 3]; 3] = [[1.0, 2.0, 0.5], [4.0, -2.0, 1.5], [-3.0, 0.25, 0.0]];

    fn put(store: &Store, of: RunId, at_s: i64, config: &RunCloudsConfig) -> Option<RunCloudEntry> {
        store.put_run_cloud(of, entry(at_s), &POINTS, &[], config).expect("written")
    }

    #[test]
    fn a_cloud_is_read_back_with_the_place_of_its_sensor_and_a_wrong_byte_is_noticed() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        let config = RunCloudsConfig { min_free_bytes: 0, ..RunCloudsConfig::default() };
        assert_eq!(store.run_clouds(run(1)).expect("read"), []);
        let first = put(&store, run(1), 10, &config).expect("there is room");
        let second = put(&store, run(1), 20, &config).expect("there is room");
        assert_eq!(store.run_clouds(run(1)).expect("read"), [first.clone(), second]);
        let RunCloud { entry, mut xyz } = store.run_cloud(run(1), first.cloud).expect("read");
        assert_eq!(entry, first);
        xyz.sort_by(|a, b| b[0].total_cmp(&a[0]));
        for (read, wanted) in xyz.iter().zip([POINTS[1], POINTS[0], POINTS[2]]) {
            assert!((0..3).all(|axis| (read[axis] - wanted[axis]).abs() <= 0.0051), "{read:?} {wanted:?}");
        }
        let path = store.dir().run_cloud(run(1), first.cloud);
        let mut bytes = fs::read(&path).expect("read");
        bytes[40] ^= 1;
        fs::write(&path, bytes).expect("written");
        assert!(matches!(store.run_cloud(run(1), first.cloud), Err(StoreError::Broken { .. })));
        let folder = store.dir().run_clouds().join(run(1).to_string());
        assert!(is_run_clouds_folder(&folder));
        let read: Vec<_> = read_run_clouds(&folder).expect("read").map(|cloud| cloud.is_ok()).collect();
        assert_eq!(read, [false, true]);
        // A crash has cut the last line.
        let index = store.dir().run_cloud_index(run(1));
        let text = fs::read_to_string(&index).expect("read");
        fs::write(&index, &text[..text.len() - 9]).expect("written");
        assert_eq!(store.run_clouds(run(1)).expect("read").len(), 1);
    }

    #[test]
    fn the_oldest_run_makes_room_and_the_active_one_never() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        let free = RunCloudsConfig { min_free_bytes: 0, ..RunCloudsConfig::default() };
        put(&store, run(1), 10, &free).expect("there is room");
        let old = SystemTime::now() - std::time::Duration::from_secs(3_600);
        let index =
            fs::File::options().append(true).open(store.dir().run_cloud_index(run(1))).expect("there");
        index.set_modified(old).expect("set");
        put(&store, run(2), 20, &free).expect("there is room");
        let used = files::bytes_below(&store.dir().run_clouds()).expect("read");
        let full = RunCloudsConfig { max_bytes: used + 10, min_free_bytes: 0 };
        put(&store, run(3), 30, &full).expect("the oldest made room");
        assert_eq!(store.other_runs_with_clouds(run(3)).expect("read"), [run(2)]);
        let counts = [1, 2, 3].map(|number| store.run_clouds(run(number)).expect("read").len());
        assert_eq!(counts, [0, 1, 1]);
        let tiny = RunCloudsConfig { max_bytes: 10, min_free_bytes: 0 };
        assert_eq!(put(&store, run(3), 40, &tiny), None);
        let counts = [2, 3].map(|number| store.run_clouds(run(number)).expect("read").len());
        assert_eq!(counts, [0, 1], "that of the run under way stays");
    }
}
