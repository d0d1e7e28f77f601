//! Downloads: tiles, lists of tiles, pose graphs.

use crate::inbox::{InboundMessage, Inbox};
use api::TileHash;
use client_model::ClientEvent;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use vocab::{KeyframeId, MapId, SessionId};
use wasm_bindgen::{JsCast, JsValue};
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{AbortController, RequestInit, Response};

/// Downloads under way.
pub(crate) struct Downloads {
    inbox: Inbox,
    tiles: Rc<RefCell<BTreeMap<TileHash, AbortController>>>,
}

impl Downloads {
    pub(crate) fn new(inbox: Inbox) -> Self {
        Self { inbox, tiles: Rc::default() }
    }

    /// Downloads a tile; it arrives as [`InboundMessage::Tile`], or as [`ClientEvent::TileFailed`].
    pub(crate) fn tile(&self, hash: TileHash) {
        let inbox = self.inbox.clone();
        let Ok(abort) = AbortController::new() else {
            inbox.leave(InboundMessage::Event(ClientEvent::TileFailed { hash }));
            return;
        };
        let signal = abort.signal();
        self.tiles.borrow_mut().insert(hash, abort);
        let under_way = Rc::clone(&self.tiles);
        spawn_local(async move {
            let init = RequestInit::new();
            init.set_signal(Some(&signal));
            let result = bytes(&api::paths::TILE_PATH.replace("{hash}", &hash.to_string()), &init).await;
            if signal.aborted() {
                return;
            }
            under_way.borrow_mut().remove(&hash);
            inbox.leave(match result {
                Ok(bytes) => InboundMessage::Tile { hash, bytes },
                Err(_) => InboundMessage::Event(ClientEvent::TileFailed { hash }),
            });
        });
    }

    /// Gives up a tile.
    pub(crate) fn cancel(&self, hash: &TileHash) {
        if let Some(abort) = self.tiles.borrow_mut().remove(hash) {
            abort.abort();
        }
    }

    /// Downloads the scan of a keyframe; it arrives as [`InboundMessage::Cloud`], or as [`ClientEvent::CloudFetched`] with a sentence.
    pub(crate) fn cloud(&self, session: SessionId, keyframe: KeyframeId) {
        let inbox = self.inbox.clone();
        spawn_local(async move {
            let path = api::paths::CLOUD_PATH.replace("{session}", &session.to_string());
            let path = path.replace("{keyframe}", &keyframe.0.to_string());
            inbox.leave(match bytes(&path, &RequestInit::new()).await {
                Ok(bytes) => InboundMessage::Cloud { session, keyframe, bytes },
                Err(sentence) => InboundMessage::Event(ClientEvent::CloudFetched {
                    session,
                    keyframe,
                    result: Err(sentence),
                }),
            });
        });
    }

    /// Downloads the tile list and the pose graph of a saved map.
    pub(crate) fn map(&self, map: MapId) {
        let inbox = self.inbox.clone();
        spawn_local(async move {
            let result = json(&api::paths::MAP_GRAPH_PATH.replace("{id}", &map.to_string())).await;
            inbox.leave(InboundMessage::Event(ClientEvent::GraphLoaded { map, result }));
            let result = json(&api::paths::MAP_TILES_PATH.replace("{id}", &map.to_string())).await;
            inbox.leave(InboundMessage::Event(ClientEvent::TilesListed { map, result }));
        });
    }
}

async fn bytes(path: &str, init: &RequestInit) -> Result<Vec<u8>, String> {
    let window = crate::browser::window().ok_or("there is no page")?;
    let unreachable =
        |_: JsValue| "The robot's server does not answer. Check the network, then try again.".to_owned();
    let response = JsFuture::from(window.fetch_with_str_and_init(path, init)).await.map_err(unreachable)?;
    let response: Response = response.dyn_into().map_err(unreachable)?;
    let body = response.array_buffer().map_err(unreachable)?;
    let body = js_sys::Uint8Array::new(&JsFuture::from(body).await.map_err(unreachable)?).to_vec();
    if response.ok() {
        return Ok(body);
    }
    Err(match serde_json::from_slice::<api::Problem>(&body) {
        Ok(problem) => problem.detail,
        Err(_) => format!("The robot's server answered with error {}. Try again.", response.status()),
    })
}

async fn json<T: serde::de::DeserializeOwned>(path: &str) -> Result<T, String> {
    let body = bytes(path, &RequestInit::new()).await?;
    serde_json::from_slice(&body)
        .map_err(|_| "The server sent a document this page cannot read. Reload the page.".to_owned())
}
