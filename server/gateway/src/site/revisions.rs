//! Earlier revisions of objects, asked from the core.

use super::objects::{ObjectPage, ObjectPageQuery, ObjectPath, named};
use super::parse::document;
use super::schemas::{RevisionDocument, RevisionListDocument};
use crate::app::App;
use crate::documents::Answer;
use crate::json_response::json;
use crate::limits::FIXED;
use crate::problem::ProblemResponse;
use crate::problem_schemas::QueryProblems;
use crate::schemas::ProblemDocument;
use crate::texts;
use api::{Query, QueryReply};
use axum::extract::State;
use axum::http::StatusCode;
use site_model::Revision;
use std::sync::Arc;

/// The states that an object has had, the newest first.
#[utoipa::path(get, path = api::paths::SITE_REVISIONS_PATH, tag = "site", operation_id = "listRevisions",
    params(
        ("kind" = String, Path, description = "Kind of object, as in the lists"),
        ("id" = String, Path, description = "Its id"),
        ("limit" = Option<u32>, Query, description = "Revisions wanted; 100 at most, and if left out"),
        ("before" = Option<u64>, Query, description = "Only revisions before this one: `next` of the page before"),
    ),
    responses(
    (status = 200, body = RevisionListDocument, description = "A page of revisions, also of an object that was removed; empty if there never was one"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such kind"),
    QueryProblems
))]
pub(crate) async fn list_revisions(
    State(app): State<Arc<App>>,
    path: ObjectPath,
    page: ObjectPageQuery,
) -> Answer {
    let object = named(path)?;
    let page = ObjectPage::of(page)?;
    let limit = page.limit();
    let query = Query::Revisions { object, before: page.before.map(Revision), limit };
    let QueryReply::Revisions(revisions) = ask(&app, query).await? else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    let next = revisions.last().map(|last| last.revision.0).filter(|last| *last > 1);
    let items = revisions.into_iter().map(|stored| RevisionDocument {
        revision: stored.revision.0,
        object: stored.object.as_ref().map(document),
        author: stored.author.and_then(|author| serde_json::from_str(&author).ok()),
        at: stored.at.nanos(),
    });
    Ok(json(RevisionListDocument { items: items.collect(), next }))
}

/// Asks the core.
pub(crate) async fn ask(app: &App, query: Query) -> Result<QueryReply, ProblemResponse> {
    let answer = app.hub.query(query).map_err(ProblemResponse::unavailable)?;
    match tokio::time::timeout(FIXED.max_answer_wait, answer).await {
        Ok(Ok(reply)) => reply.map_err(ProblemResponse::unavailable),
        Ok(Err(_)) => Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER)),
        Err(_) => Err(ProblemResponse::new(StatusCode::GATEWAY_TIMEOUT, texts::COMMAND_NOT_ANSWERED)),
    }
}
