//! Stop motion over HTTP: for programs, and for people when no control socket is free.

use crate::app::App;
use crate::documents::Answer;
use crate::maps::perform;
use crate::problem_schemas::CommandProblems;
use api::Command;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::IntoResponse;
use std::sync::Arc;

/// Stops all motion, and keeps it stopped until an operator allows it again.
#[utoipa::path(post, path = api::paths::STOP_PATH, tag = "motion", operation_id = "stopMotion",
    responses((status = 204, description = "Motion is stopped, and stays so over restarts"), CommandProblems))]
pub(crate) async fn stop(State(app): State<Arc<App>>) -> Answer {
    perform(&app, Command::StopMotion).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}
