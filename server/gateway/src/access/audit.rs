//! The audit log over HTTP: as JSON in pages, or as CSV.

use super::texts;
use crate::app::App;
use crate::documents::Answer;
use crate::json_response::json;
use crate::problem::ProblemResponse;
use crate::problem_schemas::QueryProblems;
use crate::site::ask;
use api::{MAX_PAGE, Query, QueryReply, StoredAudit};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query as UrlQuery, State};
use axum::http::header;
use axum::response::IntoResponse;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::sync::Arc;
use utoipa::ToSchema;
use vocab::csv_field;

/// Parameters of the audit log as a file.
#[derive(Clone, Copy, Debug)]
struct AuditFileConfig {
    /// Entries of one CSV file at most. Further ones are asked for with `before`. Chosen: about a megabyte, which a spreadsheet opens.
    max_entries: u32,
}

const CONFIG: AuditFileConfig = AuditFileConfig { max_entries: 10_000 };

/// Which part of the log is wanted.
#[derive(Deserialize)]
pub(crate) struct AuditQuery {
    limit: Option<u32>,
    before: Option<u64>,
    containing: Option<String>,
    format: Option<String>,
}

/// An entry of the audit log.
#[derive(Serialize, ToSchema)]
#[schema(as = AuditEntry)]
pub(crate) struct AuditDocument {
    /// Its number. There are no gaps.
    number: u64,
    /// When it was written, nanoseconds since 1970, UTC.
    at: i64,
    /// The account; of a program `token:` and the name of its token. Null: the platform itself, its console, or somebody who did not sign in.
    account: Option<String>,
    /// From where; null: from the robot's own computer.
    address: Option<String>,
    /// What was asked.
    command: String,
    /// What became of it.
    outcome: String,
}

/// A page of the audit log.
#[derive(Serialize, ToSchema)]
#[schema(as = AuditPage)]
pub(crate) struct AuditPageDocument {
    /// The entries, the newest first.
    items: Vec<AuditDocument>,
    /// What to ask for with `before` to get the next page; null: there is none.
    next: Option<u64>,
}

/// The audit log, the newest entries first.
#[utoipa::path(get, path = api::paths::AUDIT_PATH, tag = "access", operation_id = "listAudit",
    params(
        ("limit" = Option<u32>, Query, description = "Entries wanted; 100 at most, and if left out. As CSV 10,000 at most, and if left out"),
        ("before" = Option<u64>, Query, description = "Only entries before this number: `next` of the page before"),
        ("containing" = Option<String>, Query, description = "Only entries with this text in the account, the address, the command or the outcome, in any case"),
        ("format" = Option<String>, Query, description = "`csv`: a table instead of JSON"),
    ),
    responses((status = 200, body = AuditPageDocument, description = "A page of the log"), QueryProblems))]
pub(crate) async fn list(
    State(app): State<Arc<App>>,
    query: Result<UrlQuery<AuditQuery>, QueryRejection>,
) -> Answer {
    let malformed = |rejection: QueryRejection| {
        ProblemResponse::malformed(crate::texts::query_malformed(&rejection.body_text()))
    };
    let UrlQuery(AuditQuery { limit, mut before, containing, format }) = query.map_err(malformed)?;
    let is_csv = match format.as_deref() {
        None | Some("json") => false,
        Some("csv") => true,
        Some(_) => return Err(ProblemResponse::malformed(texts::FORMAT_UNKNOWN)),
    };
    let most = if is_csv { CONFIG.max_entries } else { MAX_PAGE };
    let wanted = limit.unwrap_or(most).clamp(1, most) as usize;
    let mut items = Vec::new();
    let containing = containing.unwrap_or_default();
    let mut is_end = false;
    while items.len() < wanted && !is_end {
        let limit = MAX_PAGE.min((wanted - items.len()) as u32);
        let query = Query::Audit { before, containing: containing.clone(), limit };
        let QueryReply::Audit(entries) = ask(&app, query).await? else {
            return Err(ProblemResponse::unavailable(crate::texts::CORE_LOST_BEFORE_ANSWER));
        };
        is_end = entries.len() < limit as usize || entries.last().is_none_or(|last| last.number <= 1);
        before = entries.last().map(|last| last.number);
        items.extend(entries.into_iter().map(document));
    }
    if is_csv {
        let head = [
            (header::CONTENT_TYPE, "text/csv; charset=utf-8"),
            (header::CACHE_CONTROL, "no-store"),
            (header::CONTENT_DISPOSITION, "attachment; filename=\"audit.csv\""),
        ];
        return Ok((head, csv(&items)).into_response());
    }
    let next = items.last().map(|last| last.number).filter(|_| !is_end);
    Ok(json(AuditPageDocument { items, next }))
}

fn document(entry: StoredAudit) -> AuditDocument {
    let origin: Option<Value> = entry.origin.and_then(|origin| serde_json::from_str(&origin).ok());
    let field = |name: &str| Some(origin.as_ref()?.get(name)?.as_str()?.to_owned());
    AuditDocument {
        number: entry.number,
        at: entry.at.nanos(),
        account: field("account"),
        address: field("address"),
        command: entry.command,
        outcome: entry.outcome,
    }
}

fn csv(items: &[AuditDocument]) -> String {
    let mut text = "number,at,account,address,command,outcome\r\n".to_owned();
    for item in items {
        let account = item.account.as_deref().unwrap_or_default();
        let address = item.address.as_deref().unwrap_or_default();
        let fields = [account, address, &item.command, &item.outcome].map(csv_field);
        text.push_str(&format!("{},{},{}\r\n", item.number, item.at, fields.join(",")));
    }
    text
}
