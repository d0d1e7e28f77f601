//! Two pictures of one inspection point, compared when somebody asks. The core does it.

use crate::app::App;
use crate::documents::Answer;
use crate::json_response::json;
use crate::problem::ProblemResponse;
use crate::problem_schemas::QueryProblems;
use crate::schemas::ProblemDocument;
use crate::site::ask;
use crate::texts;
use api::{Query, QueryReply};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query as UrlQuery, State};
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::Value;
use std::sync::Arc;

/// Numbers of two results.
#[derive(Deserialize)]
pub(crate) struct Pair {
    before: u64,
    after: u64,
}

/// How the photos of two results of one inspection point are aligned, and what has changed. They are compared now, which takes about a second, unless they were before.
#[utoipa::path(get, path = api::paths::PICTURE_COMPARISON_PATH, tag = "missions", operation_id = "comparePictures",
    params(
        ("before" = u64, Query, description = "Number of the result with the earlier photo"),
        ("after" = u64, Query, description = "Number of the result with the later photo"),
    ),
    responses(
        (status = 200, body = Object, description = "`before`, and `outcome`: `aligned` with the mapping, its residual and the changes, or `not_aligned` with a sentence (docs/api/missions.md)"),
        (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "The two results are no photos of one inspection point"),
        QueryProblems
    ))]
pub(crate) async fn compare_pictures(
    State(app): State<Arc<App>>,
    pair: Result<UrlQuery<Pair>, QueryRejection>,
) -> Answer {
    let UrlQuery(Pair { before, after }) =
        pair.map_err(|_| ProblemResponse::malformed(texts::PAIR_MALFORMED))?;
    let QueryReply::PictureComparison(found) = ask(&app, Query::PictureComparison { before, after }).await?
    else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    let found = found.ok_or_else(|| ProblemResponse::new(StatusCode::NOT_FOUND, texts::NO_SUCH_PAIR))?;
    Ok(json(serde_json::from_str::<Value>(&found).unwrap_or(Value::Null)))
}
