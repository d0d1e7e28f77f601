//! What runs now, and what can be asked of runs.

use super::run_id;
use crate::app::App;
use crate::documents::{Answer, AnyPath};
use crate::json_response::json;
use crate::maps::perform;
use crate::problem::ProblemResponse;
use crate::problem_schemas::CommandProblems;
use crate::schemas::ProblemDocument;
use crate::site::{FieldProblem, new_id, read_document};
use crate::texts;
use api::Command;
use axum::body::Bytes;
use axum::extract::State;
use axum::extract::rejection::BytesRejection;
use axum::http::StatusCode;
use axum::response::IntoResponse;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use site_model::{
    MissionCommandKind, MissionId, MissionStatus, QuestionAnswer, RouteStatus, RunId, StartMode, TaskId,
};
use std::sync::Arc;
use utoipa::ToSchema;

/// What runs now.
#[derive(Serialize, ToSchema)]
#[schema(as = CurrentRuns)]
pub(crate) struct CurrentRunsDocument {
    /// Runs that have not ended, those that have ended lately, and monitors.
    #[schema(value_type = Object)]
    missions: MissionStatus,
    /// Where the robot is on the topological map, and its route.
    #[schema(value_type = Object)]
    route: RouteStatus,
}

/// A mission that is to run.
#[derive(Deserialize, ToSchema)]
#[schema(as = RunRequest)]
#[serde(deny_unknown_fields)]
pub(crate) struct RunRequestDocument {
    /// Id of the run, a UUID; made here if it is left out. A request with the id of a run that exists is refused, so that it is safe to send again.
    #[schema(value_type = Option<String>)]
    id: Option<RunId>,
    /// The mission, a UUID.
    #[schema(value_type = String)]
    mission: MissionId,
    /// `now` (if nothing runs), or `queue`.
    #[schema(value_type = String)]
    mode: StartMode,
}

/// A run that was asked for.
#[derive(Serialize, ToSchema)]
#[schema(as = RequestedRun)]
pub(crate) struct RequestedRunDocument {
    /// Its id, a UUID.
    #[schema(value_type = String)]
    run: RunId,
}

/// What is asked of a run.
#[derive(Deserialize, ToSchema)]
#[schema(as = RunCommand)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum RunCommandDocument {
    /// The robot stands; an action that was begun is finished.
    Pause {},
    /// Goes on with a paused run.
    Resume {},
    /// Ends it: the current action is finished, and the robot stays where it is.
    Cancel {},
    /// Ends it at once.
    Abort {},
    /// Leaves a task out.
    SkipTask {
        /// The task, a UUID.
        #[schema(value_type = String)]
        task: TaskId,
    },
    /// Does a task again.
    RedoTask {
        /// The task, a UUID.
        #[schema(value_type = String)]
        task: TaskId,
    },
    /// Answers the question what becomes of a task.
    Answer {
        /// The task, a UUID.
        #[schema(value_type = String)]
        task: TaskId,
        /// `try_again`, `skip`, `end_at_dock` or `end_here`.
        #[schema(value_type = String)]
        answer: QuestionAnswer,
    },
}

/// The runs that have not ended, and where the robot is on the topological map.
#[utoipa::path(get, path = api::paths::CURRENT_RUNS_PATH, tag = "missions", operation_id = "getCurrentRuns",
    responses(
    (status = 200, body = CurrentRunsDocument, description = "What runs now"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not read the site yet"),
))]
pub(crate) async fn current(State(app): State<Arc<App>>) -> Answer {
    let found = app.hub.with_stored(|data| Some((data.missions?.clone(), data.route?.clone())));
    let (missions, route) = found.ok_or_else(|| ProblemResponse::unavailable(texts::SITE_NOT_READ))?;
    Ok(json(CurrentRunsDocument { missions, route }))
}

/// Runs a mission.
#[utoipa::path(post, path = api::paths::RUNS_PATH, tag = "missions", operation_id = "startRun",
    request_body(content = RunRequestDocument, example = json!({ "mission": "11111111-0000-4000-8000-000000000006", "mode": "now" })),
    responses(
    (status = 201, body = RequestedRunDocument, description = "It is queued, durably, and begins when it can"),
    CommandProblems
))]
pub(crate) async fn start(State(app): State<Arc<App>>, body: Result<Bytes, BytesRejection>) -> Answer {
    let RunRequestDocument { id, mission, mode } = parse(body)?;
    let run = id.unwrap_or_else(|| RunId(new_id()));
    perform(&app, Command::Mission(MissionCommandKind::Start { run, mission, mode })).await?;
    Ok((StatusCode::CREATED, json(RequestedRunDocument { run })).into_response())
}

/// Asks something of a run.
#[utoipa::path(post, path = api::paths::RUN_COMMANDS_PATH, tag = "missions", operation_id = "commandRun",
    params(("run" = String, Path, format = Uuid, description = "The run's id")),
    request_body(content = RunCommandDocument, example = json!({ "pause": {} })),
    responses(
    (status = 204, description = "Done, and durable"),
    CommandProblems
))]
pub(crate) async fn command(
    State(app): State<Arc<App>>,
    run: AnyPath,
    body: Result<Bytes, BytesRejection>,
) -> Answer {
    let run = run_id(run)?;
    let kind = match parse(body)? {
        RunCommandDocument::Pause {} => MissionCommandKind::Pause(run),
        RunCommandDocument::Resume {} => MissionCommandKind::Resume(run),
        RunCommandDocument::Cancel {} => MissionCommandKind::Cancel(run),
        RunCommandDocument::Abort {} => MissionCommandKind::Abort(run),
        RunCommandDocument::SkipTask { task } => MissionCommandKind::SkipTask(run, task),
        RunCommandDocument::RedoTask { task } => MissionCommandKind::RedoTask(run, task),
        RunCommandDocument::Answer { task, answer } => MissionCommandKind::Answer(run, task, answer),
    };
    perform(&app, Command::Mission(kind)).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}

/// A JSON document of a request.
///
/// # Errors
/// Where it is too long, or cannot be understood; the field that is wrong is named.
pub(crate) fn parse<T: DeserializeOwned>(body: Result<Bytes, BytesRejection>) -> Result<T, ProblemResponse> {
    let too_long = |_| ProblemResponse::new(StatusCode::PAYLOAD_TOO_LARGE, texts::DOCUMENT_TOO_LONG);
    let malformed = |errors: Vec<FieldProblem>| {
        let reason = errors.first().map_or_else(String::new, |error| error.detail.clone());
        ProblemResponse::malformed(texts::run_document_malformed(&reason)).with_fields(errors)
    };
    read_document(&body.map_err(too_long)?).map_err(malformed)
}
