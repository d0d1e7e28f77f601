//! What people change in stored data: maps are renamed, deleted and restored, uploaded files deleted. It is done by the disk lane, which also deletes
//! for good what was kept long enough.

use crate::clock::{CalendarTime, RobotClock};
use crate::mailbox::Mailbox;
use crate::map_list::{publish_map_list, publish_uploads};
use crate::map_usage::{MapUsage, MapUse};
use crate::state_publisher::StatePublisher;
use crate::texts;
use api::InterruptedSession;
use messages::{Principal, Severity};
use ports::error_with_causes;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};
use store::{Store, StoreError};
use vocab::{CommandId, MapId, UploadId};

/// Parameters of [`StoredDataWorker::clean_up`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CleanUpConfig {
    /// Time between two clean-ups. What is kept for days may stay an hour longer. Chosen: an hour, so that the disk is read seldom.
    pub period: Duration,
    /// Time between two searches for unused tiles, which read the tile lists of all maps. They are searched at each start too. Chosen: a day, as the grace of unused
    /// tiles.
    pub tiles_period: Duration,
}

impl Default for CleanUpConfig {
    fn default() -> Self {
        Self { period: Duration::from_secs(3600), tiles_period: Duration::from_secs(24 * 3600) }
    }
}

/// A change that a person asks for.
pub struct StoredDataRequest {
    /// Made by the client.
    pub id: CommandId,
    /// Who asks.
    pub by: Principal,
    /// What is to be done.
    pub change: StoredDataChange,
}

/// What is to be done.
pub enum StoredDataChange {
    /// Give a map another name.
    RenameMap(MapId, String),
    /// Move a map to the bin.
    DeleteMap(MapId),
    /// Move a map back.
    RestoreMap(MapId),
    /// Delete a map in the bin for good.
    DeleteMapPermanently(MapId),
    /// Delete an uploaded file.
    DeleteUpload(UploadId),
}

/// Carries changes out. Each can be repeated: what is done already counts as done.
pub struct StoredDataWorker {
    pub config: CleanUpConfig,
    pub store: Arc<Store>,
    pub state_publisher: Arc<StatePublisher>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
    pub usage: Arc<MapUsage>,
    /// Reads the calendar time.
    pub calendar: fn() -> CalendarTime,
    /// When unused tiles were searched last.
    pub tiles_searched: Instant,
}

impl StoredDataWorker {
    /// Carries out a change and answers it. The sessions are those that were interrupted.
    pub fn handle(&self, request: StoredDataRequest, interrupted: &[InterruptedSession]) {
        let StoredDataRequest { id, by, change } = request;
        let done = match change {
            StoredDataChange::RenameMap(map, name) => self.rename(map, &name),
            StoredDataChange::DeleteMap(map) => self.delete(map, interrupted),
            StoredDataChange::RestoreMap(map) => self.store.restore_map(map).map_err(refusal),
            StoredDataChange::DeleteMapPermanently(map) => {
                self.store.delete_map_permanently(map).map_err(refusal)
            }
            StoredDataChange::DeleteUpload(upload) => self.delete_upload(upload),
        };
        // Before the answer, so that whoever waits for it finds the new state.
        self.publish();
        self.state_publisher.answer(id, by.client, done.err());
    }

    fn rename(&self, map: MapId, name: &str) -> Result<(), String> {
        let name = stack::map_name(name).ok_or(texts::MAP_NEEDS_NAME)?;
        self.store.rename_map(map, &name).map_err(refusal)
    }

    fn delete(&self, map: MapId, interrupted: &[InterruptedSession]) -> Result<(), String> {
        let is_interrupted = interrupted.iter().any(|session| session.extends == Some(map));
        let of_session = is_interrupted.then_some(MapUse::InterruptedSession);
        if let Some(map_use) = self.usage.use_of(map).or(of_session) {
            return Err(texts::map_in_use(map_use).to_owned());
        }
        self.store.bin_map(map, (self.calendar)().synchronised()).map_err(refusal)
    }

    fn delete_upload(&self, upload: UploadId) -> Result<(), String> {
        if self.usage.is_importing(upload) {
            return Err(texts::UPLOAD_IN_USE.to_owned());
        }
        self.store.remove_upload(upload).map_err(refusal)
    }

    /// Deletes for good what was kept long enough. While the computer's clock is not synchronised, nothing is.
    pub fn clean_up(&mut self) {
        if let Some(now) = (self.calendar)().synchronised() {
            match self.store.empty_bin(now) {
                Ok(names) => {
                    for name in names {
                        self.mailbox.notice(self.clock.now(), Severity::Info, texts::map_left_bin(&name));
                    }
                }
                Err(error) => tracing::error!("the bin cannot be emptied: {}", error_with_causes(&error)),
            }
            if let Err(error) = self.store.remove_expired_uploads(now) {
                tracing::error!("an uploaded file cannot be removed: {}", error_with_causes(&error));
            }
        }
        if !self.usage.is_mapping() && self.tiles_searched.elapsed() >= self.config.tiles_period {
            self.tiles_searched = Instant::now();
            if let Err(error) = self.store.remove_unused_tiles(SystemTime::now()) {
                tracing::error!("no unused tile was removed: {}", error_with_causes(&error));
            }
        }
        self.publish();
    }

    fn publish(&self) {
        let calendar = (self.calendar)();
        let published = publish_map_list(&self.store, &self.state_publisher, calendar)
            .and_then(|()| publish_uploads(&self.store, &self.state_publisher, calendar));
        if let Err(error) = published {
            tracing::error!("{}", error_with_causes(&error));
        }
    }
}

/// Why the store refuses a change, one sentence for people.
fn refusal(error: StoreError) -> String {
    match error {
        StoreError::NoSuchMap { .. } => texts::MAP_MISSING.to_owned(),
        StoreError::NotInBin { .. } => texts::MAP_NOT_IN_BIN.to_owned(),
        StoreError::MapInBin { .. } => texts::SAME_MAP_IN_BIN.to_owned(),
        StoreError::MapExists { .. } => texts::SAME_MAP_SAVED.to_owned(),
        error => texts::stored_data_unchanged(&error_with_causes(&error)),
    }
}

#[cfg(test)]
#[path = "stored_data_tests.rs"]
mod tests;
