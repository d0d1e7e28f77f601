//! Reports over HTTP. They are made while they are sent.

use super::context::ReportContext;
use super::page::CONTENT_SECURITY_POLICY;
use super::period_report::{last_instant, write_period_report};
use super::rows::RunRow;
use super::run_report::write_run_report;
use super::texts;
use crate::app::App;
use crate::documents::{Answer, AnyPath};
use crate::problem::ProblemResponse;
use crate::problem_schemas::QueryProblems;
use crate::runs::{FileStream, run_file_name, run_id, stored_run};
use crate::schemas::ProblemDocument;
use crate::site::{ask, site};
use crate::texts as common_texts;
use api::{MAX_PAGE, Query, QueryReply, RunFilter};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query as UrlQuery, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::Response;
use serde::Deserialize;
use site_model::Utc;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use vocab::Stamp;

/// Days of a report of a period at most. Chosen: the longest month.
const MAX_DAYS: i64 = 31;
/// Nanoseconds of them, with the hour by which a month is longer where clocks go back.
const MAX_SPAN_NS: i64 = (MAX_DAYS * 24 + 1) * 3_600_000_000_000;
/// Runs of a report of a period at most. Chosen: sixteen a day for a month.
const MAX_RUNS: usize = 500;
/// Type of a report.
const HTML: &str = "text/html; charset=utf-8";

/// The time of a report.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ReportSpan {
    from_ns: i64,
    to_ns: i64,
}

/// A report of a run, to be read, printed and passed on: one HTML file with its pictures.
#[utoipa::path(get, path = api::paths::RUN_REPORT_PATH, tag = "missions", operation_id = "reportRun",
    params(("run" = String, Path, format = Uuid, description = "The run's id")),
    responses(
        (status = 200, content_type = "text/html", description = "What needs attention, then every task with its pictures and readings. Nothing in it is loaded from elsewhere, and it has no scripts. It ends early, with an error of the connection, if the core or the disk fails meanwhile"),
        (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such run"),
        QueryProblems
    ))]
pub(crate) async fn report_run(State(app): State<Arc<App>>, run: AnyPath) -> Answer {
    let run = run_id(run)?;
    let stream = FileStream::begin(&app)?;
    let stored = stored_run(&app, run).await?;
    let cx = context(&app)?;
    let name = format!("{}.html", run_file_name(&stored, Some(cx.site())));
    let run = RunRow::of(&stored);
    Ok(with_policy(stream.send(HTML, &name, move |core, sink| write_run_report(&cx, core, run, sink))))
}

/// A report of all runs that were asked for in a time, such as a week: one HTML file with the pictures of what needs attention.
#[utoipa::path(get, path = api::paths::REPORT_PATH, tag = "missions", operation_id = "reportPeriod",
    params(
        ("from_ns" = i64, Query, description = "The runs that were asked for at this time or later, nanoseconds since 1970 UTC"),
        ("to_ns" = i64, Query, description = "And before this time, 31 days later at most"),
    ),
    responses(
        (status = 200, content_type = "text/html", description = "A summary of all runs, what needs attention, then each run. It ends early, with an error of the connection, if the core or the disk fails meanwhile"),
        (status = 422, body = ProblemDocument, content_type = "application/problem+json", description = "The time is longer than 31 days, or has more than 500 runs"),
        QueryProblems
    ))]
pub(crate) async fn report_period(
    State(app): State<Arc<App>>,
    span: Result<UrlQuery<ReportSpan>, QueryRejection>,
) -> Answer {
    let malformed = |clause: &str| ProblemResponse::malformed(common_texts::query_malformed(clause));
    let UrlQuery(span) = span.map_err(|rejection| malformed(&rejection.body_text()))?;
    if span.to_ns <= span.from_ns {
        return Err(malformed(texts::SPAN_REVERSED));
    }
    if span.to_ns.saturating_sub(span.from_ns) > MAX_SPAN_NS {
        return Err(too_much(texts::span_too_long(MAX_DAYS)));
    }
    let stream = FileStream::begin(&app)?;
    let runs = runs_between(&app, span).await?;
    let cx = context(&app)?;
    let ends = [Utc(span.from_ns), Utc(span.to_ns)];
    let days = [ends[0], last_instant(ends)].map(|at| cx.local(at).date);
    let name = format!("{}.html", texts::period_file_name(days));
    Ok(with_policy(
        stream.send(HTML, &name, move |core, sink| write_period_report(&cx, core, ends, runs, sink)),
    ))
}

/// The runs that were asked for in a time, the oldest first.
async fn runs_between(app: &App, span: ReportSpan) -> Result<Vec<RunRow>, ProblemResponse> {
    let [from, to] = [span.from_ns, span.to_ns].map(|at| Some(Stamp::from_nanos(at)));
    let filter = RunFilter { from, to, ..RunFilter::default() };
    let (mut runs, mut before) = (Vec::new(), None);
    loop {
        let QueryReply::Runs(page) = ask(app, Query::Runs { filter, before, limit: MAX_PAGE }).await? else {
            return Err(ProblemResponse::unavailable(common_texts::CORE_LOST_BEFORE_ANSWER));
        };
        runs.extend(page.iter().map(RunRow::of));
        if runs.len() > MAX_RUNS {
            return Err(too_much(texts::too_many_runs(MAX_RUNS)));
        }
        before = page.last().map(|last| last.run);
        if page.len() < MAX_PAGE as usize {
            runs.reverse();
            return Ok(runs);
        }
    }
}

/// What a report made now needs.
fn context(app: &App) -> Result<ReportContext, ProblemResponse> {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let made = Utc(i64::try_from(since_1970.as_nanos()).unwrap_or(i64::MAX));
    Ok(ReportContext::new(site(app)?, &app.data_dir, made))
}

fn too_much(detail: String) -> ProblemResponse {
    ProblemResponse::new(StatusCode::UNPROCESSABLE_ENTITY, detail)
}

/// A response that a browser shows as a report: without scripts, and with nothing from elsewhere.
fn with_policy(mut response: Response) -> Response {
    let policy = HeaderValue::from_static(CONTENT_SECURITY_POLICY);
    response.headers_mut().insert(header::CONTENT_SECURITY_POLICY, policy);
    response
}
