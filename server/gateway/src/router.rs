//! Which path leads where.

use crate::app::App;
use crate::limits::FIXED;
use crate::problem::ProblemResponse;
use crate::runs::handlers as runs;
use crate::site::handlers as site;
use crate::texts;
use crate::{blobs, control, documents, example, maps, openapi, security, static_files, stream, uploads};
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::ws::{WebSocket, WebSocketUpgrade};
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{Method, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use axum::routing::{delete, get, patch, post, put};
use axum::{Router, middleware};
use std::future::Future;
use std::sync::Arc;

/// All routes.
pub(crate) fn router(app: Arc<App>) -> Router {
    // What changes anything is for pages of this server only.
    let guarded = Router::new()
        .route(api::paths::UPLOAD_PATH, put(uploads::put).delete(uploads::delete))
        .route(api::paths::MAP_PATH, patch(maps::rename).delete(maps::delete))
        .route(api::paths::RESTORE_MAP_PATH, post(maps::restore))
        .route(api::paths::BINNED_MAP_PATH, delete(maps::delete_permanently))
        .route(api::paths::EXAMPLE_PATH, post(example::make).delete(example::cancel))
        .route(api::paths::RUNS_PATH, post(runs::start))
        .route(api::paths::RUN_COMMANDS_PATH, post(runs::command))
        .layer(DefaultBodyLimit::max(FIXED.max_json_bytes))
        .merge(site_changes())
        .route(api::CONTROL_PATH, get(control_socket))
        .route(api::STREAM_PATH, get(stream_socket))
        .route_layer(middleware::from_fn(security::same_origin));
    Router::new()
        .merge(guarded)
        .route(api::paths::MAPS_PATH, get(maps::list))
        .route(api::paths::MAP_PATH, get(maps::get))
        .route(api::paths::BIN_PATH, get(maps::bin))
        .route(api::paths::DAMAGED_MAPS_PATH, get(maps::damaged))
        .route(api::paths::UPLOADS_PATH, get(uploads::list))
        .route(api::paths::MAP_TILES_PATH, get(documents::map_tiles))
        .route(api::paths::MAP_GRAPH_PATH, get(documents::map_graph))
        .route(api::paths::TILE_PATH, get(documents::tile))
        .route(api::paths::BLOB_PATH, get(blobs::blob))
        .route(api::paths::CLOUD_PATH, get(documents::cloud))
        .route(api::paths::HEALTH_PATH, get(documents::health))
        .route(api::paths::SITE_PATH, get(site::get_site))
        .route(api::paths::SITE_KIND_PATH, get(site::list_objects))
        .route(api::paths::SITE_OBJECT_PATH, get(site::get_object))
        .route(api::paths::SITE_REVISIONS_PATH, get(site::list_revisions))
        .route(api::paths::EXAMPLE_PATH, get(example::progress))
        .route(api::paths::RUNS_PATH, get(runs::list))
        .route(api::paths::CURRENT_RUNS_PATH, get(runs::current))
        .route(api::paths::RUN_STEPS_PATH, get(runs::steps))
        .route(api::paths::RUN_RESULTS_PATH, get(runs::results))
        .route(api::paths::RUN_CLOUDS_PATH, get(runs::clouds))
        .route(api::paths::RUN_CLOUD_PATH, get(runs::cloud))
        .route(api::paths::RUN_DOWNLOAD_PATH, get(runs::download))
        .route(api::paths::POINT_RESULTS_PATH, get(runs::point_results))
        .route(api::paths::SLOTS_PATH, get(runs::slots))
        .route(openapi::PATH, get(openapi::serve))
        .fallback(static_files::serve)
        .method_not_allowed_fallback(wrong_method)
        .layer(middleware::map_response(security::add_headers))
        .with_state(app)
}

/// What changes the site. The limit of a document's length depends on what it is.
fn site_changes() -> Router<Arc<App>> {
    let objects = Router::new()
        .route(api::paths::SITE_KIND_PATH, post(site::create_object))
        .route(
            api::paths::SITE_OBJECT_PATH,
            put(site::put_object).patch(site::patch_object).delete(site::delete_object),
        )
        .layer(DefaultBodyLimit::max(FIXED.max_object_json_bytes));
    let edits = Router::new()
        .route(api::paths::SITE_EDITS_PATH, post(site::post_edit))
        .layer(DefaultBodyLimit::max(FIXED.max_edit_json_bytes));
    objects.merge(edits)
}

async fn wrong_method(method: Method, uri: Uri) -> ProblemResponse {
    let detail = texts::method_not_allowed(uri.path(), method);
    ProblemResponse::new(StatusCode::METHOD_NOT_ALLOWED, detail)
}

type Upgrade = Result<WebSocketUpgrade, WebSocketUpgradeRejection>;

async fn control_socket(State(app): State<Arc<App>>, upgrade: Upgrade) -> Result<Response, ProblemResponse> {
    open(upgrade, app, FIXED.max_client_message_bytes, control::serve)
}

async fn stream_socket(State(app): State<Arc<App>>, upgrade: Upgrade) -> Result<Response, ProblemResponse> {
    open(upgrade, app, FIXED.max_stream_request_bytes, stream::serve)
}

fn open<F>(
    upgrade: Upgrade,
    app: Arc<App>,
    max_message_bytes: usize,
    serve: impl FnOnce(WebSocket, Arc<App>) -> F + Send + 'static,
) -> Result<Response, ProblemResponse>
where
    F: Future<Output = ()> + Send + 'static,
{
    let upgrade = upgrade.map_err(|rejection| {
        let status = rejection.into_response().status();
        ProblemResponse::new(status, texts::PATH_IS_WEBSOCKET)
    })?;
    let bounded = upgrade.max_message_size(max_message_bytes).max_frame_size(max_message_bytes);
    Ok(bounded.on_upgrade(move |socket| serve(socket, app)).into_response())
}
