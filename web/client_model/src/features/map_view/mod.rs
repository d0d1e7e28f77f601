//! The maps on the screen: the live one under construction and a saved one that is viewed; which tiles of them are fetched. What
//! changes them is in `reducer`.

pub(crate) mod reducer;
mod robust_bounds;
mod tiles;
mod view;
mod viewpoint;

pub use tiles::{TilePlanConfig, TileSet, TileState};
pub use view::{Loading, MapView};
pub use viewpoint::Viewpoint;

use crate::{ClientEffect, ClientTime};
use vocab::MapId;

/// The live map, the saved map that is viewed, and the viewpoint for which tiles are planned.
#[derive(Debug)]
pub(crate) struct MapViews {
    live: MapView,
    saved: Option<(MapId, MapView)>,
    viewpoint: Option<Viewpoint>,
    planned: ClientTime,
}

impl Default for MapViews {
    fn default() -> Self {
        Self { live: MapView::live(), saved: None, viewpoint: None, planned: ClientTime(f64::NEG_INFINITY) }
    }
}

impl MapViews {
    pub(crate) fn live(&self) -> &MapView {
        &self.live
    }

    pub(crate) fn saved(&self) -> Option<(MapId, &MapView)> {
        self.saved.as_ref().map(|(id, view)| (*id, view))
    }

    pub(crate) fn viewed(&self) -> Option<MapId> {
        self.saved.as_ref().map(|(id, _)| *id)
    }

    pub(crate) fn displayed(&self) -> &MapView {
        self.saved.as_ref().map_or(&self.live, |(_, map)| map)
    }

    fn displayed_mut(&mut self) -> &mut MapView {
        self.saved.as_mut().map_or(&mut self.live, |(_, map)| map)
    }

    fn saved_mut(&mut self, map: MapId) -> Option<&mut MapView> {
        self.saved.as_mut().filter(|(id, _)| *id == map).map(|(_, view)| view)
    }

    /// Views a saved map, or the live one. Returns whether another one was viewed before.
    pub(crate) fn view(&mut self, map: Option<MapId>, effects: &mut Vec<ClientEffect>) -> bool {
        if self.viewed() == map {
            return false;
        }
        self.displayed_mut().tiles.unload(false, effects);
        self.saved = map.map(|id| (id, MapView::default()));
        self.displayed_mut().tiles.mark_dirty();
        effects.extend(map.map(ClientEffect::LoadMap));
        true
    }

    /// Fetches and drops tiles for the viewpoint if that is due.
    pub(crate) fn plan(&mut self, now: ClientTime, effects: &mut Vec<ClientEffect>) {
        let Some(viewpoint) = self.viewpoint else { return };
        let tiles = &self.displayed().tiles;
        if tiles.is_empty() || !tiles.is_plan_due(now) || now.since(self.planned) < tiles.plan_period_s() {
            return;
        }
        self.planned = now;
        self.displayed_mut().plan(&viewpoint, now, effects);
    }
}

#[cfg(test)]
mod tests;
