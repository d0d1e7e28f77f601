//! The saved maps of the robot, those that cannot be read, and their docks.

#[cfg(test)]
mod tests;

use api::{DamagedMap, MapDock, MapSummary};
use vocab::{MapId, Pose};

/// Saved maps and docks as the server last listed them.
#[derive(Clone, Debug, Default)]
pub struct SavedMaps {
    maps: Option<Vec<MapSummary>>,
    damaged: Vec<DamagedMap>,
    docks: Vec<MapDock>,
}

impl SavedMaps {
    /// Saved maps, newest first; `None` before the server listed them.
    pub fn list(&self) -> Option<&[MapSummary]> {
        self.maps.as_deref()
    }

    /// Saved maps that the server cannot read.
    pub fn damaged(&self) -> &[DamagedMap] {
        &self.damaged
    }

    /// Number of saved maps that are known.
    pub fn len(&self) -> usize {
        self.maps.as_ref().map_or(0, Vec::len)
    }

    /// Whether no saved map is known.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One saved map; `None` if it is not listed.
    pub fn get(&self, id: MapId) -> Option<&MapSummary> {
        self.maps.iter().flatten().find(|map| map.id == id)
    }

    /// Docks of one map: the pose of the base while it is charged there, map frame.
    pub fn docks_of(&self, map: Option<MapId>) -> impl Iterator<Item = &Pose> {
        self.docks.iter().filter(move |dock| Some(dock.map) == map).map(|dock| &dock.map_from_base)
    }

    pub(crate) fn set_maps(&mut self, maps: Vec<MapSummary>) {
        self.maps = Some(maps);
    }

    pub(crate) fn set_damaged(&mut self, damaged: Vec<DamagedMap>) {
        self.damaged = damaged;
    }

    pub(crate) fn set_docks(&mut self, docks: Vec<MapDock>) {
        self.docks = docks;
    }
}
