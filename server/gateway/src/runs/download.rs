//! A run with all that it has gathered, as one ZIP archive. It is made while it is sent, so memory holds a few chunks and one page of results.

use super::archive::Archive;
use super::mcap::McapExport;
use super::run_id;
use super::streamed_file::FileStream;
use crate::app::App;
use crate::documents::{Answer, AnyPath};
use crate::problem::ProblemResponse;
use crate::problem_schemas::QueryProblems;
use crate::schemas::ProblemDocument;
use crate::site::ask;
use crate::texts;
use api::{Query, QueryReply, StoredRun};
use axum::extract::State;
use site_model::RunId;
use std::sync::Arc;

/// All of a run: its record, attempts, results, readings as a table, and files.
#[utoipa::path(get, path = api::paths::RUN_DOWNLOAD_PATH, tag = "missions", operation_id = "downloadRun",
    params(("run" = String, Path, format = Uuid, description = "The run's id")),
    responses(
        (status = 200, content_type = "application/zip", description = "A ZIP archive: run.json, steps.json, results.json, readings.csv and files/. It ends early, with an error of the connection, if the core or the disk fails meanwhile"),
        (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such run"),
        QueryProblems
    ))]
pub(crate) async fn download(State(app): State<Arc<App>>, run: AnyPath) -> Answer {
    let run = run_id(run)?;
    let stream = FileStream::begin(&app)?;
    let stored = stored_run(&app, run).await?;
    let archive = Archive::new(stored, app.hub.site(), &app.data_dir);
    let name = format!("{}.zip", archive.name());
    Ok(stream.send("application/zip", &name, move |core, sink| archive.write(core, sink)))
}

/// The results of a run as one MCAP file, for Foxglove and other programs.
#[utoipa::path(get, path = api::paths::RUN_MCAP_PATH, tag = "missions", operation_id = "downloadRunMcap",
    params(("run" = String, Path, format = Uuid, description = "The run's id")),
    responses(
        (status = 200, content_type = "application/octet-stream", description = "An MCAP file of JSON messages: /pose, /pictures/…, /readings/…, /spectra/…, /results and /alerts, with all other files as attachments. It ends early, with an error of the connection, if the core or the disk fails meanwhile"),
        (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such run"),
        QueryProblems
    ))]
pub(crate) async fn download_mcap(State(app): State<Arc<App>>, run: AnyPath) -> Answer {
    let run = run_id(run)?;
    let stream = FileStream::begin(&app)?;
    let stored = stored_run(&app, run).await?;
    let export = McapExport::new(stored, app.hub.site(), &app.data_dir);
    let name = format!("{}.mcap", export.name());
    Ok(stream.send("application/octet-stream", &name, move |core, sink| export.write(core, sink)))
}

/// A run as it is stored.
///
/// # Errors
/// When there is no such run, or the core cannot be asked.
pub(crate) async fn stored_run(app: &App, run: RunId) -> Result<StoredRun, ProblemResponse> {
    let QueryReply::Runs(found) = ask(app, Query::Run(run)).await? else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    found.into_iter().next().ok_or_else(|| ProblemResponse::not_found(texts::no_run(run)))
}
