//! Saved maps are renamed, deleted and restored, and the bin of deleted maps.

use super::Feature;
use crate::features::history::HistoryStep;
use crate::shared::{Context, SliceChange};
use crate::{ClientCommand, ClientEvent, ClientTime, texts};
use api::{BinnedMap, Severity};
use vocab::MapId;

/// Parameters of the deletion that can be undone at once.
struct MapDeletionConfig {
    /// Time for which it is on show with its undo, seconds. Chosen: long enough to notice a mistake. Afterwards the map can be restored from the bin.
    shown_s: f64,
}

const CONFIG: MapDeletionConfig = MapDeletionConfig { shown_s: 20.0 };

/// A map that was deleted at this client a moment ago.
#[derive(Clone, Debug, PartialEq)]
pub struct MapDeletion {
    /// The map.
    pub map: MapId,
    /// Its name.
    pub name: String,
    /// When the server has done it; `None` until then.
    done: Option<ClientTime>,
}

/// The bin, and the deletion that can be undone at once.
#[derive(Clone, Debug, Default)]
pub struct MapManagement {
    bin: Vec<BinnedMap>,
    deletion: Option<MapDeletion>,
}

impl MapManagement {
    /// Deleted maps, the last deleted first.
    pub fn bin(&self) -> &[BinnedMap] {
        &self.bin
    }

    /// The deletion on show.
    pub fn deletion(&self) -> Option<&MapDeletion> {
        self.deletion.as_ref().filter(|deletion| deletion.done.is_some())
    }

    /// A map in the bin.
    pub fn binned(&self, map: MapId) -> Option<&BinnedMap> {
        self.bin.iter().find(|binned| binned.id == map)
    }

    fn delete(&mut self, map: MapId, cx: &mut Context<'_>) {
        let name = cx.shared.maps.get(map).map_or_else(|| map.to_string(), |listed| listed.name.clone());
        self.deletion = Some(MapDeletion { map, name, done: None });
        cx.send(api::Command::DeleteMap(map));
    }

    fn on_deletion_answered(&mut self, map: MapId, accepted: bool, cx: &mut Context<'_>) {
        let Some(deletion) = self.deletion.as_mut().filter(|deletion| deletion.map == map) else { return };
        if accepted {
            deletion.done = Some(cx.now());
            cx.shared.history.add(HistoryStep::MapDeleted(map));
        } else {
            self.deletion = None;
        }
    }

    /// Views the live map if the saved one on the screen was deleted.
    fn leave_deleted_map(&self, cx: &mut Context<'_>) {
        let Some(viewed) = cx.shared.map_views.viewed() else { return };
        if cx.shared.maps.get(viewed).is_some() || self.binned(viewed).is_none() {
            return;
        }
        cx.view_map(None);
        if self.deletion.as_ref().is_none_or(|deletion| deletion.map != viewed) {
            cx.notify(Severity::Info, texts::VIEWED_MAP_DELETED.to_owned());
        }
    }
}

impl Feature for MapManagement {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        if let api::Event::BinnedMaps(bin) = event {
            bin.clone_into(&mut self.bin);
            let binned = |deletion: &MapDeletion| bin.iter().any(|map| map.id == deletion.map);
            self.deletion.take_if(|deletion| deletion.done.is_some() && !binned(deletion));
            self.leave_deleted_map(cx);
        }
    }

    fn on_client_event(&mut self, event: &ClientEvent, cx: &mut Context<'_>) {
        if matches!(event, ClientEvent::Tick) {
            let now = cx.now();
            self.deletion
                .take_if(|deletion| deletion.done.is_some_and(|done| now.since(done) > CONFIG.shown_s));
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::RenameMap { map, name } => {
                cx.send(api::Command::RenameMap { map: *map, name: name.clone() });
            }
            ClientCommand::DeleteMap(map) => self.delete(*map, cx),
            ClientCommand::RestoreMap(map) => {
                cx.shared.history.forget_map(*map);
                cx.send(api::Command::RestoreMap(*map));
            }
            ClientCommand::DeleteMapPermanently(map) => {
                cx.shared.history.forget_map(*map);
                cx.send(api::Command::DeleteMapPermanently(*map));
            }
            ClientCommand::DismissDeletion => self.deletion = None,
            _ => {}
        }
    }

    fn on_change(&mut self, change: &SliceChange, cx: &mut Context<'_>) {
        if let SliceChange::CommandAnswered {
            command: Some(api::Command::DeleteMap(map)), accepted, ..
        } = change
        {
            self.on_deletion_answered(*map, *accepted, cx);
        }
    }

    fn undo(&mut self, step: HistoryStep, cx: &mut Context<'_>) -> bool {
        let HistoryStep::MapDeleted(map) = step else { return false };
        cx.send(api::Command::RestoreMap(map));
        true
    }
}

#[cfg(test)]
mod tests;
