//! Uploaded files, which become maps. A file goes once a map was made of it. One of which no map could be made is kept for a second attempt, for
//! [`UPLOAD_RETENTION`], also over a restart.
//!
//! ```text
//! uploads/<id>        the file, as the gateway has received it
//! uploads/<id>.json   what is known of it besides its bytes, once an import was begun
//! uploads/<id>.part   a file that the gateway is receiving; not of the store
//! uploads/<id>.map/   the map that is being made of it
//! ```

use crate::checked_json::{Versions, read_checked_json, to_checked_json};
use crate::{Store, StoreError, files};
use api::{DISK_RESERVE_BYTES, UPLOAD_RETENTION};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use vocab::{MapId, Stamp, UploadId};

/// Versions of [`NoteDocument`].
pub(crate) const NOTE_FORMAT_VERSIONS: Versions = Versions { first_checked: 2, newest: 2 };

/// Parameters of the space for imports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImportSpaceConfig {
    /// Size of a map relative to the file that it is made of, at most. A map takes 14 bytes a point (`docs/benchmarks/import.md`); LAZ, the smallest format, some 3.
    /// Chosen: the ratio of both, rounded up.
    pub max_map_per_file: u64,
}

impl Default for ImportSpaceConfig {
    fn default() -> Self {
        Self { max_map_per_file: 5 }
    }
}

/// What is known of an uploaded file besides its bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct UploadNote {
    /// Name of the map that it becomes.
    #[serde(default)]
    pub name: String,
    /// The map whose frame that map is to have, if any.
    #[serde(default)]
    pub frame: Option<MapId>,
    /// Why the last import failed, one sentence.
    #[serde(default)]
    pub problem: Option<String>,
}

/// `uploads/<id>.json`.
#[derive(Serialize, Deserialize)]
struct NoteDocument {
    format_version: u32,
    #[serde(flatten)]
    note: UploadNote,
}

/// An uploaded file that no map was made of yet.
#[derive(Debug)]
pub struct StoredUpload {
    /// Its id.
    pub upload: UploadId,
    /// Its size.
    pub bytes: u64,
    /// What is known of it; none before the first import, or if that cannot be read.
    pub note: Option<UploadNote>,
    /// When it came, or the last import of it began or ended: time of the computer's clock.
    pub changed: Stamp,
}

impl StoredUpload {
    /// When it is deleted, if the computer's clock was right and is.
    pub fn kept_until(&self) -> Stamp {
        self.changed + UPLOAD_RETENTION
    }
}

impl Store {
    /// Uploaded files, the oldest first.
    ///
    /// # Errors
    /// When the directory of uploads cannot be read.
    pub fn uploads(&self) -> Result<Vec<StoredUpload>, StoreError> {
        let mut uploads = Vec::new();
        for path in files::entries(&self.dir().uploads())? {
            let id = path.file_name().and_then(|name| name.to_str()?.parse::<UploadId>().ok());
            let (Some(upload), Ok(about)) = (id, fs::metadata(&path)) else { continue };
            let note = self.dir().upload_note(upload);
            let read: Result<NoteDocument, _> = read_checked_json(&note, NOTE_FORMAT_VERSIONS);
            uploads.push(StoredUpload {
                upload,
                bytes: about.len(),
                note: read.ok().map(|document| document.note),
                changed: modified(&path).max(modified(&note)),
            });
        }
        uploads.sort_by_key(|upload| (upload.changed, upload.upload));
        Ok(uploads)
    }

    /// Notes what is known of an uploaded file. The time for which it is kept begins anew.
    ///
    /// # Errors
    /// When the disk fails, or a later program wrote the note.
    pub fn note_upload(&self, upload: UploadId, note: UploadNote) -> Result<(), StoreError> {
        let path = self.dir().upload_note(upload);
        files::check_replaceable(&path, NOTE_FORMAT_VERSIONS.newest)?;
        let document = NoteDocument { format_version: NOTE_FORMAT_VERSIONS.newest, note };
        files::replace_durably(&path, &to_checked_json(&path, &document)?)
    }

    /// Removes an uploaded file; no error if it does not exist.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn remove_upload(&self, upload: UploadId) -> Result<(), StoreError> {
        files::remove_file(&self.dir().upload(upload))?;
        files::remove_file(&self.dir().upload_note(upload))
    }

    /// Removes uploaded files that were kept long enough at this calendar time. Returns whether there were any.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn remove_expired_uploads(&self, now: Stamp) -> Result<bool, StoreError> {
        let uploads = self.uploads()?;
        let mut expired = uploads.iter().filter(|upload| upload.kept_until() <= now).peekable();
        let any = expired.peek().is_some();
        expired.try_for_each(|upload| self.remove_upload(upload.upload)).map(|()| any)
    }

    /// Whether the disk has space for the map that is made of an uploaded file, and for further recordings.
    ///
    /// # Errors
    /// When the system does not say.
    pub fn has_space_for_import(
        &self,
        upload: UploadId,
        config: &ImportSpaceConfig,
    ) -> Result<bool, StoreError> {
        let path = self.dir().upload(upload);
        let about = fs::metadata(&path).map_err(|source| StoreError::io("read", &path, source))?;
        let needed = about.len().saturating_mul(config.max_map_per_file).saturating_add(DISK_RESERVE_BYTES);
        Ok(files::free_bytes(&self.dir().uploads())? >= needed)
    }

    /// Removes what their process did not end: the halves of maps, notes without a file and half-written ones, and files that the gateway has not written to for
    /// [`UPLOAD_RETENTION`]. It may still be receiving the others.
    pub(crate) fn remove_unfinished_uploads(&self, now: SystemTime) -> Result<(), StoreError> {
        let retention = Duration::from_secs_f64(UPLOAD_RETENTION.secs_f64());
        for path in files::entries(&self.dir().uploads())? {
            match upload_of(&path) {
                Some((_, "map")) => files::remove_directory(&path)?,
                Some((_, "json.part")) => files::remove_file(&path)?,
                Some((_, "part")) if files::is_older_than(&path, retention, now) => {
                    files::remove_file(&path)?
                }
                Some((upload, "json")) if !self.dir().upload(upload).exists() => files::remove_file(&path)?,
                _ => {}
            }
        }
        Ok(())
    }
}

/// The upload that a file or folder belongs to, with the ending of its name.
fn upload_of(path: &Path) -> Option<(UploadId, &str)> {
    let (upload, ending) = path.file_name()?.to_str()?.split_once('.')?;
    Some((upload.parse().ok()?, ending))
}

/// When a file was written last; the epoch if nobody knows.
fn modified(path: &Path) -> Stamp {
    let modified = fs::metadata(path).and_then(|about| about.modified()).unwrap_or(UNIX_EPOCH);
    stamp(modified)
}

fn stamp(time: SystemTime) -> Stamp {
    let since = time.duration_since(UNIX_EPOCH).unwrap_or_default();
    Stamp::from_nanos(i64::try_from(since.as_nanos()).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use uuid::Uuid;
    use vocab::Span;

    const UPLOAD: UploadId = UploadId(Uuid::from_u128(4));

    fn note() -> UploadNote {
        UploadNote {
            name: "Hall".to_owned(),
            frame: Some(MapId(Uuid::from_u128(2))),
            problem: Some("It is no cloud.".to_owned()),
        }
    }

    /// A store with one uploaded file.
    fn stored(dir: &Path) -> Store {
        let store = Store::open(dir).expect("opens");
        fs::write(store.dir().upload(UPLOAD), "points").expect("written");
        store
    }

    #[test]
    fn files_survive_a_restart_with_their_notes_and_halves_of_maps_do_not() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = stored(dir.path());
        store.note_upload(UPLOAD, note()).expect("noted");
        let half = store.dir().upload_map(UPLOAD);
        fs::create_dir_all(half.join("tiles")).expect("made");
        let orphan = store.dir().upload_note(UploadId(Uuid::from_u128(5)));
        fs::write(&orphan, "{}").expect("written");
        let arriving = store.dir().upload(UPLOAD).with_extension("part");
        fs::write(&arriving, "poi").expect("written");
        drop(store);
        let store = Store::open(dir.path()).expect("opens");
        let [kept] = store.uploads().expect("listed").try_into().expect("one");
        assert_eq!((kept.upload, kept.bytes, kept.note), (UPLOAD, 6, Some(note())));
        assert!(!half.exists() && !orphan.exists());
        assert!(arriving.exists(), "the gateway may still be receiving it");
        // Of a note that was being written, and of a gateway that was killed.
        let half_note = store.dir().uploads().join(format!("{UPLOAD}.json.part"));
        fs::write(&half_note, "{").expect("written");
        let file = fs::File::options().write(true).open(&arriving).expect("opens");
        file.set_modified(SystemTime::now() - Duration::from_secs(25 * 3600)).expect("made older");
        drop(store);
        let store = Store::open(dir.path()).expect("opens");
        assert!(!arriving.exists() && !half_note.exists());
        assert_eq!(store.uploads().expect("listed").len(), 1);
    }

    #[test]
    fn files_are_kept_for_a_day_after_the_last_attempt() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = stored(dir.path());
        let came = store.uploads().expect("listed")[0].changed;
        let until = came + UPLOAD_RETENTION;
        assert!(!store.remove_expired_uploads(until - Span::from_millis(1)).expect("removed"));
        store.note_upload(UPLOAD, note()).expect("noted");
        let until = store.uploads().expect("listed")[0].kept_until();
        assert!(until > came + UPLOAD_RETENTION, "a note begins the time anew");
        assert!(store.remove_expired_uploads(until).expect("removed"));
        assert!(!store.dir().upload(UPLOAD).exists() && !store.dir().upload_note(UPLOAD).exists());
    }

    #[test]
    fn a_note_of_a_later_program_is_left_as_it_is_and_one_without_fields_has_defaults() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = stored(dir.path());
        let path = store.dir().upload_note(UPLOAD);
        let later = r#"{"format_version":3,"title":"Hall"}"#;
        fs::write(&path, later).expect("written");
        assert_eq!(store.uploads().expect("listed")[0].note, None);
        assert!(matches!(store.note_upload(UPLOAD, note()), Err(StoreError::LaterVersion { .. })));
        assert_eq!(fs::read_to_string(&path).expect("kept"), later);
        fs::write(&path, r#"{"format_version":1}"#).expect("written");
        assert_eq!(store.uploads().expect("listed")[0].note, Some(UploadNote::default()));
    }
}
