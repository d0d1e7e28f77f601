//! Which path leads where. The paths are those of the privilege table, `api::access::Endpoint`.

use crate::access::guard::{guard, known_host};
use crate::access::{Identity, audit, handlers as access};
use crate::app::App;
use crate::limits::FIXED;
use crate::problem::ProblemResponse;
use crate::report::handlers as report;
use crate::runs::handlers as runs;
use crate::site::handlers as site;
use crate::texts;
use crate::tls::trust;
use crate::{
    alerts, blobs, control, documents, example, maps, new_normal, openapi, security, static_files, stop,
    stream, uploads,
};
use api::access::Endpoint;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::ws::{WebSocket, WebSocketUpgrade};
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{Method, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, delete, get, patch, post, put};
use axum::{Extension, Router, middleware};
use std::future::Future;
use std::sync::Arc;

/// All routes: those of the privilege table, and the client's own files for all other paths.
pub(crate) fn router(app: Arc<App>) -> Router {
    let routes = Endpoint::ALL.iter().fold(Router::new(), |router, &endpoint| {
        let guarded =
            handler(endpoint).route_layer(middleware::from_fn_with_state((app.clone(), endpoint), guard));
        router.route(endpoint.path(), guarded)
    });
    routes
        .fallback(static_files::serve)
        .method_not_allowed_fallback(wrong_method)
        .layer(middleware::from_fn_with_state(app.clone(), known_host))
        .layer(middleware::map_response(security::add_headers))
        .with_state(app)
}

/// What answers a method of a path. The limit of a document's length depends on what it is.
fn handler(endpoint: Endpoint) -> MethodRouter<Arc<App>> {
    let small = || DefaultBodyLimit::max(FIXED.max_json_bytes);
    let object = || DefaultBodyLimit::max(FIXED.max_object_json_bytes);
    match endpoint {
        Endpoint::Control => get(control_socket),
        Endpoint::Stream => get(stream_socket),
        Endpoint::Health => get(documents::health),
        Endpoint::Description => get(openapi::serve),
        Endpoint::Authority => get(trust::about),
        Endpoint::AuthorityCertificate => get(trust::certificate),
        Endpoint::TrustCode => get(trust::code),
        Endpoint::Session => get(access::session),
        Endpoint::SignIn => post(access::sign_in).layer(small()),
        Endpoint::SignOut => delete(access::sign_out),
        Endpoint::MakeFirstAdmin => post(access::make_first_admin).layer(small()),
        Endpoint::ChangeOwnPassword => put(access::change_own_password).layer(small()),
        Endpoint::ListAccounts => get(access::list_accounts),
        Endpoint::AddAccount => post(access::add_account).layer(small()),
        Endpoint::ChangeAccount => patch(access::change_account).layer(small()),
        Endpoint::RemoveAccount => delete(access::remove_account),
        Endpoint::ListTokens => get(access::list_tokens),
        Endpoint::AddToken => post(access::add_token).layer(small()),
        Endpoint::RevokeToken => delete(access::revoke_token),
        Endpoint::ListAudit => get(audit::list),
        Endpoint::StopMotion => post(stop::stop),
        Endpoint::ListMaps => get(maps::list),
        Endpoint::GetMap => get(maps::get),
        Endpoint::RenameMap => patch(maps::rename).layer(small()),
        Endpoint::DeleteMap => delete(maps::delete),
        Endpoint::ListBin => get(maps::bin),
        Endpoint::DeleteMapPermanently => delete(maps::delete_permanently),
        Endpoint::RestoreMap => post(maps::restore).layer(small()),
        Endpoint::ListDamagedMaps => get(maps::damaged),
        Endpoint::GetMapTiles => get(documents::map_tiles),
        Endpoint::GetMapGraph => get(documents::map_graph),
        Endpoint::GetTile => get(documents::tile),
        Endpoint::GetBlob => get(blobs::blob),
        Endpoint::GetCloud => get(documents::cloud),
        Endpoint::ListUploads => get(uploads::list),
        // It has limits of its own.
        Endpoint::Upload => put(uploads::put),
        Endpoint::DeleteUpload => delete(uploads::delete),
        Endpoint::GetSite => get(site::get_site),
        Endpoint::ListObjects => get(site::list_objects),
        Endpoint::CreateObject => post(site::create_object).layer(object()),
        Endpoint::GetObject => get(site::get_object),
        Endpoint::PutObject => put(site::put_object).layer(object()),
        Endpoint::PatchObject => patch(site::patch_object).layer(object()),
        Endpoint::DeleteObject => delete(site::delete_object),
        Endpoint::ListRevisions => get(site::list_revisions),
        // It has limits of its own.
        Endpoint::PostEdit => post(site::post_edit),
        Endpoint::GetChangesNormal => get(new_normal::normal_progress),
        Endpoint::MakeChangesNormal => post(new_normal::make_normal).layer(object()),
        Endpoint::GetExample => get(example::progress),
        Endpoint::MakeExample => post(example::make).layer(small()),
        Endpoint::CancelExample => delete(example::cancel),
        Endpoint::ListRuns => get(runs::list),
        Endpoint::StartRun => post(runs::start).layer(small()),
        Endpoint::GetCurrentRuns => get(runs::current),
        Endpoint::CommandRun => post(runs::command).layer(small()),
        Endpoint::ListSteps => get(runs::steps),
        Endpoint::ListResults => get(runs::results),
        Endpoint::ListRunClouds => get(runs::clouds),
        Endpoint::GetRunCloud => get(runs::cloud),
        Endpoint::DownloadRun => get(runs::download),
        Endpoint::DownloadRunMcap => get(runs::download_mcap),
        Endpoint::ReportRun => get(report::report_run),
        Endpoint::ReportPeriod => get(report::report_period),
        Endpoint::ListPointResults => get(runs::point_results),
        Endpoint::ComparePictures => get(runs::compare_pictures),
        Endpoint::ListSlots => get(runs::slots),
        Endpoint::ListSceneChanges => get(site::list_scene_changes),
        Endpoint::ListAlerts => get(alerts::list),
    }
}

async fn wrong_method(method: Method, uri: Uri) -> ProblemResponse {
    let detail = texts::method_not_allowed(uri.path(), method);
    ProblemResponse::new(StatusCode::METHOD_NOT_ALLOWED, detail)
}

type Upgrade = Result<WebSocketUpgrade, WebSocketUpgradeRejection>;

async fn control_socket(
    State(app): State<Arc<App>>,
    Extension(identity): Extension<Identity>,
    upgrade: Upgrade,
) -> Result<Response, ProblemResponse> {
    open(upgrade, app, identity, FIXED.max_client_message_bytes, control::serve)
}

async fn stream_socket(
    State(app): State<Arc<App>>,
    Extension(identity): Extension<Identity>,
    upgrade: Upgrade,
) -> Result<Response, ProblemResponse> {
    open(upgrade, app, identity, FIXED.max_stream_request_bytes, stream::serve)
}

fn open<F>(
    upgrade: Upgrade,
    app: Arc<App>,
    identity: Identity,
    max_message_bytes: usize,
    serve: impl FnOnce(WebSocket, Arc<App>, Identity) -> F + Send + 'static,
) -> Result<Response, ProblemResponse>
where
    F: Future<Output = ()> + Send + 'static,
{
    let upgrade = upgrade.map_err(|rejection| {
        let status = rejection.into_response().status();
        ProblemResponse::new(status, texts::PATH_IS_WEBSOCKET)
    })?;
    let bounded = upgrade
        .max_message_size(max_message_bytes)
        .max_frame_size(max_message_bytes)
        .read_buffer_size(FIXED.socket_buffer_bytes)
        .write_buffer_size(FIXED.socket_buffer_bytes);
    Ok(bounded.on_upgrade(move |socket| serve(socket, app, identity)).into_response())
}
