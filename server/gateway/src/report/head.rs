//! The head of a report: what it is about, and what there is to count.

use super::context::ReportContext;
use super::findings::Counts;
use super::html::Html;
use super::page::fact;
use super::rows::{RunRow, seconds_between};
use super::{format, texts};
use site_model::RunState;
use std::io;

/// The outcome of a run in words.
pub(super) fn outcome(run: &RunRow) -> &'static str {
    run.state.map_or(texts::NOT_KNOWN, texts::run_state)
}

/// Whether a run has ended otherwise than with all its tasks done.
pub(super) fn is_incomplete(run: &RunRow) -> bool {
    run.is_ended && run.state != Some(RunState::Succeeded)
}

/// The class of the outcome.
pub(super) fn outcome_class(run: &RunRow) -> &'static str {
    if is_incomplete(run) { "outcome alert" } else { "outcome" }
}

/// When a run began and ended, for how long it was under way, and what led to it. `has_zone`: with the time zone.
pub(super) fn write_facts(
    html: &mut Html<'_>,
    cx: &ReportContext,
    run: &RunRow,
    has_zone: bool,
) -> io::Result<()> {
    html.open("dl", "facts")?;
    let at = |at| format::date_and_time(cx.local(at));
    fact(html, texts::BEGAN, &run.began.map_or_else(|| texts::NOT_BEGUN.to_owned(), at))?;
    fact(html, texts::ENDED, &run.ended.map_or_else(|| texts::NOT_ENDED.to_owned(), at))?;
    if let Some((began, ended)) = run.began.zip(run.ended) {
        fact(html, texts::DURATION, &format::duration(seconds_between(began, ended)))?;
    }
    if has_zone {
        fact(html, texts::TIME_ZONE, &cx.zone_at(run.at()))?;
    }
    fact(html, texts::CAUSE, &cx.cause(run.cause.as_ref()))?;
    html.close("dl")
}

/// What there is to count. `runs`: number of runs of a report of several.
pub(super) fn write_counts(html: &mut Html<'_>, counts: &Counts, runs: Option<usize>) -> io::Result<()> {
    html.open("ul", "counts")?;
    if let Some(runs) = runs {
        write_count(html, "", &format::count(runs as u64), named(runs, texts::RUNS))?;
    }
    write_count(html, "", &texts::of_all(counts.done, counts.tasks), texts::TASKS_DONE)?;
    let further = [
        (counts.failed, [texts::TASKS_FAILED; 2]),
        (counts.skipped, [texts::TASKS_SKIPPED; 2]),
        (counts.outside, texts::READINGS_OUTSIDE),
        (counts.changes, texts::CHANGES_FOUND),
    ];
    for (count, names) in further {
        let class = if count > 0 { "alert" } else { "" };
        write_count(html, class, &format::count(count as u64), named(count, names))?;
    }
    if counts.open() > 0 {
        write_count(html, "", &format::count(counts.open() as u64), texts::TASKS_OPEN)?;
    }
    html.close("ul")
}

/// The name of what is counted, of one and of another number.
fn named(count: usize, [one, several]: [&'static str; 2]) -> &'static str {
    if count == 1 { one } else { several }
}

fn write_count(html: &mut Html<'_>, class: &'static str, count: &str, name: &str) -> io::Result<()> {
    html.open("li", class)?;
    html.element("strong", "", count)?;
    html.element("span", "", name)?;
    html.close("li")
}
