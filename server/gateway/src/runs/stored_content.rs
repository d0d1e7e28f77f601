//! What the core has stored of a run, read from it page by page: memory holds one page.

use api::{MAX_PAGE, Query, QueryReply, StoredResult, StoredStep};
use serde_json::Value;
use site_model::{ActionReport, RunId};
use std::io;

/// Whoever answers questions about what is stored.
pub(crate) trait CoreQueries {
    /// The answer of the core.
    ///
    /// # Errors
    /// When the core is not there, or refuses.
    fn ask(&self, query: Query) -> io::Result<QueryReply>;
}

/// Hands the attempts of a run to `take`, in the order of the tasks.
///
/// # Errors
/// When the core or `take` fails.
pub(crate) fn for_each_step(
    core: &dyn CoreQueries,
    run: RunId,
    mut take: impl FnMut(StoredStep) -> io::Result<()>,
) -> io::Result<()> {
    let mut after = None;
    loop {
        let QueryReply::Steps(page) = core.ask(Query::Steps { run, after, limit: MAX_PAGE })? else {
            return Err(other_answer());
        };
        let Some(last) = page.last() else { return Ok(()) };
        after = Some((last.step, last.attempt));
        page.into_iter().try_for_each(&mut take)?;
    }
}

/// Hands the results of a run to `take`, in the order in which they were stored.
///
/// # Errors
/// When the core or `take` fails.
pub(crate) fn for_each_result(
    core: &dyn CoreQueries,
    run: RunId,
    mut take: impl FnMut(StoredResult) -> io::Result<()>,
) -> io::Result<()> {
    let mut after = None;
    loop {
        let page = result_page(core, run, after)?;
        let Some(last) = page.last() else { return Ok(()) };
        after = Some(last.number);
        page.into_iter().try_for_each(&mut take)?;
    }
}

/// The results of a run after this number, as many as a page has.
///
/// # Errors
/// When the core fails.
pub(crate) fn result_page(
    core: &dyn CoreQueries,
    run: RunId,
    after: Option<u64>,
) -> io::Result<Vec<StoredResult>> {
    match core.ask(Query::Results { run, after, limit: MAX_PAGE })? {
        QueryReply::Results(page) => Ok(page),
        _ => Err(other_answer()),
    }
}

/// The error of an answer of another kind.
pub(crate) fn other_answer() -> io::Error {
    io::Error::other("the core has answered another question")
}

/// JSON that the core has stored.
pub(crate) fn stored_json(body: &str) -> Value {
    serde_json::from_str(body).unwrap_or_default()
}

/// The report of an action in the details of its result; none if another program's action answers otherwise.
pub(crate) fn action_report(details: &Value) -> Option<ActionReport> {
    serde_json::from_value(details.get("value")?.clone()).ok()
}
