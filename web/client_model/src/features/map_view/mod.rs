//! The maps on the screen: the live one under construction and a saved one that is looked at; which tiles of them are fetched.

mod robust_bounds;
mod tiles;
mod view;

pub use tiles::{TilePlanConfig, TileSet, TileState, Viewpoint};
pub use view::{Loading, MapView};

use crate::shared::{Change, Context};
use crate::{CameraMove, ClientEffect, ClientEvent, ClientTime};
use api::{ClientMessage, Severity};
use vocab::MapId;

/// Least time between two tile plans, seconds: planning visits all tiles, and four plans a second feel immediate.
const PLAN_PERIOD_S: f64 = 0.25;

/// The live map, the saved map that is looked at, and the viewpoint for which tiles are planned.
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

    /// Looks at a saved map, or at the live one. Returns whether another one was looked at before.
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
        if tiles.is_empty() || !tiles.is_plan_due(now) || now.since(self.planned) < PLAN_PERIOD_S {
            return;
        }
        self.planned = now;
        self.displayed_mut().plan(&viewpoint, now, effects);
    }
}

pub(crate) fn on_event(event: &api::Event, cx: &mut Context<'_>) {
    let views = &mut cx.shared.map_views;
    match event {
        api::Event::Graph(graph) => {
            let another = graph.session != views.live.graph.session;
            views.live.set_graph(graph.clone());
            if another {
                cx.changes.push(Change::SessionChanged);
            }
        }
        api::Event::GraphChanged(changed) => {
            if views.live.change_graph(changed) {
                cx.effects.push(ClientEffect::Send(ClientMessage::RequestGraph));
            }
        }
        api::Event::Tiles(changed) => {
            if changed.reset {
                views.live.tiles.unload(true, cx.effects);
            }
            views.live.tiles.add(&changed.added);
        }
        _ => {}
    }
}

pub(crate) fn on_client_event(event: &ClientEvent, cx: &mut Context<'_>) {
    let now = cx.now();
    let views = &mut cx.shared.map_views;
    match event {
        ClientEvent::TilesListed { map, result } => {
            let Some(view) = views.saved_mut(*map) else { return };
            match result {
                Ok(list) => {
                    view.set_tiles(list);
                    cx.effects.push(ClientEffect::MoveCamera(CameraMove::Fit));
                }
                Err(sentence) => view.loading = Loading::Failed(sentence.clone()),
            }
        }
        ClientEvent::GraphLoaded { map, result } => {
            let Some(view) = views.saved_mut(*map) else { return };
            match result {
                Ok(graph) => view.set_graph(graph.clone()),
                Err(sentence) => cx.notify(Severity::Warning, sentence.clone()),
            }
        }
        ClientEvent::TileReady { hash, .. } if !views.displayed_mut().tiles.on_fetched(hash) => {
            cx.effects.push(ClientEffect::RemoveTile(*hash));
        }
        ClientEvent::TileFailed { hash } => views.displayed_mut().tiles.on_failed(hash, now),
        ClientEvent::ViewpointChanged(viewpoint) if views.viewpoint != Some(*viewpoint) => {
            views.viewpoint = Some(*viewpoint);
            views.displayed_mut().tiles.mark_dirty();
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests;
