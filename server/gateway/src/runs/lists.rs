//! Lists of what has run: runs, attempts of tasks, results, slots of schedules. Each is asked from the core a page at a time.

use super::documents::{
    ResultDocument, RunDocument, RunPage, SlotDocument, StepDocument, result_document, run_document,
    slot_document, step_document,
};
use super::run_id;
use crate::app::App;
use crate::documents::{Answer, AnyPath};
use crate::json_response::json;
use crate::problem::ProblemResponse;
use crate::problem_schemas::QueryProblems;
use crate::site::ask;
use crate::texts;
use api::{Query, QueryReply, RunFilter};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query as UrlQuery, State};
use serde::{Deserialize, Serialize};
use site_model::{InspectionPointId, MissionId, RunId, RunState};
use std::str::FromStr;
use std::sync::Arc;
use utoipa::ToSchema;
use vocab::Stamp;

/// Which page of a list is wanted.
#[derive(Deserialize)]
pub(crate) struct PageOfRuns {
    limit: Option<u32>,
    before: Option<String>,
    after: Option<String>,
    mission: Option<MissionId>,
    state: Option<RunState>,
    from_ns: Option<i64>,
    to_ns: Option<i64>,
}

pub(super) type RunPageQuery = Result<UrlQuery<PageOfRuns>, QueryRejection>;

/// Runs, the newest first.
#[utoipa::path(get, path = api::paths::RUNS_PATH, tag = "missions", operation_id = "listRuns",
    params(
        ("limit" = Option<u32>, Query, description = "Runs wanted; 100 at most, and if left out"),
        ("before" = Option<String>, Query, description = "Only runs before this one: `next` of the page before"),
        ("mission" = Option<String>, Query, description = "Only runs of this mission, a UUID"),
        ("state" = Option<String>, Query, description = "Only runs in this state, such as `failed`"),
        ("from_ns" = Option<i64>, Query, description = "Only runs that were asked for at this time or later, nanoseconds since 1970 UTC"),
        ("to_ns" = Option<i64>, Query, description = "Only runs that were asked for before this time"),
    ),
    responses((status = 200, body = RunPage<RunDocument>, description = "A page of runs"), QueryProblems))]
pub(crate) async fn list(State(app): State<Arc<App>>, page: RunPageQuery) -> Answer {
    let page = PageOfRuns::of(page)?;
    let limit = page.limit();
    let filter = RunFilter {
        mission: page.mission,
        state: page.state,
        from: page.from_ns.map(Stamp::from_nanos),
        to: page.to_ns.map(Stamp::from_nanos),
    };
    let before = parsed(page.before.as_deref(), texts::BEFORE_NO_RUN, RunId::from_str)?;
    let QueryReply::Runs(runs) = ask(&app, Query::Runs { filter, before, limit }).await? else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    Ok(page_of(runs, limit, |last| last.run.to_string(), run_document))
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
        QueryProblems
    ))]
pub(crate) async fn steps(State(app): State<Arc<App>>, run: AnyPath, page: RunPageQuery) -> Answer {
    let RunList { run, after, limit } = RunList::of(run, page, texts::AFTER_NO_STEP, step_and_attempt)?;
    let QueryReply::Steps(steps) = ask(&app, Query::Steps { run, after, limit }).await? else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    Ok(page_of(steps, limit, |last| format!("{}.{}", last.step, last.attempt), step_document))
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
        QueryProblems
    ))]
pub(crate) async fn results(State(app): State<Arc<App>>, run: AnyPath, page: RunPageQuery) -> Answer {
    let RunList { run, after, limit } = RunList::of(run, page, texts::AFTER_NO_NUMBER, u64::from_str)?;
    result_page(&app, Query::Results { run, after, limit }, limit).await
}

/// The results at an inspection point in all runs, the newest first.
#[utoipa::path(get, path = api::paths::POINT_RESULTS_PATH, tag = "missions", operation_id = "listPointResults",
    params(
        ("id" = String, Path, format = Uuid, description = "The inspection point's id"),
        ("limit" = Option<u32>, Query, description = "Results wanted; 100 at most, and if left out"),
        ("before" = Option<u64>, Query, description = "Only those before this number: that of a result, to find the one before it, or `next` of the page before"),
    ),
    responses(
        (status = 200, body = RunPage<ResultDocument>, description = "A page of results; empty for a point that is not known"),
        QueryProblems
    ))]
pub(crate) async fn point_results(State(app): State<Arc<App>>, point: AnyPath, page: RunPageQuery) -> Answer {
    let malformed = || ProblemResponse::malformed(texts::POINT_ID_MALFORMED);
    let point: Option<InspectionPointId> = point.ok().and_then(|Path(id)| id.parse().ok());
    let (point, page) = (point.ok_or_else(malformed)?, PageOfRuns::of(page)?);
    let limit = page.limit();
    let before = parsed(page.before.as_deref(), texts::BEFORE_NO_NUMBER, u64::from_str)?;
    result_page(&app, Query::PointResults { point, before, limit }, limit).await
}

/// Slots of all schedules that were decided, those due last first.
#[utoipa::path(get, path = api::paths::SLOTS_PATH, tag = "missions", operation_id = "listSlots",
    params(
        ("limit" = Option<u32>, Query, description = "Slots wanted; 100 at most, and if left out"),
        ("before" = Option<String>, Query, description = "Only those before this one: `next` of the page before"),
    ),
    responses((status = 200, body = RunPage<SlotDocument>, description = "A page of slots"), QueryProblems))]
pub(crate) async fn slots(State(app): State<Arc<App>>, page: RunPageQuery) -> Answer {
    let page = PageOfRuns::of(page)?;
    let limit = page.limit();
    let before = parsed(page.before.as_deref(), texts::BEFORE_NO_SLOT, |before| {
        let (due, schedule) = before.split_once('.').ok_or(())?;
        let due = due.parse().map_err(drop)?;
        Ok::<_, ()>((Stamp::from_nanos(due), schedule.parse().map_err(drop)?))
    })?;
    let QueryReply::Slots(slots) = ask(&app, Query::Slots { before, limit }).await? else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    Ok(page_of(slots, limit, |last| format!("{}.{}", last.due.nanos(), last.schedule), slot_document))
}

/// Which part of a list of one run is wanted: after a key of type `K`.
pub(super) struct RunList<K> {
    pub(super) run: RunId,
    pub(super) after: Option<K>,
    pub(super) limit: u32,
}

impl<K> RunList<K> {
    /// `reason`: what is wrong with a key that `parse` rejects, a clause.
    pub(super) fn of<E>(
        run: AnyPath,
        page: RunPageQuery,
        reason: &str,
        parse: impl FnOnce(&str) -> Result<K, E>,
    ) -> Result<Self, ProblemResponse> {
        let (run, page) = (run_id(run)?, PageOfRuns::of(page)?);
        Ok(Self { run, after: parsed(page.after.as_deref(), reason, parse)?, limit: page.limit() })
    }
}

impl PageOfRuns {
    fn of(query: RunPageQuery) -> Result<Self, ProblemResponse> {
        let malformed = |rejection: QueryRejection| {
            ProblemResponse::malformed(texts::query_malformed(&rejection.body_text()))
        };
        query.map(|UrlQuery(page)| page).map_err(malformed)
    }

    fn limit(&self) -> u32 {
        self.limit.unwrap_or(api::MAX_PAGE).clamp(1, api::MAX_PAGE)
    }
}

async fn result_page(app: &App, query: Query, limit: u32) -> Answer {
    let QueryReply::Results(results) = ask(app, query).await? else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    Ok(page_of(results, limit, |last| last.number.to_string(), result_document))
}

/// Where a page begins. `reason`: what is wrong with a text that `parse` rejects, a clause.
fn parsed<T, E>(
    text: Option<&str>,
    reason: &str,
    parse: impl FnOnce(&str) -> Result<T, E>,
) -> Result<Option<T>, ProblemResponse> {
    let malformed = |_| ProblemResponse::malformed(texts::query_malformed(reason));
    text.map(|text| parse(text).map_err(malformed)).transpose()
}

/// The page with these entries. If it is full, there may be another one after `key` of its last entry.
pub(super) fn page_of<T, D: Serialize + ToSchema>(
    entries: Vec<T>,
    limit: u32,
    key: impl FnOnce(&T) -> String,
    document: impl FnMut(T) -> D,
) -> axum::response::Response {
    let is_full = entries.len() >= usize::try_from(limit).unwrap_or(usize::MAX);
    let next = entries.last().filter(|_| is_full).map(key);
    json(RunPage { items: entries.into_iter().map(document).collect(), next })
}

fn step_and_attempt(after: &str) -> Result<(u32, u32), ()> {
    let (step, attempt) = after.split_once('.').ok_or(())?;
    Ok((step.parse().map_err(drop)?, attempt.parse().map_err(drop)?))
}
