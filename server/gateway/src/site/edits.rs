//! Objects of the site: made, changed and removed. Each request is one edit.

use super::action_parameters::ActionSchemas;
use super::fields::{FieldProblem, site_problem};
use super::objects::{KindPath, ObjectPath, kind_of, named, no_object, respond, site};
use super::parse;
use super::paths::{Condition, edit_id, etag, if_match, must_be_new, new_id, path_of};
use super::schemas::{EditDocument, EditResultDocument, FieldsProblemDocument, RemovalDocument};
use crate::access::Identity;
use crate::app::App;
use crate::documents::Answer;
use crate::json_response::json;
use crate::limits::FIXED;
use crate::problem::ProblemResponse;
use crate::problem_schemas::SiteChangeProblems;
use crate::schemas::ProblemDocument;
use crate::texts;
use api::{EditOutcome, EditRefusal, SiteState};
use axum::Extension;
use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use futures_util::StreamExt;
use serde_json::{Value, json as value};
use site_model::{
    Change, Edit, EditError, Object, ObjectId, ProblemSeverity, RevisionChange, Site, ValidationConfig,
};
use std::collections::BTreeSet;
use std::sync::Arc;

pub(crate) type Body = Result<Bytes, BytesRejection>;

/// Makes an object.
#[utoipa::path(post, path = api::paths::SITE_KIND_PATH, tag = "site", operation_id = "createObject",
    params(
        ("kind" = String, Path, description = "Kind of object, as in the lists"),
        ("Idempotency-Key" = Option<String>, Header, format = Uuid, description = "A request that is sent again with the same key is carried out once"),
    ),
    request_body(content = serde_json::Value, description = "The object; without an id it gets one", example = json!({ "name": "Pump 7", "tags": ["pump"] })),
    responses(
    (status = 201, body = serde_json::Value, description = "The object as it is stored", headers(("ETag" = String, description = "Its revision"), ("Location" = String, description = "Its path"))),
    (status = 400, body = FieldsProblemDocument, content_type = "application/problem+json", description = "The document is malformed; each field is named"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such kind"),
    (status = 412, body = FieldsProblemDocument, content_type = "application/problem+json", description = "There is one with this id already; both are in the answer"),
    (status = 422, body = FieldsProblemDocument, content_type = "application/problem+json", description = "The site cannot have this object; each field is named"),
    SiteChangeProblems
))]
pub(crate) async fn create_object(
    State(app): State<Arc<App>>,
    path: KindPath,
    headers: HeaderMap,
    body: Body,
) -> Answer {
    let kind = kind_of(path)?;
    let edit = edit_id(&headers)?;
    let mut document = read(body)?;
    let id = parse::id_of(kind, &document).map_err(malformed)?;
    // The same request sent again makes the same object.
    let id = id.unwrap_or_else(|| {
        ObjectId::new(kind, if headers.contains_key("idempotency-key") { edit.0 } else { new_id() })
    });
    parse::set_id(&mut document, id).map_err(malformed)?;
    let object = parse::object(kind, &document).map_err(malformed)?;
    let change = Change::Put { base: None, object };
    let mut response = put(&app, Edit { id: edit, changes: vec![change] }, StatusCode::CREATED).await?;
    if let Ok(location) = HeaderValue::try_from(path_of(id)) {
        response.headers_mut().insert(header::LOCATION, location);
    }
    Ok(response)
}

/// Replaces an object, or makes one with this id.
#[utoipa::path(put, path = api::paths::SITE_OBJECT_PATH, tag = "site", operation_id = "putObject",
    params(
        ("kind" = String, Path, description = "Kind of object, as in the lists"),
        ("id" = String, Path, description = "Its id"),
        ("If-Match" = Option<String>, Header, description = "Entity tag of the revision that is replaced; needed where there is one"),
        ("If-None-Match" = Option<String>, Header, description = "`*`: there must be none"),
        ("Idempotency-Key" = Option<String>, Header, format = Uuid, description = "A request that is sent again with the same key is carried out once"),
    ),
    request_body(content = serde_json::Value, description = "The whole object", example = json!({ "name": "Pump 7", "tags": ["pump"] })),
    responses(
    (status = 200, body = serde_json::Value, description = "The object as it is stored", headers(("ETag" = String, description = "Its revision"))),
    (status = 201, body = serde_json::Value, description = "It was made", headers(("ETag" = String, description = "Its revision"))),
    (status = 400, body = FieldsProblemDocument, content_type = "application/problem+json", description = "The id or the document is malformed; each field is named"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such kind"),
    (status = 412, body = FieldsProblemDocument, content_type = "application/problem+json", description = "Somebody else has changed it in the meantime; both are in the answer"),
    (status = 422, body = FieldsProblemDocument, content_type = "application/problem+json", description = "The site cannot have this object; each field is named"),
    (status = 428, body = ProblemDocument, content_type = "application/problem+json", description = "If-Match is missing"),
    SiteChangeProblems
))]
pub(crate) async fn put_object(
    State(app): State<Arc<App>>,
    path: ObjectPath,
    headers: HeaderMap,
    body: Body,
) -> Answer {
    let id = named(path)?;
    let edit = edit_id(&headers)?;
    let mut document = read(body)?;
    parse::set_id(&mut document, id).map_err(malformed)?;
    let object = parse::object(id.kind(), &document).map_err(malformed)?;
    let state = site(&app)?;
    let base = match (if_match(&headers)?, state.site.revision(id)) {
        (Condition::Revision(given), _) => Some(given),
        (Condition::Any, Some(current)) => Some(current),
        (Condition::Any, None) => return Err(no_object(id)),
        (Condition::None, Some(_)) if !must_be_new(&headers) => return Err(condition_missing()),
        (Condition::None, _) => None,
    };
    let status = if base.is_some() { StatusCode::OK } else { StatusCode::CREATED };
    put(&app, Edit { id: edit, changes: vec![Change::Put { base, object }] }, status).await
}

/// Changes fields of an object: a JSON merge patch (RFC 7396).
#[utoipa::path(patch, path = api::paths::SITE_OBJECT_PATH, tag = "site", operation_id = "patchObject",
    params(
        ("kind" = String, Path, description = "Kind of object, as in the lists"),
        ("id" = String, Path, description = "Its id"),
        ("If-Match" = String, Header, description = "Entity tag of the revision that is changed"),
        ("Idempotency-Key" = Option<String>, Header, format = Uuid, description = "A request that is sent again with the same key is carried out once"),
    ),
    request_body(content = serde_json::Value, description = "The fields that change; null removes one", example = json!({ "name": "Pump 7, east" })),
    responses(
    (status = 200, body = serde_json::Value, description = "The object as it is stored", headers(("ETag" = String, description = "Its revision"))),
    (status = 400, body = FieldsProblemDocument, content_type = "application/problem+json", description = "The id or the document is malformed; each field is named"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such object"),
    (status = 412, body = FieldsProblemDocument, content_type = "application/problem+json", description = "Somebody else has changed it in the meantime; both are in the answer"),
    (status = 422, body = FieldsProblemDocument, content_type = "application/problem+json", description = "The site cannot have this object; each field is named"),
    (status = 428, body = ProblemDocument, content_type = "application/problem+json", description = "If-Match is missing"),
    SiteChangeProblems
))]
pub(crate) async fn patch_object(
    State(app): State<Arc<App>>,
    path: ObjectPath,
    headers: HeaderMap,
    body: Body,
) -> Answer {
    let id = named(path)?;
    let edit = edit_id(&headers)?;
    let patch = read(body)?;
    let state = site(&app)?;
    let current = state.site.get(id).ok_or_else(|| no_object(id))?;
    let mut document = parse::document(&current.object);
    parse::merge_patch(&mut document, &patch);
    parse::set_id(&mut document, id).map_err(malformed)?;
    let object = parse::object(id.kind(), &document).map_err(malformed)?;
    let base = match if_match(&headers)? {
        Condition::Revision(given) => Some(given),
        Condition::Any => Some(current.revision),
        Condition::None => return Err(condition_missing()),
    };
    put(&app, Edit { id: edit, changes: vec![Change::Put { base, object }] }, StatusCode::OK).await
}

/// Removes an object and all that cannot be without it: with a node its edges and docks.
#[utoipa::path(delete, path = api::paths::SITE_OBJECT_PATH, tag = "site", operation_id = "deleteObject",
    params(
        ("kind" = String, Path, description = "Kind of object, as in the lists"),
        ("id" = String, Path, description = "Its id"),
        ("If-Match" = String, Header, description = "Entity tag of the revision that is removed"),
        ("Idempotency-Key" = Option<String>, Header, format = Uuid, description = "A request that is sent again with the same key is carried out once"),
    ),
    responses(
    (status = 200, body = RemovalDocument, description = "What was removed, and the missions that needed it"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such object"),
    (status = 412, body = FieldsProblemDocument, content_type = "application/problem+json", description = "Somebody else has changed it in the meantime; it is in the answer"),
    (status = 428, body = ProblemDocument, content_type = "application/problem+json", description = "If-Match is missing"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected, or cannot write"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn delete_object(
    State(app): State<Arc<App>>,
    path: ObjectPath,
    headers: HeaderMap,
) -> Answer {
    let id = named(path)?;
    let edit = edit_id(&headers)?;
    let state = site(&app)?;
    let current = state.site.get(id).ok_or_else(|| no_object(id))?;
    match if_match(&headers)? {
        Condition::None => return Err(condition_missing()),
        Condition::Revision(given) if given != current.revision => {
            return Err(conflict(&state.site, id, None));
        }
        Condition::Revision(_) | Condition::Any => {}
    }
    let edit = state.site.removal(edit, id);
    let missions = state.site.missions_that_need(id);
    let removed = edit.changes.iter().map(|change| path_of(change.object_id())).collect();
    perform(&app, edit).await?;
    let missions = missions.into_iter().map(|mission| path_of(ObjectId::Mission(mission))).collect();
    Ok(json(RemovalDocument { removed, missions }))
}

/// Changes several objects together or not at all.
#[utoipa::path(post, path = api::paths::SITE_EDITS_PATH, tag = "site", operation_id = "edit",
    request_body(content = EditDocument, description = "The edit: at most 20,000 changes in 4 MB. Sent again with the same id, it is carried out once",
        example = json!({ "id": "0e984725-c51c-4bf4-9960-e1c80e27aba0", "changes": [
            { "put": { "base": null, "object": { "asset": { "id": "7c9e6679-7425-40de-944b-e07fc1f90ae7", "name": "Pump 7" } } } },
            { "remove": { "base": 3, "object": { "asset": "f47ac10b-58cc-4372-a567-0e02b2c3d479" } } } ] })),
    responses(
    (status = 200, body = EditResultDocument, description = "The revisions of the changed objects"),
    (status = 400, body = FieldsProblemDocument, content_type = "application/problem+json", description = "The edit is malformed; each field is named"),
    (status = 408, body = ProblemDocument, content_type = "application/problem+json", description = "The edit came too slowly"),
    (status = 412, body = FieldsProblemDocument, content_type = "application/problem+json", description = "Somebody else has changed objects in the meantime; each is named"),
    (status = 422, body = FieldsProblemDocument, content_type = "application/problem+json", description = "The site cannot be as the edit would make it; each field is named"),
    SiteChangeProblems
))]
pub(crate) async fn post_edit(
    State(app): State<Arc<App>>,
    Extension(identity): Extension<Identity>,
    request: Request,
) -> Answer {
    let length = request.headers().get(header::CONTENT_LENGTH);
    let length: Option<u64> = length.and_then(|length| length.to_str().ok()?.parse().ok());
    // Before anything of it is read, because what is read stays in memory.
    let place = app.editing.claim(identity.account.as_deref(), length).await;
    let _place = place.map_err(|_| ProblemResponse::unavailable(texts::CORE_BUSY))?;
    let bytes = read_long(request).await?;
    // A long document takes tenths of a second, for which no connection should wait.
    let parsed = tokio::task::spawn_blocking(move || {
        if !parse::is_of_bounded_size(&bytes) {
            return Err(ProblemResponse::new(StatusCode::PAYLOAD_TOO_LARGE, texts::SITE_DOCUMENT_TOO_LONG));
        }
        let document = parse::json(&bytes).map_err(malformed)?;
        drop(bytes);
        parse::edit(&document).map_err(malformed)
    });
    let edit = parsed.await.map_err(|_| ProblemResponse::unavailable(texts::CORE_BUSY))??;
    let (revision, changes) = perform(&app, edit).await?;
    Ok(json(EditResultDocument { revision, changes: value!(changes) }))
}

/// Reads the document of an edit, within a time limit.
async fn read_long(request: Request) -> Result<Vec<u8>, ProblemResponse> {
    let too_long = || ProblemResponse::new(StatusCode::PAYLOAD_TOO_LARGE, texts::SITE_DOCUMENT_TOO_LONG);
    let mut parts = request.into_body().into_data_stream();
    let reading = async {
        let mut bytes = Vec::new();
        while let Some(part) = parts.next().await {
            // An error: the client has gone, and gets no answer.
            let part = part.map_err(|_| too_long())?;
            if bytes.len() + part.len() > FIXED.max_edit_json_bytes {
                return Err(too_long());
            }
            bytes.extend_from_slice(&part);
        }
        Ok(bytes)
    };
    let too_slow = |_| ProblemResponse::new(StatusCode::REQUEST_TIMEOUT, texts::EDIT_TOO_SLOW);
    tokio::time::timeout(FIXED.max_edit_read_time, reading).await.map_err(too_slow)?
}

/// Carries out an edit that puts one object, and answers with it.
async fn put(app: &App, edit: Edit, status: StatusCode) -> Answer {
    let Some(id) = edit.changes.first().map(Change::object_id) else {
        return Err(no_object(ObjectId::Settings));
    };
    perform(app, edit).await?;
    let state = site(app)?;
    // Somebody may have changed or removed it already.
    state.site.get(id).map(|versioned| respond(status, versioned)).ok_or_else(|| no_object(id))
}

/// Checks an edit, lets the core carry it out, and waits until it is durable. Returns the revision of the site after it, and those of its objects.
async fn perform(app: &App, edit: Edit) -> Result<(u64, Vec<RevisionChange>), ProblemResponse> {
    let state = site(app)?;
    let refused = check(&state, &app.hub.action_schemas(), &edit);
    // One that was carried out before does not fit any more, and gets its answer again from the core.
    if let Err(refused) = refused
        && state.site.check(&edit).is_ok()
    {
        return Err(refused);
    }
    let answer = app.hub.edit(edit.clone()).map_err(ProblemResponse::unavailable)?;
    match tokio::time::timeout(FIXED.max_answer_wait, answer).await {
        Ok(Ok(EditOutcome::Applied { revision, changes })) => Ok((revision, changes)),
        Ok(Ok(EditOutcome::Refused(refusal))) => Err(refusal_problem(app, &edit, refusal).of_core()),
        Ok(Err(_)) => Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER)),
        Err(_) => Err(ProblemResponse::new(StatusCode::GATEWAY_TIMEOUT, texts::COMMAND_NOT_ANSWERED)),
    }
}

/// Whether the objects of an edit could be used in the site after it.
fn check(state: &SiteState, schemas: &ActionSchemas, edit: &Edit) -> Result<(), ProblemResponse> {
    let mut after = state.site.clone();
    if after.apply(edit, edit.id).is_err() {
        return Err(ProblemResponse::malformed(texts::EDIT_DOES_NOT_FIT));
    }
    let put: BTreeSet<ObjectId> = edit
        .changes
        .iter()
        .filter(|change| matches!(change, Change::Put { .. }))
        .map(Change::object_id)
        .collect();
    let problems = after.problems(&ValidationConfig::default());
    let problems = problems
        .iter()
        .filter(|problem| problem.kind.severity() == ProblemSeverity::Error && put.contains(&problem.object));
    let mut fields: Vec<FieldProblem> = problems
        .filter_map(|problem| {
            let object = &after.get(problem.object)?.object;
            let field = site_problem(object, &parse::document(object), problem);
            Some(field.below(&prefix(edit, problem.object)))
        })
        .collect();
    for change in &edit.changes {
        if let Change::Put { object, .. } = change {
            let prefix = prefix(edit, change.object_id());
            let wrong = schemas.problems(&parse::document(object));
            fields.extend(wrong.into_iter().map(|problem| problem.below(&prefix)));
        }
    }
    if fields.is_empty() {
        return Ok(());
    }
    let status = StatusCode::UNPROCESSABLE_ENTITY;
    Err(ProblemResponse::new(status, texts::OBJECT_UNUSABLE).with_fields(fields))
}

/// Where a document of several changes has an object; empty for a request with one object.
fn prefix(edit: &Edit, object: ObjectId) -> String {
    if edit.changes.len() == 1 {
        return String::new();
    }
    let index = edit.changes.iter().position(|change| change.object_id() == object).unwrap_or_default();
    format!("/changes/{index}/put/object/{}", object.kind().name())
}

fn refusal_problem(app: &App, edit: &Edit, refusal: EditRefusal) -> ProblemResponse {
    let errors = match refusal {
        EditRefusal::Unavailable(reason) => return ProblemResponse::unavailable(reason),
        EditRefusal::Rejected(reason) => {
            return ProblemResponse::new(StatusCode::UNPROCESSABLE_ENTITY, reason);
        }
        EditRefusal::Invalid(errors) => errors,
    };
    if let ([EditError::Conflict { object, .. }], [change]) = (&errors[..], &edit.changes[..])
        && let Ok(state) = site(app)
    {
        let yours = match change {
            Change::Put { object, .. } => Some(object),
            Change::Remove { .. } => None,
        };
        return conflict(&state.site, *object, yours);
    }
    let is_conflict = errors.iter().any(|error| matches!(error, EditError::Conflict { .. }));
    let fields = errors.iter().map(|error| {
        let (object, field) = match error {
            EditError::Conflict { object, .. } => (object, "base"),
            EditError::ChangedTwice(object) | EditError::NotFinite(object) => (object, "object"),
        };
        let index = edit.changes.iter().rposition(|change| change.object_id() == *object).unwrap_or_default();
        let verb = match &edit.changes.get(index) {
            Some(Change::Remove { .. }) => "remove",
            _ => "put",
        };
        FieldProblem::new(format!("/changes/{index}/{verb}/{field}"), format!("{error}."))
    });
    let status = if is_conflict { StatusCode::PRECONDITION_FAILED } else { StatusCode::UNPROCESSABLE_ENTITY };
    ProblemResponse::new(status, texts::EDIT_DOES_NOT_FIT).with_fields(fields.collect())
}

/// 412 with the object as it is and as it was to become.
fn conflict(site: &Site, id: ObjectId, yours: Option<&Object>) -> ProblemResponse {
    let current = site.get(id);
    let versions = value!({
        "current": current.map(|versioned| value!({
            "revision": versioned.revision,
            "object": parse::document(&versioned.object),
        })),
        "yours": yours.map(parse::document),
    });
    let detail = texts::object_changed(id, current.is_some());
    let problem = ProblemResponse::new(StatusCode::PRECONDITION_FAILED, detail).with_members(versions);
    match current {
        Some(versioned) => problem.with_header(header::ETAG, etag(versioned.revision)),
        None => problem,
    }
}

fn condition_missing() -> ProblemResponse {
    ProblemResponse::new(StatusCode::PRECONDITION_REQUIRED, texts::IF_MATCH_MISSING)
}

fn malformed(fields: Vec<FieldProblem>) -> ProblemResponse {
    ProblemResponse::malformed(texts::SITE_DOCUMENT_MALFORMED).with_fields(fields)
}

fn read(body: Body) -> Result<Value, ProblemResponse> {
    let too_long = |_| ProblemResponse::new(StatusCode::PAYLOAD_TOO_LARGE, texts::SITE_DOCUMENT_TOO_LONG);
    parse::json(&body.map_err(too_long)?).map_err(malformed)
}
