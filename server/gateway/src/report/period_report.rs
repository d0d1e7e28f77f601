//! The report of all runs that were asked for in a time: a summary, what needs attention of all, and then each run, with the pictures of what needs attention.

use super::attention::{RunWithFindings, write_attention};
use super::context::ReportContext;
use super::findings::{Counts, Findings};
use super::html::Html;
use super::rows::RunRow;
use super::table::{Cell, Table};
use super::tasks::{Pictures, RunTasks};
use super::{format, head, page, texts};
use crate::runs::CoreQueries;
use site_model::Utc;
use std::io::{self, Write};

/// Writes the report. `runs` are in the order in which they are reported; `span` is the time in which they were asked for.
///
/// # Errors
/// When the core, the disk or whoever reads the report fails.
pub(super) fn write_period_report(
    cx: &ReportContext,
    core: &dyn CoreQueries,
    span: [Utc; 2],
    runs: Vec<RunRow>,
    mut sink: impl Write,
) -> io::Result<()> {
    let look = |run: RunRow| Ok(RunWithFindings { findings: Findings::read(cx, core, &run)?, run });
    let runs: Vec<RunWithFindings> = runs.into_iter().map(look).collect::<io::Result<_>>()?;
    let html = &mut Html::new(&mut sink);
    write_head(html, cx, span, &runs)?;
    html.element("h2", "", texts::SUMMARY_HEAD)?;
    if runs.is_empty() {
        html.element("p", "", texts::NO_RUNS)?;
    } else {
        write_summary(html, cx, &runs)?;
        write_attention(html, cx, &runs, true)?;
    }
    for (number, entry) in runs.iter().enumerate() {
        write_run(html, cx, core, number, entry)?;
    }
    page::end(html, cx, &[])?;
    sink.flush()
}

/// The last instant of a time, whose end does not belong to it.
pub(super) fn last_instant([_, to]: [Utc; 2]) -> Utc {
    Utc(to.0.saturating_sub(1))
}

fn write_head(
    html: &mut Html<'_>,
    cx: &ReportContext,
    span: [Utc; 2],
    runs: &[RunWithFindings],
) -> io::Result<()> {
    let site = cx.site_name();
    let [from, to] = span.map(|at| cx.local(at));
    page::begin(html, &texts::title(&site, texts::OF_PERIOD, &format::date_and_time(from)))?;
    html.markup("<header>\n")?;
    html.element("p", "kicker", &texts::kicker(&site, texts::OF_PERIOD))?;
    let last = cx.local(last_instant(span));
    html.element("h1", "", &texts::days(&format::day(from.date), &format::day(last.date)))?;
    html.open("dl", "facts")?;
    page::fact(html, texts::FROM, &format::date_and_time(from))?;
    page::fact(html, texts::TO, &format::date_and_time(to))?;
    page::fact(html, texts::TIME_ZONE, &cx.zone_at(span[1]))?;
    html.close("dl")?;
    let counts = runs.iter().map(|entry| entry.findings.counts);
    head::write_counts(html, &counts.fold(Counts::default(), Counts::plus), Some(runs.len()))?;
    html.markup("</header>\n")
}

fn write_summary(html: &mut Html<'_>, cx: &ReportContext, runs: &[RunWithFindings]) -> io::Result<()> {
    let columns = [
        (texts::TIME, "t"),
        (texts::MISSION, ""),
        (texts::OUTCOME, ""),
        (texts::DONE_OF_ALL, "n"),
        (texts::OUTSIDE, "n"),
    ];
    let mut table = Table::begin(html, "", &columns)?;
    for (number, RunWithFindings { run, findings }) in runs.iter().enumerate() {
        let at = format::short_date_and_time(cx.local(run.at()));
        let mission = cx.mission_name(run.mission);
        let done = texts::of_all(findings.counts.done, findings.counts.tasks);
        let outside = format::count(findings.counts.outside as u64);
        table.row(&[
            Cell::Run(number, &at),
            Cell::Text(&mission),
            if head::is_incomplete(run) {
                Cell::Alert(head::outcome(run))
            } else {
                Cell::Text(head::outcome(run))
            },
            Cell::Text(&done),
            if findings.counts.outside > 0 { Cell::Alert(&outside) } else { Cell::Text(&outside) },
        ])?;
    }
    table.end()
}

fn write_run(
    html: &mut Html<'_>,
    cx: &ReportContext,
    core: &dyn CoreQueries,
    number: usize,
    RunWithFindings { run, findings }: &RunWithFindings,
) -> io::Result<()> {
    html.markup("<section class=\"run\" id=\"run-")?;
    html.text(&number.to_string())?;
    html.markup("\">\n")?;
    let at = format::short_date_and_time(cx.local(run.at()));
    html.element("h2", "", &texts::run_head(&cx.mission_name(run.mission), &at))?;
    html.element("p", head::outcome_class(run), head::outcome(run))?;
    head::write_facts(html, cx, run, false)?;
    RunTasks { cx, core, run, findings, pictures: Pictures::OfAttention }.write(html)?;
    html.element("p", "note", &texts::run_id(run.run))?;
    html.close("section")
}
