//! Objects of the site: listed and read.

use super::parse::document;
use super::paths::{etag, kind, kind_path, object_id};
use super::schemas::{ObjectListDocument, SiteDocument, SiteProblemDocument, VersionedDocument};
use crate::app::App;
use crate::documents::Answer;
use crate::json_response::json;
use crate::problem::ProblemResponse;
use crate::schemas::ProblemDocument;
use crate::texts;
use api::SiteState;
use axum::extract::rejection::{PathRejection, QueryRejection};
use axum::extract::{Path, Query, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use site_model::{ObjectId, ObjectKind, ValidationConfig, Versioned};
use std::sync::Arc;
use uuid::Uuid;

pub(crate) type KindPath = Result<Path<String>, PathRejection>;
pub(crate) type ObjectPath = Result<Path<(String, String)>, PathRejection>;
pub(crate) type ObjectPageQuery = Result<Query<ObjectPage>, QueryRejection>;

/// Which part of a list is asked for.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectPage {
    /// Entries wanted, [`api::MAX_PAGE`] at most.
    limit: Option<u32>,
    /// Only objects after this one.
    after: Option<Uuid>,
    /// Only revisions before this one.
    pub(crate) before: Option<u64>,
}

impl ObjectPage {
    pub(crate) fn of(query: ObjectPageQuery) -> Result<Self, ProblemResponse> {
        let malformed = |rejection: QueryRejection| {
            ProblemResponse::malformed(texts::query_malformed(&rejection.body_text()))
        };
        query.map(|Query(page)| page).map_err(malformed)
    }

    pub(crate) fn limit(&self) -> u32 {
        self.limit.unwrap_or(api::MAX_PAGE).clamp(1, api::MAX_PAGE)
    }
}

/// The site, once the core has sent it.
pub(crate) fn site(app: &App) -> Result<Arc<SiteState>, ProblemResponse> {
    app.hub.site().ok_or_else(|| ProblemResponse::unavailable(texts::SITE_NOT_READ))
}

pub(crate) fn named(path: ObjectPath) -> Result<ObjectId, ProblemResponse> {
    let Path((kind, id)) = path.map_err(|_| ProblemResponse::malformed(texts::OBJECT_ID_MALFORMED))?;
    object_id(&kind, &id)
}

pub(crate) fn kind_of(path: KindPath) -> Result<ObjectKind, ProblemResponse> {
    let Path(name) = path.map_err(|_| ProblemResponse::not_found(texts::no_kind("")))?;
    kind(&name)
}

/// The object with its revision as entity tag.
pub(crate) fn respond(status: StatusCode, versioned: &Versioned) -> Response {
    let mut response = (status, json(document(&versioned.object))).into_response();
    response.headers_mut().insert(header::ETAG, etag(versioned.revision));
    response
}

pub(crate) fn no_object(id: ObjectId) -> ProblemResponse {
    ProblemResponse::not_found(texts::no_object(id, kind_path(id.kind())))
}

/// The site: how many objects of each kind it has, and what is wrong with it.
#[utoipa::path(get, path = api::paths::SITE_PATH, tag = "site", operation_id = "getSite", responses(
    (status = 200, body = SiteDocument, description = "The site"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not sent the site yet"),
))]
pub(crate) async fn get_site(State(app): State<Arc<App>>) -> Answer {
    let state = site(&app)?;
    let count = |kind: ObjectKind| state.site.objects().filter(|it| it.object.id().kind() == kind).count();
    let objects = ObjectKind::ALL.into_iter().map(|kind| (kind_path(kind).to_owned(), count(kind) as u64));
    let problems = state.site.problems(&ValidationConfig::default());
    let problem_count = problems.len() as u64;
    let problems = problems.into_iter().take(api::MAX_PAGE as usize).map(|problem| SiteProblemDocument {
        path: super::paths::path_of(problem.object),
        severity: match problem.kind.severity() {
            site_model::ProblemSeverity::Warning => "warning".to_owned(),
            site_model::ProblemSeverity::Error => "error".to_owned(),
        },
        detail: format!("{}.", problem.kind),
    });
    Ok(json(SiteDocument {
        revision: state.revision,
        objects: objects.collect(),
        problems: problems.collect(),
        problem_count,
    }))
}

/// Objects of one kind, in the order of their ids.
#[utoipa::path(get, path = api::paths::SITE_KIND_PATH, tag = "site", operation_id = "listObjects",
    params(
        ("kind" = String, Path, description = "Kind of object: settings, nodes, edges, edge-blocks, zones, docks, assets, inspection-points, missions, schedules, monitors, mutex-holds, scene-changes or alerts"),
        ("limit" = Option<u32>, Query, description = "Objects wanted; 100 at most, and if left out"),
        ("after" = Option<String>, Query, format = Uuid, description = "Only objects after this one: `next` of the page before"),
    ),
    responses(
    (status = 200, body = ObjectListDocument, description = "A page of objects with their revisions"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "A parameter is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such kind"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not sent the site yet"),
))]
pub(crate) async fn list_objects(
    State(app): State<Arc<App>>,
    path: KindPath,
    page: ObjectPageQuery,
) -> Answer {
    let kind = kind_of(path)?;
    let page = ObjectPage::of(page)?;
    let state = site(&app)?;
    let objects = state.site.objects().filter(|versioned| {
        let id = versioned.object.id();
        id.kind() == kind && page.after.is_none_or(|after| id.uuid() > after)
    });
    let mut objects = objects.peekable();
    let (mut items, mut bytes, mut last) = (Vec::new(), 0, None);
    while let Some(versioned) = objects
        .next_if(|_| items.len() < page.limit() as usize && (items.is_empty() || bytes < api::MAX_PAGE_BYTES))
    {
        bytes += api::encoded_bytes(versioned);
        last = Some(versioned.object.id().uuid());
        items.push(VersionedDocument {
            revision: versioned.revision.0,
            object: document(&versioned.object),
            history: None,
        });
    }
    let next = last.filter(|_| objects.peek().is_some()).map(|id| id.to_string());
    Ok(json(ObjectListDocument { revision: state.revision, items, next }))
}

/// An object.
#[utoipa::path(get, path = api::paths::SITE_OBJECT_PATH, tag = "site", operation_id = "getObject",
    params(
        ("kind" = String, Path, description = "Kind of object, as in the lists"),
        ("id" = String, Path, description = "Its UUID; of the settings `main`, of an edge block the edge's"),
    ),
    responses(
    (status = 200, body = serde_json::Value, description = "The object; its revision is the entity tag", headers(("ETag" = String, description = "Its revision"))),
    (status = 304, description = "Unchanged since the client's copy"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such object"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not sent the site yet"),
))]
pub(crate) async fn get_object(State(app): State<Arc<App>>, path: ObjectPath, headers: HeaderMap) -> Answer {
    let id = named(path)?;
    let state = site(&app)?;
    let versioned = state.site.get(id).ok_or_else(|| no_object(id))?;
    let tag = etag(versioned.revision);
    if headers.get(header::IF_NONE_MATCH) == Some(&tag) {
        return Ok((StatusCode::NOT_MODIFIED, [(header::ETAG, tag)]).into_response());
    }
    Ok(respond(StatusCode::OK, versioned))
}
