//! Saved maps over HTTP: their lists, and renaming, deleting and restoring them. The core does the work; its lists are answered from.

use crate::app::App;
use crate::documents::{Answer, AnyPath, map_id};
use crate::json_response::json;
use crate::limits::FIXED;
use crate::pages::{AnyQuery, PageRequest};
use crate::problem::ProblemResponse;
use crate::problem_schemas::ListProblems;
use crate::schemas::{
    BinnedMapDocument, DamagedMapDocument, MapSummaryDocument, ProblemDocument, RenameDocument,
};
use crate::site::read_document;
use crate::stored_data::StoredData;
use crate::texts;
use api::{Command, CommandOutcome, MapSummary};
use axum::body::Bytes;
use axum::extract::State;
use axum::extract::rejection::BytesRejection;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use std::sync::Arc;
use vocab::MapId;

/// Saved maps, newest first.
#[utoipa::path(get, path = api::paths::MAPS_PATH, tag = "maps", operation_id = "listMaps",
    params(
        ("limit" = Option<usize>, Query, description = "Greatest number of entries, 1 to 1000; 1000 if it is not given"),
        ("after" = Option<String>, Query, description = "Id of the last entry that was read; a `Link` header with `rel=\"next\"` leads to the next page"),
    ),
    responses(
    (status = 200, body = [MapSummaryDocument], description = "Every saved map version"),
    ListProblems
))]
pub(crate) async fn list(State(app): State<Arc<App>>, query: AnyQuery) -> Answer {
    let page = PageRequest::parse(query)?;
    stored(&app, |data| Some(paged(api::paths::MAPS_PATH, &page, data.maps?, |map| map.id.to_string())))?
}

/// Saved maps that cannot be read, with what to do.
#[utoipa::path(get, path = api::paths::DAMAGED_MAPS_PATH, tag = "maps", operation_id = "listDamagedMaps",
    params(
        ("limit" = Option<usize>, Query, description = "Greatest number of entries, 1 to 1000; 1000 if it is not given"),
        ("after" = Option<String>, Query, description = "Folder of the last entry that was read; a `Link` header with `rel=\"next\"` leads to the next page"),
    ),
    responses(
    (status = 200, body = [DamagedMapDocument], description = "Every saved map that cannot be read; nothing of it is removed"),
    ListProblems
))]
pub(crate) async fn damaged(State(app): State<Arc<App>>, query: AnyQuery) -> Answer {
    let page = PageRequest::parse(query)?;
    stored(&app, |data| {
        Some(paged(api::paths::DAMAGED_MAPS_PATH, &page, data.damaged?, |map| map.folder.clone()))
    })?
}

/// Deleted maps, the last deleted first.
#[utoipa::path(get, path = api::paths::BIN_PATH, tag = "maps", operation_id = "listBin",
    params(
        ("limit" = Option<usize>, Query, description = "Greatest number of entries, 1 to 1000; 1000 if it is not given"),
        ("after" = Option<String>, Query, description = "Id of the last entry that was read; a `Link` header with `rel=\"next\"` leads to the next page"),
    ),
    responses(
    (status = 200, body = [BinnedMapDocument], description = "Every map in the bin. It is kept for 7 days"),
    ListProblems
))]
pub(crate) async fn bin(State(app): State<Arc<App>>, query: AnyQuery) -> Answer {
    let page = PageRequest::parse(query)?;
    stored(&app, |data| Some(paged(api::paths::BIN_PATH, &page, data.binned?, |map| map.id.to_string())))?
}

/// A saved map.
#[utoipa::path(get, path = api::paths::MAP_PATH, tag = "maps", operation_id = "getMap",
    params(("id" = String, Path, format = Uuid, description = "The map's id")),
    responses(
    (status = 200, body = MapSummaryDocument, description = "The map"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such map"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not sent its maps yet"),
))]
pub(crate) async fn get(State(app): State<Arc<App>>, id: AnyPath) -> Answer {
    let id = map_id(id)?;
    stored(&app, |data| Some(summary(data.maps?, id)))?
        .ok_or_else(|| ProblemResponse::not_found(texts::no_map(id)))
}

/// Gives a saved map another name.
#[utoipa::path(patch, path = api::paths::MAP_PATH, tag = "maps", operation_id = "renameMap",
    params(("id" = String, Path, format = Uuid, description = "The map's id")),
    request_body(content = RenameDocument, description = "The new name", example = json!({ "name": "Pump hall, east wing" })),
    responses(
    (status = 200, body = MapSummaryDocument, description = "The map with its new name"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id or the document is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such map"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "The name is empty, or the map cannot be renamed now; the detail says why and what to do"),
    (status = 413, body = ProblemDocument, content_type = "application/problem+json", description = "The document is too long"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn rename(
    State(app): State<Arc<App>>,
    id: AnyPath,
    body: Result<Bytes, BytesRejection>,
) -> Answer {
    let id = map_id(id)?;
    let too_long = |_| ProblemResponse::new(StatusCode::PAYLOAD_TOO_LARGE, texts::DOCUMENT_TOO_LONG);
    let malformed = |errors| ProblemResponse::malformed(texts::RENAME_MALFORMED).with_fields(errors);
    let RenameDocument { name } = read_document(&body.map_err(too_long)?).map_err(malformed)?;
    let missing = || ProblemResponse::not_found(texts::no_map(id));
    stored(&app, |data| Some(summary(data.maps?, id)))?.ok_or_else(missing)?;
    perform(&app, Command::RenameMap { map: id, name }).await?;
    stored(&app, |data| Some(summary(data.maps?, id)))?.ok_or_else(missing)
}

/// Moves a saved map to the bin, where it is kept for 7 days.
#[utoipa::path(delete, path = api::paths::MAP_PATH, tag = "maps", operation_id = "deleteMap",
    params(("id" = String, Path, format = Uuid, description = "The map's id; of a damaged map the name of its folder")),
    responses(
    (status = 200, body = BinnedMapDocument, description = "The map in the bin"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such map"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "The map is in use; the detail says by what and what to do",
        example = json!({ "status": 409, "title": "Conflict", "detail": "The robot uses this map. Leave the map first, then delete it." })),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn delete(State(app): State<Arc<App>>, id: AnyPath) -> Answer {
    let id = map_id(id)?;
    let is_saved = stored(&app, |data| {
        let folder = id.to_string();
        let is_damaged = data.damaged?.iter().any(|map| map.folder == folder);
        Some(is_damaged || data.maps?.iter().any(|map| map.id == id))
    })?;
    if !is_saved {
        return Err(ProblemResponse::not_found(texts::no_map(id)));
    }
    perform(&app, Command::DeleteMap(id)).await?;
    let binned = stored(&app, |data| Some(data.binned?.iter().find(|map| map.id == id).map(json)))?;
    // Somebody may have restored it already.
    Ok(binned.unwrap_or_else(|| StatusCode::NO_CONTENT.into_response()))
}

/// Moves a map back from the bin.
#[utoipa::path(post, path = api::paths::RESTORE_MAP_PATH, tag = "maps", operation_id = "restoreMap",
    params(("id" = String, Path, format = Uuid, description = "The map's id")),
    responses(
    (status = 200, body = MapSummaryDocument, description = "The map, saved again"),
    (status = 204, description = "The map is back, and it is damaged; see the list of damaged maps"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "The map is not in the bin"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "It cannot be restored; the detail says why and what to do"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn restore(State(app): State<Arc<App>>, id: AnyPath) -> Answer {
    let id = map_id(id)?;
    check_is_binned(&app, id)?;
    perform(&app, Command::RestoreMap(id)).await?;
    let restored = stored(&app, |data| Some(summary(data.maps?, id)))?;
    Ok(restored.unwrap_or_else(|| StatusCode::NO_CONTENT.into_response()))
}

/// Deletes a map in the bin for good.
#[utoipa::path(delete, path = api::paths::BINNED_MAP_PATH, tag = "maps", operation_id = "deleteMapPermanently",
    params(("id" = String, Path, format = Uuid, description = "The map's id")),
    responses(
    (status = 204, description = "It is gone. Its tiles are removed a day later"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "The map is not in the bin"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "It cannot be deleted; the detail says why and what to do"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn delete_permanently(State(app): State<Arc<App>>, id: AnyPath) -> Answer {
    let id = map_id(id)?;
    check_is_binned(&app, id)?;
    perform(&app, Command::DeleteMapPermanently(id)).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}

/// Lets the core carry out a command, and waits until it is done.
///
/// # Errors
/// What to answer if it is not.
pub(crate) async fn perform(app: &App, command: Command) -> Result<(), ProblemResponse> {
    let answer = app.hub.request(command).map_err(ProblemResponse::unavailable)?;
    match tokio::time::timeout(FIXED.max_answer_wait, answer).await {
        Ok(Ok(CommandOutcome::Accepted)) => Ok(()),
        Ok(Ok(CommandOutcome::Refused(reason))) => {
            Err(ProblemResponse::new(StatusCode::CONFLICT, reason).of_core())
        }
        Ok(Err(_)) => Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER)),
        Err(_) => Err(ProblemResponse::new(StatusCode::GATEWAY_TIMEOUT, texts::COMMAND_NOT_ANSWERED)),
    }
}

/// What `read` finds in the core's lists of stored data; `None` where it needs one that the core has not sent.
///
/// # Errors
/// When the core has not sent a list that is needed.
pub(crate) fn stored<T>(
    app: &App,
    read: impl FnOnce(&StoredData<'_>) -> Option<T>,
) -> Result<T, ProblemResponse> {
    app.hub.with_stored(read).ok_or_else(|| ProblemResponse::unavailable(texts::MAPS_NOT_LISTED))
}

fn summary(maps: &[MapSummary], id: MapId) -> Option<Response> {
    maps.iter().find(|map| map.id == id).map(json)
}

fn check_is_binned(app: &App, id: MapId) -> Result<(), ProblemResponse> {
    let is_binned = stored(app, |data| Some(data.binned?.iter().any(|map| map.id == id)))?;
    if is_binned { Ok(()) } else { Err(ProblemResponse::not_found(texts::not_in_bin(id))) }
}

/// A page of a list.
///
/// # Errors
/// When the page begins after an entry that is not in the list any more.
fn paged<T: Serialize>(path: &str, page: &PageRequest, all: &[T], key: impl Fn(&T) -> String) -> Answer {
    let (entries, last) = page.of(all, key)?;
    let mut response = json(entries);
    page.link_next(&mut response, path, last.as_deref());
    Ok(response)
}
