//! The list of saved maps for clients, with those that cannot be read.

use crate::state_publisher::StatePublisher;
use crate::texts;
use api::Event;
use ports::error_with_causes;
use store::{MapList, Store, StoreError};

/// Reads the list of saved maps and publishes it.
///
/// # Errors
/// When the directory of maps cannot be read.
pub fn publish_map_list(store: &Store, state_publisher: &StatePublisher) -> Result<(), StoreError> {
    let MapList { maps, damaged } = store.list_maps()?;
    state_publisher.publish(Event::Maps(maps));
    state_publisher.publish(Event::DamagedMaps(damaged.iter().map(damaged_map).collect()));
    Ok(())
}

fn damaged_map(map: &store::DamagedMap) -> api::DamagedMap {
    let folder = map.folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let problem = texts::damaged_map_problem(&error_with_causes(&map.error));
    let remedy = match map.error {
        StoreError::LaterVersion { .. } => texts::MAP_OF_LATER_PROGRAM_REMEDY.to_owned(),
        _ => texts::damaged_map_remedy(&map.folder),
    };
    api::DamagedMap { folder, problem, remedy }
}
