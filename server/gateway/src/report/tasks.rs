//! The tasks of a run in their order, each with its attempts and what was gathered.

use super::compared::ComparedPhoto;
use super::context::{ReportContext, legible_name};
use super::files::write_files;
use super::findings::{Findings, gauge_problem};
use super::html::Html;
use super::results::ResultsByAttempt;
use super::rows::{Attempt, ResultContent, ResultRow, RunRow, for_each_task, reason};
use super::table::{Cell, Table};
use super::{format, texts};
use crate::runs::CoreQueries;
use site_model::{Reading, ReadingLimits, TaskState};
use std::io;

/// Which pictures and plots a report shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pictures {
    All,
    /// Those of what needs attention, so that a report of many runs stays small.
    OfAttention,
}

/// What is known of a run while its tasks are written.
pub(super) struct RunTasks<'a> {
    pub(super) cx: &'a ReportContext,
    pub(super) core: &'a dyn CoreQueries,
    pub(super) run: &'a RunRow,
    pub(super) findings: &'a Findings,
    pub(super) pictures: Pictures,
}

impl RunTasks<'_> {
    /// Writes all tasks.
    ///
    /// # Errors
    /// When the core, the disk or whoever reads the report fails.
    pub(super) fn write(&self, html: &mut Html<'_>) -> io::Result<()> {
        let mut results = ResultsByAttempt::read(self.core, self.run.run)?;
        let mut is_empty = true;
        for_each_task(self.core, self.run.run, |attempts| {
            is_empty = false;
            self.write_task(html, attempts, &mut results)
        })?;
        match (is_empty, self.run.is_ended) {
            (false, _) => Ok(()),
            (true, true) => html.element("p", "", texts::NO_TASKS),
            (true, false) => html.element("p", "", texts::NO_TASKS_YET),
        }
    }

    fn write_task(
        &self,
        html: &mut Html<'_>,
        attempts: &[Attempt],
        results: &mut ResultsByAttempt<'_>,
    ) -> io::Result<()> {
        let Some(last) = attempts.last() else { return Ok(()) };
        let place = self.cx.place_of(self.run.mission, last);
        html.open("article", "task")?;
        html.element("div", "number", &(u64::from(last.step) + 1).to_string())?;
        self.write_line(html, last, attempts.len(), &place)?;
        if attempts.len() > 1 {
            self.write_attempts(html, attempts)?;
        } else if let Some(reason) = reason(attempts) {
            html.element("p", "reason", &reason)?;
        }
        let is_pictured = self.pictures == Pictures::All || self.findings.needs_attention(attempts);
        for attempt in attempts {
            results.for_each_of(attempt.step, attempt.attempt, |stored| {
                let row = ResultRow::of(stored);
                let compared = if is_pictured { ComparedPhoto::of(self.core, stored, &row)? } else { None };
                self.write_result(html, &row, is_pictured, &place, compared.as_ref())
            })?;
        }
        html.close("article")
    }

    /// Place, state, action and time of a task on a line.
    fn write_line(
        &self,
        html: &mut Html<'_>,
        last: &Attempt,
        attempts: usize,
        place: &str,
    ) -> io::Result<()> {
        html.open("div", "line")?;
        html.element("h3", "", place)?;
        html.element("span", if last.is_failed_or_skipped() { "alert" } else { "" }, state(last))?;
        let mut facts = vec![self.cx.action_of(last), format::time(self.cx.local(last.began))];
        facts.extend(last.took_s().map(format::duration));
        facts.extend((attempts > 1).then(|| texts::attempts(attempts)));
        html.element("span", "dim", &facts.join(" · "))?;
        html.close("div")
    }

    fn write_attempts(&self, html: &mut Html<'_>, attempts: &[Attempt]) -> io::Result<()> {
        let columns = [
            (texts::ATTEMPT, "t"),
            (texts::STATE, "t"),
            (texts::TIME, "t"),
            (texts::TOOK, "t"),
            (texts::REASON, ""),
        ];
        let mut table = Table::begin(html, "", &columns)?;
        for (number, attempt) in attempts.iter().enumerate() {
            let is_last = number + 1 == attempts.len();
            let known = if is_last { attempts } else { attempts.get(number..=number).unwrap_or_default() };
            let (count, time) = (attempt.attempt.to_string(), format::time(self.cx.local(attempt.began)));
            let took = attempt.took_s().map(format::duration).unwrap_or_default();
            let reason = reason(known).unwrap_or_default();
            table.row(&[
                Cell::Text(&count),
                Cell::Text(state(attempt)),
                Cell::Text(&time),
                Cell::Text(&took),
                Cell::Text(&reason),
            ])?;
        }
        table.end()
    }

    fn write_result(
        &self,
        html: &mut Html<'_>,
        result: &ResultRow,
        is_pictured: bool,
        place: &str,
        compared: Option<&ComparedPhoto>,
    ) -> io::Result<()> {
        match &result.content {
            ResultContent::Nothing => Ok(()),
            ResultContent::Other(answer) => html.element("p", "answer", answer),
            ResultContent::Report(report) => {
                write_readings(html, &report.readings, self.cx.limits(result.point))?;
                if let Some(problem) = gauge_problem(report) {
                    html.element("p", "reason", &problem)?;
                }
                let at = format::short_date_and_time(self.cx.local(result.at));
                write_files(html, self.cx, &report.files, is_pictured, (place, &at), compared)
            }
        }
    }
}

fn state(attempt: &Attempt) -> &'static str {
    attempt.state.map_or(texts::NOT_KNOWN, |state: TaskState| texts::task_state(state))
}

/// Writes the readings of a result. `limits` are those of its inspection point; they judge readings of their unit only.
fn write_readings(
    html: &mut Html<'_>,
    readings: &[Reading],
    limits: Option<&ReadingLimits>,
) -> io::Result<()> {
    if readings.is_empty() {
        return Ok(());
    }
    let judging = |reading: &Reading| limits.filter(|limits| limits.unit == reading.unit);
    let columns = [
        (texts::READING, ""),
        (texts::VALUE, "n"),
        (texts::DEVIATION, "n"),
        (texts::UNIT, "t"),
        (texts::LIMITS, "t"),
        (texts::JUDGEMENT, "t"),
    ];
    let is_judged = readings.iter().any(|reading| judging(reading).is_some());
    let columns = if is_judged { &columns[..] } else { &columns[..4] };
    let mut table = Table::begin(html, "readings", columns)?;
    for reading in readings {
        write_reading(&mut table, reading, judging(reading))?;
    }
    table.end()
}

fn write_reading(
    table: &mut Table<'_, '_>,
    reading: &Reading,
    limits: Option<&ReadingLimits>,
) -> io::Result<()> {
    let decimals = format::decimals(reading.value, reading.standard_deviation);
    let (name, unit) = (texts::reading_name(&legible_name(&reading.name)), legible_name(&reading.unit));
    let value = format::decimal(reading.value, decimals);
    let deviation = reading.standard_deviation.map(|it| texts::deviation(&format::decimal(it, decimals)));
    let allowed = limits.map(texts::limits).unwrap_or_default();
    let outside = limits.and_then(|limits| limits.outside(reading)).map(texts::outside);
    let (value, judgement) = match (&outside, limits) {
        (Some(outside), _) => (Cell::Alert(&value), Cell::Alert(outside)),
        (None, Some(_)) => (Cell::Text(&value), Cell::Text(texts::WITHIN)),
        (None, None) => (Cell::Text(&value), Cell::Text("")),
    };
    let deviation = deviation.unwrap_or_default();
    let [name, deviation, unit, allowed] = [&name, &deviation, &unit, &allowed].map(|text| Cell::Text(text));
    table.row(&[name, value, deviation, unit, allowed, judgement])
}
