//! What was last seen of each place: clouds of several runs in one folder, in the form of the clouds of one run, and what was found to have changed between them.
//!
//! The folder has hard links to the clouds, or copies where the file system has none, `index.jsonl` as that of a run, and `changed-since.json`. It is made for one comparison and removed after it, so the
//! clouds themselves and what each run has found stay the only source.

use crate::run_clouds::{INDEX, RunCloudEntry};
use crate::{Store, StoreError, files};
use serde::{Deserialize, Serialize};
use site_model::{OrientedBox, RunId};
use std::fs;
use std::path::Path;

const CHANGED_SINCE: &str = "changed-since.json";
const FORMAT_VERSION: u32 = 1;

/// A thing that a run has found to be elsewhere than before. Rays of older clouds that ended at it where it was, or went through where it is, tell nothing any more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChangedSince {
    /// When the first cloud of the run was seen, UTC, nanoseconds since 1970: older clouds show what was before.
    pub utc_ns: i64,
    /// Where it was, frame of the map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub was: Option<OrientedBox>,
    /// Where it is, frame of the map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub is: Option<OrientedBox>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Document {
    format_version: u32,
    changes: Vec<ChangedSince>,
}

impl Store {
    /// Puts clouds of runs into a new folder. A cloud that is gone, because newer ones needed its room, is left out.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn put_background(
        &self,
        folder: &Path,
        clouds: &[(RunId, RunCloudEntry)],
        changes: Vec<ChangedSince>,
    ) -> Result<(), StoreError> {
        files::make_directory(folder)?;
        let mut index = Vec::new();
        for (run, entry) in clouds {
            let (from, to) = (self.dir().run_cloud(*run, entry.cloud), folder.join(entry.cloud.to_string()));
            if !from.exists() {
                continue;
            }
            // Two runs have the same cloud only if it is the same file.
            if !to.exists() {
                fs::hard_link(&from, &to)
                    .or_else(|_| fs::copy(&from, &to).map(|_| ()))
                    .map_err(|source| StoreError::io("write", &to, source))?;
            }
            // Plain data always becomes JSON.
            index.extend(serde_json::to_vec(entry).unwrap_or_default());
            index.push(b'\n');
        }
        files::replace_durably(&folder.join(INDEX), &index)?;
        files::write_json(&folder.join(CHANGED_SINCE), &Document { format_version: FORMAT_VERSION, changes })
    }
}

/// What was found to have changed between the clouds in a folder; nothing for the folder of one run.
///
/// # Errors
/// When the list cannot be read.
pub fn read_changed_since(folder: &Path) -> Result<Vec<ChangedSince>, StoreError> {
    let path = folder.join(CHANGED_SINCE);
    if !path.exists() {
        return Ok(Vec::new());
    }
    Ok(files::read_json::<Document>(&path)?.changes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RunCloudsConfig, read_run_clouds, run_clouds};
    use uuid::Uuid;
    use vocab::Vec3;

    #[test]
    fn clouds_of_several_runs_are_read_as_those_of_one() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        let config = RunCloudsConfig { min_free_bytes: 0, ..RunCloudsConfig::default() };
        let mut clouds = Vec::new();
        for number in 1..=3_u8 {
            let run = RunId(Uuid::from_u128(number.into()));
            let entry = run_clouds::tests::entry(number.into());
            let put = store.put_run_cloud(run, entry, &[[f32::from(number), 2.0, 3.0]], &[], &config);
            clouds.push((run, put.expect("written").expect("there is room")));
        }
        fs::remove_file(store.dir().run_cloud(clouds[1].0, clouds[1].1.cloud)).expect("removed");
        let folder = dir.path().join("background");
        let place = OrientedBox { centre_m: Vec3::new(1.0, 2.0, 0.5), size_m: [0.5; 3], yaw_rad: 0.1 };
        let change = ChangedSince { utc_ns: 7, was: Some(place), is: None };
        store.put_background(&folder, &clouds, vec![change]).expect("written");
        let read: Vec<_> =
            read_run_clouds(&folder).expect("read").map(|cloud| cloud.expect("whole")).collect();
        assert_eq!(
            read.iter().map(|cloud| cloud.entry.clone()).collect::<Vec<_>>(),
            [clouds[0].1.clone(), clouds[2].1.clone()]
        );
        assert_eq!(read_changed_since(&folder).expect("read"), [change]);
        assert_eq!(read_changed_since(&store.dir().clouds_of_run(clouds[0].0)).expect("read"), []);
        // The clouds stay when the folder goes.
        fs::remove_dir_all(&folder).expect("removed");
        assert!(store.run_cloud(clouds[0].0, clouds[0].1.cloud).is_ok());
        fs::create_dir_all(&folder).expect("made");
        fs::write(folder.join(CHANGED_SINCE), "{").expect("written");
        assert!(matches!(read_changed_since(&folder), Err(StoreError::Document { .. })));
    }
}
