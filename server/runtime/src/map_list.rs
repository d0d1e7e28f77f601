//! Lists of stored data for clients: saved maps, those that cannot be read, those in the bin, and uploaded files.

use crate::clock::CalendarTime;
use crate::state_publisher::StatePublisher;
use crate::texts;
use api::{Event, MAX_LISTED_MAPS};
use ports::error_with_causes;
use std::path::Path;
use store::{MapList, Store, StoreError};

/// Reads the lists of saved maps and of the bin, and publishes them.
///
/// # Errors
/// When a directory of maps cannot be read.
pub fn publish_map_list(
    store: &Store,
    state_publisher: &StatePublisher,
    now: CalendarTime,
) -> Result<(), StoreError> {
    let MapList { mut maps, mut damaged } = store.list_maps()?;
    if maps.len() > MAX_LISTED_MAPS {
        tracing::warn!(maps = maps.len(), "clients are shown the newest {MAX_LISTED_MAPS} saved maps only");
    }
    // Newest first.
    maps.truncate(MAX_LISTED_MAPS);
    damaged.truncate(MAX_LISTED_MAPS);
    state_publisher.publish(Event::Maps(maps));
    state_publisher.publish(Event::DamagedMaps(damaged.iter().map(damaged_map).collect()));
    let binned = store.binned_maps()?;
    state_publisher.publish(Event::BinnedMaps(
        binned.iter().take(MAX_LISTED_MAPS).map(|map| binned_map(map, now)).collect(),
    ));
    Ok(())
}

/// Reads the list of uploaded files and publishes it.
///
/// # Errors
/// When the directory of uploads cannot be read.
pub fn publish_uploads(
    store: &Store,
    state_publisher: &StatePublisher,
    now: CalendarTime,
) -> Result<(), StoreError> {
    let uploads = store.uploads()?.into_iter().map(|stored| {
        let kept_until = stored.kept_until();
        let note = stored.note.unwrap_or_default();
        api::StoredUpload {
            upload: stored.upload,
            name: Some(note.name).filter(|name| !name.is_empty()),
            frame: note.frame,
            bytes: stored.bytes,
            problem: note.problem,
            kept_until: now.synchronised().map(|_| kept_until),
        }
    });
    state_publisher.publish(Event::Uploads(uploads.collect()));
    Ok(())
}

fn damaged_map(map: &store::DamagedMap) -> api::DamagedMap {
    let folder = map.folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    api::DamagedMap { folder, problem: problem(&map.error), remedy: remedy(&map.error, &map.folder) }
}

fn problem(error: &StoreError) -> String {
    texts::damaged_map_problem(&error_with_causes(error))
}

fn remedy(error: &StoreError, folder: &Path) -> String {
    match error {
        StoreError::LaterVersion { .. } => texts::MAP_OF_LATER_PROGRAM_REMEDY.to_owned(),
        _ => texts::damaged_map_remedy(folder),
    }
}

fn binned_map(map: &store::BinnedMap, now: CalendarTime) -> api::BinnedMap {
    let kept_until = map.kept_until();
    api::BinnedMap {
        id: map.map,
        name: map.summary.as_ref().map_or_else(|| map.map.to_string(), |summary| summary.name.clone()),
        bytes: map.summary.as_ref().map_or(0, |summary| summary.bytes),
        kept_until,
        time_left: kept_until.zip(now.synchronised()).map(|(until, now)| until - now),
        problem: map.problem.as_ref().map(|error| format!("{} {}", problem(error), texts::STAYS_IN_BIN)),
    }
}
