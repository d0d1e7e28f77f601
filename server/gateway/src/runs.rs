//! Runs of missions over HTTP: what runs now, what has run, with its steps and results, and what can be asked of runs. The core decides.

use crate::app::App;
use crate::documents::{Answer, AnyPath};
use crate::json_response::json;
use crate::maps::perform;
use crate::problem::ProblemResponse;
use crate::schemas::ProblemDocument;
use crate::site::{ask, new_id};
use crate::texts;
use api::{Command, Query, QueryReply, StoredResult, StoredRun, StoredStep};
use axum::body::Bytes;
use axum::extract::rejection::{BytesRejection, QueryRejection};
use axum::extract::{Path, Query as UrlQuery, State};
use axum::http::StatusCode;
use axum::response::IntoResponse;
use serde::{Deserialize, Serialize};
use serde_json::Value;
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

/// A page of a list.
#[derive(Serialize, ToSchema)]
pub(crate) struct RunPage<T: Serialize + ToSchema> {
    items: Vec<T>,
    /// `before` or `after` of the next page; null: there is none.
    next: Option<String>,
}

/// A run as it is stored.
#[derive(Serialize, ToSchema)]
#[schema(as = StoredRun)]
pub(crate) struct RunDocument {
    /// Its id.
    #[schema(value_type = String)]
    run: RunId,
    /// Its mission.
    #[schema(value_type = String)]
    mission: MissionId,
    /// Its state.
    state: String,
    /// Whether it has ended.
    is_ended: bool,
    /// What led to it, when it began, and the revisions of the objects that it was made from.
    #[schema(value_type = Object)]
    details: Value,
    /// When it was asked for, nanoseconds since 1970 UTC.
    asked_ns: i64,
    /// When it changed last.
    changed_ns: i64,
}

/// An attempt of a task.
#[derive(Serialize, ToSchema)]
#[schema(as = StoredStep)]
pub(crate) struct StepDocument {
    /// Number of the task in its run, from 0.
    step: u32,
    /// Number of the attempt, from 1.
    attempt: u32,
    /// Its state.
    state: String,
    /// The task, its node and action, and why it failed.
    #[schema(value_type = Object)]
    details: Value,
    /// When it was intended, nanoseconds since 1970 UTC.
    intended_ns: i64,
    /// When it was done; null: not yet.
    done_ns: Option<i64>,
}

/// A result of a task.
#[derive(Serialize, ToSchema)]
#[schema(as = StoredResult)]
pub(crate) struct ResultDocument {
    /// Its number among all results.
    number: u64,
    /// Number of the task in its run, from 0.
    step: u32,
    /// Number of the attempt, from 1.
    attempt: u32,
    /// The action, such as `photo`.
    kind: String,
    /// BLAKE3 of its most important file; null: it has none.
    blob: Option<String>,
    /// The report of the action, where the robot was, and the revisions of the objects.
    #[schema(value_type = Object)]
    details: Value,
    /// When it was stored, nanoseconds since 1970 UTC.
    at_ns: i64,
}

/// Which page of a list is wanted.
#[derive(Deserialize)]
pub(crate) struct PageOfRuns {
    limit: Option<u32>,
    before: Option<RunId>,
    after: Option<String>,
}

type PageQuery = Result<UrlQuery<PageOfRuns>, QueryRejection>;

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
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The document is malformed"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "It cannot run now; the detail says why and what to do"),
    (status = 413, body = ProblemDocument, content_type = "application/problem+json", description = "The document is too long"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
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
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id or the document is malformed"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "It is not possible now; the detail says why and what to do"),
    (status = 413, body = ProblemDocument, content_type = "application/problem+json", description = "The document is too long"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
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

/// Runs, the newest first.
#[utoipa::path(get, path = api::paths::RUNS_PATH, tag = "missions", operation_id = "listRuns",
    params(
        ("limit" = Option<u32>, Query, description = "Runs wanted; 100 at most, and if left out"),
        ("before" = Option<String>, Query, description = "Only runs before this one: `next` of the page before"),
    ),
    responses(
    (status = 200, body = RunPage<RunDocument>, description = "A page of runs"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The query is malformed"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected, or cannot read"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn list(State(app): State<Arc<App>>, page: PageQuery) -> Answer {
    let page = PageOfRuns::of(page)?;
    let limit = page.limit();
    let QueryReply::Runs(runs) = ask(&app, Query::Runs { before: page.before, limit }).await? else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    let next = runs.last().filter(|_| is_full(runs.len(), limit)).map(|last| last.run.to_string());
    Ok(json(RunPage { items: runs.into_iter().map(run_document).collect(), next }))
}

/// All attempts of the tasks of a run.
#[utoipa::path(get, path = api::paths::RUN_STEPS_PATH, tag = "missions", operation_id = "listSteps",
    params(
        ("run" = String, Path, format = Uuid, description = "The run's id"),
        ("limit" = Option<u32>, Query, description = "Attempts wanted; 100 at most, and if left out"),
        ("after" = Option<String>, Query, description = "Only those after this step and attempt, such as `3.1`: `next` of the page before"),
    ),
    responses(
    (status = 200, body = RunPage<StepDocument>, description = "A page of attempts; empty for a run that is not known"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id or the query is malformed"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected, or cannot read"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn steps(State(app): State<Arc<App>>, run: AnyPath, page: PageQuery) -> Answer {
    let (run, page) = (run_id(run)?, PageOfRuns::of(page)?);
    let limit = page.limit();
    let after = page.after.as_deref().map(step_and_attempt).transpose()?;
    let QueryReply::Steps(steps) = ask(&app, Query::Steps { run, after, limit }).await? else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    let last = steps.last().filter(|_| is_full(steps.len(), limit));
    let next = last.map(|last| format!("{}.{}", last.step, last.attempt));
    Ok(json(RunPage { items: steps.into_iter().map(step_document).collect(), next }))
}

/// The results of a run.
#[utoipa::path(get, path = api::paths::RUN_RESULTS_PATH, tag = "missions", operation_id = "listResults",
    params(
        ("run" = String, Path, format = Uuid, description = "The run's id"),
        ("limit" = Option<u32>, Query, description = "Results wanted; 100 at most, and if left out"),
        ("after" = Option<u64>, Query, description = "Only those after this number: `next` of the page before"),
    ),
    responses(
    (status = 200, body = RunPage<ResultDocument>, description = "A page of results, in the order in which they were stored; empty for a run that is not known"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id or the query is malformed"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected, or cannot read"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn results(State(app): State<Arc<App>>, run: AnyPath, page: PageQuery) -> Answer {
    let (run, page) = (run_id(run)?, PageOfRuns::of(page)?);
    let limit = page.limit();
    let malformed = |_| ProblemResponse::malformed(texts::query_malformed("after is not a number"));
    let after = page.after.as_deref().map(|after| after.parse().map_err(malformed)).transpose()?;
    let QueryReply::Results(results) = ask(&app, Query::Results { run, after, limit }).await? else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    let next = results.last().filter(|_| is_full(results.len(), limit)).map(|last| last.number.to_string());
    Ok(json(RunPage { items: results.into_iter().map(result_document).collect(), next }))
}

impl PageOfRuns {
    fn of(query: PageQuery) -> Result<Self, ProblemResponse> {
        let malformed = |rejection: QueryRejection| {
            ProblemResponse::malformed(texts::query_malformed(&rejection.body_text()))
        };
        query.map(|UrlQuery(page)| page).map_err(malformed)
    }

    fn limit(&self) -> u32 {
        self.limit.unwrap_or(api::MAX_PAGE).clamp(1, api::MAX_PAGE)
    }
}

/// Whether there may be a further page.
fn is_full(entries: usize, limit: u32) -> bool {
    entries >= usize::try_from(limit).unwrap_or(usize::MAX)
}

fn run_id(path: AnyPath) -> Result<RunId, ProblemResponse> {
    let malformed = || ProblemResponse::malformed(texts::RUN_ID_MALFORMED);
    let Path(id) = path.map_err(|_| malformed())?;
    id.parse().map_err(|_| malformed())
}

fn step_and_attempt(after: &str) -> Result<(u32, u32), ProblemResponse> {
    let parse = || {
        let (step, attempt) = after.split_once('.')?;
        Some((step.parse().ok()?, attempt.parse().ok()?))
    };
    parse().ok_or_else(|| {
        ProblemResponse::malformed(texts::query_malformed("after is not a step and an attempt, such as 3.1"))
    })
}

/// A JSON document of a request.
fn parse<T: for<'a> Deserialize<'a>>(body: Result<Bytes, BytesRejection>) -> Result<T, ProblemResponse> {
    let too_long = |_| ProblemResponse::new(StatusCode::PAYLOAD_TOO_LARGE, texts::DOCUMENT_TOO_LONG);
    let malformed = |error: serde_json::Error| {
        ProblemResponse::malformed(texts::run_document_malformed(&error.to_string()))
    };
    serde_json::from_slice(&body.map_err(too_long)?).map_err(malformed)
}

/// Details that the core has written as JSON.
fn details(body: &str) -> Value {
    serde_json::from_str(body).unwrap_or(Value::Null)
}

fn run_document(stored: StoredRun) -> RunDocument {
    let StoredRun { run, mission, state, is_ended, body, began, changed } = stored;
    let (asked_ns, changed_ns) = (began.nanos(), changed.nanos());
    RunDocument { run, mission, state, is_ended, details: details(&body), asked_ns, changed_ns }
}

fn step_document(stored: StoredStep) -> StepDocument {
    let StoredStep { step, attempt, state, body, intended, done } = stored;
    let (intended_ns, done_ns) = (intended.nanos(), done.map(vocab::Stamp::nanos));
    StepDocument { step, attempt, state, details: details(&body), intended_ns, done_ns }
}

fn result_document(stored: StoredResult) -> ResultDocument {
    let StoredResult { number, step, attempt, kind, blob, body, at } = stored;
    let blob = blob.map(|hash| hash.iter().map(|byte| format!("{byte:02x}")).collect());
    ResultDocument { number, step, attempt, kind, blob, details: details(&body), at_ns: at.nanos() }
}
