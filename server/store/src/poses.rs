//! Poses in saved maps that outlive the process: where the robot was last (`place.json`), and its docks (`docks.json`).
//!
//! Both are JSON documents with a version and a checksum. A file that cannot be read is put aside under another name and counts as absent. One that a later
//! program wrote counts as absent too; it is left as it is, and nothing is written in its place.

use crate::checked_json::{Versions, read_checked_json, to_checked_json};
use crate::{Store, StoreError, files, texts};
use messages::PoseInMap;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

/// Versions of both documents.
pub(crate) const POSES_FORMAT_VERSIONS: Versions = Versions { first_checked: 2, newest: 2 };

/// `place.json`. Programs up to November 2026 wrote no version, which counts as 1.
#[derive(Serialize, Deserialize)]
struct PoseDocument {
    #[serde(default = "files::first_format_version")]
    format_version: u32,
    #[serde(flatten)]
    pose: PoseInMap,
}

/// `docks.json`.
#[derive(Serialize, Deserialize)]
pub(crate) struct DocksDocument {
    format_version: u32,
    pub(crate) docks: Vec<PoseInMap>,
}

impl Store {
    /// The robot's last known pose in a map, if that map still exists.
    pub fn last_pose(&self) -> Option<PoseInMap> {
        let document: PoseDocument =
            self.read_or_put_aside(&self.dir().last_pose(), read_pose, texts::POSE_IS_FORGOTTEN)?;
        Some(document.pose).filter(|pose| self.dir().map(pose.map).exists())
    }

    /// The saved pose, whether its map exists or not.
    pub(crate) fn stored_pose(&self) -> Option<PoseInMap> {
        let document: PoseDocument =
            read_checked_json(&self.dir().last_pose(), POSES_FORMAT_VERSIONS).ok()?;
        Some(document.pose)
    }

    /// Saves the robot's pose for the next start, or deletes the saved one. Both survive a power cut.
    ///
    /// # Errors
    /// When the disk fails, or a later program wrote the file.
    pub fn save_last_pose(&self, pose: Option<&PoseInMap>) -> Result<(), StoreError> {
        let path = self.dir().last_pose();
        files::check_replaceable(&path, POSES_FORMAT_VERSIONS.newest)?;
        let Some(&pose) = pose else { return files::remove_file_durably(&path) };
        let document = PoseDocument { format_version: POSES_FORMAT_VERSIONS.newest, pose };
        files::replace_durably(&path, &to_checked_json(&path, &document)?)
    }

    /// Docks in the saved maps and in those in the bin, without those of maps that no longer exist.
    pub fn docks(&self) -> Vec<PoseInMap> {
        let docks = self.read_or_put_aside(&self.dir().docks(), read_docks, texts::DOCKS_ARE_FORGOTTEN);
        let mut docks = docks.unwrap_or_default();
        docks.retain(|dock| self.dir().map(dock.map).exists() || self.dir().binned_map(dock.map).exists());
        docks
    }

    /// Saves the docks for the next start.
    ///
    /// # Errors
    /// When the disk fails, or a later program wrote the file.
    pub fn save_docks(&self, docks: &[PoseInMap]) -> Result<(), StoreError> {
        let path = self.dir().docks();
        files::check_replaceable(&path, POSES_FORMAT_VERSIONS.newest)?;
        let document = DocksDocument { format_version: POSES_FORMAT_VERSIONS.newest, docks: docks.to_vec() };
        files::replace_durably(&path, &to_checked_json(&path, &document)?)
    }

    /// Reads a document that the program can do without. One that cannot be read is put aside, because this program will write its own. People are told
    /// of both, with `consequence`, a sentence.
    fn read_or_put_aside<T>(
        &self,
        path: &Path,
        read: impl FnOnce(&Path) -> Result<T, StoreError>,
        consequence: &str,
    ) -> Option<T> {
        if !path.exists() {
            return None;
        }
        match read(path) {
            Ok(document) => return Some(document),
            Err(error @ StoreError::LaterVersion { .. }) => {
                self.add_problem(texts::file_of_later_program(&error, consequence));
            }
            Err(error) => {
                self.add_problem(texts::file_damaged(&error, &files::put_aside(path), consequence));
            }
        }
        None
    }
}

fn read_pose(path: &Path) -> Result<PoseDocument, StoreError> {
    read_checked_json(path, POSES_FORMAT_VERSIONS)
}

/// Programs up to November 2026 wrote the list alone.
fn read_docks(path: &Path) -> Result<Vec<PoseInMap>, StoreError> {
    let bytes = fs::read(path).map_err(|source| StoreError::io("read", path, source))?;
    if bytes.starts_with(b"[") {
        return files::read_json(path);
    }
    Ok(read_checked_json::<DocksDocument>(path, POSES_FORMAT_VERSIONS)?.docks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use uuid::Uuid;
    use vocab::{MapId, Pose, Vec3};

    fn pose_in(map: MapId) -> PoseInMap {
        PoseInMap { map, map_from_base: Pose { position: Vec3::new(1.5, -2.0, 0.5), ..Pose::IDENTITY } }
    }

    fn store_with_map(dir: &Path) -> (Store, PoseInMap) {
        let store = Store::open(dir).expect("opens");
        let map = MapId(Uuid::from_u128(3));
        fs::create_dir_all(store.dir().map(map)).expect("made");
        (store, pose_in(map))
    }

    #[test]
    fn documents_without_a_version_are_read() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let (store, pose) = store_with_map(dir.path());
        fs::write(store.dir().last_pose(), serde_json::to_vec(&pose).expect("json")).expect("written");
        fs::write(store.dir().docks(), serde_json::to_vec(&[pose]).expect("json")).expect("written");
        assert_eq!((store.last_pose(), store.docks()), (Some(pose), vec![pose]));
        store.save_last_pose(Some(&pose)).expect("saved");
        store.save_docks(&[pose]).expect("saved");
        for path in [store.dir().last_pose(), store.dir().docks()] {
            let document: serde_json::Value = files::read_json(&path).expect("json");
            assert_eq!(document["format_version"], 2);
        }
        assert_eq!((store.last_pose(), store.docks()), (Some(pose), vec![pose]));
    }

    #[test]
    fn documents_that_cannot_be_read_are_kept_under_another_name() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let (store, pose) = store_with_map(dir.path());
        for (number, content) in ["nonsense", "[{}]"].into_iter().enumerate() {
            fs::write(store.dir().docks(), content).expect("written");
            assert_eq!(store.docks(), []);
            store.save_docks(&[pose]).expect("saved");
            let aside = ["docks.json.damaged", "docks.json.damaged-2"][number];
            assert_eq!(fs::read_to_string(dir.path().join(aside)).expect("kept"), content);
        }
        fs::write(store.dir().last_pose(), "").expect("written");
        assert_eq!(store.last_pose(), None);
        assert!(dir.path().join("place.json.damaged").exists() && !store.dir().last_pose().exists());
        let problems = store.take_problems();
        assert_eq!(problems.len(), 3, "people are told of each: {problems:?}");
        assert!(
            problems[0].contains("docks.json.damaged") && problems[2].contains("place.json"),
            "{problems:?}"
        );
    }

    #[test]
    fn documents_of_a_later_program_are_left_as_they_are() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let (store, pose) = store_with_map(dir.path());
        let later = r#"{"format_version":3,"beacons":[]}"#;
        for path in [store.dir().last_pose(), store.dir().docks()] {
            fs::write(path, later).expect("written");
        }
        assert_eq!((store.last_pose(), store.docks()), (None, Vec::new()));
        let refused =
            [store.save_last_pose(Some(&pose)), store.save_last_pose(None), store.save_docks(&[pose])];
        assert!(
            refused.iter().all(|saved| matches!(saved, Err(StoreError::LaterVersion { version: 3, .. })))
        );
        for path in [store.dir().last_pose(), store.dir().docks()] {
            assert_eq!(fs::read_to_string(path).expect("kept"), later);
        }
        let problems = store.take_problems();
        let is_reported = |name: &str| {
            problems.iter().any(|text| text.contains(name) && text.contains("update AutoInspect"))
        };
        assert!(is_reported("place.json") && is_reported("docks.json"), "{problems:?}");
    }

    #[test]
    fn poses_in_a_damaged_map_are_kept() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let (store, pose) = store_with_map(dir.path());
        store.save_docks(&[pose]).expect("saved");
        assert_eq!(store.damaged_maps().expect("listed").len(), 1, "it has no map.json");
        assert_eq!(store.docks(), [pose]);
    }
}
