//! What events of the server and of the client do to the maps on the screen.

use super::Loading;
use crate::shared::{Context, SliceChange};
use crate::{CameraMove, ClientEffect, ClientEvent};
use api::{ClientMessage, Severity};

/// An event of the server.
pub(crate) fn on_event(event: &api::Event, cx: &mut Context<'_>) {
    let views = &mut cx.shared.map_views;
    match event {
        api::Event::Graph(graph) => {
            let another = graph.session != views.live.graph.session;
            views.live.set_graph(graph.clone());
            if another {
                cx.changes.push(SliceChange::SessionChanged);
            }
        }
        api::Event::GraphChanged(changed) => {
            let is_lost = views.live.change_graph(changed);
            cx.effects.extend(is_lost.then_some(ClientEffect::Send(ClientMessage::RequestGraph)));
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

/// Something happened on the client.
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
