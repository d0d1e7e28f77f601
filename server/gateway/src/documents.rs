//! Documents over HTTP: tiles and graphs of maps, scans of keyframes, health.

use crate::app::App;
use crate::files::{FileResponseOptions, REVALIDATE, respond, respond_named};
use crate::json_response::json;
use crate::pages::{AnyQuery, PageRequest};
use crate::problem::ProblemResponse;
use crate::schemas::{GraphDocument, HealthDocument, ProblemDocument, TileListDocument};
use crate::{texts, tile_pages};
use api::TileHash;
use axum::Json;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::io;
use std::sync::Arc;
use vocab::{KeyframeId, MapId, SessionId};

pub(crate) type AnyPath = Result<Path<String>, PathRejection>;
type TwoParts = Result<Path<(String, String)>, PathRejection>;
pub(crate) type Answer = Result<Response, ProblemResponse>;

/// Media type of bytes of our own.
pub(crate) const OCTETS: &str = "application/octet-stream";

/// The tiles of a saved map: all of them, or a page.
#[utoipa::path(get, path = api::paths::MAP_TILES_PATH, tag = "maps", operation_id = "listTiles",
    params(
        ("id" = String, Path, format = Uuid, description = "The map's id"),
        ("limit" = Option<usize>, Query, description = "Greatest number of tiles, 1 to 1000. Without `limit` and `after` the whole list is answered, as it is on the disk"),
        ("after" = Option<String>, Query, description = "Hash of the last tile that was read; a `Link` header with `rel=\"next\"` leads to the next page"),
    ),
    responses(
    (status = 200, body = TileListDocument, description = "Its tiles, coarse levels first"),
    (status = 304, description = "Unchanged since the client's copy"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id or the query is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such map, or no such tile in it"),
))]
pub(crate) async fn map_tiles(
    State(app): State<Arc<App>>,
    id: AnyPath,
    query: AnyQuery,
    headers: HeaderMap,
) -> Answer {
    let page = PageRequest::parse(query)?;
    if page.is_whole() {
        return map_document(&app, id, TILES_FILE, &headers).await;
    }
    let id = map_id(id)?;
    let malformed = || ProblemResponse::malformed(texts::TILE_HASH_MALFORMED);
    let after = page.after.as_ref().map(|after| after.parse::<TileHash>().map_err(|_| malformed()));
    let after = after.transpose()?;
    let file = app.data_dir.join("maps").join(id.to_string()).join(TILES_FILE);
    let wanted = page.clone();
    let read = tokio::task::spawn_blocking(move || tile_pages::read(&file, &wanted, after)).await;
    let tiles = read.unwrap_or_else(|error| Err(io::Error::other(error))).map_err(|error| {
        if error.kind() == io::ErrorKind::NotFound {
            return ProblemResponse::not_found(texts::no_map(id));
        }
        tracing::warn!(%id, %error, "could not read a tile list");
        ProblemResponse::new(StatusCode::INTERNAL_SERVER_ERROR, texts::FILE_NOT_READ)
    })?;
    if let Some(after) = after.filter(|_| !tiles.is_found) {
        return Err(ProblemResponse::not_found(texts::no_tile(&after.to_string())));
    }
    let mut response = json(&tiles.list);
    let last = tiles.list.tiles.last().filter(|_| tiles.has_more).map(|tile| tile.hash.to_string());
    page.link_next(
        &mut response,
        &api::paths::MAP_TILES_PATH.replace("{id}", &id.to_string()),
        last.as_deref(),
    );
    Ok(response)
}

/// Name of the list of tiles in a map's folder.
const TILES_FILE: &str = "tiles.json";

/// Pose graph of a saved map.
#[utoipa::path(get, path = api::paths::MAP_GRAPH_PATH, tag = "maps", operation_id = "getGraph",
    params(("id" = String, Path, format = Uuid, description = "The map's id")),
    responses(
    (status = 200, body = GraphDocument, description = "Its keyframes and edges"),
    (status = 304, description = "Unchanged since the client's copy"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such map"),
))]
pub(crate) async fn map_graph(State(app): State<Arc<App>>, id: AnyPath, headers: HeaderMap) -> Answer {
    map_document(&app, id, "graph.json", &headers).await
}

async fn map_document(app: &App, id: AnyPath, name: &str, headers: &HeaderMap) -> Answer {
    let id = map_id(id)?;
    // From the parsed id, so that the path holds hexadecimal digits and hyphens only.
    let file = app.data_dir.join("maps").join(id.to_string()).join(name);
    let serving = FileResponseOptions {
        content_type: "application/json",
        cache_control: REVALIDATE,
        etag: None,
        has_ranges: false,
    };
    let missing = || ProblemResponse::not_found(texts::no_map(id));
    respond(&file, headers, serving).await?.ok_or_else(missing)
}

/// Bytes of a tile.
#[utoipa::path(get, path = api::paths::TILE_PATH, tag = "maps", operation_id = "getTile",
    params(("hash" = String, Path, description = "BLAKE3 of the tile's bytes, 64 hexadecimal digits")),
    responses(
    (status = 200, content_type = "application/octet-stream", description = "Its bytes; they never change"),
    (status = 304, description = "Unchanged since the client's copy"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The hash is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such tile"),
))]
pub(crate) async fn tile(State(app): State<Arc<App>>, hash: AnyPath, headers: HeaderMap) -> Answer {
    let malformed = || ProblemResponse::malformed(texts::TILE_HASH_MALFORMED);
    let hash: TileHash = text(hash).and_then(|text| text.parse().ok()).ok_or_else(malformed)?;
    let name = hash.to_string();
    let file = app.data_dir.join("tiles").join(&name[..2]).join(&name);
    respond_named(&file, &name, OCTETS, false, &headers, || texts::no_tile(&name)).await
}

/// The whole scan of a keyframe, in its own frame.
#[utoipa::path(get, path = api::paths::CLOUD_PATH, tag = "maps", operation_id = "getCloud",
    params(
        ("session" = String, Path, format = Uuid, description = "The mapping session's id, as its graph names it"),
        ("keyframe" = u32, Path, description = "The keyframe's number"),
    ),
    responses(
    (status = 200, content_type = "application/octet-stream", description = "Its points, encoded like a tile; they never change"),
    (status = 304, description = "Unchanged since the client's copy"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id or number is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such scan, or not any more"),
))]
pub(crate) async fn cloud(State(app): State<Arc<App>>, names: TwoParts, headers: HeaderMap) -> Answer {
    let malformed = || ProblemResponse::malformed(texts::KEYFRAME_MALFORMED);
    let Path((session, keyframe)) = names.map_err(|_| malformed())?;
    let session: SessionId = session.parse().map_err(|_| malformed())?;
    let keyframe = KeyframeId(keyframe.parse().map_err(|_| malformed())?);
    // From the parsed names, so that the path holds hexadecimal digits and hyphens only.
    let file =
        app.data_dir.join("sessions").join(session.to_string()).join(format!("{:06}.scan", keyframe.0));
    let etag = format!("{session}-{}", keyframe.0);
    respond_named(&file, &etag, OCTETS, false, &headers, || texts::no_keyframe_scan(keyframe.0)).await
}

/// Whether gateway and core are connected.
#[utoipa::path(get, path = api::paths::HEALTH_PATH, tag = "server", operation_id = "getHealth", responses(
    (status = 200, body = HealthDocument, description = "Connected"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "Not connected, and why"),
))]
pub(crate) async fn health(State(app): State<Arc<App>>) -> Answer {
    app.hub.core_state().map_err(ProblemResponse::unavailable)?;
    let clients = app.hub.listeners().borrow().clients;
    let restarts = app.hub.restarts();
    Ok((
        [(header::CACHE_CONTROL, "no-store")],
        Json(HealthDocument { core_connected: true, clients, restarts }),
    )
        .into_response())
}

/// The map that a path names.
pub(crate) fn map_id(id: AnyPath) -> Result<MapId, ProblemResponse> {
    let malformed = || ProblemResponse::malformed(texts::MAP_ID_MALFORMED);
    text(id).and_then(|text| text.parse().ok()).ok_or_else(malformed)
}

/// The variable part of a path, if it is valid text.
fn text(path: AnyPath) -> Option<String> {
    path.ok().map(|Path(text)| text)
}
