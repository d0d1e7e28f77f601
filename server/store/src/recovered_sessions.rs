//! Mapping sessions that their process did not end: it was killed, or the power went. They stay until a person saves or discards them.

use crate::checked_json::{Versions, read_checked_json, to_checked_json};
use crate::checksums::Checksums;
use crate::cloud_files::{CloudFiles, cloud_name};
use crate::session_journal::{RecoveredJournal, ScanPoses, SessionJournal};
use crate::session_records::HEADER_BYTES;
use crate::sessions::{is_cloud, keyframe_of, link_clouds};
use crate::{MapFilesReport, SavedMap, Store, StoreError, files, texts};
use api::InterruptedSession;
use messages::{FinishedMap, RevisitCounts};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::{MapId, SessionId};

/// Versions of [`SavingDocument`].
const SAVING_FORMAT_VERSIONS: Versions = Versions { first_checked: 2, newest: 2 };

/// Parameters of [`Store::interrupted_sessions`] and of the check of their clouds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SessionRecoveryConfig {
    /// Clouds without a keyframe in the journal from which on the journal has lost records. A cloud may be written up to a second before the pose of its
    /// keyframe, and a session makes at most this many keyframes in a second: one a metre, at the greatest speed of a legged robot, 4 m/s.
    pub(crate) min_clouds_without_keyframe: usize,
}

impl Default for SessionRecoveryConfig {
    fn default() -> Self {
        Self { min_clouds_without_keyframe: 4 }
    }
}

/// `saving.json` of a session: the map as which it is being saved. Once that map is on the disk, the session is not needed any more.
#[derive(Serialize, Deserialize)]
struct SavingDocument {
    format_version: u32,
    map: MapId,
}

/// The sessions that the last process left, and what is wrong with them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterruptedSessions {
    /// The newest first.
    pub sessions: Vec<InterruptedSession>,
    /// Damaged files and what became of them, sentences for people.
    pub problems: Vec<String>,
}

impl Store {
    /// The journal of a running session.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn session_journal(&self, session: SessionId) -> Result<SessionJournal, StoreError> {
        let folder = self.session(session);
        files::make_directory(&folder)?;
        SessionJournal::open(journal_path(&folder))
    }

    /// The sessions that the last process left. To be called before a session begins.
    ///
    /// # Errors
    /// When the directory of sessions cannot be read.
    pub fn interrupted_sessions(&self) -> Result<InterruptedSessions, StoreError> {
        let config = SessionRecoveryConfig::default();
        let mut found = InterruptedSessions::default();
        for folder in files::entries(&self.dir().sessions())? {
            let name = folder.file_name().unwrap_or_default().to_string_lossy();
            let Ok(session) = name.parse::<SessionId>() else { continue };
            let journal = journal_path(&folder);
            let clouds = files::entries(&folder)?.iter().filter_map(|path| keyframe_of(path)).max();
            let (read, problem) = match RecoveredJournal::read(&journal, ScanPoses::Ignored) {
                Ok(mut read) => {
                    let keyframes = read.graph.nodes.len();
                    let ends_early = clouds.is_some_and(|last| {
                        last.0 as usize >= keyframes + config.min_clouds_without_keyframe
                    });
                    let is_damaged = read.damaged_at.is_some() || ends_early;
                    let problem = is_damaged.then(|| texts::journal_damaged(&journal, keyframes));
                    match CloudFiles::open(&folder) {
                        Ok(clouds) => read.drop_last_keyframes_without_cloud(&clouds),
                        // Saving the session reports it.
                        Err(error) => tracing::warn!("{}", ports::error_with_causes(&error)),
                    }
                    (read, problem)
                }
                Err(error) => (RecoveredJournal::default(), Some(texts::journal_unreadable(&error))),
            };
            found.problems.extend(problem);
            found.sessions.push(InterruptedSession {
                session,
                at: read.last(),
                keyframes: read.graph.nodes.len() as u32,
                distance_m: read.distance_m,
                extends: read.extends,
            });
        }
        found.sessions.sort_by_key(|session| (std::cmp::Reverse(session.at), session.session));
        Ok(found)
    }

    /// Saves an interrupted session as a map, as [`Store::save_map`] does. The session stays. Returns also what is wrong with clouds that are damaged, sentences
    /// for people: they are left out of the map, and kept beside its clouds under another name.
    ///
    /// # Errors
    /// When the session has no keyframes, the map that it extends cannot be read, the id is taken, or the disk fails.
    pub fn save_interrupted_session(
        &self,
        session: SessionId,
        map: MapId,
        name: &str,
    ) -> Result<(MapFilesReport, Vec<String>), StoreError> {
        let folder = self.session(session);
        let mut journal = RecoveredJournal::read(&journal_path(&folder), ScanPoses::Wanted)?;
        let trajectory = journal.trajectory();
        journal.drop_last_keyframes_without_cloud(&CloudFiles::open(&folder)?);
        let finished = FinishedMap {
            map,
            name: name.to_owned(),
            session,
            extends: journal.extends,
            at: journal.last(),
            distance_m: journal.distance_m,
            trajectory,
            graph: Arc::new(journal.graph),
            degenerate: Vec::new(),
            decisions: journal.decisions,
            unverified: 0,
            revisits: RevisitCounts::default(),
        };
        let mut problems = Vec::new();
        let report = self.save_session(&finished, |from, to| {
            link_clouds(from, to)?;
            problems = put_damaged_clouds_aside(from, to, &finished)?;
            Ok(())
        })?;
        Ok((report, problems))
    }

    /// Notes durably as which map a session is being saved.
    pub(crate) fn mark_as_saving(&self, session: SessionId, map: MapId) -> Result<(), StoreError> {
        let path = saving_path(&self.session(session));
        let document = SavingDocument { format_version: SAVING_FORMAT_VERSIONS.newest, map };
        files::replace_durably(&path, &to_checked_json(&path, &document)?)
    }

    /// Removes sessions with nothing to lose: those whose map is on the disk, and those that have neither keyframes nor damage.
    pub(crate) fn remove_ended_sessions(&self) -> Result<(), StoreError> {
        for folder in files::entries(&self.dir().sessions())? {
            if self.is_saved(&folder) || is_empty(self, &folder)? {
                files::remove_directory_at_once(&folder)?;
            }
        }
        Ok(())
    }

    /// Whether the map as which a session was being saved is on the disk. A damaged map does not count.
    fn is_saved(&self, folder: &Path) -> bool {
        let path = saving_path(folder);
        if !path.exists() {
            return false;
        }
        match read_checked_json::<SavingDocument>(&path, SAVING_FORMAT_VERSIONS) {
            Ok(document) => self.is_on_disk(document.map),
            Err(error) => {
                self.add_problem(texts::saving_note_damaged(&error));
                false
            }
        }
    }

    /// Whether a map is saved, or in the bin, and can be read.
    fn is_on_disk(&self, map: MapId) -> bool {
        [self.dir().map(map), self.dir().binned_map(map)].iter().any(|folder| SavedMap::read(folder).is_ok())
    }
}

fn journal_path(session: &Path) -> PathBuf {
    session.join("journal.bin")
}

fn saving_path(session: &Path) -> PathBuf {
    session.join("saving.json")
}

/// Whether nothing would be lost with a session's folder: it has no clouds but copies of those of the map that it extends, and no keyframes.
fn is_empty(store: &Store, folder: &Path) -> Result<bool, StoreError> {
    if !folder.is_dir() {
        return Ok(false);
    }
    let clouds = files::entries(folder)?.into_iter().filter(|path| is_cloud(path)).collect::<Vec<_>>();
    let journal = journal_path(folder);
    if clouds.is_empty() && std::fs::metadata(&journal).map_or(true, |about| about.len() < HEADER_BYTES) {
        return Ok(true);
    }
    let Ok(read) = RecoveredJournal::read(&journal, ScanPoses::Ignored) else { return Ok(false) };
    if !read.graph.nodes.is_empty() || read.damaged_at.is_some() {
        return Ok(false);
    }
    let copied = match read.extends.map(|map| store.map(map)) {
        Some(Ok(map)) => map.poses.len() as u32,
        Some(Err(_)) => return Ok(false),
        None => 0,
    };
    Ok(!clouds.iter().any(|cloud| keyframe_of(cloud).is_some_and(|keyframe| keyframe.0 >= copied)))
}

/// Puts clouds aside that cannot be read, so that one of them does not keep the others from being saved. Returns what is wrong with them.
fn put_damaged_clouds_aside(
    session: &Path,
    clouds: &Path,
    finished: &FinishedMap,
) -> Result<Vec<String>, StoreError> {
    // Damaged checksums were reported when the program started. They must not keep the session from being saved.
    let sums = Checksums::read(session).ok().flatten().unwrap_or_default();
    let cloud_files = CloudFiles::open(clouds)?;
    let mut problems = Vec::new();
    for node in &finished.graph.nodes {
        let name = cloud_name(node.id);
        let read = cloud_files.read(node.id, node.stamp).and_then(|_| match sums.has(&name) {
            true => sums.check(clouds, &name).map(drop),
            false => Ok(()),
        });
        if let Err(error) = read {
            let aside = files::put_aside(&clouds.join(&name))?;
            problems.push(texts::cloud_damaged(&error, &aside));
        }
    }
    Ok(problems)
}

#[cfg(test)]
#[path = "recovered_sessions_tests.rs"]
mod tests;
