//! Downloads: tiles, tile lists, pose graphs, scans of keyframes.

use crate::inbox::{InboundMessage, Inbox};
use crate::texts;
use api::TileHash;
use client_model::{ClientEvent, RunContent, RunQuery, StoredPage, StoredResult};
use site_model::{InspectionPointId, RunId};
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
    /// `inbox` receives the results.
    pub(crate) fn new(inbox: Inbox) -> Self {
        Self { inbox, tiles: Rc::default() }
    }

    /// Fetches a tile. The result is [`InboundMessage::Tile`] or [`ClientEvent::TileFailed`].
    pub(crate) fn fetch_tile(&self, hash: TileHash) {
        let inbox = self.inbox.clone();
        let Ok(abort) = AbortController::new() else {
            inbox.push_event(ClientEvent::TileFailed { hash });
            return;
        };
        let signal = abort.signal();
        self.tiles.borrow_mut().insert(hash, abort);
        let tiles = Rc::clone(&self.tiles);
        spawn_local(async move {
            let init = RequestInit::new();
            init.set_signal(Some(&signal));
            let path = api::paths::TILE_PATH.replace("{hash}", &hash.to_string());
            let result = fetch_bytes(&path, &init).await;
            if signal.aborted() {
                return;
            }
            tiles.borrow_mut().remove(&hash);
            inbox.push(match result {
                Ok(bytes) => InboundMessage::Tile { hash, bytes },
                Err(_) => InboundMessage::Event(ClientEvent::TileFailed { hash }),
            });
        });
    }

    /// Cancels the download of a tile.
    pub(crate) fn cancel_tile(&self, hash: &TileHash) {
        if let Some(abort) = self.tiles.borrow_mut().remove(hash) {
            abort.abort();
        }
    }

    /// Fetches the scan of a keyframe. The result is [`InboundMessage::KeyframeScan`] or [`ClientEvent::CloudFetched`] with an error
    /// message.
    pub(crate) fn fetch_keyframe_scan(&self, session: SessionId, keyframe: KeyframeId) {
        let inbox = self.inbox.clone();
        spawn_local(async move {
            let path = api::paths::CLOUD_PATH.replace("{session}", &session.to_string());
            let path = path.replace("{keyframe}", &keyframe.0.to_string());
            inbox.push(match fetch_bytes(&path, &RequestInit::new()).await {
                Ok(bytes) => InboundMessage::KeyframeScan { session, keyframe, bytes },
                Err(message) => InboundMessage::Event(ClientEvent::CloudFetched {
                    session,
                    keyframe,
                    result: Err(message),
                }),
            });
        });
    }

    /// Fetches a page of the stored runs, the newest first. The result is [`ClientEvent::RunsListed`].
    pub(crate) fn fetch_runs(&self, query: RunQuery, before: Option<String>) {
        let inbox = self.inbox.clone();
        spawn_local(async move {
            let path = run_list_address(&query, before.as_deref());
            let result = fetch_json(&path).await;
            inbox.push_event(ClientEvent::RunsListed { query, before, result });
        });
    }

    /// Fetches the slots of schedules that were decided last. The result is [`ClientEvent::SlotsListed`].
    pub(crate) fn fetch_slots(&self) {
        let inbox = self.inbox.clone();
        spawn_local(async move {
            inbox.push_event(ClientEvent::SlotsListed(fetch_json(api::paths::SLOTS_PATH).await));
        });
    }

    /// Fetches the result before another one at an inspection point. The result is [`ClientEvent::PreviousFetched`].
    pub(crate) fn fetch_previous(&self, point: InspectionPointId, before: u64) {
        let inbox = self.inbox.clone();
        spawn_local(async move {
            let path = api::paths::POINT_RESULTS_PATH.replace("{id}", &point.to_string());
            let page = fetch_json(&format!("{path}?before={before}&limit=1")).await;
            let result = page.map(|page: StoredPage<StoredResult>| page.items.into_iter().next());
            inbox.push_event(ClientEvent::PreviousFetched { point, before, result });
        });
    }

    /// Fetches a page of the results at an inspection point, the newest first. The result is [`ClientEvent::PointResultsFetched`].
    pub(crate) fn fetch_point_results(&self, point: InspectionPointId, before: Option<String>) {
        let inbox = self.inbox.clone();
        spawn_local(async move {
            let path = api::paths::POINT_RESULTS_PATH.replace("{id}", &point.to_string());
            let from = before.as_ref().map(|before| format!("?before={before}")).unwrap_or_default();
            let result = fetch_json(&format!("{path}{from}")).await;
            inbox.push_event(ClientEvent::PointResultsFetched { point, before, result });
        });
    }

    /// Asks how the photos of two results are aligned. The result is [`ClientEvent::PicturesCompared`].
    pub(crate) fn compare_pictures(&self, before: u64, after: u64) {
        let inbox = self.inbox.clone();
        spawn_local(async move {
            let path = api::paths::PICTURE_COMPARISON_PATH;
            let result = fetch_json(&format!("{path}?before={before}&after={after}")).await;
            inbox.push_event(ClientEvent::PicturesCompared { before, after, result });
        });
    }

    /// Fetches the attempts and results of a run. The result is [`ClientEvent::RunFetched`].
    pub(crate) fn fetch_run(&self, run: RunId) {
        let inbox = self.inbox.clone();
        spawn_local(async move {
            let result = fetch_run_content(run).await;
            inbox.push_event(ClientEvent::RunFetched { run, result });
        });
    }

    /// Fetches the pose graph and the tile list of a saved map. The results are [`ClientEvent::GraphLoaded`] and
    /// [`ClientEvent::TilesListed`].
    pub(crate) fn fetch_map(&self, map: MapId) {
        let inbox = self.inbox.clone();
        spawn_local(async move {
            let result = fetch_json(&api::paths::MAP_GRAPH_PATH.replace("{id}", &map.to_string())).await;
            inbox.push_event(ClientEvent::GraphLoaded { map, result });
            let result = fetch_json(&api::paths::MAP_TILES_PATH.replace("{id}", &map.to_string())).await;
            inbox.push_event(ClientEvent::TilesListed { map, result });
        });
    }
}

/// Address of a page of these runs.
fn run_list_address(query: &RunQuery, before: Option<&str>) -> String {
    let outcome = query.outcome.and_then(|outcome| serde_json::to_value(outcome).ok());
    let parameters = [
        ("before", before.map(str::to_owned)),
        ("mission", query.mission.map(|mission| mission.to_string())),
        ("state", outcome.and_then(|outcome| Some(outcome.as_str()?.to_owned()))),
        ("from_ns", query.from.map(|from| from.0.to_string())),
        ("to_ns", query.to.map(|to| to.0.to_string())),
    ];
    let given = parameters.into_iter().filter_map(|(name, value)| Some(format!("{name}={}", value?)));
    format!("{}?{}", api::paths::RUNS_PATH, given.collect::<Vec<_>>().join("&"))
}

/// The body of a successful response; else a message for the operator.
pub(crate) async fn fetch_bytes(path: &str, init: &RequestInit) -> Result<Vec<u8>, String> {
    let window = crate::browser::window().ok_or(texts::NO_PAGE)?;
    let unreachable = |_: JsValue| texts::SERVER_SILENT.to_owned();
    let response = JsFuture::from(window.fetch_with_str_and_init(path, init)).await.map_err(unreachable)?;
    let response: Response = response.dyn_into().map_err(unreachable)?;
    let body = response.array_buffer().map_err(unreachable)?;
    let body = js_sys::Uint8Array::new(&JsFuture::from(body).await.map_err(unreachable)?).to_vec();
    if response.ok() {
        return Ok(body);
    }
    Err(match serde_json::from_slice::<api::Problem>(&body) {
        Ok(problem) => problem.detail,
        Err(_) => texts::server_error(response.status()),
    })
}

async fn fetch_run_content(run: RunId) -> Result<RunContent, String> {
    let run = run.to_string();
    let attempts = fetch_pages(&api::paths::RUN_STEPS_PATH.replace("{run}", &run)).await?;
    let results = fetch_pages(&api::paths::RUN_RESULTS_PATH.replace("{run}", &run)).await?;
    Ok(RunContent { attempts, results })
}

/// All pages of a list.
async fn fetch_pages<T: serde::de::DeserializeOwned>(path: &str) -> Result<Vec<T>, String> {
    let mut items = Vec::new();
    let mut address = path.to_owned();
    loop {
        let page: StoredPage<T> = fetch_json(&address).await?;
        items.extend(page.items);
        match page.next {
            Some(next) => address = format!("{path}?after={next}"),
            None => return Ok(items),
        }
    }
}

async fn fetch_json<T: serde::de::DeserializeOwned>(path: &str) -> Result<T, String> {
    let body = fetch_bytes(path, &RequestInit::new()).await?;
    serde_json::from_slice(&body).map_err(|_| texts::DOCUMENT_UNREADABLE.to_owned())
}
