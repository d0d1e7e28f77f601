//! The description of the HTTP interface (OpenAPI 3.1), made from the handlers' own attributes.

use crate::access::{audit, handlers as access};
use crate::openapi_access::describe_access;
use crate::report::handlers as report;
use crate::runs::handlers as runs;
use crate::site::handlers as site;
use crate::tls::trust;
use crate::{alerts, blobs, documents, example, maps, new_normal, stop, uploads};
use axum::body::Bytes;
use axum::http::header;
use axum::response::{IntoResponse, Response};
use std::sync::OnceLock;
use utoipa::OpenApi;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "AutoInspect",
        description = "Documents of one robot. Live state, commands and scans go over the WebSockets /api/v1/control and \
                       /api/v1/stream, in the messages of crate `api`.",
    ),
    paths(
        trust::about,
        trust::certificate,
        trust::code,
        access::session,
        access::sign_in,
        access::sign_out,
        access::make_first_admin,
        access::change_own_password,
        access::list_accounts,
        access::add_account,
        access::change_account,
        access::remove_account,
        access::list_tokens,
        access::add_token,
        access::revoke_token,
        audit::list,
        stop::stop,
        maps::list,
        maps::damaged,
        maps::get,
        maps::rename,
        maps::delete,
        maps::bin,
        maps::restore,
        maps::delete_permanently,
        documents::map_tiles,
        documents::map_graph,
        documents::tile,
        documents::cloud,
        blobs::blob,
        documents::health,
        uploads::list,
        uploads::put,
        uploads::delete,
        site::get_site,
        site::list_objects,
        site::create_object,
        site::get_object,
        site::put_object,
        site::patch_object,
        site::delete_object,
        site::list_revisions,
        site::post_edit,
        site::list_scene_changes,
        alerts::list,
        new_normal::make_normal,
        new_normal::normal_progress,
        example::make,
        example::progress,
        example::cancel,
        runs::current,
        runs::start,
        runs::command,
        runs::list,
        runs::steps,
        runs::results,
        runs::clouds,
        runs::cloud,
        runs::download,
        runs::download_mcap,
        report::report_run,
        report::report_period,
        runs::point_results,
        runs::compare_pictures,
        runs::slots
    )
)]
struct Description;

/// The description as pretty JSON, ending in a newline: the content of `docs/api/openapi.json`.
pub fn description() -> String {
    let mut description = Description::openapi();
    describe_access(&mut description);
    let mut json = description.to_pretty_json().unwrap_or_default();
    json.push('\n');
    json
}

/// Serves the description.
pub(crate) async fn serve() -> Response {
    // Made once: readers that are slow share it.
    static DESCRIPTION: OnceLock<Bytes> = OnceLock::new();
    let document = DESCRIPTION.get_or_init(|| description().into()).clone();
    ([(header::CONTENT_TYPE, "application/json"), (header::CACHE_CONTROL, "no-cache")], document)
        .into_response()
}

#[cfg(test)]
#[path = "openapi_tests.rs"]
mod tests;
