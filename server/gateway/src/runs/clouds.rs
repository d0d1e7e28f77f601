//! Clouds that the robot saw on a run. The gateway reads them in the data directory, where the core keeps them.

use super::documents::{RunCloudDocument, RunPage};
use super::lists::{RunList, RunPageQuery, page_of};
use crate::app::App;
use crate::blobs::file_name;
use crate::documents::{Answer, AnyPath, OCTETS};
use crate::files::{not_read, respond_named};
use crate::problem::ProblemResponse;
use crate::problem_schemas::QueryProblems;
use crate::schemas::ProblemDocument;
use crate::texts;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::HeaderMap;
use site_model::RunId;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

/// The clouds that the robot saw on a run, in their order.
#[utoipa::path(get, path = api::paths::RUN_CLOUDS_PATH, tag = "missions", operation_id = "listRunClouds",
    params(
        ("run" = String, Path, format = Uuid, description = "The run's id"),
        ("limit" = Option<u32>, Query, description = "Clouds wanted; 100 at most, and if left out"),
        ("after" = Option<u64>, Query, description = "Only those after this number: `next` of the page before"),
    ),
    responses(
        (status = 200, body = RunPage<RunCloudDocument>, description = "A page of clouds: hash, length, time, why it was kept, pose of the base, and the sensor in the base. Empty if none were kept, or they made room for those of later runs"),
        (status = 500, body = ProblemDocument, content_type = "application/problem+json", description = "The disk fails"),
        QueryProblems
    ))]
pub(crate) async fn clouds(State(app): State<Arc<App>>, run: AnyPath, page: RunPageQuery) -> Answer {
    let list = RunList::of(run, page, texts::AFTER_NO_NUMBER, u64::from_str)?;
    let path = folder(&app, list.run).join("index.jsonl");
    let text = match tokio::fs::read_to_string(&path).await {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
        Err(error) => return Err(not_read(&path, &error)),
    };
    let after = list.after.unwrap_or(0);
    let numbered = text.lines().zip(1_u64..).filter(|(_, number)| *number > after);
    let numbered = numbered.filter_map(|(line, number)| {
        let mut entry: RunCloudDocument = serde_json::from_str(line).ok()?;
        entry.number = number;
        Some(entry)
    });
    let entries = numbered.take(list.limit as usize).collect();
    Ok(page_of(entries, list.limit, |last: &RunCloudDocument| last.number.to_string(), |entry| entry))
}

/// A cloud that the robot saw on a run.
#[utoipa::path(get, path = api::paths::RUN_CLOUD_PATH, tag = "missions", operation_id = "getRunCloud",
    params(
        ("run" = String, Path, format = Uuid, description = "The run's id"),
        ("hash" = String, Path, description = "BLAKE3 of the file, 64 hexadecimal digits, as the list has it"),
    ),
    responses(
        (status = 200, content_type = "application/octet-stream", description = "A header with what the list has of it, and the points (docs/api/missions.md)"),
        (status = 206, content_type = "application/octet-stream", description = "The part of its bytes that was asked for"),
        (status = 304, description = "Unchanged since the client's copy"),
        (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id or the hash is malformed"),
        (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such cloud, or it has made room for those of later runs"),
        (status = 416, body = ProblemDocument, content_type = "application/problem+json", description = "The file has no such part"),
    ))]
pub(crate) async fn cloud(
    State(app): State<Arc<App>>,
    path: Result<Path<(String, String)>, PathRejection>,
    headers: HeaderMap,
) -> Answer {
    let (run, hash) = path.map_or((None, None), |Path((run, hash))| (run.parse().ok(), Some(hash)));
    let name = file_name(hash)?;
    let run = run.ok_or_else(|| ProblemResponse::malformed(texts::RUN_ID_MALFORMED))?;
    let file = folder(&app, run).join(&name);
    respond_named(&file, &name, OCTETS, true, &headers, || texts::NO_RUN_CLOUD.to_owned()).await
}

/// Where the clouds of a run are.
fn folder(app: &App, run: RunId) -> PathBuf {
    app.data_dir.join("run-clouds").join(run.to_string())
}
